"""Common parts of drilled holes and slugs: bores, places, walls, metal on the way, traces."""
