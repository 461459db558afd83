"""Rotors, torsion and rotor benches, shown."""
