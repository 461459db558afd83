"""Inertia forces of an engine: orders, bearing loads, balance factors."""
