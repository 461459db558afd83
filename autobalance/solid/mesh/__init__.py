"""Triangles with shared vertices: weld, repair, validate, measure."""
