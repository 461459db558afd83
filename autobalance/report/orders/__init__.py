"""Spectra and orders, shown."""
