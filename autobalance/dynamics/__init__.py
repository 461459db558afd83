"""What turns and shakes: beam rotors, torsion, speed control, balancing machines, influence coefficients."""
