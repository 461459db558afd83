"""Webs of a crankshaft from its dimensions: outlines, and counterweights that are on them."""

from __future__ import annotations

import math
from itertools import pairwise

from autobalance.drawn_cranks.axial_plan import PAST_MM, Span, shoulder_height_mm
from autobalance.drawn_cranks.design import Design, DesignCounterweight, DesignWeb
from autobalance.errors import JobError
from autobalance.solid.csg.shape import (
    Arc,
    Drafted,
    Line,
    Outline,
    Prism,
    Shape,
    circle,
    on_grid,
    reversed_outline,
    rotated,
    with_corners,
)


def web_outline(
    web: DesignWeb,
    crank_radius_mm: float,
    counterweight: DesignCounterweight | None,
    splits: tuple[float, ...] = (),
) -> Outline:
    """Return a web's outline, its crankpin at +x.

    Parameters
    ----------
    web : DesignWeb
    crank_radius_mm : float
    counterweight : DesignCounterweight or None
        The sector on the other side.
    splits : tuple of float
        Angles from the sector's edges at which its rim has corners besides [rad].
    """
    if counterweight is None:
        return (
            _pear(web, crank_radius_mm) if web.outline == "pear" else circle(float(web.disc_radius_mm or 0))
        )
    edge = _edge_angle(counterweight)
    rim = _rim(counterweight.radius_mm, edge, splits)
    if web.outline == "disc":
        disc = Arc((0.0, 0.0), float(web.disc_radius_mm or 0.0), -edge, edge)
        return (disc, Line(disc.end, rim[0].start), *rim, Line(rim[-1].end, disc.start))
    return _pear_and_sector(web, crank_radius_mm, edge, rim)


def _rim(radius: float, edge: float, splits: tuple[float, ...]) -> tuple[Arc, ...]:
    """Return the arc opposite the crankpin from angle ``edge`` on, with corners at ``splits``."""
    near = sorted(edge + split for split in splits)
    far = [2.0 * math.pi - angle for angle in reversed(near)]
    stations = [edge, *near, *far, 2.0 * math.pi - edge]
    return tuple(Arc((0.0, 0.0), radius, a, b) for a, b in pairwise(stations))


def _tangent_angle(web: DesignWeb, crank_radius: float) -> float:
    """Return the angle of the normal of the pear's straight flank, from the crankpin's direction."""
    return math.acos((float(web.hub_radius_mm or 0.0) - float(web.pin_end_radius_mm or 0.0)) / crank_radius)


def _pear(web: DesignWeb, crank_radius: float) -> Outline:
    angle = _tangent_angle(web, crank_radius)
    pin_end = Arc((crank_radius, 0.0), float(web.pin_end_radius_mm or 0.0), -angle, angle)
    hub = Arc((0.0, 0.0), float(web.hub_radius_mm or 0.0), angle, 2.0 * math.pi - angle)
    return (pin_end, Line(pin_end.end, hub.start), hub, Line(hub.end, pin_end.start))


def _pear_and_sector(web: DesignWeb, crank_radius: float, edge: float, rim: tuple[Arc, ...]) -> Outline:
    """Return the pear with the sector's two radial edges standing on its hub or on its straight flanks."""
    angle, hub = _tangent_angle(web, crank_radius), float(web.hub_radius_mm or 0.0)
    pin_end = Arc((crank_radius, 0.0), float(web.pin_end_radius_mm or 0.0), -angle, angle)
    if edge >= angle:
        up = Arc((0.0, 0.0), hub, angle, edge)
        down = Arc((0.0, 0.0), hub, 2.0 * math.pi - edge, 2.0 * math.pi - angle)
        return (
            pin_end, Line(pin_end.end, up.start), up, Line(up.end, rim[0].start), *rim,
            Line(rim[-1].end, down.start), down, Line(down.end, pin_end.start),
        )  # fmt: skip
    reach = hub / math.cos(angle - edge)
    foot = (reach * math.cos(edge), reach * math.sin(edge))
    mirrored = (foot[0], -foot[1])
    if reach >= rim[0].radius or hub * math.tan(angle - edge) > crank_radius * math.sin(angle):
        raise JobError("counterweight.fan_angle_deg is so wide that the sector runs into the crankpin's end")
    return (
        pin_end, Line(pin_end.end, foot), Line(foot, rim[0].start), *rim,
        Line(rim[-1].end, mirrored), Line(mirrored, pin_end.start),
    )  # fmt: skip


def _between_outline(web: DesignWeb, crank_radius: float, first: float, second: float, pin: float) -> Outline:
    """Return the hull of two equal discs about crankpins at two angles."""
    radius = float(web.pin_end_radius_mm) if web.pin_end_radius_mm is not None else pin
    a, b = sorted((first, second))
    if b - a > math.pi:
        a, b = b, a + 2.0 * math.pi
    middle = 0.5 * (a + b)
    across = middle + 0.5 * math.pi
    one = (crank_radius * math.cos(a), crank_radius * math.sin(a))
    two = (crank_radius * math.cos(b), crank_radius * math.sin(b))
    far = Arc(two, radius, across - 0.5 * math.pi, across + 0.5 * math.pi)
    near = Arc(one, radius, across + 0.5 * math.pi, across + 1.5 * math.pi)
    return (far, Line(far.end, near.start), near, Line(near.end, far.start))


def web_shapes(crank: Design, web: Span) -> list[Shape]:
    if web.second_angle_rad is not None:
        least = crank.crankpin.diameter_mm / 2.0 + crank.fillet_mm
        outline = _between_outline(
            crank.web, crank.crank_radius_mm, web.angle_rad, web.second_angle_rad, least
        )
        return [Prism(outline, web.low, web.high)]
    size = crank.counterweight if web.counterweight else None
    height = shoulder_height_mm(crank) if size else 0.0
    lean = height * math.tan(math.radians(size.draft_deg)) if size else 0.0
    splits = (math.asin(lean / size.radius_mm),) if size and lean > 0.0 else ()
    outline = web_outline(crank.web, crank.crank_radius_mm, size, splits)
    if size is None or height == 0.0:
        return [Prism(rotated(outline, web.angle_rad), web.low, web.high)]
    shoulder = _shoulder_outline(crank, size, height)
    arm = with_corners(outline, (edge.start for edge in shoulder))
    standing = with_corners(shoulder, (edge.start for edge in outline))
    return [
        Prism(rotated(arm, web.angle_rad), web.low, web.high),
        _shoulder(size, web, height, rotated(standing, web.angle_rad)),
    ]


def _edge_angle(size: DesignCounterweight) -> float:
    """Return the angle between crankpin and the sector's edge [rad]."""
    return math.pi - math.radians(size.fan_angle_deg) / 2.0


def _inner_radius(crank: Design, size: DesignCounterweight) -> float:
    if size.inner_radius_mm is not None:
        return size.inner_radius_mm
    return crank.main_journal.diameter_mm / 2.0 + crank.fillet_mm + PAST_MM


def _shoulder_outline(crank: Design, size: DesignCounterweight, height: float) -> Outline:
    """Return the part of a ring that is on the web: rim, edge, inner arc, edge."""
    inner, edge = _inner_radius(crank, size), _edge_angle(size)
    lean = math.tan(math.radians(size.draft_deg))
    rim, arc = (
        _rim(radius, edge, (math.asin(height * lean / radius),) if lean > 0.0 else ())
        for radius in (size.radius_mm, inner)
    )
    back = reversed_outline(arc)
    return (*rim, Line(rim[-1].end, back[0].start), *back, Line(back[-1].end, rim[0].start))


def _shoulder(size: DesignCounterweight, web: Span, height: float, outline: Outline) -> Shape:
    """Return the part of a counterweight that is on the web's face."""
    face = web.high if web.journal_side > 0 else web.low
    top = on_grid(face + web.journal_side * height)
    edges = tuple(place for place, edge in enumerate(outline) if isinstance(edge, Line))
    lean = math.tan(math.radians(size.draft_deg))
    if lean == 0.0:
        return Prism(outline, min(face, top), max(face, top))
    return Drafted(outline, face, top, edges, lean)
