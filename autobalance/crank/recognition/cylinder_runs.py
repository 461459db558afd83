"""Bare cylinders along the crank: runs of sections that stay one and the same circle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.recognition.circles import distances, fit_circle
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

SAME_CENTRE = 0.03
"""Circles of two sections belong to one axis when their centres are closer than this share of the radius."""
SAME_RADIUS = 0.01
"""... and to one cylinder when their radii differ by less than this share."""
ON_CYLINDER = 1e-5
"""A vertex lies on a cylinder when it is off by less than this share of the radius (and rounding)."""
ROUNDING = 3e-7
"""Rounding of a file's coordinates (float32), as a share of the largest coordinate, with some room."""
MAX_INNER_DEPTH_RATIO = 1e-3
"""Metal within a cylinder, up to this share of its radius, is part of it: drillings, keyways, grooves."""
GAP_SHARE = 0.5
"""A groove all around may part a cylinder for this share of its radius."""
SURFACE_LEFT = 0.035
"""Between parts of one cylinder, however long a window parts them, some surface is left: metal still reaches
the radius except for this share (twelve facets)."""
MAX_VERTEX_DISTANCE_RATIO = 0.2
"""Vertices farther than this share of the radius from a cylinder are ignored."""
NARROW_SEARCH_RATIOS = (2e-5, 2e-4)
WIDE_SEARCH_RATIO = 0.02
"""Distances from the sections' circle within which vertices of the cylinder are sought, as shares of the
radius. Regular meshes give it exactly. Irregular ones give it too small by the coarseness of their facets,
and sections through fillets too large. The radius of most vertices is tried then."""
TRIED_RADII = 3
"""Number of most frequent vertex radii that are tried."""
OUT_OF_ROUND = 1e-3
"""A cylinder's vertices are off it by less than this share of its radius, half of them at least: coarse
facets have their corners on the true surface, a scan near it. A web with a rim of two radii looks round only
beside the length of coarse facets."""
OUT_OF_LINE = 0.3
"""Cylinders are out of line when vertices are nearer than this to their own lines, beside a common one."""
LEAST_VERTICES = 8
"""Smallest number of vertices that show a cylinder: fewer are on some circle by chance."""
MOST_OF_SPAN = 0.6
"""A cylinder's vertices reach over at least this share of the sections that show it."""
LEAST_WIDTH = 0.05
"""Bare cylinders shorter than this share of their radius are chamfers and steps."""


@dataclass(frozen=True, eq=False)
class CylinderRun:
    """A bare cylinder: ``centre`` (2,) and ``radius`` in the turned axes, z range of its metal [mm]."""

    centre: Array
    radius: float
    z_low: float
    z_high: float

    @property
    def width(self) -> float:
        """Length of the bare cylinder [mm]."""
        return self.z_high - self.z_low

    @property
    def z_mid(self) -> float:
        """Middle along z [mm]."""
        return 0.5 * (self.z_low + self.z_high)


@dataclass(frozen=True, eq=False)
class Link:
    """A circle in the section with number ``place``: a whole piece of it, or a hole."""

    place: int
    centre: Array
    radius: float

    def continues(self, first: Link, rough_mm: float = 0.0) -> bool:
        """Return whether this circle equals a chain's first one, except for waves of a rough surface."""
        return (
            abs(self.radius - first.radius) < SAME_RADIUS * first.radius + rough_mm
            and float(np.linalg.norm(self.centre - first.centre)) < SAME_CENTRE * first.radius + rough_mm
        )


def find_runs(long: SectionStack, rounding_mm: float) -> list[CylinderRun]:
    """Return the bare cylinders whose whole section piece is their circle, by increasing z."""
    runs = [run_of_chain(long, chain, rounding_mm) for chain in _chains(long)]
    return _joined(long, _distinct([run for run in runs if run is not None]))


def find_thin_runs(
    long: SectionStack, rounding_mm: float, least_width_mm: float, known: Sequence[CylinderRun]
) -> list[CylinderRun]:
    """Return discs too thin for ``find_runs``, but at least ``least_width_mm`` wide; none of those known."""
    chains = [
        chain
        for chain in _chains(long, least_width_mm / LEAST_WIDTH)
        if len(chain) > 1 and not any(_is_on(long, chain, run) for run in known)
    ]
    runs = [run_of_chain(long, chain, rounding_mm, least_width_mm) for chain in chains]
    thin = [run for run in runs if run is not None and run.width < LEAST_WIDTH * run.radius]
    return [run for run in _distinct([*known, *thin]) if any(run is other for other in thin)]


def _is_on(long: SectionStack, chain: Sequence[Link], run: CylinderRun) -> bool:
    """Return whether the middle circle of a chain is a cylinder's."""
    link = chain[len(chain) // 2]
    inside = run.z_low <= long.sections[link.place].z_mm <= run.z_high
    return inside and link.continues(Link(link.place, run.centre, run.radius))


def _chains(long: SectionStack, least_radius_mm: float = 0.0) -> list[list[Link]]:
    """Return the circles of each supposed cylinder of a radius or more, by increasing z."""
    chains: list[list[Link]] = []
    for place, section in enumerate(long.sections):
        for piece in section.pieces:
            if piece.circle is None or piece.circle.radius < least_radius_mm:
                continue
            here = Link(place, piece.circle.centre, piece.circle.radius)
            for chain in reversed(chains):
                if here.continues(chain[0]) and _unbroken(long, chain, here):
                    chain.append(here)
                    break
            else:
                chains.append([here])
    return chains


def _joined(long: SectionStack, runs: Sequence[CylinderRun]) -> list[CylinderRun]:
    """Return runs; pieces of a cylinder that meet end to end or at a drilling are joined."""
    joined: list[CylinderRun] = []
    for run in runs:
        for place, other in enumerate(joined):
            if (
                abs(run.radius - other.radius) < NARROW_SEARCH_RATIOS[-1] * run.radius
                and float(np.linalg.norm(run.centre - other.centre)) < NARROW_SEARCH_RATIOS[-1] * run.radius
                and _meet(long, other, run)
            ):
                joined[place] = replace(other, z_high=run.z_high)
                break
        else:
            joined.append(run)
    return joined


def _meet(long: SectionStack, before: CylinderRun, after: CylinderRun) -> bool:
    """Return whether one piece of a cylinder follows another, and metal between reaches just its radius."""
    gap = after.z_low - before.z_high
    if gap < LEAST_WIDTH * before.radius:
        return gap > -LEAST_WIDTH * before.radius
    between = [s for s in long.sections if before.z_high < s.z_mm < after.z_low]
    own = Link(0, before.centre, before.radius)
    circles = [piece.circle for section in between for piece in section.pieces if piece.circle is not None]
    if not all(Link(0, circle.centre, circle.radius).continues(own) for circle in circles):
        return False  # a groove, or a crankpin between two webs
    reaches = [max((p.reach_from(before.centre) for p in s.pieces), default=0.0) for s in between]
    return gap < GAP_SHARE * before.radius and all(
        (1.0 - SURFACE_LEFT) * before.radius < reach < (1.0 + MAX_INNER_DEPTH_RATIO) * before.radius
        for reach in reaches
    )


def _distinct(runs: Sequence[CylinderRun]) -> list[CylinderRun]:
    """Return cylinders by z, without those that are part of another."""
    kept: list[CylinderRun] = []
    for run in sorted(runs, key=lambda run: -run.width):
        if not any(
            abs(run.radius - other.radius) < SAME_RADIUS * run.radius
            and float(np.linalg.norm(run.centre - other.centre)) < SAME_RADIUS * run.radius
            and min(run.z_high, other.z_high) > max(run.z_low, other.z_low)
            for other in kept
        ):
            kept.append(run)
    return sorted(kept, key=lambda run: run.z_mid)


def _unbroken(long: SectionStack, chain: Sequence[Link], here: Link) -> bool:
    """Return whether a circle follows its chain, with nothing but drillings and grooves between."""
    last = chain[-1].place
    if last >= here.place - 1:
        return last == here.place - 1
    between = long.sections[last + 1 : here.place]
    centre = np.median([link.centre for link in chain], axis=0)
    radius = float(np.median([link.radius for link in chain]))
    circles = [p.circle for s in between for p in s.pieces if p.circle is not None]
    if any(float(np.linalg.norm(c.centre - centre)) > SAME_CENTRE * c.radius for c in circles):
        return False
    least, most = (1.0 - SURFACE_LEFT) * radius, (1.0 + MAX_INNER_DEPTH_RATIO) * radius
    if circles:
        groove = long.sections[here.place].z_mm - long.sections[last].z_mm <= GAP_SHARE * radius
        if not (groove and len(chain) > 1):  # two sections through fillets are not a cylinder with a groove
            return False
        least = 0.0
    distinct = {section.pieces for section in between}
    return all(
        least < max((piece.reach_from(centre) for piece in pieces), default=0.0) <= most
        for pieces in distinct
    )


def run_of_chain(
    long: SectionStack, chain: Sequence[Link], rounding_mm: float, least_width_mm: float | None = None
) -> CylinderRun | None:
    """Return the cylinder of a chain of circles, its ends at its last vertices; None if they show none.

    It is at least ``least_width_mm`` wide (default: a share of its radius).
    """
    centre = np.median([link.centre for link in chain], axis=0)
    radius = float(np.median([link.radius for link in chain]))
    shown = sorted(chain, key=lambda link: abs(link.radius - radius))
    before, after = chain[0].place - 1, chain[-1].place + 1
    z_from = long.sections[before].z_mm if before >= 0 else -np.inf
    z_to = long.sections[after].z_mm if after < len(long.sections) else np.inf
    span = long.sections[chain[-1].place].z_mm - long.sections[chain[0].place].z_mm
    run = bare_cylinder(long, centre, radius, (z_from, z_to), span, rounding_mm, shown, least_width_mm)
    if run is not None:
        return run
    return _between_faces(long, chain, CylinderRun(centre, radius, z_from, z_to), rounding_mm, least_width_mm)


def _between_faces(
    long: SectionStack,
    chain: Sequence[Link],
    within: CylinderRun,
    rounding_mm: float,
    least_width_mm: float | None,
) -> CylinderRun | None:
    """Return the cylinder of a chain that ends at faces square to it and has few vertices; None if unsure.

    Where others cross a coarse cylinder's ends most of its corners are theirs: too few are left to tell it
    from chance. Its sections have corners all round though, and no fillet or taper shows one and the same
    circle, exactly, in all of them.
    """
    slack = ON_CYLINDER * within.radius + rounding_mm
    rough = any(piece.rough_mm > 0.0 for link in chain for piece in long.sections[link.place].pieces)
    if len(chain) < 2 or rough or long.blur_mm > 0.0:
        return None
    off = [max(abs(c.radius - within.radius), float(np.linalg.norm(c.centre - within.centre))) for c in chain]
    first, last = (long.sections[chain[end].place].z_mm for end in (0, -1))
    below = long.levels_mm[(long.levels_mm > within.z_low) & (long.levels_mm < first)]
    above = long.levels_mm[(long.levels_mm > last) & (long.levels_mm < within.z_high)]
    if max(off) > slack or len(below) == 0 or len(above) == 0:
        return None
    run = replace(within, z_low=float(below.max()), z_high=float(above.min()))
    least = LEAST_WIDTH * run.radius if least_width_mm is None else least_width_mm
    return run if run.width >= least else None


def bare_cylinder(
    long: SectionStack,
    centre: Array,
    radius: float,
    z_range: tuple[float, float],
    span: float,
    rounding_mm: float,
    shown: Sequence[Link] = (),
    least_width_mm: float | None = None,
) -> CylinderRun | None:
    """Return the cylinder along z on which vertices in a range of z lie; None if they show none.

    A cylinder's vertices lie on it at (at least) two heights, ``span`` or more apart, however coarse its
    facets. Vertices of fillets, tapers and chamfers do not. Sections through a regular mesh give the radius
    exactly, except those that go through fillets or drillings. So each circle ``shown`` is tried, then the
    one near it that most vertices have, then a wide ring.
    """
    near = long.between(*z_range)
    away = distances(near, centre)
    rows = np.flatnonzero(np.abs(away - radius) <= MAX_VERTEX_DISTANCE_RATIO * radius + rounding_mm)
    near = near.T.take(rows, axis=1).T
    circles = [(centre, radius)]
    for link in shown:
        grain = NARROW_SEARCH_RATIOS[-1] * link.radius
        if all(abs(link.radius - r) + float(np.abs(link.centre - c).max()) > grain for c, r in circles):
            circles.append((link.centre, link.radius))
    for middle, size in circles:
        away = distances(near, middle)
        for share in NARROW_SEARCH_RATIOS:
            run = _fitted(near, away, size, share, span, rounding_mm, least_width_mm)
            if run is not None:
                return run
    away = distances(near, centre)
    rest = away[np.abs(away - radius) < 2.0 * WIDE_SEARCH_RATIO * radius]
    fallback = None
    for _ in range(TRIED_RADII):
        dense = densest(rest, NARROW_SEARCH_RATIOS[-1] * radius, radius)
        for share in (NARROW_SEARCH_RATIOS[-1], WIDE_SEARCH_RATIO):
            run = _fitted(near, away, dense, share, span, rounding_mm, least_width_mm)
            if run is not None and _is_reached(long, run):
                return run
            fallback = fallback or run
        rest = rest[np.abs(rest - dense) > NARROW_SEARCH_RATIOS[-1] * radius]
    return fallback


def _fitted(
    near: Array,
    away: Array,
    radius: float,
    share: float,
    span: float,
    rounding_mm: float,
    least_width_mm: float | None,
) -> CylinderRun | None:
    """Return the cylinder through vertices whose distances ``away`` are a radius except for a share of it."""
    ring = np.flatnonzero(np.abs(away - radius) <= share * radius + rounding_mm)
    if len(ring) < LEAST_VERTICES:
        return None
    fitted, size = fit_circle(near[:, :2].T.take(ring, axis=1).T)
    off = np.abs(distances(near, fitted) - size)
    close = off[off <= 2.0 * share * size]
    typical = float(np.median(close)) if len(close) else size
    if typical > OUT_OF_ROUND * size + rounding_mm:
        return None
    slack = max(ON_CYLINDER * size + rounding_mm, 2.0 * typical)
    heights = near[:, 2][off <= slack]
    if len(heights) < LEAST_VERTICES:
        return None
    low, high = float(heights.min()), float(heights.max())
    least = LEAST_WIDTH * size if least_width_mm is None else least_width_mm
    wide = high - low >= max(least, MOST_OF_SPAN * span)
    return CylinderRun(fitted, size, low, high) if wide else None


def _is_reached(long: SectionStack, run: CylinderRun) -> bool:
    """Return whether a section in a cylinder reaches its radius; those between two fillets' feet do not."""
    inside = [s for s in long.sections if run.z_low < s.z_mm < run.z_high]
    return any(
        abs(max((p.reach_from(run.centre) for p in s.pieces), default=0.0) - run.radius)
        < MAX_INNER_DEPTH_RATIO * run.radius
        for s in inside
    )


def densest(values: Array, width: float, otherwise: float) -> float:
    """Return the middle of the window of ``width`` that holds most values; the largest of equals."""
    if len(values) == 0:
        return otherwise
    ranked = np.sort(values)
    held = np.searchsorted(ranked, ranked + width, side="right") - np.arange(len(ranked))
    best = len(held) - 1 - int(np.argmax(held[::-1]))
    return float(np.median(ranked[best : best + held[best]]))


TRIMMED, TRIMMED_FITS = 4.0, 3
"""Vertices so many times the median off an axis are of no cylinder on it; the next fit leaves them out."""


def common_axis(long: SectionStack, runs: Sequence[CylinderRun], rounding_mm: float) -> tuple[Array, Array]:
    """Return the common axis of cylinders nearly along z: point (3,), unit direction (3,).

    Least squares over the vertices on the cylinders, linear in the line's position and slope and in each
    radius; the vertices lie on the true surface however coarse the facets are. Cylinders out of line keep
    their common direction, and the line passes through the mean of their places.
    """
    where: list[Array] = []
    who: list[Indices] = []
    for number, run in enumerate(runs):
        near = long.between(run.z_low, run.z_high)
        away = distances(near, run.centre)
        on = np.flatnonzero(np.abs(away - run.radius) <= 2e-4 * run.radius + rounding_mm)
        where.append(near.T.take(on, axis=1).T)
        who.append(np.full(len(on), number))
    points, owner = np.concatenate(where), np.concatenate(who)
    middle, scale = float(points[:, 2].mean()), max(float(np.ptp(points[:, 2])), 1e-12)
    lever = (points[:, 2] - middle) / scale
    start = runs[0].centre
    radii = np.array([run.radius for run in runs])
    unit = points[:, :2] - np.array([run.centre for run in runs]).T.take(owner, axis=1).T
    unit /= np.hypot(*unit.T)[:, None]
    line = np.column_stack([unit, unit * lever[:, None]])
    is_of = owner[:, None] == np.arange(len(runs))
    reach = ((points[:, :2] - start) * unit).sum(axis=1) - radii[owner]
    off, slack = np.abs(line @ _solved(line, reach) - reach), ON_CYLINDER * radii[owner] + rounding_mm
    if len(runs) > 1 and float(np.median(off / slack)) > 1.0:
        apart = np.column_stack([unit * lever[:, None], *(unit * each[:, None] for each in is_of.T)])
        solution = _solved(apart, reach)
        if float(np.median(np.abs(apart @ solution - reach))) < OUT_OF_LINE * float(np.median(off)):
            place = start + solution[2:].reshape(-1, 2).mean(axis=0)
            return _line(place, solution[:2] / scale, middle)
    rows = np.column_stack([line, is_of])
    keep = off <= slack
    keep = keep if keep.sum() > 0.1 * len(keep) else np.ones(len(rows), dtype=bool)
    for _ in range(TRIMMED_FITS):  # those of an oil hole's rim lie on chords, inside the cylinder
        solution = _solved(rows[keep], reach[keep])
        left = np.abs(rows @ solution - reach)
        trimmed = left <= max(TRIMMED * float(np.median(left[keep])), rounding_mm)
        if np.array_equal(trimmed, keep) or trimmed.sum() < 0.5 * keep.sum():
            break
        keep = trimmed
    return _line(start + solution[:2], solution[2:4] / scale, middle)


def _line(place: Array, slope: Array, z_mm: float) -> tuple[Array, Array]:
    """Return point and direction of the line through ``place`` (2,) with slopes (2,) of x and y."""
    along = np.array([*slope, 1.0])
    return np.array([*place, z_mm]), along / np.linalg.norm(along)


def _solved(rows: Array, target: Array) -> Array:
    return np.asarray(np.linalg.lstsq(rows.T @ rows, rows.T @ target, rcond=None)[0], dtype=np.float64)
