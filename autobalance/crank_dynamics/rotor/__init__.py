"""A shaft on bearings: critical speeds, modes, unbalance response, balancing."""
