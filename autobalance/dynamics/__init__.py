"""Rotating and vibrating systems: beam rotors, torsion, speed control, balancing machines, trial weights."""
