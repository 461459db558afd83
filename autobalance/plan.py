"""Choose the parameters of a correction; pure numbers."""
