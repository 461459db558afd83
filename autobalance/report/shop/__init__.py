"""Machine readings, influence trials and rods, shown."""
