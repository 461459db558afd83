"""Corrections as they were measured tool by tool: on true surfaces, or on the metal of a scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.balancing.rotor import Rotor
from autobalance.correction.contract import Correction
from autobalance.correction.cut import Made, as_taken
from autobalance.correction.faces.patches import face_frame
from autobalance.correction.outline import listed_outline, loops_area_mm2, side_of
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

if TYPE_CHECKING:
    from autobalance.solid.cad.taken import EachTaken


def one_by_one(
    rotor: Rotor, cut_depths: Made, removed: Sequence[EachTaken], added: Sequence[EachTaken]
) -> tuple[Correction | None, ...]:
    """Return the corrections of cuts as measured, one a cut; None where no metal went or came.

    ``removed`` and ``added`` are what the tools of the cuts took and added, each in the order of the cuts.
    """
    takes, adds = iter(removed), iter(added)
    measured: list[Correction | None] = []
    for cut, depth in cut_depths:
        if cut.exact_tool(depth) is None:
            measured.append(None)
            continue
        took = next(adds if cut.adds_metal else takes)
        measured.append(_measured(rotor, cut.correction(depth), cut.pressed_in(depth), took, cut.adds_metal))
    return tuple(measured)


def _measured(rotor: Rotor, planned: Correction, pressed_in: Any, took: EachTaken, adds: bool) -> Correction:
    frame, sign = rotor.anatomy.file_to_rotor, 1.0 if adds else -1.0
    density = sign * rotor.density_g_mm3
    change = took.volume.moved(frame).scaled(density) + pressed_in
    rate = None
    details: dict[str, Any] = {}
    area = 0.0
    if took.floor is not None and took.floor.mass_g > 0.0 and planned.axis is not None:
        rate, area = took.floor.moved(frame).scaled(density), took.floor.mass_g
        details = _outline(took, sign * planned.axis, frame)
        details |= {"area_mm2": area} if "area_mm2" in planned.details else {}
        details |= {"entry_lift_mm": took.lift_mm} if took.lift_mm > 0.0 else {}
    correction = as_taken(planned, change, rate, area, -sign * took.volume.mass_g, **details)
    if "outline" in details:
        volume = (abs(correction.depth_mm) + took.lift_mm) * loops_area_mm2(details["outline"])
        correction = replace(correction, tool_volume_mm3=volume)
    return correction if took.hole is None else _in_old_hole(correction, frame @ took.hole)


def taken_of_scan(
    rotor: Rotor, left: Solid, cut_depths: Made, corrections: Sequence[Correction]
) -> tuple[Correction, ...]:
    """Return corrections as measured on the metal that each tool takes of a rough surface, one after another.

    ``left`` is what all of them take, in the file's axes: each boolean with the whole scan takes as long as
    cutting it. Where that begins is planned on the fitted plane; how much it is, its waves and rounded edges
    decide.
    """
    frame = rotor.anatomy.file_to_rotor
    measured = []
    for (cut, depth), planned in zip(cut_depths, corrections, strict=True):
        if cut.adds_metal:
            measured.append(planned)
            continue
        metal, left = left.split(cut.tool(depth).moved(rotor.anatomy.rotor_to_file))
        if metal.is_empty:
            measured.append(planned)
            continue
        change = cut.pressed_in(depth) - metal.moments(rotor.density_g_mm3, frame)
        area = planned.details.get("new_face_area_mm2", 0.0)
        measured.append(as_taken(planned, change, None, area, metal.volume_mm3))
    return tuple(measured)


def _outline(took: EachTaken, normal: Array, frame: Array) -> dict[str, Any]:
    """Return the outline of the new face in the rotor frame, or in separate axes where it is askew."""
    from autobalance.solid.cad.taken import flat_loops

    to_face = face_frame(normal)
    to_rotor = np.eye(4)
    to_rotor[:3, :3] = to_face[:3, :3].T
    plane = frame if side_of(normal) is not None else to_face @ frame
    return listed_outline(flat_loops(took.loops, plane), to_rotor)


def _in_old_hole(correction: Correction, placement: Array) -> Correction:
    """Return the correction of a drill that ran along a hole that was there."""
    inward, entry = placement[:3, 2], placement[:3, 3]
    details = dict(correction.details) | {"inward": [float(v) for v in inward]}
    if details.get("entry_mm") is not None:
        sunk = float(details["deepened_from_mm"])
        details["entry_mm"] = [float(v) for v in entry - sunk * inward]
    return replace(correction, position_mm=entry, axis=inward, details=details)
