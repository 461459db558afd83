"""A job's own statements on a crank: its axis, journals and crankpins."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.crank.anatomy import Overrides, PinHint
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.errors import RecognitionError
from autobalance.types import Array


def without_given_keys(text: str, overrides: Overrides) -> str:
    """Return a refusal that asks for what is missing beside ``main_journals`` or ``crankpins``.

    Recognition is skipped only where both exist; the key that is there is not requested again.
    """
    hints_by_name = {name: getattr(overrides, name) for name in ("main_journals", "crankpins")}
    fault, remedy, advice = text.rpartition(". Set ")
    (there, hints), *more = [(name, hints) for name, hints in hints_by_name.items() if hints is not None] or [
        ("", ())
    ]
    if more or not remedy or not there or there not in advice:
        return text
    missing = [name for name in hints_by_name if name != there]
    if there == "main_journals" and len(hints) < 2 and overrides.axis_direction is None:
        missing.append("axis_direction")
    return f"{fault}. Set {' and '.join(missing)} as well as {there}"


def given_axis(overrides: Overrides) -> tuple[Array | None, Array] | None:
    """Return a job's axis as (point or None, direction), stated or by two main journals; None without."""
    if overrides.axis_direction is not None:
        point = overrides.axis_point_mm
        if point is None and overrides.main_journals:
            point = np.mean([hint.centre_mm for hint in overrides.main_journals], axis=0)
        return point, upright(overrides.axis_direction)
    if overrides.main_journals is not None and len(overrides.main_journals) > 1:
        centres = np.array([hint.centre_mm for hint in overrides.main_journals])
        middle = centres.mean(axis=0)
        direction = np.linalg.svd(centres - middle)[2][0]
        if float(np.ptp(centres @ direction)) > 0.0:
            point = middle if overrides.axis_point_mm is None else overrides.axis_point_mm
            return point, upright(direction)
    return None


def upright(direction: Array) -> Array:
    """Return the unit vector along ``direction`` whose largest component is positive (the frame's rule)."""
    length = float(np.linalg.norm(direction))
    if not (length > 0.0 and math.isfinite(length)):
        raise RecognitionError("axis_direction has no length; it needs three numbers, not all zero")
    unit = np.asarray(direction, dtype=np.float64) / length
    size = np.abs(unit)
    first = int(np.flatnonzero(size >= size.max() - 1e-6)[0])
    return unit if unit[first] > 0.0 else -unit


def hinted(long: SectionStack, hint: PinHint, runs: Sequence[CylinderRun], key: str) -> CylinderRun:
    """Return the cylinder of a job's hint, completed from the one recognised there."""
    centre = long.placed(hint.centre_mm)
    there = [
        run
        for run in runs
        if run.z_low <= centre[2] <= run.z_high
        and float(np.linalg.norm(run.centre - centre[:2])) < 0.1 * run.radius
    ]
    if (hint.diameter_mm is None or hint.width_mm is None) and not there:
        text = ", ".join(f"{value:g}" for value in hint.centre_mm)
        raise RecognitionError(
            f"{key} names a cylinder at [{text}] mm without its diameter or width, and none was found there; "
            "give diameter_mm and width_mm"
        )
    radius = there[0].radius if hint.diameter_mm is None else 0.5 * hint.diameter_mm
    width = there[0].width if hint.width_mm is None else hint.width_mm
    middle = there[0].z_mid if hint.width_mm is None else float(centre[2])
    return CylinderRun(centre[:2], radius, middle - 0.5 * width, middle + 0.5 * width)
