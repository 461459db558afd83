"""Test is: the bench, the balancing machine, influence coefficients."""
