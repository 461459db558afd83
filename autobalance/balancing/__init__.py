"""A crank and a job become a rotor that is balanced; solids in, solids out."""
