"""Pictures without a graphics library: z-buffer, lettering, polar plots."""
