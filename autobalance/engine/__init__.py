"""Weights and forces of an engine; no geometry."""
