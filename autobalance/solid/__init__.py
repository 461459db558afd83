"""Triangles and solids: read, weld, check, measure, cut, write."""
