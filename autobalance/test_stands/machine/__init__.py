"""A balancing machine, simulated and read."""
