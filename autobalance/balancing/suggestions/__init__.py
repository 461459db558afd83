"""What metal to take or add, and which sizes, for what a user asked for."""
