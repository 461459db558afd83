"""Choice of cuts and their depths: pure numbers on the effects of cuts."""
