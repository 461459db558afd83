"""Zones of a web for holes, and the fillets beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from autobalance.crank.anatomy import Anatomy, Pin, Web
from autobalance.types import Array

Zone = Literal["counterweights", "web", "anywhere"]
ON_AXIS = 1e-9
"""Length up to which a direction counts as zero, for rounding."""
ON_EDGE_RAD = 1e-9
"""Angle up to which a place is on the edge of its zone: rounding."""
MOST_FILLET_SHARE = 0.25
"""Longest fillet, as a share of the radius of its cylinder."""
FILLET_GRAIN = 1e-3
"""Corners of a fillet's facets lie off its circle by up to this share of the radius."""


def in_zone(anatomy: Anatomy, web: Web, angle_rad: float, zone: Zone) -> bool:
    """Return whether an angle lies in a web's counterweight, or on the web's half away from its crankpins.

    The counterweight is the arc that its rim spans; where the rim is not known, that half.
    """
    if zone == "anywhere":
        return True
    towards = sum((throw.direction for throw in anatomy.throws_of(web)), np.zeros(2))
    size = float(np.linalg.norm(towards))
    if zone == "counterweights" and not web.counterweight:
        return False
    if size < ON_AXIS:
        return True
    away = math.atan2(-float(towards[1]), -float(towards[0]))
    half, middle = 0.5 * math.pi, away
    if zone == "counterweights" and web.outline is not None:
        half, middle = min(half, 0.5 * web.outline.fan_angle_rad), away + web.outline.skew_rad
    return abs(math.remainder(angle_rad - middle, math.tau)) <= half + ON_EDGE_RAD


def least_radius_mm(anatomy: Anatomy, web: Web, zone: Zone) -> float:
    """Return the radius at which a counterweight begins: that of the main journals and fillets beside it."""
    if zone != "counterweights":
        return 0.0
    fillets = (fillet_of(journal, web) for journal in anatomy.main_journals)
    return max((each.radius_mm + each.least_mm for each in fillets if each is not None), default=0.0)


@dataclass(frozen=True, eq=False)
class Fillet:
    """Fillet between a cylinder and a web, rotor frame.

    It begins at the end ``z_mm`` of the bare cylinder, runs towards the web (``sense`` along z), and is
    nowhere higher than it is long, at any radius; ``least_mm`` and ``most_mm`` bound its length.
    """

    centre_mm: Array
    radius_mm: float
    z_mm: float
    sense: float
    least_mm: float
    most_mm: float

    def holds(self, corners: Array) -> NDArray[np.bool_]:
        """Return whether triangles (m, 3, 3) lie in it with all corners."""
        rise = np.hypot(corners[:, :, 0] - self.centre_mm[0], corners[:, :, 1] - self.centre_mm[1])
        rise -= self.radius_mm
        along = self.sense * (corners[:, :, 2] - self.z_mm)
        slack = FILLET_GRAIN * self.radius_mm
        inside = (rise <= along + slack) & (along >= -slack) & (along <= self.most_mm + slack)
        held: NDArray[np.bool_] = inside.all(axis=1)
        return held


def fillets_of(anatomy: Anatomy, web: Web) -> tuple[Fillet, ...]:
    """Return the fillets on both sides of a web."""
    pins: list[Pin] = [*anatomy.main_journals, *(throw.crankpin for throw in anatomy.throws)]
    fillets = (fillet_of(pin, web) for pin in pins)
    return tuple(each for each in fillets if each is not None)


def in_fillets(corners: Array, fillets: tuple[Fillet, ...]) -> NDArray[np.bool_]:
    """Return whether triangles (m, 3, 3) are part of a fillet."""
    held = np.zeros(len(corners), dtype=bool)
    for each in fillets:
        held |= each.holds(corners)
    return held


def fillet_of(pin: Pin, web: Web) -> Fillet | None:
    """Return the fillet of a cylinder at a web; None where the cylinder is not beside that web.

    A web with a counterweight thicker than its hub begins, as it was recognised, above the fillet.
    """
    radius = 0.5 * pin.diameter_mm
    low, high = pin.z_range_mm
    middle = 0.5 * (web.z_min_mm + web.z_max_mm)
    below = high < middle
    gap = web.z_min_mm - high if below else low - web.z_max_mm
    if gap > radius:
        return None
    end, sense = (high, 1.0) if below else (low, -1.0)
    most = min(MOST_FILLET_SHARE * radius, abs(middle - end))
    return Fillet(pin.centre_mm, radius, end, sense, min(max(gap, 0.0), most), most)
