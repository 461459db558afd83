"""Checks of values that follow from the job and the measured moments."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.balancing.assembly_from_job import staged_assembly
from autobalance.correction import KINDS
from autobalance.correction.holes.trace import SlugTrace
from autobalance.crank.anatomy import Anatomy
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance, TolerancePlane
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.running_gear.balance_factor import bob_weight_moments
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM
from autobalance.verification.claims import ROUNDING, Claims
from autobalance.verification.solids import keys_of_pressed_in

MOMENT_ROUNDING = 1e-11
"""Rounding of unbalances as a share of mass times size: the run summed in the same order."""


def check_tolerance(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments) -> Tolerance:
    """Check the tolerance; return it as the job makes it."""
    tolerance = rotor_from_job.tolerance_of(job, anatomy, crank)
    speed_rpm = job.balance.service_speed_rad_s / RAD_S_PER_RPM
    claims.near("tolerance.grade_mm_s", tolerance.grade_mm_s, tolerance.grade_mm_s)
    claims.near("tolerance.speed_rpm", speed_rpm, speed_rpm)
    claims.near("tolerance.rotor_mass_g", tolerance.rotor_mass_g, tolerance.rotor_mass_g)
    claims.near("tolerance.permissible_g_mm", tolerance.permissible_g_mm, tolerance.permissible_g_mm)
    claims.same("tolerance.judge", tolerance.judge)
    if "margin" in claims.get("tolerance", dict) or tolerance.margin != "none":
        claims.same("tolerance.margin", tolerance.margin)
    _check_planes(claims, "tolerance.planes", tolerance.planes)
    if "others" in claims.get("tolerance", dict) or tolerance.others:
        listed = claims.entries("tolerance.others", len(tolerance.others))
        for part, other in zip(listed, tolerance.others, strict=True):
            part.same("meant", other.meant)
            _check_planes(part, "planes", other.planes)
    return tolerance


def _check_planes(claims: Claims, key: str, planes: Sequence[TolerancePlane]) -> None:
    for part, plane in zip(claims.entries(key, len(planes)), planes, strict=True):
        part.same("name", plane.name)
        part.near("z_mm", plane.z_mm, max(abs(plane.z_mm), 1.0))
        part.near("permissible_g_mm", plane.permissible_g_mm, plane.permissible_g_mm)
    if not planes:
        claims.same(key, [])


def check_loads(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments) -> Moments:
    """Check target factor and bob-weights; return the moments of bob-weights and attached rotors."""
    factor = rotor_from_job.target_factor(job, anatomy, crank)
    claims.near("balance_factor.target", factor, 1.0)
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    for part, load in zip(claims.entries("engine.bob_weights", len(loads)), loads, strict=True):
        part.near("mass_g", load.parts.bob_weight_g(factor), load.parts.bob_weight_g(factor))
    return bob_weight_moments(loads, factor) + rotor_from_job.beside_throws(job.engine)


def check_unbalance(
    claims: Claims, key: str, unbalance: Unbalance, tolerance: Tolerance, size_g_mm: float
) -> None:
    """Check an unbalance in all its forms: resultant, angle, moment, planes."""
    claims.near(f"{key}.unbalance_g_mm", unbalance.resultant_g_mm, size_g_mm, MOMENT_ROUNDING)
    claims.near(f"{key}.magnitude_g_mm", unbalance.magnitude_g_mm, size_g_mm, MOMENT_ROUNDING)
    claimed = claims.array(f"{key}.unbalance_g_mm", (2,))
    angle = math.degrees(math.atan2(claimed[1], claimed[0]))
    claims.near_angle(f"{key}.angle_deg", angle, 360.0 * ROUNDING)
    places = [plane.z_mm for plane in tolerance.planes]
    span = (max(places) - min(places)) if places else 1.0
    claims.near(f"{key}.moment_g_mm2", unbalance.moment_g_mm2, size_g_mm * max(span, 1.0), MOMENT_ROUNDING)
    vectors: Sequence[Array] = list(unbalance.in_planes(places[0], places[1])) if places else []
    for name, part, vector in zip("AB", claims.entries(f"{key}.planes", len(vectors)), vectors, strict=False):
        part.same("name", name)
        part.near("unbalance_g_mm", vector, size_g_mm, MOMENT_ROUNDING)
        part.near("magnitude_g_mm", math.hypot(*vector), size_g_mm, MOMENT_ROUNDING)


def check_after(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments, after: Moments) -> None:
    """Check the balance factor before and after correction."""
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    attached = rotor_from_job.beside_throws(job.engine)
    for key, moments in (("initial", crank), ("final", after)):
        factor = rotor_from_job.crank_factor(moments, loads, attached)
        if factor is None:
            claims.same(f"balance_factor.{key}", None)
        else:
            claims.near(f"balance_factor.{key}", factor, 10.0)


def check_inertia(claims: Claims, crank: Moments, after: Moments) -> None:
    """Check the change of polar inertia, with that of slugs about their own axes by their sizes."""
    change = after.polar_inertia_g_mm2 - crank.polar_inertia_g_mm2
    for part in claims.entries("corrections"):
        keys = keys_of_pressed_in(part)
        if keys is None or part.get("depth_mm", float) == 0.0:  # nothing pressed in, or kept and not made
            continue
        trace = KINDS[part.get("kind", str)].trace(part.values)
        if not isinstance(trace, SlugTrace):
            claims.ledger.why_not["inertia_change_kg_mm2"] = (
                "what is pressed in has a shape that is not known"
            )
            return
        point = Moments.point(part.get(keys[0], float), part.array(keys[1], (3,)))
        change += trace.slug().polar_inertia_g_mm2 - point.polar_inertia_g_mm2
    claims.near("inertia_change_kg_mm2", change / 1000.0, crank.polar_inertia_g_mm2 / 1000.0)


def check_assembly(
    claims: Claims, job: Job, tolerance: Tolerance, residual: Unbalance, size_g_mm: float
) -> None:
    """Check the unbalance after each mounted part, in their order."""
    if not job.assembly:
        return
    stages = staged_assembly(job, tolerance, residual)
    for part, stage in zip(claims.entries("assembly", len(stages)), stages, strict=True):
        total = np.array([stage.sum_g_mm.real, stage.sum_g_mm.imag])
        part.near("sum.unbalance_g_mm", total, size_g_mm, MOMENT_ROUNDING)
        part.near("permissible_g_mm", stage.permissible_g_mm, stage.permissible_g_mm)
        part.near("left", np.array([stage.left_g_mm.real, stage.left_g_mm.imag]), size_g_mm, MOMENT_ROUNDING)
        part.same("within", stage.within)
