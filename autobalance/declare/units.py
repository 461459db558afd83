"""Units of fields and their keys: the endings of both names, and the way from one unit to the other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Final

from autobalance.units import BAR_PER_MPA, G_MM2_PER_KG_MM2, M_PER_MM, N_M_PER_N_MM, RAD_S_PER_RPM


@dataclass(frozen=True)
class Unit:
    """Unit outside of a field whose name ends in another: outside = inside · ``times`` / ``over``.

    Two numbers, because one of them is exact: 0.3 MPa is 3.0 bar as 0.3 · 10, and not as 0.3 / 0.1.
    """

    inside: str
    outside: str
    times: float = 1.0
    over: float = 1.0

    def key(self, name: str) -> str:
        """Return the key of a field.

        Raises
        ------
        TypeError
            If the field's name does not end in its unit.
        """
        if not name.endswith(self.inside):
            raise TypeError(f"{name}: a field whose key ends in {self.outside} must end in {self.inside}")
        return name.removesuffix(self.inside) + self.outside

    def written(self, number: float) -> float:
        """Return a number of the field's unit in the key's."""
        return number * self.times / self.over

    def read(self, number: float) -> float:
        """Return a number of the key's unit in the field's."""
        return number * self.over / self.times


DEGREES: Final = Unit("_rad", "_deg", times=180.0 / math.pi)
MRAD: Final = Unit("_rad", "_mrad", times=1e3)
RPM: Final = Unit("_rad_s", "_rpm", over=RAD_S_PER_RPM)
HERTZ: Final = Unit("_rad_s", "_hz", over=2.0 * math.pi)
KG_MM2: Final = Unit("_g_mm2", "_kg_mm2", over=G_MM2_PER_KG_MM2)
BAR: Final = Unit("_mpa", "_bar", times=BAR_PER_MPA)
MPA: Final = Unit("_pa", "_MPa", over=1e6)
GPA: Final = Unit("_pa", "_gpa", over=1e9)
JOULES: Final = Unit("_n_mm", "_J", times=N_M_PER_N_MM)
NEWTONS: Final = Unit("_n", "_N")
NEWTON_METRES: Final = Unit("_n_m", "_N_m")
MM: Final = Unit("_m", "_mm", over=M_PER_MM)
UM: Final = Unit("_m", "_um", times=1e6)
MM3_S: Final = Unit("_m3_s", "_mm3_s", times=1e9)
G_MM: Final = Unit("_kg_m", "_g_mm", times=1e6)
KG_MM2_OF_SI: Final = Unit("_kg_m2", "_kg_mm2", times=1e6)

Degrees = Annotated[float, DEGREES]
Mrad = Annotated[float, MRAD]
Rpm = Annotated[float, RPM]
Hertz = Annotated[float, HERTZ]
KgMm2 = Annotated[float, KG_MM2]
Bar = Annotated[float, BAR]
Mpa = Annotated[float, MPA]
Joules = Annotated[float, JOULES]
Newtons = Annotated[float, NEWTONS]
NewtonMetres = Annotated[float, NEWTON_METRES]
