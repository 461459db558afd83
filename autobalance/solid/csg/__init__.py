"""Solids and their booleans, exact shapes and tools."""
