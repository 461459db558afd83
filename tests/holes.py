"""Holes whose effect is a formula, for the tests of planning."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from autobalance.correction.contract import Count
from autobalance.correction.drill import DrillCut
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.hole import Hole, keep_apart
from autobalance.correction.holes.sites import Site
from autobalance.correction.holes.surface import Axis
from autobalance.correction.kind import Candidates
from autobalance.rigid_rotor.tolerance import Judge, Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance

Array = NDArray[np.float64]
STEEL = 7.85e-3
RIM = 62.0
EIGHT_WEBS_Z_MM = [-150.0, -110.0, -60.0, -20.0, 20.0, 60.0, 110.0, 150.0]


def holes(
    diameters_mm: Sequence[float],
    webs_z_mm: Sequence[float],
    *,
    places: int = 24,
    step_mm: float = 0.0,
    max_holes: int = 6,
    max_depth_mm: float = 25.0,
) -> Candidates:
    """Radial holes into round webs, evenly all around."""
    cuts: list[DrillCut] = []
    counts: list[Count] = []
    limits = DrillLimits(diameters_mm=tuple(diameters_mm), max_holes=max_holes)
    for web, z in enumerate(webs_z_mm, 1):
        members = []
        for k, diameter in itertools.product(range(places), diameters_mm):
            angle = 2.0 * math.pi * k / places
            out = np.array([math.cos(angle), math.sin(angle), 0.0])
            axis = Axis(RIM * out + np.array([0.0, 0.0, z]), -out)
            hole = Hole(axis, 0.5 * diameter, math.radians(59.0), 1.0, Moments.zero(), 0.0, 0.0)
            site = Site(web, angle, axis, np.zeros((0, 3, 3)), 1.0)
            members.append(len(cuts))
            cuts.append(DrillCut(hole, site, STEEL, limits, 2.0, max_depth_mm, step_mm, "max_depth_mm"))
        counts.append(Count(tuple(members), max_holes, f"max_holes = {max_holes} in web {web}"))
    apart = keep_apart([cut.hole for cut in cuts], [cut.max_depth_mm for cut in cuts], 3.0)
    return Candidates(tuple(cuts), apart=apart, counts=tuple(counts))


def tolerance(permissible: float, judge: Judge = "dynamic", half_mm: float = 60.0) -> Tolerance:
    return Tolerance.of(
        grade_mm_s=permissible,
        service_speed_rad_s=1.0,
        rotor_mass_g=1.0,
        z_centre_mm=0.0,
        planes_z_mm=(-half_mm, half_mm),
        judge=judge,
    )


def at_planes(a: complex, b: complex, half_mm: float = 40.0) -> Unbalance:
    planes = np.array([[a.real, a.imag], [b.real, b.imag]])
    return Unbalance.of_planes(planes, -half_mm, half_mm)


def mass_g(candidates: Candidates, depths_mm: Array) -> float:
    return sum(-c.effect(float(d)).mass_g for c, d in zip(candidates.cuts, depths_mm, strict=True) if d > 0.0)


def assert_rules_are_kept(candidates: Candidates, depths_mm: Array) -> None:
    for cut, depth in zip(candidates.cuts, depths_mm, strict=True):
        assert depth == 0.0 or cut.least_depth_mm - 1e-9 <= depth <= cut.max_depth_mm + 1e-9
        if cut.depth_step_mm:
            assert depth / cut.depth_step_mm == pytest.approx(round(depth / cut.depth_step_mm), abs=1e-6)
    for rule in candidates.counts:
        assert sum(depths_mm[k] > 0.0 for k in rule.members) <= rule.most
    for pair in candidates.apart:
        both = min(depths_mm[pair.first], depths_mm[pair.second])
        if both > 0.0:
            assert max(depths_mm[pair.first], depths_mm[pair.second]) <= pair.most_mm + 1e-6
