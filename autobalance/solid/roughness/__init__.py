"""What noise does to a surface: whether a mesh has any, and how much."""
