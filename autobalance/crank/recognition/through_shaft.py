"""Crankpins of a shaft that runs straight through: beside it between webs, or around it as eccentrics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from autobalance.crank.recognition.circles import Circle, all_within, corners_of, distances, fit_circle
from autobalance.crank.recognition.cylinder_runs import (
    LEAST_VERTICES,
    LEAST_WIDTH,
    SAME_CENTRE,
    SAME_RADIUS,
    CylinderRun,
    bare_cylinder,
)
from autobalance.crank.recognition.datums import shaft_marks
from autobalance.crank.recognition.section_stack import SectionPiece, SectionStack, encloses
from autobalance.types import Array
from autobalance.value_classes import dataclass

ON_CIRCLE = 1e-3
"""Corners of an eccentric's outline are off its circle by less than this share of the radius."""
HIDDEN_SHARE = 0.5
"""Waves hide an eccentric's circle for at most this share of its radius."""
BARE_SHARE = 0.6
"""At least this share of an eccentric's circle is bare: the shaft takes the rest. Of the boss of a web around
a crankpin it is less than half."""
MIN_HELD_BOTH_RATIO, MIN_HELD_ONCE_RATIO = 0.3, 0.5
"""Smallest radius of a crankpin next to a shaft, as a share of the shaft's: first if both of its ends are
held, then if one is free. A dowel next to a flange's pilot has less than the second."""
MOSTLY = 0.5
"""A shaft's cylinder with a crankpin next to more than this share of it is not a journal."""
MIN_SHAFT_RATIO = 2.0
"""Beyond the free end of a crankpin its shaft continues for at least this many times its radius."""


def find_eccentrics(
    long: SectionStack, on_axis: Sequence[CylinderRun], axis: Array, rounding_mm: float
) -> list[CylinderRun]:
    """Return the cylinders from which a shaft that runs through them stands out at one side.

    Their section is one piece, whose outline is part of the shaft's circle and most of another's.
    ``on_axis`` are the shaft's bare cylinders, ``axis`` (2,) is their centre.
    """
    chains: list[list[tuple[int, Circle]]] = []
    last: tuple[tuple[SectionPiece, ...], Circle | None] = ((), None)
    for place, section in enumerate(long.sections):
        if section.pieces is not last[0]:
            last = section.pieces, _eccentric_circle(section.pieces, _radii_near(on_axis, section.z_mm), axis)
        circle = last[1]
        if circle is None:
            continue
        if chains and _meets(long, chains[-1], place, circle):
            chains[-1].append((place, circle))
        else:
            chains.append([(place, circle)])
    runs = [_run(long, chain, rounding_mm) for chain in chains]
    return [run for run in runs if run is not None]


def _meets(long: SectionStack, chain: Sequence[tuple[int, Circle]], place: int, circle: Circle) -> bool:
    """Return whether an eccentric's circle follows a chain; waves may hide it in a few sections of a scan."""
    last, first = chain[-1][0], chain[0][1]
    if last == place - 1 or not long.blur_mm > 0.0:
        return last == place - 1 and _same(circle, first)
    between = long.sections[last + 1 : place]
    gap = long.sections[place].z_mm - long.sections[last].z_mm
    whole = any(piece.circle is not None for section in between for piece in section.pieces)
    return gap < HIDDEN_SHARE * circle.radius and not whole and _same(circle, first)


def _radii_near(on_axis: Sequence[CylinderRun], z_mm: float) -> set[float]:
    """Return the radii of the shaft's next cylinders below and above a height."""
    below = max((r for r in on_axis if r.z_mid < z_mm), key=lambda r: r.z_mid, default=None)
    above = min((r for r in on_axis if r.z_mid >= z_mm), key=lambda r: r.z_mid, default=None)
    return {run.radius for run in (below, above) if run is not None}


def _eccentric_circle(
    pieces: Sequence[SectionPiece], shaft_radii: Iterable[float], axis: Array
) -> Circle | None:
    """Return the circle of an eccentric around a shaft of one of some radii; None without one."""
    if len(pieces) != 1 or pieces[0].circle is not None:
        return None
    piece = pieces[0]
    corners = corners_of(piece.outline, piece.grain_mm)
    for radius in shaft_radii:
        away = distances(corners, axis)
        on_shaft = away <= (1.0 + ON_CIRCLE) * radius + piece.rough_mm
        rest = corners[~on_shaft]
        if len(rest) < LEAST_VERTICES or float(np.abs(away[on_shaft] - radius).min(initial=np.inf)) > (
            ON_CIRCLE * radius + piece.rough_mm
        ):
            continue
        centre, size = fit_circle(rest)
        off = np.abs(distances(rest, centre) - size)
        beside = float(np.linalg.norm(centre - axis)) > SAME_CENTRE * size
        round_ = all_within(off, ON_CIRCLE * size, piece.rough_mm)
        if beside and round_ and _bare_share(rest, centre) >= BARE_SHARE:
            return Circle(centre, size)
    return None


def _bare_share(points: Array, centre: Array) -> float:
    """Return the share of the full angle around ``centre`` that is left beside the widest gap of points."""
    angles = np.sort(np.arctan2(points[:, 1] - centre[1], points[:, 0] - centre[0]))
    gaps = np.diff(angles, append=angles[0] + 2.0 * math.pi)
    return 1.0 - float(gaps.max()) / (2.0 * math.pi)


def _same(a: Circle, b: Circle) -> bool:
    return (
        abs(a.radius - b.radius) < SAME_RADIUS * b.radius
        and float(np.linalg.norm(a.centre - b.centre)) < SAME_CENTRE * b.radius
    )


def _run(long: SectionStack, chain: Sequence[tuple[int, Circle]], rounding_mm: float) -> CylinderRun | None:
    centre = np.median([circle.centre for _, circle in chain], axis=0)
    radius = float(np.median([circle.radius for _, circle in chain]))
    first, last = chain[0][0], chain[-1][0]
    low, high = long.sections[first].z_mm, long.sections[last].z_mm
    if long.blur_mm > 0.0:
        return CylinderRun(centre, radius, low, high) if high - low > LEAST_WIDTH * radius else None
    z_from = long.sections[first - 1].z_mm if first > 0 else -np.inf
    z_to = long.sections[last + 1].z_mm if last + 1 < len(long.sections) else np.inf
    return bare_cylinder(long, centre, radius, (z_from, z_to), high - low, rounding_mm)


def with_eccentrics(runs: Sequence[CylinderRun], eccentrics: Sequence[CylinderRun]) -> list[CylinderRun]:
    """Return bare cylinders by increasing z, eccentrics among them, joined where they are parts of one."""
    joined = list(runs)
    for part in eccentrics:
        whole = part
        for run in [*joined]:
            if _continues(whole, run):
                joined = [other for other in joined if other is not run]
                larger = max(whole, run, key=lambda one: one.width)
                ends = min(whole.z_low, run.z_low), max(whole.z_high, run.z_high)
                whole = replace(larger, z_low=ends[0], z_high=ends[1])
        joined.append(whole)
    return sorted(joined, key=lambda run: run.z_mid)


def _continues(a: CylinderRun, b: CylinderRun) -> bool:
    """Return whether two bare cylinders are parts of one that meet."""
    return (
        abs(a.radius - b.radius) < SAME_RADIUS * b.radius
        and float(np.linalg.norm(a.centre - b.centre)) < SAME_CENTRE * b.radius
        and shared_mm(a, b) > -LEAST_WIDTH * b.radius
    )


def shared_mm(a: CylinderRun, b: CylinderRun) -> float:
    """Return the length along z that two cylinders share [mm], below 0 where they are apart."""
    return min(a.z_high, b.z_high) - max(a.z_low, b.z_low)


def pins_beside_shaft(
    long: SectionStack, on_axis: Sequence[CylinderRun], others: Sequence[CylinderRun], slack_mm: float
) -> list[CylinderRun]:
    """Return the cylinders beside a shaft that runs past them, each alone with it and held by a web.

    A cylinder with a free end is a crankpin only if its radius is at least half the shaft's, and the shaft
    continues past it for a journal's length. The eyes of a connecting rod end together.
    """
    if len(on_axis) < 2:
        return []
    pins = []
    for run in others:
        beside = [one for one in on_axis if shared_mm(one, run) > slack_mm]
        alone = all(shared_mm(run, other) < slack_mm for other in others if other is not run)
        if not beside or not alone:
            continue
        shaft = max(beside, key=lambda one: one.radius)
        free = [side for side in (-1, 1) if not _goes_on(long, run, side)]
        least = (MIN_HELD_ONCE_RATIO if free else MIN_HELD_BOTH_RATIO) * shaft.radius
        long_enough = all(_beyond_mm(beside, run, side) >= MIN_SHAFT_RATIO * shaft.radius for side in free)
        if len(free) < 2 and run.radius >= least and long_enough:
            pins.append(run)
    return pins


def _goes_on(long: SectionStack, run: CylinderRun, side: int) -> bool:
    """Return whether there is metal beyond a cylinder's end, on the lower (-1) or upper (1) side."""
    end = run.z_low if side < 0 else run.z_high
    beyond = [section for section in long.sections if side * (section.z_mm - end) > 0.0]
    nearest = min(beyond, key=lambda section: abs(section.z_mm - end), default=None)
    return nearest is not None and any(encloses(piece.outline, run.centre) for piece in nearest.pieces)


def _beyond_mm(shafts: Sequence[CylinderRun], run: CylinderRun, side: int) -> float:
    """Return the length by which shafts next to a cylinder continue past its end on a side."""
    if side < 0:
        return run.z_low - min(shaft.z_low for shaft in shafts)
    return max(shaft.z_high for shaft in shafts) - run.z_high


def shafts_within(
    long: SectionStack, on_axis: Sequence[CylinderRun], pins: Sequence[CylinderRun], axis: Array
) -> tuple[CylinderRun, ...]:
    """Return the stretches of a shaft beside or within each crankpin; none where a web alone holds it."""
    stretches = []
    for pin in pins:
        beside = [run for run in on_axis if shared_mm(run, pin) > MOSTLY * min(run.width, pin.width)]
        radii = {run.radius for run in beside}
        if not beside:
            reach = pin.radius + float(np.linalg.norm(pin.centre - axis))
            touching = (
                run for run in on_axis if shared_mm(run, pin) > -max(LEAST_WIDTH * run.radius, long.blur_mm)
            )
            radii = {run.radius for run in touching if run.radius < reach}
        stretches += [CylinderRun(axis, radius, pin.z_low, pin.z_high) for radius in radii]
    return tuple(stretches)


def clear_of(
    runs: Sequence[CylinderRun], pins: Sequence[CylinderRun]
) -> list[tuple[CylinderRun, CylinderRun]]:
    """Return the part of each cylinder that no crankpin is next to, with the cylinder itself."""
    parts = []
    for run in runs:
        if any(shared_mm(run, pin) > MOSTLY * run.width for pin in pins):
            continue
        ends = [(run.z_low, run.z_high)]
        for pin in pins:
            ends = (
                [
                    (low, high)
                    for a, b in ends
                    for low, high in ((a, min(b, pin.z_low)), (max(a, pin.z_high), b))
                    if high - low > LEAST_WIDTH * run.radius
                ]
                if shared_mm(run, pin) > 0.0
                else ends
            )
        widest = max(ends, key=lambda pair: pair[1] - pair[0], default=None)
        if widest is not None:
            whole = widest == (run.z_low, run.z_high)
            parts.append((run if whole else replace(run, z_low=widest[0], z_high=widest[1]), run))
    return parts


# Choice of the main journal on each stretch of the crank axis that crankpins part.
#
# If several cylinders are on one stretch, the rules apply in this order. A cylinder as thick as the certain
# journals is chosen first, then one next to the web that is not a thrust collar, then one as thick as
# journals chosen in this way. A keyway, a spline or teeth mark a shaft. If the choice stays open, it is a
# doubt: one cylinder is chosen, another may be meant.


SAME_THICKNESS = 0.02
"""Main journals of one crank differ by less than this share of their diameter, as a rule."""
RING, RING_DOUBT = 0.15, 0.3
"""A cylinder narrower than the first share of its diameter is a ring: a thrust collar, a gear's or a seal's.
One up to the second share may be. A public crank has shoulders of 54 mm by 12 mm at its webs, and its seats
of 34.93 mm by 18.8 mm behind them. Another one has main journals of 69.85 mm by 19.05 mm."""
ROUGH_RING = 0.9
"""Rounded edges of a scan leave so much of a ring's width (a journal of 19.05 mm: 17.44 mm)."""
LIKELY_RING = 0.225
"""Ratio of the ring's width to the width of the seat behind it below which the seat is chosen."""
SEAT = 0.4
"""Smallest width of a bearing's seat as a share of its diameter."""


@dataclass(frozen=True, eq=False)
class JournalChoice:
    """A main journal, and the cylinder that may be meant instead of it; None without a doubt."""

    run: CylinderRun
    other: CylinderRun | None = None


@dataclass(frozen=True, eq=False)
class _Stretch:
    """The cylinders on one stretch of the axis, by z, and whether a crankpin is below and above it."""

    runs: tuple[CylinderRun, ...]
    below: bool
    above: bool

    def outward(self, runs: Sequence[CylinderRun]) -> list[list[CylinderRun]]:
        """Return cylinders in their order from the web: at an end once, between crankpins from both sides."""
        orders = [list(runs)] if self.below else []
        return [*orders, list(runs)[::-1]] if self.above else orders


def journal_choices(
    long: SectionStack, on_axis: Sequence[CylinderRun], pins: Sequence[CylinderRun], axis: Array
) -> list[JournalChoice]:
    """Return the main journal of each stretch of the axis, by z; a stretch of discs alone has no journal.

    Parameters
    ----------
    long : SectionStack
    on_axis, pins : sequence of CylinderRun
        Cylinders on the axis, and crankpins.
    axis : (2,) float
        Of the crank, in the turned axes.
    """
    stretches = _stretches(on_axis, pins, axis)
    if not stretches:
        return [JournalChoice(max(on_axis, key=lambda run: run.width))]
    size = ROUGH_RING if long.blur_mm else 1.0
    likely = [_likely(long, stretch.runs, size) for stretch in stretches]
    certain = [runs[0].radius for runs in likely if len(runs) == 1]
    choices = [_chosen(*each, certain, size) for each in zip(stretches, likely, strict=True)]
    certain += [choice.run.radius for choice in choices if choice.other is None]
    return [
        choice if choice.other is None else _chosen(stretch, runs, certain, size)
        for choice, stretch, runs in zip(choices, stretches, likely, strict=True)
    ]


def _stretches(on_axis: Sequence[CylinderRun], pins: Sequence[CylinderRun], axis: Array) -> list[_Stretch]:
    """Return the stretches between crankpins, without the discs that hold one."""
    borders = sorted(pins, key=lambda run: run.z_mid)
    ends: list[CylinderRun | None] = [None, *borders, None]
    stretches = []
    for below, above in pairwise(ends):
        beside = [pin for pin in (below, above) if pin is not None]
        here = tuple(
            run
            for run in sorted(on_axis, key=lambda run: run.z_mid)
            if (below is None or run.z_mid >= below.z_mid)
            and (above is None or run.z_mid < above.z_mid)
            and not any(holds(run, pin, axis) for pin in beside)
        )
        if here:
            stretches.append(_Stretch(here, below is not None, above is not None))
    return stretches


def holds(disc: CylinderRun, pin: CylinderRun, centre: Array) -> bool:
    """Return whether a disc about ``centre`` (2,) is wide enough to hold a crankpin: it is a web."""
    offset = float(np.linalg.norm(pin.centre - centre))
    return disc.radius > offset + 0.98 * pin.radius


def _likely(long: SectionStack, runs: Sequence[CylinderRun], size: float) -> list[CylinderRun]:
    """Return the cylinders that are neither rings nor, if others are left, shafts; all if none is left."""
    wide = [run for run in runs if _is_wide(run.width, run, RING * size)]
    if len(wide) > 1 and long.blur_mm == 0.0:
        wide = [run for run in wide if not _is_shaft(long, run)] or wide
    return wide or [max(runs, key=lambda run: run.width)]


def _is_wide(width_mm: float, run: CylinderRun, share: float) -> bool:
    return width_mm >= share * 2.0 * run.radius


def _chosen(
    stretch: _Stretch, likely: Sequence[CylinderRun], certain: Sequence[float], size: float
) -> JournalChoice:
    """Return the choice among cylinders that are neither thin rings nor shafts."""
    alike = [run for run in likely if any(abs(run.radius - r) < SAME_THICKNESS * r for r in certain)]
    orders = stretch.outward(alike or likely)
    picks = [JournalChoice(order[0]) if alike else _beside_web(order, size) for order in orders]
    one, *more = picks
    if not more or more[0].run is one.run:
        other = next((pick.other for pick in picks if pick.other is not None), None)
        return JournalChoice(one.run, other)
    wide, narrow = sorted((one.run, more[0].run), key=lambda run: -run.width)
    return JournalChoice(wide, narrow)


def _beside_web(order: Sequence[CylinderRun], size: float) -> JournalChoice:
    """Return the cylinder next to the web, or the seat behind it where it may be a thrust collar."""
    ring, *rest = order
    if not rest or _is_wide(ring.width, ring, RING_DOUBT * size):
        return JournalChoice(ring)
    seat = rest[0]
    if seat.radius >= ring.radius or not _is_wide(seat.width, seat, SEAT):
        return JournalChoice(ring)
    if _is_wide(ring.width, ring, LIKELY_RING * size):
        return JournalChoice(ring, seat)
    return JournalChoice(seat, ring)


# --- keyways and splines ------------------------------------------------------------------------------------


def _is_shaft(long: SectionStack, run: CylinderRun) -> bool:
    """Return whether keyways, a spline or teeth leave less of a cylinder than a bearing's seat."""
    plain = [(run.z_low, run.z_high)]
    for low, high in shaft_marks(long, run):
        parts = ((a, min(b, low)) for a, b in plain), ((max(a, high), b) for a, b in plain)
        plain = [(a, b) for part in parts for a, b in part if a < b]
    plain_mm = max((b - a for a, b in plain), default=0.0)
    return plain_mm < run.width and not _is_wide(plain_mm, run, SEAT)
