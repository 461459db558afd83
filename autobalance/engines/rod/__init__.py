"""A connecting rod measured from its solid."""
