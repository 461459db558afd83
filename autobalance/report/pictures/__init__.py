"""Pictures of solids."""
