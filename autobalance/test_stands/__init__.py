"""Test stands: the bench, the balancing machine, influence coefficients."""
