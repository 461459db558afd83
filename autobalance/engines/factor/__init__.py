"""Candidates for the balance factor: forces that each leaves, metal that each costs."""
