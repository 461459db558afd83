"""Verbs of the documented formulas, which stand in `theory`."""
