"""Design searches, shown."""
