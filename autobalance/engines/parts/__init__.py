"""Weights of an engine's parts."""
