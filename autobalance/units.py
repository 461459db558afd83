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
M_PER_MM: Final = 1e-3
STEEL_KG_M3: Final = 7850.0
"""Density taken where none is stated."""

G_PER: Final = {"g": 1.0, "kg": G_PER_KG, "oz": G_PER_OZ, "lb": 16.0 * G_PER_OZ}
"""Grams in one unit of mass."""
G_MM_PER: Final = {"g·mm": 1.0, "kg·mm": G_PER_KG, "g·cm": 10.0, "g·in": 25.4, "oz·in": G_MM_PER_OZ_IN}
"""Gram-millimetres in one unit of unbalance."""

G_MM2_PER_KG_MM2: Final = 1000.0
"""g·mm² in one kg·mm²."""
N_PER_G_MM_S2: Final = 1e-6
"""Newtons in one g·mm/s²."""
N_M_PER_G_MM2_S2: Final = 1e-9
"""Newton-metres in one g·mm²/s²."""
BAR_PER_MPA: Final = 10.0
"""Bars in one MPa (N/mm²)."""
N_M_PER_N_MM: Final = 1e-3
"""Newton-metres (joules) in one newton-millimetre."""
N_MM_PER_N_M: Final = 1e3
MPA_PER_GPA: Final = 1e3
UM_PER_MM: Final = 1e3
KG_PER_G: Final = 1e-3
M3_PER_MM3: Final = 1e-9
KG_MM2_PER_G_MM2: Final = 1e-3
KG_M2_PER_G_MM2: Final = 1e-9
KG_M2_PER_KG_MM2: Final = 1e-6
G_S2_PER_N_MM: Final = 1e6
"""g/s² in one N/mm, for stiffness in mm, g, s."""


def wrapped_deg(angle_deg: float) -> float:
    """Return an angle as one of 0 to below 360 degrees.

    Examples
    --------
    >>> wrapped_deg(-90.0), wrapped_deg(-1e-15)
    (270.0, 0.0)
    """
    return angle_deg % 360.0 % 360.0  # twice: −1e-15 % 360 is 360 itself
