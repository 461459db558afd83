"""Webs between journals and crankpins, and the journals of a pressed-up crank."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import dropwhile, groupby, pairwise, takewhile

import numpy as np

from autobalance.crank.anatomy import CounterweightOutline, Web
from autobalance.crank.recognition.bores import bore_runs, bored_arm, single_web
from autobalance.crank.recognition.circles import all_within, distances, following
from autobalance.crank.recognition.cylinder_runs import (
    MAX_INNER_DEPTH_RATIO,
    SAME_CENTRE,
    CylinderRun,
    bare_cylinder,
)
from autobalance.crank.recognition.layout import JournalLayout, crank_axis, mean_centre
from autobalance.crank.recognition.section_stack import ASIDE_SHARE, CrossSection, SectionPiece, SectionStack
from autobalance.crank.recognition.through_shaft import journal_choices
from autobalance.errors import RecognitionError
from autobalance.types import Array

# Webs between journals and crankpins, and whether they carry a counterweight.


MAX_COLLAR_OFFSET_RATIO = 0.02
"""A section piece is a collar or fillet of a cylinder when it is a circle whose centre is off the cylinder's
by less than this share of its radius."""
COUNTERWEIGHT_SHARE = 0.4
"""A web carries a counterweight when its first moment beyond the axis, away from the crankpin, is at least
this share of that on the crankpin's side. A plain web's hub has less than a quarter, a disc has all."""
DISC_SHARE = 0.99
"""... but it is a round hub about the axis, not a counterweight, if that moment is less than this share and
the web's outline is one arc that continues there towards the crankpin. A counterweight's edges step in."""
HUB_FROM_RAD, HUB_RAYS = math.radians(78.0), 16
"""The arc is looked at from this angle to the crankpin on, on both sides, at so many places."""
HUB_ROUNDNESS = 0.05
"""Largest change of its radius, as a share; facets of a coarse circle are in by 0.035."""
CYLINDER_MARGIN_RATIO = 0.25
"""Within the width that a job (or the recogniser) gives a cylinder, metal up to this share beyond its radius
is still the cylinder: corners of coarse facets, a diameter given roundly."""
ROUGH_FILLET = 0.2
"""Fillets of a scanned crank are lower than this share of their cylinder's radius."""
MAX_RAGGED_SECTIONS = 3
"""Number of a scan's sections in a row that may cut a step's face, whose waves do not form a circle."""
RIM_SHARE = 0.99
"""The rim is where the counterweight reaches at least this share of its largest radius."""


def find_webs(long: SectionStack, layout: JournalLayout) -> list[Web]:
    """Return the webs by increasing z, in the turned axes' z [mm]."""
    z = long.vertices[:, 2]
    ends = float(z.min()), float(z.max())
    if layout.bored and layout.lone_bores:
        one, other = (_end(layout.axis, end) for end in ends)
        extent = _extent(long, one, other, layout)
        return [] if extent is None else [_web(long, layout.axis, extent, layout.pins, 1)]
    order = sorted(
        [(_faced(run, layout.pins, ends) if layout.bored else run, False) for run in layout.journals]
        + [(_faced(run, layout.journals, ends) if layout.lone_bores else run, True) for run in layout.pins],
        key=lambda item: item[0].z_mid,
    )
    if order[0][1]:  # beyond an outermost crankpin there may be a web without a journal
        order.insert(0, (_end(layout.axis, ends[0]), False))
    if order[-1][1]:
        order.append((_end(layout.axis, ends[1]), False))
    webs: list[Web] = []
    for (a, a_is_pin), (b, b_is_pin) in pairwise(order):
        if not (a_is_pin or b_is_pin):
            continue
        extent = _extent(long, a, b, layout)
        if extent is not None:
            pins = [run for run, is_pin in ((a, a_is_pin), (b, b_is_pin)) if is_pin]
            webs.append(_web(long, layout.axis, extent, pins, len(webs) + 1))
    return webs


def _faced(run: CylinderRun, others: Sequence[CylinderRun], ends: tuple[float, float]) -> CylinderRun:
    """Return the circle of a bore in a web at that end of the part which is away from other cylinders."""
    end = ends[1] if run.z_mid > others[0].z_mid else ends[0]
    return replace(run, z_low=end, z_high=end)


def _end(axis: Array, z_mm: float) -> CylinderRun:
    """Return the end of the part as a journal without width."""
    return CylinderRun(axis, 0.0, z_mm, z_mm)


def _extent(
    long: SectionStack, a: CylinderRun, b: CylinderRun, layout: JournalLayout
) -> tuple[float, float] | None:
    """Return beginning and end of the web between two cylinders; None without a web."""
    sections = [s for s in long.sections if a.z_mid < s.z_mm < b.z_mid]
    inside = _without_ragged(
        [place for place, s in enumerate(sections) if _is_web(s, a, b, layout.shafts)], long.blur_mm > 0.0
    )
    if not inside:
        return None
    first, last = inside[0], inside[-1]
    before = sections[first - 1] if first > 0 else None
    after = sections[last + 1] if last + 1 < len(sections) else None
    beside = 4.0 * ASIDE_SHARE * long.length_mm  # a small blend around a level belongs to the level
    low = _edge(long, before.z_mm if before else a.z_mid, sections[first].z_mm + beside, a, upward=True)
    high = _edge(long, sections[last].z_mm - beside, after.z_mm if after else b.z_mid, b, upward=False)
    return low, high


def _without_ragged(inside: Sequence[int], rough: bool) -> Sequence[int]:
    """Return the sections of a rough web without the few that lie apart: through the face of a step."""
    if not rough or not inside:
        return inside
    stretches = np.split(np.array(inside), np.flatnonzero(np.diff(inside) > 1) + 1)
    longest = max(map(len, stretches))
    return [
        int(place)
        for some in stretches
        if len(some) > min(MAX_RAGGED_SECTIONS, longest - 1)
        for place in some
    ]


def _is_web(section: CrossSection, a: CylinderRun, b: CylinderRun, shafts: Sequence[CylinderRun]) -> bool:
    """Return whether a section has metal that is neither cylinder nor its fillet or collar.

    Nor is a shaft beside a crankpin web, nor the outline of both where they are one piece.
    """
    z = section.z_mm
    through = [shaft for shaft in shafts if shaft.z_low <= z <= shaft.z_high]
    return any(
        not (_belongs(piece, z, a, b) or _belongs(piece, z, b, a) or _is_within(piece, through, a, b))
        for piece in section.pieces
    )


def _is_within(piece: SectionPiece, through: Sequence[CylinderRun], a: CylinderRun, b: CylinderRun) -> bool:
    """Return whether every corner of a piece is within a shaft or one of two cylinders."""
    if not through:
        return False
    beyond = [
        distances(piece.outline, run.centre) - (1.0 + MAX_INNER_DEPTH_RATIO) * run.radius
        for run in (*through, a, b)
    ]
    return all_within(np.min(beyond, axis=0), 0.0, piece.rough_mm)


def _belongs(piece: SectionPiece, z: float, run: CylinderRun, other: CylinderRun) -> bool:
    room = CYLINDER_MARGIN_RATIO if run.z_low <= z <= run.z_high else MAX_INNER_DEPTH_RATIO
    if piece.reach_from(run.centre) <= (1.0 + room) * run.radius + piece.rough_mm:
        return True
    circle = piece.circle
    if (
        circle is None
        or float(np.linalg.norm(circle.centre - run.centre)) > MAX_COLLAR_OFFSET_RATIO * circle.radius
    ):
        return False
    return circle.radius < float(np.linalg.norm(other.centre - run.centre))


def _edge(long: SectionStack, low: float, high: float, run: CylinderRun, upward: bool) -> float:
    """Return the web's beginning (``upward``) or end between two stations: a level, or its last vertex."""
    levels = (long.levels_mm >= low) & (long.levels_mm <= high)
    if levels.any():
        return float(long.levels_mm[levels][np.argmax(long.level_areas_mm2[levels])])
    if long.blur_mm > 0.0:  # sections of a rough fillet show no circle, and are taken for the web
        inward = long.blur_mm + ROUGH_FILLET * run.radius
        low, high = (low, high + inward) if upward else (low - inward, high)
        near = long.levels_mm[(long.levels_mm >= low) & (long.levels_mm <= high)]
        if len(near):
            return float(near[0] if upward else near[-1])
    z = long.vertices[:, 2]
    near = long.vertices[(z >= low) & (z <= high)]
    outside = near[distances(near, run.centre) > (1.0 + MAX_COLLAR_OFFSET_RATIO) * run.radius]
    if len(outside) == 0:
        return high if upward else low
    return float(outside[:, 2].min() if upward else outside[:, 2].max())


def _web(
    long: SectionStack, axis: Array, extent: tuple[float, float], pins: Sequence[CylinderRun], number: int
) -> Web:
    low, high = extent
    arms = [pin.centre - axis for pin in pins]
    towards = sum((arm / np.linalg.norm(arm) for arm in arms), np.zeros(2))
    if float(np.linalg.norm(towards)) < 1e-3:
        towards = arms[0]
    towards = towards / np.linalg.norm(towards)
    sections = [s for s in long.sections if low < s.z_mm < high]
    beyond = toward = 0.0
    for pieces, equal in groupby(section.pieces for section in sections):
        count = len(list(equal))
        for piece in pieces:
            for outline in (piece.outline, *piece.holes):
                toward += count * _half_moment((outline - axis) @ _basis(towards))
                beyond += count * _half_moment((outline - axis) @ _basis(-towards))
    heavy = beyond >= COUNTERWEIGHT_SHARE * toward
    if heavy and beyond < DISC_SHARE * toward:
        heavy = not _is_round_hub(sections, axis, towards)
    outline_of = _outline(sections, axis, towards, extent) if heavy and sections else None
    return Web(number, low, high, heavy, outline_of)


def _is_round_hub(sections: Sequence[CrossSection], axis: Array, towards: Array) -> bool:
    """Return whether a web away from its crankpin is an arc about the axis that continues towards it."""
    angles = np.concatenate([sign * np.linspace(HUB_FROM_RAD, math.pi, HUB_RAYS) for sign in (1.0, -1.0)])
    outlines = {id(piece): piece.outline for section in sections for piece in section.pieces}
    reach = np.max([_reach(outline - axis, towards, angles) for outline in outlines.values()], axis=0)
    return bool(reach.min() > 0.0 and reach.max() <= (1.0 + HUB_ROUNDNESS) * reach.min())


def _reach(outline: Array, towards: Array, angles: Array) -> Array:
    """Return the reach of a closed outline (k, 2) from the origin at angles (n,) from a direction [mm]."""
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1) @ np.array(
        [[towards[0], towards[1]], [-towards[1], towards[0]]]
    )
    a, b = outline, following(outline)
    one, other = (rays[:, :1] * p[:, 1] - rays[:, 1:] * p[:, 0] for p in (a, b))
    crosses = (one < 0.0) != (other < 0.0)
    share = np.divide(one, one - other, out=np.zeros_like(one), where=crosses)
    along = rays[:, :1] * (a[:, 0] + share * (b - a)[:, 0]) + rays[:, 1:] * (a[:, 1] + share * (b - a)[:, 1])
    reach: Array = np.where(crosses, along, 0.0).max(axis=1)
    return reach


def _basis(towards: Array) -> Array:
    return np.array([[towards[0], -towards[1]], [towards[1], towards[0]]])


def _half_moment(outline: Array) -> float:
    """Return ∫ x dA over the part x > 0 of the area inside a counter-clockwise outline (k, 2), exactly."""
    x0, y0 = outline.T
    x1, y1 = following(x0), following(y0)
    a, b = np.maximum(x0, 0.0), np.maximum(x1, 0.0)
    run = x1 - x0
    steep = np.abs(run) > 1e-9 * (np.abs(x0) + np.abs(x1) + 1e-300)
    mean = np.where(steep, (b**3 - a**3) / (6.0 * np.where(steep, run, 1.0)), 0.5 * a**2)
    return float((mean * (y1 - y0)).sum())


def _outline(
    sections: Sequence[CrossSection], axis: Array, towards: Array, extent: tuple[float, float]
) -> CounterweightOutline | None:
    points = np.concatenate([p.outline for p in dict.fromkeys(p for s in sections for p in s.pieces)]) - axis
    local = points @ _basis(-towards)
    local = local[local[:, 0] > 0.0]
    if len(local) == 0:
        return None
    reach = np.hypot(*local.T)
    rim = float(reach.max())
    angles = np.arctan2(local[:, 1], local[:, 0])[reach >= RIM_SHARE * rim]
    fan = min(float(np.ptp(angles)), 2.0 * math.pi)
    skew = 0.5 * float(angles.min() + angles.max())
    return CounterweightOutline(rim, fan, extent[1] - extent[0], skew)


# Journals of a pressed-up crank, whose throws are the gaps between bores.


BORE_DISTANCE_RATIO = 0.5
"""Ratio by which a bore of a half crank is nearer to the end with the web than to the other end."""


def pressed_up_layout(
    long: SectionStack, runs: Sequence[CylinderRun], given_axis: Array | None, rounding_mm: float
) -> JournalLayout:
    """Return journals and throws of a crank whose crankpins are not in the file, from the pins' bores.

    Raises
    ------
    RecognitionError
        If there is no axis, or no gap between webs has a bore at its sides.
    """
    web = _lone_web(long, runs, given_axis, rounding_mm)
    if web is not None:
        return web
    on_axis = crank_axis(long, runs, given_axis)
    axis = mean_centre(on_axis)
    gaps = _gaps(long, axis)
    if not gaps:
        raise RecognitionError(
            "no gap between webs and no web's face with a bore for the crankpin found; cylinders: "
            f"{len(on_axis)} on the axis, {len(runs) - len(on_axis)} beside it. "
            "Set crankpins, or crankpin_in_file = true if they are in the file"
        )
    pins = [_bore_pin(long, gap, axis, rounding_mm) for gap in gaps]
    layout = JournalLayout.chosen(axis, journal_choices(long, on_axis, pins, axis), pins)
    if gaps[0][1] > gaps[0][0]:
        return layout
    bores = bore_runs(long, rounding_mm)
    layout = replace(layout, pins=(_own_bore(bores, pins[0], gaps[0][0]),), lone_bores=True)
    arm = bored_arm(long, runs, bores)
    if arm is None or arm.settled is False:
        return layout
    other = arm.shaft if given_axis is None else None
    setting = "crankshaft.crankpin_in_file = true"
    return replace(layout, pins=(arm.shaft,), other_axis=other, axis_setting=setting)


def _own_bore(bores: Sequence[CylinderRun], pin: CylinderRun, end_mm: float) -> CylinderRun:
    """Return the bore that a crankpin is pressed into, of half a crank: the metal beside it is the web's.

    Of several in line, as the two sides of a counterbore are, it is the one next to the web's free face.
    """
    own = [bore for bore in bores if _near((bore.centre, bore.radius), (pin.centre, pin.radius))]
    if not own:
        raise RecognitionError(
            f"the crankpin's bore, {2.0 * pin.radius:.4g} mm wide, has no measurable depth. Set crankpins"
        )
    return min(own, key=lambda bore: min(abs(bore.z_low - end_mm), abs(bore.z_high - end_mm)))


def _lone_web(
    long: SectionStack, runs: Sequence[CylinderRun], given_axis: Array | None, rounding_mm: float
) -> JournalLayout | None:
    """Return the layout of one web of a built-up crank, whose bores are the shaft's and the crankpin's."""
    if not all(section.pieces for section in long.sections):
        return None
    web = single_web(long, runs, bore_runs(long, rounding_mm), is_web=given_axis is not None)
    if web is None:
        return None
    if given_axis is not None:
        away = [float(np.linalg.norm(bore.centre - given_axis)) for bore in (web.shaft, web.pin)]
        web = web if away[0] <= away[1] else web.exchanged
    other = web.pin if web.settled is None and given_axis is None else None
    return JournalLayout(
        web.shaft.centre, (web.shaft,), (web.pin,), bored=True, lone_bores=True, other_axis=other
    )


def _gaps(long: SectionStack, axis: Array) -> list[tuple[float, float]]:
    """Return the z ranges without metal; without any, the end of the part if there are bores."""
    z = long.vertices[:, 2]
    empty = [section.z_mm for section in long.sections if not section.pieces]
    gaps: list[tuple[float, float]] = []
    for height in empty:
        if not gaps or height > gaps[-1][1]:
            gaps.append((float(z[z < height].max()), float(z[z > height].min())))
    if gaps:
        return gaps
    ends = [(float(end), float(end)) for end in (z.min(), z.max())]
    depths = [_bore_depth(long, end, side, axis) for end, side in zip(ends, (1, -1), strict=True)]
    order = np.argsort(depths)
    first, second = (depths[place] for place in order)
    return [ends[order[0]]] if first < BORE_DISTANCE_RATIO * second else []


def _bore_depth(long: SectionStack, end: tuple[float, float], side: int, axis: Array) -> float:
    """Return the distance of a round hole beside the axis from an end of the part; infinite without one."""
    sections = _webward(long, end, side, axis)
    return abs(sections[0].z_mm - end[0]) if sections else np.inf


def _bore_pin(long: SectionStack, gap: tuple[float, float], axis: Array, rounding_mm: float) -> CylinderRun:
    sides = [_bores(_webward(long, gap, side, axis), axis) for side in (-1, 1)]
    with_bores = [bores for bores in sides if bores]
    if not with_bores or (gap[1] > gap[0] and len(with_bores) < 2):
        raise RecognitionError(
            f"a side of the gap between webs, {gap[0]:.4g} to {gap[1]:.4g} mm from the middle of the part, "
            "has no bore for the crankpin. Set crankpins"
        )
    shared = [
        bore
        for bore in with_bores[0]
        if all(any(_near(bore, other) for other in bores) for bores in with_bores)
    ]
    alone = [bore for bore in shared if not any(_twins(bore, other, axis) for other in shared)]
    shared = sorted(alone or shared, key=lambda bore: -bore[1])  # holes beside the pin come in pairs
    if not shared or (len(shared) > 1 and shared[1][1] > 0.95 * shared[0][1]):
        raise RecognitionError(
            f"{len(shared)} pairs of crankpin bores in line found, expected one. Set crankpins"
        )
    centre, radius = shared[0]
    z = long.vertices[:, 2]
    reach = 0.5 * (float(z.max()) - float(z.min()))
    exact = bare_cylinder(long, centre, radius, (gap[0] - reach, gap[1] + reach), 0.0, rounding_mm)
    if exact is not None and float(np.linalg.norm(exact.centre - centre)) < SAME_CENTRE * radius:
        centre, radius = exact.centre, exact.radius
    return CylinderRun(centre, radius, gap[0], gap[1])


def _twins(a: tuple[Array, float], b: tuple[Array, float], axis: Array) -> bool:
    """Return whether two different bores have one size and one distance from the axis."""
    away = [float(np.linalg.norm(bore[0] - axis)) for bore in (a, b)]
    alike = abs(a[1] - b[1]) < 0.05 * a[1] and abs(away[0] - away[1]) < SAME_CENTRE * away[0]
    return alike and not _near(a, b)


def _near(a: tuple[Array, float], b: tuple[Array, float]) -> bool:
    return float(np.linalg.norm(a[0] - b[0])) < SAME_CENTRE * min(a[1], b[1]) and abs(
        a[1] - b[1]
    ) < 0.2 * min(a[1], b[1])


def _webward(long: SectionStack, gap: tuple[float, float], side: int, axis: Array) -> list[CrossSection]:
    """Return the sections of the web beyond a gap that have a round hole beside the axis.

    The first few may be missing: those of a shoulder or a collar, and of a face that leans a little.
    """
    edge = gap[0] if side < 0 else gap[1]
    outward = sorted(
        (section for section in long.sections if side * (section.z_mm - edge) > 0.0),
        key=lambda section: side * section.z_mm,
    )
    solid = takewhile(lambda section: bool(section.pieces), outward)
    begun = dropwhile(lambda section: not _bores([section], axis), solid)
    return list(takewhile(lambda section: bool(_bores([section], axis)), begun))


def _bores(sections: Sequence[CrossSection], axis: Array) -> list[tuple[Array, float]]:
    """Return centre and radius of each round hole beside the axis, once."""
    bores: list[tuple[Array, float]] = []
    for section in sections:
        for piece in section.pieces:
            for bore in piece.bores:
                here = (bore.centre, bore.radius)
                beside = float(np.linalg.norm(bore.centre - axis)) > 0.1 * bore.radius
                if beside and not any(_near(here, other) for other in bores):
                    bores.append(here)
    return bores
