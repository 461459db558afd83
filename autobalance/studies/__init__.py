"""Many runs: Monte Carlo tolerance studies and batches of jobs, on this machine or on a cluster."""
