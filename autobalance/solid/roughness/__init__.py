"""Noise on the surface of a mesh: its presence and its size."""
