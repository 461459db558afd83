"""The crank as an elastic body: rotor on bearings, torsion, bending, strength."""
