"""Keyways, splines and teeth: what marks a cylinder as a shaft, and a bore as that for one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.recognition.circles import Circle, corners_of, distances, preceding
from autobalance.crank.recognition.cylinder_runs import SAME_CENTRE, SAME_RADIUS, CylinderRun
from autobalance.crank.recognition.datums import (
    LONG_AS_WIDE,
    MIN_SLOT_DEPTH_RATIO,
    SAME_WIDTH,
    Slot,
    bore_slot,
    shaft_slot,
)
from autobalance.crank.recognition.section_stack import SectionPiece, SectionStack, encloses
from autobalance.types import Array, Flags

SPLINE_SLOTS = 3
"""Slots from which on a cylinder's section is that of a spline or of teeth; drillings are one or two."""
SPLINE_LENGTH = 0.1
"""... over at least this share of its diameter."""


def shaft_marks(long: SectionStack, run: CylinderRun, bore: bool = False) -> list[tuple[float, float]]:
    """Return the z ranges of keyways, splines and teeth in a cylinder, or in the wall of a bore."""
    seen: dict[int, tuple[int, Slot | None]] = {}
    splined, slots = [], []
    for section in long.sections:
        if not run.z_low < section.z_mm < run.z_high:
            continue
        for piece in section.pieces:
            if id(piece) not in seen:
                seen[id(piece)] = (_bore_slots if bore else _slots)(piece, run, section.z_mm)
            count, slot = seen[id(piece)]
            if count >= SPLINE_SLOTS:
                splined.append(section.z_mm)
            if slot is not None:
                slots.append(replace(slot, z_mm=section.z_mm))
    return [*_keyed(slots), *_splined(splined, run)]


def _keyed(slots: Sequence[Slot]) -> list[tuple[float, float]]:
    """Return the z ranges of slots as wide all along and at least about as long as wide: keyways."""
    found, rest = [], list(slots)
    while rest:
        first = rest[0]
        same = [slot for slot in rest if abs(slot.width - first.width) < SAME_WIDTH * first.width]
        low, high = same[0].z_mm, same[-1].z_mm
        if high - low >= LONG_AS_WIDE * first.width:
            found.append((low, high))
        rest = [slot for slot in rest if all(slot is not other for other in same)]
    return found


def _splined(heights: Sequence[float], run: CylinderRun) -> list[tuple[float, float]]:
    """Return the z range over which several slots are cut into a cylinder."""
    if not heights or heights[-1] - heights[0] < SPLINE_LENGTH * 2.0 * run.radius:
        return []
    return [(heights[0], heights[-1])]


def _slots(piece: SectionPiece, run: CylinderRun, z_mm: float) -> tuple[int, Slot | None]:
    """Return the number of slots in a cylinder's section, and the keyway's if it is one."""
    circle = piece.circle
    if circle is None or float(np.linalg.norm(circle.centre - run.centre)) > SAME_CENTRE * run.radius:
        return 0, None
    away = distances(piece.outline, circle.centre)
    least = (1.0 - MIN_SLOT_DEPTH_RATIO) * run.radius
    if float(away.min()) >= least:
        return 0, None
    corners = corners_of(piece.outline, piece.grain_mm)
    inside = distances(corners, circle.centre) < least - _facet_mm(corners) ** 2 / run.radius
    return _rows(inside), shaft_slot(piece, circle, z_mm)


def _bore_slots(piece: SectionPiece, run: CylinderRun, z_mm: float) -> tuple[int, Slot | None]:
    """Return the number of slots in the wall of a bore, and the keyway's if it is one."""
    circle = next((each for each in piece.bores if _is_of(each, run)), None)
    hole = next((hole for hole in piece.holes if encloses(hole, run.centre)), None)
    if circle is None or hole is None:
        return 0, None
    corners = corners_of(hole[::-1], piece.grain_mm)
    beyond = distances(corners, circle.centre) > (1.0 + MIN_SLOT_DEPTH_RATIO) * circle.radius
    return _rows(beyond), bore_slot(piece, circle, z_mm)


def _is_of(circle: Circle, run: CylinderRun) -> bool:
    apart = float(np.linalg.norm(circle.centre - run.centre))
    return apart < SAME_CENTRE * run.radius and abs(circle.radius - run.radius) < SAME_RADIUS * run.radius


def _facet_mm(corners: Array) -> float:
    return float(np.median(np.linalg.norm(np.diff(corners, axis=0), axis=1)))


def _rows(flagged: Flags) -> int:
    """Return the number of rows of neighbours that are flagged in a closed ring."""
    return int(np.count_nonzero(flagged & ~preceding(flagged)))
