"""Common parts of cuts of planar faces: layers, patches, depth limits, traces."""
