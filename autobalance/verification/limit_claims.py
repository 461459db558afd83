"""Checks of a report's limits against the job file, and of its cuts against these limits."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from autobalance.correction.contract import Limits
from autobalance.correction.holes.sites import in_sectors
from autobalance.errors import AutobalanceError, ClaimError
from autobalance.job import describe
from autobalance.job.read import load
from autobalance.verification.claims import Claims
from autobalance.verification.solids import Files

KEY = "job.correction"
DEEPER_MM = 2e-3
"""Greatest excess of a depth over its limit: rounding of a file moves faces."""
THINNER_MM = 5e-3
"""Greatest shortfall of a wall from its limit: walls are printed to hundredths, limits are exact."""
OFF_POSITION_DEG = 3.0
"""Greatest angle between a position and the axis of an old hole that counts as the one there."""
BESIDE_DEG = 0.05


def check_limits_of_job(claims: Claims, folder: Path, files: Files) -> None:
    """Check the correction's limits against the job file, where it exists.

    A job that was changed after its run proves nothing of the report: then a warning says where they differ.

    Raises
    ------
    ClaimError
        If they differ, and the job file is older than the report.
    """
    claims.against("the job file")
    job = claims.get("job", dict)
    name, settings = job.get("file"), claims.values.get("job_set", [])
    path = folder / name if isinstance(name, str) and name else None
    if path is None or not path.is_file():
        claims.ledger.why_not[KEY] = "its job file is not there; only the cuts were held against these limits"
        return
    try:
        in_file = files.once(("limits", str(path), repr(settings)), lambda: _limits_in(path, settings))
    except AutobalanceError:
        claims.ledger.why_not[KEY] = f"{path.name} can not be read as the job that ran"
        return
    differs = _first_difference(in_file, job.get("correction"), KEY)
    if differs is None:
        claims.hold(KEY)
        return
    difference = f"{differs} in {path}"
    report = folder / claims.name
    if report.is_file() and path.stat().st_mtime <= report.stat().st_mtime:
        raise ClaimError(f"{claims.name}: {difference}")
    claims.ledger.why_not[KEY] = f"{path.name} was changed after the run"
    claims.warnings.append(f"{path.name} was changed after the run: {difference}")


def _limits_in(path: Path, settings: Any) -> Any:
    """Return ``[correction]`` of a job file as a report has it."""
    return json.loads(json.dumps(describe(load(path, tuple(map(str, settings))))["correction"]))


def _first_difference(in_file: Any, reported: Any, place: str) -> str | None:
    """Return the first difference between a job file and a report's echo of it, in words; None if equal."""
    if not (isinstance(in_file, dict) and isinstance(reported, dict)):
        return None if in_file == reported else f"{place} is {reported!r}, but it is {in_file!r}"
    keys = [*in_file, *(key for key in reported if key not in in_file)]
    every = (_first_difference(in_file.get(key), reported.get(key), f"{place}.{key}") for key in keys)
    return next((each for each in every if each is not None), None)


def check_within_limits(part: Claims, limits: Limits | None) -> None:
    """Refuse a cut beyond its limits of depth, wall, positions or sectors.

    Raises
    ------
    ClaimError
        If it does not.
    """
    kind = part.get("kind", str)
    sunk = part.values.get("deepened_from_mm")
    depth = abs(part.get("depth_mm", float)) + (
        0.0 if sunk is None else float(part.get("deepened_from_mm", float))
    )
    most = getattr(limits, "max_depth_mm", None)
    if most is not None and depth > most + DEEPER_MM:
        raise ClaimError(
            f"{part.name}: {part.path('depth_mm')} makes {depth:.9g}; job.correction.{kind}.max_depth_mm "
            f"is {most:.9g}"
        )
    left = 0.0 if part.values.get("depth_left_mm") is None else float(part.get("depth_left_mm", float))
    if left < -DEEPER_MM:
        raise ClaimError(f"{part.name}: {part.path('depth_left_mm')} is {left:.9g}; expected at least 0")
    if most is not None and depth + left > most + DEEPER_MM:
        raise ClaimError(
            f"{part.name}: {part.path('depth_left_mm')} is {left:.9g} beyond {depth:.9g}; "
            f"job.correction.{kind}.max_depth_mm is {most:.9g}"
        )
    least, wall = getattr(limits, "min_wall_mm", None), part.values.get("wall_left_mm")
    if least is not None and wall is not None and not part.values.get("fills_a_hole"):
        wall = part.get("wall_left_mm", float)
        if wall < least - THINNER_MM:
            raise ClaimError(
                f"{part.name}: {part.path('wall_left_mm')} is {wall:.9g}; job.correction.{kind}.min_wall_mm "
                f"is {least:.9g}"
            )
    positions = getattr(limits, "positions", None)
    if positions is not None:
        angle = part.get("angle_deg", float)
        if all(abs(math.remainder(angle - each[0], 360.0)) > OFF_POSITION_DEG for each in positions):
            raise ClaimError(
                f"{part.name}: {part.path('angle_deg')} is {angle:.9g}, at none of "
                f"job.correction.{kind}.positions"
            )
    sectors = getattr(limits, "sectors_deg", None)
    if sectors is not None:
        angle = part.get("angle_deg", float)
        near = (angle - BESIDE_DEG, angle, angle + BESIDE_DEG)
        if not any(in_sectors(math.radians(each), sectors) for each in near):
            raise ClaimError(
                f"{part.name}: {part.path('angle_deg')} is {angle:.9g}, outside of "
                f"job.correction.{kind}.sectors_deg"
            )
