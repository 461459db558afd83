"""The true anatomy of a generated crankshaft."""

from __future__ import annotations

import math

import numpy as np

from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw, Web
from autobalance.drawn_cranks.axial_plan import (
    AxialPlan,
    Span,
    at_angle,
    axial_plan,
    has_free_end,
    shoulder_height_mm,
)
from autobalance.drawn_cranks.design import Design
from autobalance.drawn_cranks.true_cylinders import true_cylinders
from autobalance.types import Array


def crank_anatomy(crank: Design, placement: Array | None = None) -> Anatomy:
    """Return the true anatomy of a crankshaft, in the rotor frame.

    Parameters
    ----------
    crank : Design
    placement : (4, 4) float, optional
        The rigid motion that takes the crank from its own axes to the file's.
    """
    place = np.eye(4) if placement is None else placement
    plan = axial_plan(crank)
    sense = _sense(place[:3, 2])
    order = slice(None, None, sense)
    pins = plan.pins[order]
    frame = _rotor_frame(pins[0].angle_rad, sum(_bare(crank, plan, pins[0])) / 2.0, sense)
    throws = []
    for number, span in enumerate(pins, start=1):
        low, high = _bare(crank, plan, span)
        centre = _moved(frame, (*at_angle(crank.crank_radius_mm, span.angle_rad), 0.5 * (low + high)))
        angle = math.atan2(centre[1], centre[0]) % (2.0 * math.pi)
        angle = 0.0 if 2.0 * math.pi - angle < 1e-12 else angle
        pin = Pin(centre, crank.crankpin.diameter_mm, high - low)
        throws.append(Throw(number, crank.crank_radius_mm, angle, pin))
    journals = _main_journals(crank, plan, frame, order)
    return Anatomy(
        file_to_rotor=frame @ np.linalg.inv(place),
        main_journals=journals,
        throws=tuple(throws),
        webs=_webs(crank, plan, frame, order),
        journal_misalignment_mm=0.0,
        cylinders=true_cylinders(crank, plan, frame, order, journals, throws),
    )


def _sense(direction: Array) -> int:
    """Return 1 if the axis already points as the rotor frame's does, else −1."""
    largest = np.abs(direction).max()
    decider = int(np.flatnonzero(np.abs(direction) >= largest - 1e-6)[0])
    return 1 if direction[decider] > 0.0 else -1


def _bare(crank: Design, plan: AxialPlan, pin: Span) -> tuple[float, float]:
    """Return the ends of a crankpin's bare cylinder.

    Without its pin, these are of the gap between the webs; beside the last web of an overhung crank, of the
    bore in that web.
    """
    if has_free_end(crank, plan, pin) and not crank.crankpin_in_file:
        return next((web.low, web.high) for web in plan.webs if web.high == pin.low)
    fillet = crank.fillet_mm if crank.crankpin_in_file else 0.0
    return pin.low + fillet, pin.high - (0.0 if has_free_end(crank, plan, pin) else fillet)


def _rotor_frame(angle_rad: float, z_mm: float, sense: int) -> Array:
    """Return the matrix (4, 4) from the crank's own axes to the rotor frame of a crankpin 1 placed so."""
    x = np.array([math.cos(angle_rad), math.sin(angle_rad), 0.0])
    z = np.array([0.0, 0.0, float(sense)])
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z])
    frame[2, 3] = -sense * z_mm
    return frame


def _moved(frame: Array, point: tuple[float, float, float]) -> Array:
    moved: Array = frame[:3, :3] @ np.array(point) + frame[:3, 3]
    return moved


def _main_journals(crank: Design, plan: AxialPlan, frame: Array, order: slice) -> tuple[MainJournal, ...]:
    spans = []
    for journal in plan.journals:
        low = journal.low + crank.fillet_mm * (journal.low > 0.0)
        high = journal.high - crank.fillet_mm * any(web.low == journal.high for web in plan.webs)
        spans.append((low, high))
    return tuple(
        MainJournal(
            _moved(frame, (0.0, 0.0, 0.5 * (low + high))), crank.main_journal.diameter_mm, high - low, number
        )
        for number, (low, high) in enumerate(spans[order], start=1)
    )


def _webs(crank: Design, plan: AxialPlan, frame: Array, order: slice) -> tuple[Web, ...]:
    webs = []
    for number, web in enumerate(plan.webs[order], start=1):
        height = shoulder_height_mm(crank) if web.counterweight else 0.0
        low = web.low - height * (web.journal_side < 0)
        high = web.high + height * (web.journal_side > 0)
        ends = sorted(float(_moved(frame, (0.0, 0.0, z))[2]) for z in (low, high))
        webs.append(Web(number, ends[0], ends[1], web.counterweight))
    return tuple(webs)
