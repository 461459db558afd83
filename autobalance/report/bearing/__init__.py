"""Bearings, shown."""
