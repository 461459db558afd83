"""Metal taken out of a crankshaft: bores, oil holes, keyway and bolt holes."""

from __future__ import annotations

import math

from autobalance.drawn_cranks.axial_plan import PAST_MM, AxialPlan, Span, at_angle
from autobalance.drawn_cranks.design import Design
from autobalance.errors import JobError
from autobalance.solid.csg.shape import Bar, Prism, Shape, circle, on_grid, polygon


def metal_taken(crank: Design, plan: AxialPlan) -> list[Shape]:
    tools: list[Shape] = []
    tools += _pin_bores(crank, plan)
    tools += _journal_bores(crank, plan)
    tools += _oil_holes(crank, plan)
    tools += _keyway(crank)
    tools += _bolt_holes(crank, plan)
    return tools


def _pin_bores(crank: Design, plan: AxialPlan) -> list[Shape]:
    """Return bores through crankpins and webs; where a journal overlaps the bore they end at its face."""
    bore = crank.crankpin.bore_mm if crank.crankpin_in_file else crank.crankpin.diameter_mm
    if bore == 0.0:
        return []
    near = crank.crank_radius_mm - bore / 2.0
    past = 0.0 if near <= crank.main_journal.diameter_mm / 2.0 + crank.fillet_mm + PAST_MM else PAST_MM
    tools: list[Shape] = []
    for pin in plan.pins:
        low = min(web.low for web in plan.webs if web.high == pin.low)
        high = max((web.high for web in plan.webs if web.low == pin.high), default=pin.high + PAST_MM)
        outline = circle(bore / 2.0, at_angle(crank.crank_radius_mm, pin.angle_rad))
        tools.append(Prism(outline, on_grid(low - past), on_grid(high + past)))
    return tools


def _journal_bores(crank: Design, plan: AxialPlan) -> list[Shape]:
    """Return bores through main journals and the webs beside them."""
    bore = crank.main_journal.bore_mm
    if bore == 0.0:
        return []
    ends = [
        (
            min((web.low for web in plan.webs if web.high == journal.low), default=_bottom(crank)),
            max((web.high for web in plan.webs if web.low == journal.high), default=_top(crank, plan)),
        )
        for journal in plan.journals
    ]
    return [Prism(circle(bore / 2.0), on_grid(low - PAST_MM), on_grid(high + PAST_MM)) for low, high in ends]


def _bottom(crank: Design) -> float:
    return on_grid(-crank.nose.length_mm) if crank.nose else 0.0


def _top(crank: Design, plan: AxialPlan) -> float:
    return on_grid(plan.journals[-1].high + (crank.flange.thickness_mm if crank.flange else 0.0))


def _oil_holes(crank: Design, plan: AxialPlan) -> list[Shape]:
    """Return a slanted hole for every crankpin that has a main journal beside it."""
    if crank.oil_hole_mm == 0.0:
        return []
    tools: list[Shape] = []
    for pin in plan.pins:
        for web in plan.webs:
            beside = web.high == pin.low or web.low == pin.high
            journal = next(
                (j for j in plan.journals if beside and (j.high == web.low or j.low == web.high)), None
            )
            if journal is not None:
                tools.append(_oil_hole(crank, journal, pin))
                break
    return tools


def _oil_hole(crank: Design, journal: Span, pin: Span) -> Shape:
    """Return a hole from the far side of the journal's middle to the outermost line of the pin's middle."""
    main, rod = crank.main_journal.diameter_mm / 2.0, crank.crankpin.diameter_mm / 2.0
    z0, z1 = 0.5 * (journal.low + journal.high), 0.5 * (pin.low + pin.high)
    r0, r1 = -main, crank.crank_radius_mm + rod
    faces = (journal.high, pin.low) if z1 > z0 else (journal.low, pin.high)
    at_journal, at_pin = (r0 + (r1 - r0) * (face - z0) / (z1 - z0) for face in faces)
    room = crank.oil_hole_mm
    if abs(at_journal) > main - room or abs(at_pin - crank.crank_radius_mm) > rod - room:
        raise JobError("oil_hole_mm: a straight hole would break out beside the web")
    length = math.hypot(r1 - r0, z1 - z0)
    past = 2.0 * room / length
    ends = [(r0 + s * (r1 - r0), z0 + s * (z1 - z0)) for s in (-past, 1.0 + past)]
    start, end = ((*at_angle(r, pin.angle_rad), z) for r, z in ends)
    return Bar(start, end, crank.oil_hole_mm)


def _keyway(crank: Design) -> list[Shape]:
    nose = crank.nose
    if nose is None or nose.keyway is None:
        return []
    key, tip = nose.keyway, (nose.end_diameter_mm or nose.diameter_mm) / 2.0
    low, high, half = tip - key.depth_mm, nose.diameter_mm, key.width_mm / 2.0
    slot = polygon([(-half, low), (half, low), (half, high), (-half, high)])
    bottom = _bottom(crank)
    return [Prism(slot, on_grid(bottom - PAST_MM), on_grid(bottom + key.length_mm))]


def _bolt_holes(crank: Design, plan: AxialPlan) -> list[Shape]:
    flange = crank.flange
    if flange is None or flange.bolts == 0:
        return []
    radius, hole = flange.bolt_circle_mm / 2.0, flange.bolt_diameter_mm / 2.0
    if (
        not crank.main_journal.diameter_mm / 2.0 < radius - hole
        or not radius + hole < flange.diameter_mm / 2.0
    ):
        raise JobError(f"flange.bolt_circle_mm is {flange.bolt_circle_mm:g}; the holes need metal")
    low, high = plan.journals[-1].high, _top(crank, plan)
    angles = (2.0 * math.pi * i / flange.bolts for i in range(flange.bolts))
    return [
        Prism(circle(hole, at_angle(radius, angle)), on_grid(low - PAST_MM), on_grid(high + PAST_MM))
        for angle in angles
    ]
