"""Recorded signals: records, spectra, angle, orders, maps, modes, bearings; numbers in, numbers out."""
