"""Conversions at the border. Inside everything is mm, g, s, rad."""

from typing import Final

MM_PER: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": 25.4}
"""Millimetres in one unit of length, by the name a job file uses."""

G_PER_OZ: Final = 28.349523125
G_PER_KG: Final = 1000.0
G_MM_PER_OZ_IN: Final = G_PER_OZ * 25.4
"""720.0778874 g·mm in one oz·in."""

RAD_S_PER_RPM: Final = 2.0 * 3.141592653589793 / 60.0
G_PER_MM3_PER_KG_M3: Final = 1e-6
"""1 kg/m³ in g/mm³."""
