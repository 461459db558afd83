"""Many runs: what many cranks to one plan would be, and many jobs; here, on all cores, or on a cluster."""
