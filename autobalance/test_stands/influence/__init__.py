"""Balancing by influence coefficients."""
