"""A crankshaft recognised in a solid."""
