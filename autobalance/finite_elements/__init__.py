"""Finite elements of a solid: quadratic tetrahedra, free and held modes, static stress.

Pure numerics in mm, N, tonne and s (so MPa and Hz come out as they are). The mesher and the finite-element
library are the extra ``fem``; they are imported in this room alone.
"""
