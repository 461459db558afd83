"""Crankpins of a shaft that runs straight through: beside it between webs, or around it as eccentrics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

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
from autobalance.crank.recognition.section_stack import SectionPiece, SectionStack, encloses
from autobalance.types import Array

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
