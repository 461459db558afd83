"""Batches, shown."""
