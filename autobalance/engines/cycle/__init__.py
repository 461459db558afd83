"""The working cycle: gas pressure, and what it does to pins, bearings, torque and speed.

Inside this room lengths are mm, masses g, time s, angles rad, pressures MPa (N/mm²), energies N·mm (mJ).
"""
