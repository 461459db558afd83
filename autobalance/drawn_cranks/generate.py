"""Build a crankshaft from its dimensions: places along the axis, pins, webs, bores and keyways."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise

from autobalance.drawn_cranks.design import Design, DesignCounterweight, DesignWeb
from autobalance.errors import JobError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.shape import (
    Arc,
    Bar,
    Drafted,
    Joined,
    Line,
    Outline,
    Prism,
    Revolved,
    Shape,
    Without,
    circle,
    on_grid,
    polygon,
    reversed_outline,
    rotated,
    tessellated,
    with_corners,
)
from autobalance.solid.csg.solid import Solid
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass

# Places of a crankshaft's parts along its axis.


PAST_MM = 1.0
"""Reach of tools past the metal."""


@dataclass(frozen=True)
class Span:
    """A stretch along the axis; ``angle_rad`` is the angle of its crankpin, if it belongs to one."""

    low: float
    high: float
    angle_rad: float = 0.0
    counterweight: bool = False
    journal_side: int = 0
    second_angle_rad: float | None = None


@dataclass(frozen=True)
class AxialPlan:
    """Places of all parts along the axis: spans from face to face, fillets included."""

    journals: tuple[Span, ...]
    pins: tuple[Span, ...]
    webs: tuple[Span, ...]


def axial_plan(crank: Design) -> AxialPlan:
    """Return the places of journals, crankpins and webs, the first main journal beginning at z = 0."""
    journals: list[Span] = []
    pins: list[Span] = []
    webs: list[Span] = []
    here = 0.0

    def span(width: float) -> tuple[float, float]:
        nonlocal here
        low, here = here, on_grid(here + width)
        return low, here

    end = crank.end_journal_width_mm or crank.main_journal.width_mm
    thickness = crank.web.thickness_mm
    journals.append(Span(*span(end)))
    for number, bay in enumerate(crank.bays, start=1):
        angles = [math.radians(angle) for angle in bay.crankpins_deg]
        first, last = (flag and crank.counterweight is not None for flag in bay.counterweights)
        webs.append(Span(*span(thickness), angles[0], first, -1))
        for i, angle in enumerate(angles):
            pins.append(Span(*span(crank.crankpin.width_mm), angle))
            if i + 1 < len(angles):
                webs.append(Span(*span(crank.web.between_pins_mm), angle, second_angle_rad=angles[i + 1]))
        final = number == len(crank.bays)
        if final and crank.journals == "first":
            break
        webs.append(Span(*span(thickness), angles[-1], last, 1))
        journals.append(Span(*span(end if final else crank.main_journal.width_mm)))
    return AxialPlan(tuple(journals), tuple(pins), tuple(webs))


def has_free_end(crank: Design, plan: AxialPlan, pin: Span) -> bool:
    """Return whether a crankpin has a web below it only: the last one of an overhung crank."""
    return crank.journals == "first" and pin is plan.pins[-1]


def at_angle(radius: float, angle_rad: float) -> tuple[float, float]:
    return (radius * math.cos(angle_rad), radius * math.sin(angle_rad))


def shoulder_height_mm(crank: Design) -> float:
    """Return the height of counterweights beyond their webs."""
    size = crank.counterweight
    if size is None or size.thickness_mm is None:
        return 0.0
    return on_grid(size.thickness_mm - crank.web.thickness_mm)


# Crankpins and main journals of a crankshaft from its dimensions, fillets, nose and flange included.


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


# Metal taken out of a crankshaft: bores, oil holes, keyway and bolt holes.


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


# Webs of a crankshaft from its dimensions: outlines, and counterweights that are on them.


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


# Build a crankshaft from its dimensions.
#
# The crank axis is z; the first crankpin lies at the angle that the design gives it, and the first main
# journal begins at z = 0.


def crank_shape(crank: Design) -> Shape:
    """Return the exact shape of a crankshaft.

    Raises
    ------
    JobError
        If its parts do not fit together.
    """
    plan = axial_plan(crank)
    parts: list[Shape] = [part for web in plan.webs for part in web_shapes(crank, web)]
    for number, journal in enumerate(plan.journals):
        above = number + 1 < len(plan.journals) or crank.journals == "first"
        parts.append(journal_shape(crank, journal, webs_below=number > 0, webs_above=above))
    if crank.crankpin_in_file:
        thinnest = min(web.high - web.low for web in plan.webs)
        root = on_grid(thinnest / 2.0)
        parts += [crankpin_shape(crank, pin, root, has_free_end(crank, plan, pin)) for pin in plan.pins]
    tools = metal_taken(crank, plan)
    body = Joined(tuple(parts))
    return Without(body, tuple(tools)) if tools else body


def crank_solid(crank: Design, segments: int | None = None) -> Solid:
    """Return a crankshaft as triangles, ``segments`` a full circle (default: the design's)."""
    return tessellated(crank_shape(crank), segments or crank.segments)


@lru_cache(maxsize=16)
def exact_moments(crank: Design, segments: int = 128) -> Moments:
    """Return the mass moments of the true surface, without facets.

    The facets' error falls as n⁻², so that two tessellations, one twice as fine as the other in every arc,
    give the limit (Richardson). What is left falls as n⁻⁴; where surfaces cross slantwise more is left: some
    1e-7 of the mass with oil holes.
    """
    density = crank.density_kg_m3 * G_PER_MM3_PER_KG_M3
    shape = crank_shape(crank)
    coarse, fine = (tessellated(shape, segments, times).moments(density) for times in (1, 2))
    return fine.scaled(4.0 / 3.0) - coarse.scaled(1.0 / 3.0)
