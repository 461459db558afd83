"""Balance shafts."""
