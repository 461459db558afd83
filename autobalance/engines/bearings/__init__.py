"""Bearings: friction, oil films, the film through a cycle. SI inside; where not, the unit ends the name."""
