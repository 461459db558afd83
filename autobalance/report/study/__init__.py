"""Tolerance studies, shown."""
