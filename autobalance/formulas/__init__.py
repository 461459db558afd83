"""Verbs of the documented formulas, which are in `theory`."""
