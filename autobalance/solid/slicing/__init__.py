"""Cross-sections, slabs, and the independent measurement by slices."""
