"""What cuts of planar faces share: layers, patches, depth limits, traces."""
