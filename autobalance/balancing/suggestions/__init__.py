"""Suggestions of metal to take or add, and of sizes, for a wanted balance factor or inertia."""
