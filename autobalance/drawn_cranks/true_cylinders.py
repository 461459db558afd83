"""All cylinders and bores along a generated crankshaft, as its dimensions place them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autobalance.crank.anatomy import Cylinder, CylinderKind, CylinderRole, MainJournal, Throw
from autobalance.crank.recognition.journal_rules import RING_DOUBT
from autobalance.drawn_cranks.axial_plan import AxialPlan, Span, at_angle
from autobalance.drawn_cranks.design import Design
from autobalance.types import Array


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
