"""One file per kind of correction: parameters, limits, tool body, effect."""
