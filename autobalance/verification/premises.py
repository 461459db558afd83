"""Premises of a check, taken from the report: job, frame, pins and journals, the crank's moments."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

from autobalance import job as jobs
from autobalance.balancing.external import attached_to
from autobalance.crank.anatomy import (
    Anatomy,
    CounterweightOutline,
    Cylinder,
    CylinderKind,
    CylinderRole,
    Doubt,
    DoubtSubject,
    MainJournal,
    Pin,
    Throw,
    Web,
)
from autobalance.crank.datums import Datums
from autobalance.errors import ClaimError, FormatError, JobError
from autobalance.job import Job
from autobalance.job.model import ThrowOil
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.verification.claims import ROUNDING, Claims

MAX_ROTATION_ERROR = 1e-9
"""Largest absolute entry of RᵀR − 1 in a rotation."""


def claimed_job(claims: Claims, folder: Path) -> Job:
    """Return the job as the report echoes it, with the oil, external parts and density that it claims."""
    raw = without_nulls(claims.get("job", dict))
    file = raw.pop("file", "job")
    try:
        job = jobs.parse(raw, folder / str(file), crank_given=True)
        job = _with_claimed_oil(claims, _with_claimed_external(claims, job))
        return _with_claimed_density(claims, job)
    except JobError as error:
        raise FormatError(f"{claims.name}: job: {error}") from None


def _with_claimed_density(claims: Claims, job: Job) -> Job:
    """Return a job with its report's calibrated density, which the crank's mass proves or disproves."""
    calibration = claims.get("crank", dict).get("calibration")
    if calibration is None or job.crankshaft.weighed.readings.calibrate != "density":
        return job
    density = float(claims.get("crank.calibration.density_kg_m3", float)) * G_PER_MM3_PER_KG_M3
    if not 0.0 < density < math.inf:
        raise FormatError(f"{claims.name}: crank.calibration.density_kg_m3 must be > 0")
    crankshaft = replace(job.crankshaft, density_g_mm3=density)
    return replace(job, crankshaft=crankshaft.weighed_with(density_g_mm3=density))


def density_before(claims: Claims, job: Job) -> float:
    """Return a job's density before calibration [g/mm³]."""
    if job.crankshaft.weighed.readings.calibrate != "density":
        return job.crankshaft.density_g_mm3
    return float(claims.get("job.crankshaft.density_kg_m3", float)) * G_PER_MM3_PER_KG_M3


def _with_claimed_external(claims: Claims, job: Job) -> Job:
    """Return a job with the external parts' claimed unbalances, which the residual proves or disproves."""
    if job.balance.external != "solve":
        return job
    carried = []
    for part, entry in zip(
        job.balance.external_parts, claims.entries("external", len(job.balance.external_parts)), strict=True
    ):
        entry.same("name", part.name)
        entry.near("z_mm", part.z_mm, max(abs(part.z_mm), 1.0))
        carried.append(entry.array("unbalance_g_mm", (2,)))
    return attached_to(job, carried)


def _with_claimed_oil(claims: Claims, job: Job) -> Job:
    """Return a job with the oil that its report claims, which the crank proves or disproves."""
    if job.engine.oil_g_mm3 is None or "oil" not in claims.values:
        return job
    throws, by_throw = claims.entries("crank.throws"), {}
    for part in claims.entries("oil"):
        number = part.get("throw", int)
        if not 1 <= number <= len(throws):
            raise ClaimError(f"{claims.name}: {part.path('throw')} is {number}; the crank has {len(throws)}")
        throw = throws[number - 1]
        centre_mm = throw.at("crankpin", throw.get("crankpin", dict)).array("centre_mm", (3,))
        oil, on_crankpin_g = _moments(part, "centre_mm"), float(part.get("on_crankpin_g", float))
        by_throw[number] = ThrowOil(oil, on_crankpin_g, oil - Moments.point(on_crankpin_g, centre_mm))
    return replace(job, engine=replace(job.engine, oil=by_throw))


def without_nulls(value: Any) -> Any:
    """Return a described job without keys that are None, at any depth."""
    if isinstance(value, dict):
        return {key: without_nulls(item) for key, item in value.items() if item is not None}
    if isinstance(value, list):
        return [without_nulls(item) for item in value]
    return value


def claimed_frame(claims: Claims) -> Array:
    """Return the motion from file to rotor (4, 4); refuse one that is not rigid."""
    frame = claims.array("frame.file_to_rotor", (4, 4))
    turn = frame[:3, :3]
    rigid = np.abs(turn.T @ turn - np.eye(3)).max() <= MAX_ROTATION_ERROR and np.linalg.det(turn) > 0.0
    if not (rigid and frame[3].tolist() == [0.0, 0.0, 0.0, 1.0]):
        raise ClaimError(f"{claims.name}: frame.file_to_rotor is not a rigid motion")
    claims.note("frame.file_to_rotor is a rigid motion", True, True)
    return frame


def claimed_anatomy(claims: Claims) -> Anatomy:
    """Return main journals, throws, webs, cylinders, doubts and datums as a report lists them, in its frame.

    Older reports list neither cylinders nor doubts.
    """
    frame = claimed_frame(claims)
    throws = []
    for number, part in enumerate(claims.entries("crank.throws"), 1):
        pin = _pin(part.at("crankpin", part.get("crankpin", dict)))
        x, y = pin.centre_mm[:2]
        radius, angle = math.hypot(x, y), math.atan2(y, x)
        part.near("crank_radius_mm", radius, radius)
        part.near_angle("angle_deg", math.degrees(angle), 360.0 * ROUNDING)
        part.same("number", number)
        throws.append(Throw(number, radius, angle, pin))
    journals = []
    for number, part in enumerate(claims.entries("crank.main_journals"), 1):
        pin = _pin(part)
        journals.append(MainJournal(pin.centre_mm, pin.diameter_mm, pin.width_mm, number))
    off = claims.get("crank.journal_misalignment_mm", float)
    webs = tuple(_web(part) for part in claims.entries("crank.webs"))
    crank = claims.at("crank", claims.get("crank", dict))
    cylinders = crank.entries("cylinders") if "cylinders" in crank.values else []
    doubts = crank.entries("doubts") if "doubts" in crank.values else []
    return Anatomy(
        frame,
        tuple(journals),
        tuple(throws),
        webs,
        off,
        _datums(claims),
        cylinders=tuple(map(_cylinder, cylinders)),
        doubts=tuple(map(_doubt, doubts)),
    )


def _cylinder(claims: Claims) -> Cylinder:
    offset, angle = claims.get("offset_mm", float), math.radians(claims.get("angle_deg", float))
    centre = np.array([offset * math.cos(angle), offset * math.sin(angle), claims.get("z_mm", float)])
    kind: Any = _one_of(claims, "kind", get_args(CylinderKind))
    role: Any = _one_of(claims, "role", get_args(CylinderRole))
    number = None if claims.get("number", object) is None else claims.get("number", int)
    return Cylinder(
        centre, claims.get("diameter_mm", float), claims.get("width_mm", float), kind, role, number
    )


def _doubt(claims: Claims) -> Doubt:
    def place(key: str) -> Pin:
        part = claims.at(key, claims.get(key, dict))
        centre = np.array([0.0, 0.0, part.get("z_mm", float)])
        return Pin(centre, part.get("diameter_mm", float), part.get("width_mm", float))

    about: Any = _one_of(claims, "about", get_args(DoubtSubject))
    number, setting = claims.get("number", int), claims.get("set", str)
    return Doubt(about, number, place("chosen"), place("other"), setting)


def _datums(claims: Claims) -> Datums | None:
    """Return keyways, flanges and machined faces as a report lists them; None where it lists no datums."""
    if claims.get("crank.datums", object) is None:
        return None
    found = claims.record(Datums, "crank.datums")
    return Datums(found.keyways, found.flanges, found.faces)  # the angle follows: a claim, no premise


def _one_of(claims: Claims, key: str, allowed: Sequence[str]) -> str:
    value = claims.get(key, str)
    if value not in allowed:
        raise FormatError(
            f"{claims.name}: {claims.path(key)} is {value!r}; expected one of {', '.join(allowed)}"
        )
    return str(value)


def _web(claims: Claims) -> Web:
    outline, number = claims.values.get("outline"), claims.get("number", int)
    counterweight = claims.get("counterweight", bool)
    ends = claims.get("z_min_mm", float), claims.get("z_max_mm", float)
    if outline is not None:
        claims = claims.at("outline", claims.get("outline", dict))
        radius, fan = claims.get("rim_radius_mm", float), math.radians(claims.get("fan_angle_deg", float))
        skew = math.radians(claims.get("skew_deg", float) if "skew_deg" in claims.values else 0.0)
        outline = CounterweightOutline(radius, fan, claims.get("thickness_mm", float), skew)
    return Web(number, *ends, counterweight, outline)


def _pin(claims: Claims) -> Pin:
    return Pin(
        claims.array("centre_mm", (3,)), claims.get("diameter_mm", float), claims.get("width_mm", float)
    )


def claimed_crank(claims: Claims) -> Moments:
    """Return the moments of the crank before correction as the report claims them."""
    return _moments(claims.at("crank", claims.get("crank", dict)), "centre_of_mass_mm")


def _moments(claims: Claims, centre_key: str) -> Moments:
    """Return the moments that follow from a listed mass, centre and inertia."""
    mass = float(claims.get("mass_g", float))
    centre = claims.array(centre_key, (3,))
    inertia = 1000.0 * claims.array("inertia_kg_mm2", (3, 3))
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return Moments(mass, mass * centre, second)
