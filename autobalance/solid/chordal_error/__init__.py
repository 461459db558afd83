"""What flat facets hide of the smooth surface they stand for."""
