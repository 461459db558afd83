"""Crankshafts from dimensions: designs, presets, solids."""
