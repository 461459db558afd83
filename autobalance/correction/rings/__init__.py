"""Turned rims: their trace."""
