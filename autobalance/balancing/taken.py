"""Corrections as they were measured tool by tool: on true surfaces, or on the metal of a scan."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.balancing.rotor import Rotor
from autobalance.correction.contract import Correction
from autobalance.correction.cut import Made, as_taken
from autobalance.correction.faces.patches import face_frame
from autobalance.correction.outline import listed_outline, loops_area_mm2, side_of
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

if TYPE_CHECKING:
    from autobalance.solid.cad.taken import EachTaken


def one_by_one(
    rotor: Rotor, cut_depths: Made, removed: Sequence[EachTaken], added: Sequence[EachTaken]
) -> tuple[Correction | None, ...]:
    """Return the corrections of cuts as measured, one a cut; None if no metal went or came.

    ``removed`` and ``added`` are the metal that the tools took and added, each in the order of the cuts.
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

    ``left`` is the metal that all of them take, in the file's axes: each boolean with the whole scan takes as
    long as cutting it. Its beginning is planned on the fitted plane; its amount depends on the surface's
    waves and rounded edges.
    """
    removing = [cut.tool(depth) for cut, depth in cut_depths if not cut.adds_metal]
    taken = metal_of_each(left.moved(rotor.anatomy.file_to_rotor), removing)
    measured = []
    for (cut, depth), planned in zip(cut_depths, corrections, strict=True):
        mesh = None if cut.adds_metal else next(taken)
        if mesh is None or not len(mesh.triangles):
            measured.append(planned)
            continue
        metal = mesh_moments(mesh, rotor.density_g_mm3)
        area, volume = planned.details.get("new_face_area_mm2", 0.0), metal.mass_g / rotor.density_g_mm3
        measured.append(as_taken(planned, cut.pressed_in(depth) - metal, None, area, volume))
    return tuple(measured)


def metal_of_each(metal: Solid, tools: Sequence[Solid]) -> Iterator[Mesh]:
    """Yield each tool's part of the metal that all of them take, one after another, all in one frame."""
    low, high = np.array([tool.bounds for tool in tools]).swapaxes(0, 1)
    apart = (low[:, None] > high[None]) | (low[None] > high[:, None])
    if apart.any(axis=2).sum() < len(tools) * (len(tools) - 1):
        for tool in tools:
            taken, metal = metal.split(tool)
            yield taken.mesh
        return
    mesh = metal.mesh  # the boxes hold a piece each: no boolean is needed to tell them from each other
    first = mesh.vertices.take(mesh.triangles[:, 0], axis=0)
    outside = [
        np.maximum(least - first, first - most).max(axis=1) for least, most in zip(low, high, strict=True)
    ]
    nearest = np.argmin(outside, axis=0)
    for number in range(len(tools)):
        yield mesh.part(nearest == number)


def _outline(took: EachTaken, normal: Array, frame: Array) -> dict[str, Any]:
    """Return the outline of the new face in the rotor frame, or in separate axes where it is askew."""
    from autobalance.solid.cad.taken import flat_loops

    to_face = face_frame(normal)
    to_rotor = np.eye(4)
    to_rotor[:3, :3] = to_face[:3, :3].T
    plane = frame if side_of(normal) is not None else to_face @ frame
    return listed_outline(flat_loops(took.loops, plane), to_rotor)


def _in_old_hole(correction: Correction, placement: Array) -> Correction:
    """Return the correction of a drill that ran along an existing hole."""
    inward, entry = placement[:3, 2], placement[:3, 3]
    details = dict(correction.details) | {"inward": [float(v) for v in inward]}
    if details.get("entry_mm") is not None:
        sunk = float(details["deepened_from_mm"])
        details["entry_mm"] = [float(v) for v in entry - sunk * inward]
    return replace(correction, position_mm=entry, axis=inward, details=details)
