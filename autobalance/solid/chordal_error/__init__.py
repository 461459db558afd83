"""Chord error of flat facets against the smooth surface they stand for."""
