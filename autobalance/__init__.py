"""Balance crankshafts from their solid models."""

__version__ = "0.1.0"
