"""What drilled holes and slugs share: bores, places, walls, metal on the way, traces."""
