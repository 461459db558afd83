"""Whether a solid can be trusted: bodies, overlaps, slivers of booleans, and what is repaired."""
