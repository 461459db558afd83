"""A rotor under speed control in its bearings, beside measured torques."""
