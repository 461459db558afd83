"""The anatomy of a crankshaft and how it is recognised in a solid."""
