"""Recognition of an assembly's bodies by their places: crank, rods, pins, bearings and pistons.

A rod's big end lies on a crankpin of the crank. Its pin or bearing lies within a rod's eye. The piston lies
around the small end. Names of parts are not trusted: they are in any language.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.recognition.rod_eyes import RodEyes, find_eyes
from autobalance.errors import RecognitionError
from autobalance.solid.formats.bodies import BodySource
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

Role = Literal[
    "crank", "rod", "wrist_pin", "small_end_bearing", "big_end_bearing", "piston", "on_piston", "other"
]

BORE_RADII = 1.02
"""A pin or bearing lies within this many radii of the eye's bore: drawn with no play, or pressed in."""
MIN_BORE_SHARE = 0.7
"""A bearing in an eye leaves at least this share of the bore's radius free."""
WRIST_PIN_WIDTHS = 1.25
"""A wrist pin is longer than this many widths of the small end; bushes are not."""
LEAST_CRANK = 0.05
"""A crank has at least this share of the largest body's volume."""
CANDIDATES = 24
"""And is one of so many largest bodies: of a bin of equal parts none is looked at for long."""
ON_PIN = 0.05
"""The big end's axis is the crankpin's when they are apart by less than this share of the bore's radius."""
MAX_PROTRUSION_SHARE = 0.02
"""Rings and clips stand out of the piston's box by at most this share of its size."""
EQUAL_VOLUME_SHARE = 1e-3
"""Bodies whose volumes differ by less are the same part again."""


@dataclass(frozen=True, eq=False)
class AssemblyPart:
    """A body of an assembly with its role; ``rod`` is the number of the rod it belongs to, from 1.

    ``eyes`` are a rod's, ``anatomy`` a crank's.
    """

    body: BodySource
    role: Role
    rod: int | None = None
    eyes: RodEyes | None = None
    anatomy: Anatomy | None = None


def assembly_parts(bodies: Sequence[BodySource]) -> tuple[AssemblyPart, ...]:
    """Return each body of an assembly with its role.

    Parameters
    ----------
    bodies : sequence of BodySource
        All of one file, in its coordinates, by falling volume.

    Returns
    -------
    tuple of AssemblyPart
        In the order given. Of several cranks (a balance shaft may pass for one) only those that carry a rod
        are called so, if any does.
    """
    eyes = [_eyes(body) for body in bodies]
    rods = [pair for pair in eyes if pair is not None]
    least_mm3 = LEAST_CRANK * max((body.source.volume_mm3 for body in bodies), default=0.0)
    cranks = [
        _crank(body) if pair is None and body.source.volume_mm3 >= least_mm3 and place < CANDIDATES else None
        for place, (body, pair) in enumerate(zip(bodies, eyes, strict=True))
    ]
    carrying = [anatomy is not None and _carries(anatomy, rods) for anatomy in cranks]
    parts: list[AssemblyPart] = []
    number = 0
    for body, pair, anatomy, carries in zip(bodies, eyes, cranks, carrying, strict=True):
        if pair is not None:
            number += 1
            parts.append(AssemblyPart(body, "rod", number, pair))
        elif anatomy is not None and (carries or not any(carrying)):
            parts.append(AssemblyPart(body, "crank", anatomy=anatomy))
        else:
            parts.append(_beside_a_rod(body, rods))
    return tuple(_with_pistons(parts, rods))


def _eyes(body: BodySource) -> RodEyes | None:
    source = body.source
    cylinders = () if source.surfaces is None else source.surfaces.cylinders
    try:
        return find_eyes(source.solid.mesh, source.moments(1.0).centre_mm, cylinders)
    except RecognitionError:
        return None


def _crank(body: BodySource) -> Anatomy | None:
    cylinders = () if body.source.surfaces is None else body.source.surfaces.cylinders
    try:
        return recognise(body.source.solid, Overrides(crankpin_in_file=True), cylinders)
    except RecognitionError:
        return None


def _carries(anatomy: Anatomy, rods: Sequence[RodEyes]) -> bool:
    for eyes in rods:
        centre = anatomy.file_to_rotor[:3, :3] @ eyes.big.file_centre_mm + anatomy.file_to_rotor[:3, 3]
        for throw in anatomy.throws:
            pin = throw.crankpin
            low, high = pin.z_range_mm
            off = float(np.hypot(*(centre[:2] - pin.centre_mm[:2])))
            if off < ON_PIN * eyes.big.diameter_mm and low - pin.width_mm < centre[2] < high + pin.width_mm:
                return True
    return False


def _beside_a_rod(body: BodySource, rods: Sequence[RodEyes]) -> AssemblyPart:
    """Return a body with its role in a rod's eye, as wrist pin or bearing; "other" outside of every eye."""
    for number, eyes in enumerate(rods, 1):
        placed = _placed(body.source.solid.mesh, eyes)
        for eye, along in ((eyes.small, eyes.length_mm), (eyes.big, 0.0)):
            away = np.hypot(placed[:, 0] - along, placed[:, 1])
            radius = 0.5 * eye.diameter_mm
            middle = 0.0 if eye is eyes.big else eyes.offset_mm
            holds_middle = float(placed[:, 2].min()) < middle < float(placed[:, 2].max())
            if float(away.max()) > BORE_RADII * radius or not holds_middle:
                continue
            if eye is eyes.small and float(np.ptp(placed[:, 2])) > WRIST_PIN_WIDTHS * eye.width_mm:
                return AssemblyPart(body, "wrist_pin", number)
            if float(away.min()) > MIN_BORE_SHARE * radius:
                role: Role = "small_end_bearing" if eye is eyes.small else "big_end_bearing"
                return AssemblyPart(body, role, number)
    return AssemblyPart(body, "other")


def _placed(mesh: Mesh, eyes: RodEyes) -> Array:
    placed: Array = mesh.vertices @ eyes.file_to_rod[:3, :3].T + eyes.file_to_rod[:3, 3]
    return placed


def _with_pistons(parts: Sequence[AssemblyPart], rods: Sequence[RodEyes]) -> list[AssemblyPart]:
    """Return the parts, with the largest around each small end as piston and parts within it on it."""
    assembly = list(parts)
    for number, eyes in enumerate(rods, 1):
        boxes = {
            place: _box(part, eyes)
            for place, part in enumerate(assembly)
            if part.role == "other" and part.body.source.volume_mm3 > 0.0
        }
        around = [place for place, box in boxes.items() if _holds(box, eyes)]
        if not around:
            continue
        piston = max(around, key=lambda place: assembly[place].body.source.volume_mm3)
        assembly[piston] = AssemblyPart(assembly[piston].body, "piston", number)
        room = MAX_PROTRUSION_SHARE * float(np.ptp(boxes[piston], axis=0).max())
        for place, box in boxes.items():
            inside = (box[0] > boxes[piston][0] - room).all() and (box[1] < boxes[piston][1] + room).all()
            if place != piston and inside:
                assembly[place] = AssemblyPart(assembly[place].body, "on_piston", number)
    return assembly


def _box(part: AssemblyPart, eyes: RodEyes) -> Array:
    placed = _placed(part.body.source.solid.mesh, eyes)
    return np.stack([placed.min(axis=0), placed.max(axis=0)])


def _holds(box: Array, eyes: RodEyes) -> bool:
    """Return whether a box in the rod's axes is around the small end and not around the big one."""
    small = np.array([eyes.length_mm, 0.0, eyes.offset_mm])
    return bool((box[0] < small).all() and (box[1] > small).all()) and box[0][0] > 0.0
