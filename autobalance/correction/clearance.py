"""Walls and spacing on a scan, with clearance for its roughness."""

from __future__ import annotations

import math
from dataclasses import replace

from autobalance.correction.contract import Limits
from autobalance.crank.anatomy import Anatomy

CLEARANCE_STEP_MM = 0.01
"""Step to which roughness is rounded up as clearance, since messages name walls."""


def clear_of_roughness(limits: Limits, anatomy: Anatomy) -> Limits:
    """Return limits whose walls and spacing hold on the surface below a scan's waves too."""
    if anatomy.scan is None:
        return limits
    waves = math.ceil(anatomy.scan.roughness_mm / CLEARANCE_STEP_MM) * CLEARANCE_STEP_MM
    walls = {name: getattr(limits, name, None) for name in ("min_wall_mm", "min_spacing_mm")}
    return replace(limits, **{name: wall + waves for name, wall in walls.items() if wall is not None})
