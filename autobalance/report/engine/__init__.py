"""Forces and cycles, shown."""
