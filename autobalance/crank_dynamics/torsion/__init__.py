"""Torsional vibration of a crank or a chain of inertias."""
