"""Engines: forces, balance shafts, parts, rods, the working cycle, mounts and bearings."""
