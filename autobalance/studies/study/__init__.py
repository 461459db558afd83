"""Tolerance study: yield, and which tolerances matter most."""
