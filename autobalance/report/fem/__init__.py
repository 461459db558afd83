"""Finite-element results, shown."""
