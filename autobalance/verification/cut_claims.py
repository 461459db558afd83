"""Where a report says that cuts begin: its numbers must agree with one another."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from autobalance.errors import ClaimError

if TYPE_CHECKING:
    from autobalance.verification.claims import Claims

UNIT_LENGTH = 1e-9
"""How far the length of a stated direction may be off 1."""


def check_places(claims: Claims) -> None:
    """Check angle, z, radius of entry and direction of feed of each correction against its position.

    Keys that a report of an earlier version does not have are not asked for.
    """
    for place, values in enumerate(claims.get("corrections", list), 1):
        part = type(claims)(f"{claims.name}: corrections[{place}]", values)
        x, y, z = part.array("position_mm", (3,))
        size = max(math.hypot(x, y, z), 1.0)
        if values.get("angle_deg") is not None:
            turn = math.radians(part.get("angle_deg", float))
            radius = math.hypot(x, y)
            part.near("position_mm", np.array([radius * math.cos(turn), radius * math.sin(turn), z]), size)
        if values.get("z_mm") is not None and values.get("entry_radius_mm") is not None:
            part.near("z_mm", z, size)
            part.near("entry_radius_mm", math.hypot(x, y), size)
        if values.get("inward") is not None:
            inward = part.array("inward", (3,))
            if abs(float(np.linalg.norm(inward)) - 1.0) > UNIT_LENGTH:
                raise ClaimError(f"{part.name}.inward: {inward.tolist()} is no unit vector")
        claims.held += part.held
