"""Checks and repairs that make a solid trustworthy: bodies, overlaps, holes, slivers of booleans."""
