"""Crankpins and main journals of a crankshaft from its dimensions, fillets, nose and flange included."""

from __future__ import annotations

import math

from autobalance.drawn_cranks.axial_plan import Span, at_angle
from autobalance.drawn_cranks.design import Design
from autobalance.solid.csg.shape import Arc, Line, Outline, Revolved, Shape, on_grid

FILLET_SHARE = 1.0 / 8.0
"""Fineness of a fillet's division over a full circle's: its radius is that much smaller."""


def _fillets(radius: float, fillet: float, low: float, high: float, root: float) -> tuple[Outline, Outline]:
    """Return the profiles of a cylinder's lower end at its web, and of the rest up to the upper web."""
    if fillet == 0.0:
        return (
            (Line((radius, low - root), (radius, low)),),
            (Line((radius, low), (radius, high)), Line((radius, high), (radius, high + root))),
        )
    wide = radius + fillet
    leave = Arc((wide, low + fillet), fillet, 1.5 * math.pi, math.pi, FILLET_SHARE, 2)
    enter = Arc((wide, high - fillet), fillet, math.pi, 0.5 * math.pi, FILLET_SHARE, 2)
    return (
        (Line((wide, low - root), (wide, low)), leave),
        (Line(leave.end, enter.start), enter, Line((wide, high), (wide, high + root))),
    )


def _closed(edges: Outline) -> Outline:
    """Return a profile closed along the axis r = 0."""
    start, end = edges[0].start, edges[-1].end
    bottom, top = (0.0, start[1]), (0.0, end[1])
    return (Line(bottom, start), *edges, Line(end, top), Line(top, bottom))


def crankpin_shape(crank: Design, pin: Span, root: float, free_end: bool) -> Shape:
    """Return a crankpin; with a free end it has a web below it only."""
    radius = crank.crankpin.diameter_mm / 2.0
    leave, enter = _fillets(radius, crank.fillet_mm, pin.low, pin.high, root)
    if free_end:
        enter = (Line(leave[-1].end, (radius, pin.high)),)
    return Revolved(_closed((*leave, *enter)), at_angle(crank.crank_radius_mm, pin.angle_rad))


def journal_shape(crank: Design, journal: Span, webs_below: bool, webs_above: bool) -> Shape:
    """Return a main journal; the first carries the nose, the last the flange."""
    radius, root = crank.main_journal.diameter_mm / 2.0, on_grid(crank.web.thickness_mm / 2.0)
    leave, enter = _fillets(radius, crank.fillet_mm, journal.low, journal.high, root)
    edges = list(leave if webs_below else _free_start(crank, journal.low))
    if not webs_above:
        edges += [Line(edges[-1].end, (radius, journal.high)), *_free_end(crank, journal.high)]
        return Revolved(_closed(tuple(edges)))
    straight, *rest = enter
    return Revolved(_closed((*edges, Line(edges[-1].end, straight.end), *rest)))


def _free_start(crank: Design, low: float) -> Outline:
    radius, nose = crank.main_journal.diameter_mm / 2.0, crank.nose
    if nose is None:
        return (Line((radius, low), (radius, low)),)
    tip = (nose.end_diameter_mm or nose.diameter_mm) / 2.0
    base = (nose.diameter_mm / 2.0, low)
    return (Line((tip, on_grid(low - nose.length_mm)), base), Line(base, (radius, low)))


def _free_end(crank: Design, high: float) -> Outline:
    flange = crank.flange
    if flange is None:
        return ()
    radius, wide = crank.main_journal.diameter_mm / 2.0, flange.diameter_mm / 2.0
    top = on_grid(high + flange.thickness_mm)
    return (Line((radius, high), (wide, high)), Line((wide, high), (wide, top)))
