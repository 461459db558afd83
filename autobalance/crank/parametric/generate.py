"""Build a crankshaft from its dimensions, with the anatomy it truly has.

The crank axis is z; the first crankpin lies at the angle that the design gives it, and the first main
journal begins at z = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from autobalance.crank.anatomy import Anatomy, Array, MainJournal, Pin, Throw, Web
from autobalance.crank.parametric.design import Bay, CounterweightSize, Design, WebSize
from autobalance.errors import JobError
from autobalance.rigid_rotor.moments import Moments
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

FILLET_SHARE = 1.0 / 8.0
"""How finely a fillet is divided, compared with a full circle: its radius is that much smaller."""
PAST_MM = 1.0
"""How far tools reach past the metal."""


@dataclass(frozen=True)
class _Span:
    """A stretch along the axis; ``angle_rad`` is where its crankpin lies, if it belongs to one."""

    low: float
    high: float
    angle_rad: float = 0.0
    counterweight: bool = False
    journal_side: int = 0
    second_angle_rad: float | None = None


@dataclass(frozen=True)
class _Plan:
    """Where everything stands along the axis: spans from face to face, fillets included."""

    journals: tuple[_Span, ...]
    pins: tuple[_Span, ...]
    webs: tuple[_Span, ...]


def _plan(crank: Design) -> _Plan:
    journals: list[_Span] = []
    pins: list[_Span] = []
    webs: list[_Span] = []
    here = 0.0

    def span(width: float) -> tuple[float, float]:
        nonlocal here
        low, here = here, on_grid(here + width)
        return low, here

    end = crank.end_journal_width_mm or crank.main_journal.width_mm
    thickness = crank.web.thickness_mm
    journals.append(_Span(*span(end)))
    for number, bay in enumerate(crank.bays, start=1):
        angles = [math.radians(angle) for angle in bay.crankpins_deg]
        first, last = (flag and crank.counterweight is not None for flag in bay.counterweights)
        webs.append(_Span(*span(thickness), angles[0], first, -1))
        for i, angle in enumerate(angles):
            pins.append(_Span(*span(crank.crankpin.width_mm), angle))
            if i + 1 < len(angles):
                webs.append(_Span(*span(crank.web.between_pins_mm), angle, second_angle_rad=angles[i + 1]))
        final = number == len(crank.bays)
        if final and crank.journals == "first":
            break
        webs.append(_Span(*span(thickness), angles[-1], last, 1))
        journals.append(_Span(*span(end if final else crank.main_journal.width_mm)))
    return _Plan(tuple(journals), tuple(pins), tuple(webs))


# --- outlines ----------------------------------------------------------------------------------------------
def web_outline(
    web: WebSize,
    crank_radius_mm: float,
    counterweight: CounterweightSize | None,
    splits: tuple[float, ...] = (),
) -> Outline:
    """Return a web's outline, its crankpin at +x.

    Parameters
    ----------
    web : WebSize
    crank_radius_mm : float
    counterweight : CounterweightSize or None
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


def _tangent_angle(web: WebSize, crank_radius: float) -> float:
    """Return the angle of the normal of the pear's straight flank, from the crankpin's direction."""
    return math.acos((float(web.hub_radius_mm or 0.0) - float(web.pin_end_radius_mm or 0.0)) / crank_radius)


def _pear(web: WebSize, crank_radius: float) -> Outline:
    angle = _tangent_angle(web, crank_radius)
    pin_end = Arc((crank_radius, 0.0), float(web.pin_end_radius_mm or 0.0), -angle, angle)
    hub = Arc((0.0, 0.0), float(web.hub_radius_mm or 0.0), angle, 2.0 * math.pi - angle)
    return (pin_end, Line(pin_end.end, hub.start), hub, Line(hub.end, pin_end.start))


def _pear_and_sector(web: WebSize, crank_radius: float, edge: float, rim: tuple[Arc, ...]) -> Outline:
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


def _between_outline(web: WebSize, crank_radius: float, first: float, second: float, pin: float) -> Outline:
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


# --- parts -------------------------------------------------------------------------------------------------
def _web(crank: Design, web: _Span) -> list[Shape]:
    """Return a web with its counterweight."""
    if web.second_angle_rad is not None:
        least = crank.crankpin.diameter_mm / 2.0 + crank.fillet_mm
        outline = _between_outline(
            crank.web, crank.crank_radius_mm, web.angle_rad, web.second_angle_rad, least
        )
        return [Prism(outline, web.low, web.high)]
    size = crank.counterweight if web.counterweight else None
    height = _shoulder_height(crank) if size else 0.0
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


def _edge_angle(size: CounterweightSize) -> float:
    """Return the angle between crankpin and the sector's edge [rad]."""
    return math.pi - math.radians(size.fan_angle_deg) / 2.0


def _inner_radius(crank: Design, size: CounterweightSize) -> float:
    if size.inner_radius_mm is not None:
        return size.inner_radius_mm
    return crank.main_journal.diameter_mm / 2.0 + crank.fillet_mm + PAST_MM


def _shoulder_height(crank: Design) -> float:
    size = crank.counterweight
    if size is None or size.thickness_mm is None:
        return 0.0
    return on_grid(size.thickness_mm - crank.web.thickness_mm)


def _shoulder_outline(crank: Design, size: CounterweightSize, height: float) -> Outline:
    """Return the part of a ring that stands on the web: rim, edge, inner arc, edge."""
    inner, edge = _inner_radius(crank, size), _edge_angle(size)
    lean = math.tan(math.radians(size.draft_deg))
    rim, arc = (
        _rim(radius, edge, (math.asin(height * lean / radius),) if lean > 0.0 else ())
        for radius in (size.radius_mm, inner)
    )
    back = reversed_outline(arc)
    return (*rim, Line(rim[-1].end, back[0].start), *back, Line(back[-1].end, rim[0].start))


def _shoulder(size: CounterweightSize, web: _Span, height: float, outline: Outline) -> Shape:
    """Return what the counterweight has beyond the web, standing on its face."""
    face = web.high if web.journal_side > 0 else web.low
    top = on_grid(face + web.journal_side * height)
    edges = tuple(place for place, edge in enumerate(outline) if isinstance(edge, Line))
    lean = math.tan(math.radians(size.draft_deg))
    if lean == 0.0:
        return Prism(outline, min(face, top), max(face, top))
    return Drafted(outline, face, top, edges, lean)


def _fillets(radius: float, fillet: float, low: float, high: float, root: float) -> tuple[Outline, Outline]:
    """Return how a cylinder's profile leaves its lower web, and how it enters the upper one."""
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
    """Close a profile along the axis r = 0."""
    start, end = edges[0].start, edges[-1].end
    bottom, top = (0.0, start[1]), (0.0, end[1])
    return (Line(bottom, start), *edges, Line(end, top), Line(top, bottom))


def _pin(crank: Design, pin: _Span, root: float, free_end: bool) -> Shape:
    """Return a crankpin; with a free end it has a web below it only."""
    radius = crank.crankpin.diameter_mm / 2.0
    leave, enter = _fillets(radius, crank.fillet_mm, pin.low, pin.high, root)
    if free_end:
        enter = (Line(leave[-1].end, (radius, pin.high)),)
    return Revolved(_closed((*leave, *enter)), _at(crank.crank_radius_mm, pin.angle_rad))


def _has_free_end(crank: Design, plan: _Plan, pin: _Span) -> bool:
    return crank.journals == "first" and pin is plan.pins[-1]


def _at(radius: float, angle_rad: float) -> tuple[float, float]:
    return (radius * math.cos(angle_rad), radius * math.sin(angle_rad))


def _journal(crank: Design, journal: _Span, webs_below: bool, webs_above: bool) -> Shape:
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


# --- tools -------------------------------------------------------------------------------------------------
def _tools(crank: Design, plan: _Plan) -> list[Shape]:
    tools: list[Shape] = []
    tools += _pin_bores(crank, plan)
    tools += _journal_bores(crank, plan)
    tools += _oil_holes(crank, plan)
    tools += _keyway(crank)
    tools += _bolt_holes(crank, plan)
    return tools


def _pin_bores(crank: Design, plan: _Plan) -> list[Shape]:
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
        outline = circle(bore / 2.0, _at(crank.crank_radius_mm, pin.angle_rad))
        tools.append(Prism(outline, on_grid(low - past), on_grid(high + past)))
    return tools


def _journal_bores(crank: Design, plan: _Plan) -> list[Shape]:
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


def _top(crank: Design, plan: _Plan) -> float:
    return on_grid(plan.journals[-1].high + (crank.flange.thickness_mm if crank.flange else 0.0))


def _oil_holes(crank: Design, plan: _Plan) -> list[Shape]:
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


def _oil_hole(crank: Design, journal: _Span, pin: _Span) -> Shape:
    """Drill from the far side of the journal's middle to the outermost line of the crankpin's middle."""
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
    start, end = ((*_at(r, pin.angle_rad), z) for r, z in ends)
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


def _bolt_holes(crank: Design, plan: _Plan) -> list[Shape]:
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
        Prism(circle(hole, _at(radius, angle)), on_grid(low - PAST_MM), on_grid(high + PAST_MM))
        for angle in angles
    ]


# --- the whole ---------------------------------------------------------------------------------------------
def crank_shape(crank: Design) -> Shape:
    """Return the exact shape of a crankshaft.

    Raises
    ------
    JobError
        If its parts do not fit together.
    """
    plan = _plan(crank)
    parts: list[Shape] = [part for web in plan.webs for part in _web(crank, web)]
    for number, journal in enumerate(plan.journals):
        above = number + 1 < len(plan.journals) or crank.journals == "first"
        parts.append(_journal(crank, journal, webs_below=number > 0, webs_above=above))
    if crank.crankpin_in_file:
        thinnest = min(web.high - web.low for web in plan.webs)
        root = on_grid(thinnest / 2.0)
        parts += [_pin(crank, pin, root, _has_free_end(crank, plan, pin)) for pin in plan.pins]
    tools = _tools(crank, plan)
    body = Joined(tuple(parts))
    return Without(body, tuple(tools)) if tools else body


def crank_solid(crank: Design, segments: int | None = None) -> Solid:
    """Return a crankshaft as triangles, ``segments`` a full circle (default: the design's)."""
    return tessellated(crank_shape(crank), segments or crank.segments)


def exact_moments(crank: Design, segments: int = 128) -> Moments:
    """Return the mass moments of the true surface, without facets.

    The facets' error falls as n⁻², so that two tessellations, one twice as fine as the other in every arc,
    tell the limit (Richardson). What is left falls as n⁻⁴; where surfaces cross slantwise more is left: some
    1e-7 of the mass with oil holes.
    """
    density = crank.density_kg_m3 * G_PER_MM3_PER_KG_M3
    shape = crank_shape(crank)
    coarse, fine = (tessellated(shape, segments, times).moments(density) for times in (1, 2))
    return fine.scaled(4.0 / 3.0) - coarse.scaled(1.0 / 3.0)


def crank_anatomy(crank: Design, placement: Array | None = None) -> Anatomy:
    """Return the anatomy that a crankshaft has, in the rotor frame.

    Parameters
    ----------
    crank : Design
    placement : (4, 4) float, optional
        The rigid motion that takes the crank from its own axes to the file's.
    """
    place = np.eye(4) if placement is None else placement
    plan = _plan(crank)
    sense = _sense(place[:3, 2])
    order = slice(None, None, sense)
    pins = plan.pins[order]
    frame = _rotor_frame(pins[0].angle_rad, sum(_bare(crank, plan, pins[0])) / 2.0, sense)
    throws = []
    for number, span in enumerate(pins, start=1):
        low, high = _bare(crank, plan, span)
        centre = _moved(frame, (*_at(crank.crank_radius_mm, span.angle_rad), 0.5 * (low + high)))
        angle = math.atan2(centre[1], centre[0]) % (2.0 * math.pi)
        angle = 0.0 if 2.0 * math.pi - angle < 1e-12 else angle
        pin = Pin(centre, crank.crankpin.diameter_mm, high - low)
        throws.append(Throw(number, crank.crank_radius_mm, angle, pin))
    return Anatomy(
        file_to_rotor=frame @ np.linalg.inv(place),
        main_journals=_main_journals(crank, plan, frame, order),
        throws=tuple(throws),
        webs=_webs(crank, plan, frame, order),
        journal_misalignment_mm=0.0,
    )


def _sense(direction: Array) -> int:
    """Return 1 if the axis already points where the rotor frame wants it, else −1."""
    largest = np.abs(direction).max()
    decider = int(np.flatnonzero(np.abs(direction) >= largest - 1e-6)[0])
    return 1 if direction[decider] > 0.0 else -1


def _bare(crank: Design, plan: _Plan, pin: _Span) -> tuple[float, float]:
    """Return where a crankpin's bare cylinder begins and ends.

    Without its pin, that is the gap between the webs; beside the last web of an overhung crank there is none.
    """
    if _has_free_end(crank, plan, pin) and not crank.crankpin_in_file:
        return pin.low, pin.low
    fillet = crank.fillet_mm if crank.crankpin_in_file else 0.0
    return pin.low + fillet, pin.high - (0.0 if _has_free_end(crank, plan, pin) else fillet)


def _rotor_frame(angle_rad: float, z_mm: float, sense: int) -> Array:
    """Return the matrix (4, 4) from the crank's own axes to the rotor frame of a crankpin 1 there."""
    x = np.array([math.cos(angle_rad), math.sin(angle_rad), 0.0])
    z = np.array([0.0, 0.0, float(sense)])
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z])
    frame[2, 3] = -sense * z_mm
    return frame


def _moved(frame: Array, point: tuple[float, float, float]) -> Array:
    moved: Array = frame[:3, :3] @ np.array(point) + frame[:3, 3]
    return moved


def _main_journals(crank: Design, plan: _Plan, frame: Array, order: slice) -> tuple[MainJournal, ...]:
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


def _webs(crank: Design, plan: _Plan, frame: Array, order: slice) -> tuple[Web, ...]:
    webs = []
    for number, web in enumerate(plan.webs[order], start=1):
        height = _shoulder_height(crank) if web.counterweight else 0.0
        low = web.low - height * (web.journal_side < 0)
        high = web.high + height * (web.journal_side > 0)
        ends = sorted(float(_moved(frame, (0.0, 0.0, z))[2]) for z in (low, high))
        webs.append(Web(number, ends[0], ends[1], web.counterweight))
    return tuple(webs)


__all__ = ["Bay", "crank_anatomy", "crank_shape", "crank_solid", "exact_moments", "web_outline"]
