"""Checks of a report's limits against the job file, and of its cuts against these limits."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.correction.contract import Limits
from autobalance.correction.holes.sites import in_sectors
from autobalance.errors import AutobalanceError, ClaimError
from autobalance.job import describe
from autobalance.job.from_options import differences
from autobalance.job.read import load
from autobalance.verification.claims import Claims
from autobalance.verification.solids import Files

KEY = "job.correction"
DEEPER_MM = 2e-3
"""Largest excess of a depth over its limit: rounding of a file moves faces."""
THINNER_MM = 5e-3
"""Largest shortfall of a wall from its limit: walls are printed to hundredths, limits are exact."""
OFF_POSITION_DEG = 3.0
"""Largest angle between a position and the axis of an old hole that counts as the one there."""
BESIDE_DEG = 0.05
MOST_LISTED = 5
"""Changed keys of a job that a warning names."""


def check_limits_of_job(claims: Claims, folder: Path, files: Files) -> None:
    """Check the correction's limits against the job file, if it exists, and repeat its warnings.

    A job that was changed after its run proves nothing about the report; a warning then lists the
    differences.

    Raises
    ------
    ClaimError
        If the limits differ, and the job file is older than the report.
    """
    claims.against("the job file")
    path = _job_file(claims, folder)
    if path is None:
        claims.ledger.why_not[KEY] = (
            "its job file is missing; only the cuts were checked against these limits"
        )
        return
    in_file = _job_now(claims, path, files)
    if in_file is None:
        claims.ledger.why_not[KEY] = f"{path.name} can not be read as the job that ran"
        return
    reported = claims.get("job", dict)
    differs = list(differences(reported.get("correction"), in_file.get("correction"), KEY))
    report = folder / claims.name
    if not differs:
        claims.hold(KEY)
    elif report.is_file() and path.stat().st_mtime <= report.stat().st_mtime:
        key, claimed, there = differs[0]
        raise ClaimError(f"{claims.name}: {key} is {claimed!r}, but it is {there!r} in {path}")
    else:
        claims.ledger.why_not[KEY] = f"{path.name} was changed after the run"
    _warn_of_changes(claims, path, in_file)


def warn_of_changed_job(claims: Claims, folder: Path, files: Files) -> None:
    """Warn of limits that the job file has now and had not in the run; a stage has separate limits."""
    path = _job_file(claims, folder)
    in_file = None if path is None else _job_now(claims, path, files)
    if path is not None and in_file is not None:
        _warn_of_changes(claims, path, {**in_file, "correction": claims.get("job", dict).get("correction")})


def _job_file(claims: Claims, folder: Path) -> Path | None:
    name = claims.get("job", dict).get("file")
    path = folder / name if isinstance(name, str) and name else None
    return path if path is not None and path.is_file() else None


def _job_now(claims: Claims, path: Path, files: Files) -> Mapping[str, Any] | None:
    """Return the job file as a report has it; None, and a warning, if it is not such a job any more."""
    settings = claims.values.get("job_set", [])
    try:
        return files.once(("job", str(path), repr(settings)), lambda: _described(path, settings))
    except AutobalanceError as error:
        claims.warnings.append(
            f"{path.name} was changed after the run and no longer such a job: {str(error).splitlines()[0]}"
        )
        return None


def _described(path: Path, settings: Any) -> Mapping[str, Any]:
    """Return a job file as a report has it."""
    values: Mapping[str, Any] = json.loads(json.dumps(describe(load(path, tuple(map(str, settings))))))
    return values


def _warn_of_changes(claims: Claims, path: Path, in_file: Mapping[str, Any]) -> None:
    reported = {key: value for key, value in claims.get("job", dict).items() if key != "file"}
    here = {key: value for key, value in in_file.items() if key != "file"}
    found = [each.words() for each in differences(reported, here, "job")]
    if not found:
        return
    more = f"; and {len(found) - MOST_LISTED} more" if len(found) > MOST_LISTED else ""
    claims.warnings.append(
        f"{path.name} was changed after the run: {'; '.join(found[:MOST_LISTED])}{more}. "
        "This report is of the job as it was; balance again for the new one"
    )


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
