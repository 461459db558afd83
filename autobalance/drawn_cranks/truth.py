"""The true anatomy of a generated crankshaft, and all cylinders and bores along it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.crank.anatomy import (
    Anatomy,
    Cylinder,
    CylinderKind,
    CylinderRole,
    MainJournal,
    Pin,
    Throw,
    Web,
)
from autobalance.crank.recognition.through_shaft import RING_DOUBT
from autobalance.drawn_cranks.design import Design
from autobalance.drawn_cranks.generate import (
    AxialPlan,
    Span,
    at_angle,
    axial_plan,
    has_free_end,
    shoulder_height_mm,
)
from autobalance.types import Array

# All cylinders and bores along a generated crankshaft, as its dimensions place them.


def true_cylinders(
    crank: Design,
    plan: AxialPlan,
    frame: Array,
    order: slice,
    journals: Sequence[MainJournal],
    throws: Sequence[Throw],
) -> tuple[Cylinder, ...]:
    """Return the cylinders and bores of a crank, by increasing z.

    Parameters
    ----------
    crank : Design
    plan : AxialPlan
    frame : (4, 4) float
        From the crank's own axes to the rotor frame.
    order : slice
        Order of the plan's parts by increasing z of the rotor frame.
    journals, throws : sequence
        In the rotor frame.
    """
    found = [
        Cylinder(each.centre_mm, each.diameter_mm, each.width_mm, "outside", "main_journal", each.number)
        for each in journals
    ]
    for throw, span in zip(throws, plan.pins[order], strict=True):
        pin = throw.crankpin
        if crank.crankpin_in_file:
            found.append(
                Cylinder(pin.centre_mm, pin.diameter_mm, pin.width_mm, "outside", "crankpin", throw.number)
            )
        found += _pin_bores(crank, plan, frame, throw, span)
    found += _journal_bores(crank, plan, frame)
    found += _ends(crank, plan, frame)
    found += _disc_webs(crank, plan, frame)
    return tuple(sorted(found, key=lambda each: (float(each.centre_mm[2]), each.diameter_mm)))


def _at(
    frame: Array,
    ends: tuple[float, float],
    diameter_mm: float,
    kind: CylinderKind,
    role: CylinderRole = "none",
    number: int | None = None,
    centre: tuple[float, float] = (0.0, 0.0),
) -> Cylinder:
    """Return a cylinder between two ends along the crank's own axis, about a line beside it."""
    middle = frame[:3, :3] @ np.array([*centre, 0.5 * sum(ends)]) + frame[:3, 3]
    return Cylinder(middle, diameter_mm, ends[1] - ends[0], kind, role, number)


def _pin_bores(crank: Design, plan: AxialPlan, frame: Array, throw: Throw, pin: Span) -> list[Cylinder]:
    """Return the bore through a crankpin and its webs, or in each web for a crankpin that is pressed in."""
    bore = crank.crankpin.bore_mm if crank.crankpin_in_file else crank.crankpin.diameter_mm
    if bore == 0.0:
        return []
    centre = at_angle(crank.crank_radius_mm, pin.angle_rad)
    webs = [web for web in plan.webs if web.high == pin.low or web.low == pin.high]
    if crank.crankpin_in_file:
        ends = min(web.low for web in webs), max(pin.high, *(web.high for web in webs))
        return [_at(frame, ends, bore, "bore", centre=centre)]
    return [_at(frame, (web.low, web.high), bore, "bore", "crankpin", throw.number, centre) for web in webs]


def _journal_bores(crank: Design, plan: AxialPlan, frame: Array) -> list[Cylinder]:
    bore = crank.main_journal.bore_mm
    if bore == 0.0:
        return []
    bores = []
    for journal in plan.journals:
        below = [web.low for web in plan.webs if web.high == journal.low] or [_bottom_mm(crank)]
        above = [web.high for web in plan.webs if web.low == journal.high] or [_top_mm(crank, plan)]
        bores.append(_at(frame, (below[0], above[0]), bore, "bore"))
    return bores


def _bottom_mm(crank: Design) -> float:
    return -crank.nose.length_mm if crank.nose else 0.0


def _top_mm(crank: Design, plan: AxialPlan) -> float:
    return plan.journals[-1].high + (crank.flange.thickness_mm if crank.flange else 0.0)


def _ends(crank: Design, plan: AxialPlan, frame: Array) -> list[Cylinder]:
    """Return a cylindrical nose, and the flange with its bolts' holes."""
    found = []
    nose, flange = crank.nose, crank.flange
    if nose is not None and nose.end_diameter_mm in (None, nose.diameter_mm):
        found.append(_shaft(frame, (_bottom_mm(crank), 0.0), nose.diameter_mm))
    if flange is not None and crank.journals == "both":
        ends = plan.journals[-1].high, _top_mm(crank, plan)
        found.append(_shaft(frame, ends, flange.diameter_mm))
        for turn in np.arange(flange.bolts) * 2.0 * np.pi / max(flange.bolts, 1):
            centre = at_angle(0.5 * flange.bolt_circle_mm, float(turn))
            found.append(_at(frame, ends, flange.bolt_diameter_mm, "bore", centre=centre))
    return found


def _shaft(frame: Array, ends: tuple[float, float], diameter_mm: float) -> Cylinder:
    is_ring = ends[1] - ends[0] < RING_DOUBT * diameter_mm
    return _at(frame, ends, diameter_mm, "outside", "collar" if is_ring else "shaft")


def _disc_webs(crank: Design, plan: AxialPlan, frame: Array) -> list[Cylinder]:
    """Return the webs that are round discs about the axis: those without a counterweight."""
    diameter = 2.0 * float(crank.web.disc_radius_mm or 0.0)
    if crank.web.outline != "disc":
        return []
    return [
        _at(frame, (web.low, web.high), diameter, "outside", "web")
        for web in plan.webs
        if web.second_angle_rad is None and not (web.counterweight and crank.counterweight)
    ]


# The true anatomy of a generated crankshaft.


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
