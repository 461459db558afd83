"""Many jobs from a list or a folder."""
