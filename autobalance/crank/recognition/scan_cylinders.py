"""Bare cylinders of a scanned crank, and possible faults of a scan without any."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.rough_fits import Fit, WeightedPoints, fit_circle_along_z, rows_near
from autobalance.crank.recognition.section_stack import (
    CrossSection,
    SectionStack,
    pieces_of,
    rotated,
    turn_to_z,
)
from autobalance.errors import RecognitionError
from autobalance.rigid_rotor.tolerance import listed_grade
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.roughness import local_roughness_mm, smoothed_normals, vertex_areas
from autobalance.solid.slicing.slices import cross_sections
from autobalance.types import Array, Indices
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass

# Possible faults of a scan in which no crank is recognised: half a crank, a stand, too rough a surface.


CUT_SHARE = 0.12
"""No face of a whole crank holds so large a share of its surface; a cut through it, or a stand's, does."""
ONE_WAY, ONE_HEIGHT = 0.98, 2.0
"""Triangles are of one plane whose directions agree by this much and whose heights by so many mm."""
EXAMPLE_RPM = 6000.0
"""Speed [1/min] for which the grade is given as an example: no job is known here."""


def cut_or_stand(mesh: Mesh, directions: Array) -> str:
    """Return a hint at a plane that holds much of a mesh, empty where none does.

    ``directions`` (m, 3) are those of its triangles, smoothed.
    """
    area = 0.5 * mesh.doubled_areas
    cells = np.round(8.0 * directions).astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])
    distinct, number = np.unique(cells, return_inverse=True)
    total = np.bincount(number, area, len(distinct))
    best = 0.0
    for cell in np.argsort(total)[-6:]:
        way = (directions[number == cell] * area[number == cell, None]).sum(axis=0)
        way /= max(float(np.linalg.norm(way)), 1e-300)
        rows = np.flatnonzero(directions @ way > ONE_WAY)
        height = mesh.vertices.take(mesh.triangles.take(rows, axis=0), axis=0).mean(axis=1) @ way
        share = np.bincount(((height - height.min()) / ONE_HEIGHT).astype(np.int64), area.take(rows))
        best = max(best, float((share[1:] + share[:-1]).max()) if len(share) > 1 else float(share[0]))
    if best < CUT_SHARE * float(area.sum()):
        return ""
    percent = 100.0 * best / float(area.sum())
    return f"one plane holds {percent:.0f} % of the surface: half a crank, or its stand with it?"


def grade_for(mesh: Mesh, roughness_mm: float) -> str:
    """Return the finest grade for which a skin of such roughness would do, as "G 40 at 6000 rpm"."""
    area = 0.5 * mesh.doubled_areas
    corners = mesh.corners - mesh.bounds.mean(axis=0)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    centre = volume @ corners.sum(axis=1) / 4.0 / volume.sum()
    off = area @ (corners.mean(axis=1) - centre)
    specific_mm = roughness_mm * float(np.linalg.norm(off)) / float(volume.sum())
    velocity = specific_mm * EXAMPLE_RPM * RAD_S_PER_RPM
    grade = listed_grade(velocity)
    return f"{'no grade' if grade is None else f'G {grade.grade_mm_s:g}'} at {EXAMPLE_RPM:.0f} rpm"


# Bare cylinders of a scanned crank: sections at even steps, circles through rough outlines, runs of them.


STEP_MM = 0.6
STATIONS = (120, 600)
"""Sections are this far apart, but not fewer or more of them."""
MAX_OUTLINE_DISTANCE = (4.0, 0.02)
"""A rough outline may be off its circle by so many times the local roughness, and this much more [mm]:
waves longer than a neighbourhood, journals out of round."""
SAME_CENTRE, SAME_RADIUS = 0.03, 0.015
"""Circles follow each other along one shaft when centre and radius differ by less, as shares of the last."""
FACE_BLUR_STEPS = 3.0
"""A face lies within so many steps of the sections that show it."""
GAP_SHARE = 0.5
"""Drillings and grooves part a cylinder for this share of its radius."""
LEAST_WIDTH = 0.15
"""Bare cylinders shorter than this share of their radius are chamfers, collars and fillets."""
MOST_TAPER = 0.015
"""A cylinder's radius changes by less than this along its length: cones for pulleys begin at 1 : 40."""
MIN_SECTION_SHARE = 0.6
"""Smallest share of a cylinder's sections that show its circle."""


def rough_slack_mm(local_mm: float) -> float:
    """Return the largest distance of an outline from its circle, for a roughness [mm]."""
    return MAX_OUTLINE_DISTANCE[0] * local_mm + MAX_OUTLINE_DISTANCE[1]


def rough_stack(mesh: Mesh, direction: Array, slack_mm: float) -> SectionStack:
    """Return a scanned mesh with ``direction`` (3,) turned to z, cut at even steps; it has no levels yet."""
    turn = turn_to_z(direction, mesh.bounds.mean(axis=0))
    vertices = rotated(mesh.vertices, turn)
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    count = int(np.clip((high - low) / STEP_MM, *STATIONS))
    heights = low + (high - low) * (np.arange(count) + 0.5) / count
    outlines = cross_sections(vertices, mesh.triangles, heights)
    sections = tuple(
        CrossSection(float(z), pieces_of(outline, 0.0, slack_mm))
        for z, outline in zip(heights, outlines, strict=True)
    )
    step = (high - low) / count
    return SectionStack(turn, vertices, np.zeros(0), np.zeros(0), sections, blur_mm=FACE_BLUR_STEPS * step)


@dataclass(frozen=True, eq=False)
class _Ring:
    """A circle that is a whole piece of a section."""

    place: int
    z_mm: float
    centre: Array
    radius: float


def rough_runs(long: SectionStack) -> list[CylinderRun]:
    """Return the bare cylinders along a rough shaft, by increasing z."""
    chains: list[list[_Ring]] = []
    step = long.blur_mm / FACE_BLUR_STEPS
    for place, section in enumerate(long.sections):
        for piece in section.pieces:
            if piece.circle is None:
                continue
            ring = _Ring(place, section.z_mm, piece.circle.centre, piece.circle.radius)
            for chain in reversed(chains):
                if _follows(ring, chain[-1], step):
                    chain.append(ring)
                    break
            else:
                chains.append([ring])
    runs = [run for chain in chains for run in _cylinders(chain, long)]
    return sorted(_distinct(runs), key=lambda run: run.z_mid)


def _follows(ring: _Ring, last: _Ring, step: float) -> bool:
    return (
        0.0 < ring.z_mm - last.z_mm <= max(GAP_SHARE * last.radius, 2.1 * step)
        and abs(ring.radius - last.radius) < SAME_RADIUS * last.radius + 0.05
        and float(np.linalg.norm(ring.centre - last.centre)) < SAME_CENTRE * last.radius
    )


def _cylinders(chain: Sequence[_Ring], long: SectionStack) -> list[CylinderRun]:
    """Return the stretches of a chain over which its circle stays the same."""
    runs: list[CylinderRun] = []
    rest = list(chain)
    slack = long.sections[chain[0].place].pieces[0].rough_mm
    step = long.blur_mm / FACE_BLUR_STEPS
    while len(rest) >= 3:
        radii = np.sort([ring.radius for ring in rest])
        held = np.searchsorted(radii, radii + slack, side="right") - np.arange(len(radii))
        best = len(held) - 1 - int(np.argmax(held[::-1]))
        radius = float(np.median(radii[best : best + held[best]]))
        same = [ring for ring in rest if abs(ring.radius - radius) <= slack]
        stretch = _longest(same, radius, step)
        if len(stretch) < 3:
            break
        run = _run(stretch, step)
        if run is not None:
            runs.append(run)
        rest = [ring for ring in rest if all(ring is not other for other in stretch)]
    return runs


def _longest(same: Sequence[_Ring], radius: float, step: float) -> list[_Ring]:
    stretches: list[list[_Ring]] = [[]]
    for ring in same:
        if stretches[-1] and ring.z_mm - stretches[-1][-1].z_mm > max(GAP_SHARE * radius, 2.1 * step):
            stretches.append([])
        stretches[-1].append(ring)
    return max(stretches, key=len)


def _run(stretch: Sequence[_Ring], step: float) -> CylinderRun | None:
    z = np.array([ring.z_mm for ring in stretch])
    radii = np.array([ring.radius for ring in stretch])
    radius, width = float(np.median(radii)), float(np.ptp(z)) + step
    if width < max(LEAST_WIDTH * radius, 3.0 * step) or len(stretch) * step < MIN_SECTION_SHARE * width:
        return None
    slope = float(np.polyfit(z - z.mean(), radii, 1)[0])
    if abs(slope) > MOST_TAPER and abs(slope) * width > 0.1:
        return None
    centre = np.median([ring.centre for ring in stretch], axis=0)
    return CylinderRun(centre, radius, float(z[0]) - 0.5 * step, float(z[-1]) + 0.5 * step)


def _distinct(runs: Sequence[CylinderRun]) -> list[CylinderRun]:
    """Return cylinders without those that are part of a longer one."""
    kept: list[CylinderRun] = []
    for run in sorted(runs, key=lambda run: -run.width):
        if not any(
            min(run.z_high, other.z_high) - max(run.z_low, other.z_low) > 0.5 * run.width
            and float(np.linalg.norm(run.centre - other.centre)) < SAME_CENTRE * run.radius
            for other in kept
        ):
            kept.append(run)
    return kept


# Cylinders of a scanned crank: the mesh's points on one, its size, and its ends.


NEIGHBOURS = 40.0
"""Roughness is measured on neighbourhoods of about so many triangles."""
MAX_AXIAL_COMPONENT = 0.25
"""Triangles of a cylinder along z face z by less than this."""
HOPELESS_MM = 0.3
"""Rougher meshes are refused: neighbourhoods of a coarse mesh seem rougher than its faces are."""
CREDIBLE_MM = 0.1
"""Largest roughness that counts: neighbourhoods of a mesh decimated to a few large triangles have more."""
ROUGHEST_MM = 0.15
"""Rougher surfaces are not judged."""
BORE_REACH = 2.0
"""A crankpin's bores are sought in webs so many of its radii deep."""


GROOVE_PLACES = 6
"""Beyond a groove a cylinder continues over at least so many of the places where it is checked."""


MIN_POINTS = 24
"""A cylinder of fewer points is not fitted."""
END_MM = 1e-3
"""Corners beyond a cylinder's end by less are at its end."""
BEYOND_RUN_MM = 1.5
"""A cylinder's ends are sought so far beyond the last section that shows it whole."""
END_PM_MM = 0.4
"""Standard error of an end without a face beside it: points are checked in steps of this length."""
UNIFORM_SIGMA = 1.0 / math.sqrt(12.0)
"""Standard deviation of a point anywhere between two places, as a share of their distance."""
THIN_RING_SHARE = 0.15
"""Points that stand for less than this share of the ring between two places say nothing of it: where a mesh
has its vertices in rows, only walls of a keyway lie between. A journal of 46 mm ended there at 38."""

End = tuple[float, float]
"""A height and its standard error [mm]."""


@dataclass(frozen=True, eq=False)
class RoughMesh:
    """A scanned mesh with its properties, measured once."""

    mesh: Mesh
    directions: Array
    at_vertex: Array
    local_mm: float

    @property
    def edge_mm(self) -> float:
        """Edge of an equilateral triangle of the median area [mm]."""
        return math.sqrt(2.0 / math.sqrt(3.0) * float(np.median(self.mesh.doubled_areas)))

    @classmethod
    def of(cls, mesh: Mesh) -> RoughMesh:
        """Return a mesh with its roughness.

        Raises
        ------
        RecognitionError
            If it is too rough to look for a crank in it.
        """
        middle = 0.5 * float(np.median(mesh.doubled_areas))
        local = local_roughness_mm(mesh, math.sqrt(NEIGHBOURS * max(middle, 0.1)))
        rough = cls(mesh, smoothed_normals(mesh), vertex_areas(mesh), local)
        if local > HOPELESS_MM:
            raise rough.refusal(RecognitionError("not looked for"))
        return rough

    @property
    def slack_mm(self) -> float:
        """Largest distance of an outline from its circle [mm]."""
        return rough_slack_mm(min(self.local_mm, CREDIBLE_MM))

    def refusal(self, reason: RecognitionError) -> RecognitionError:
        """Return a refusal of the mesh with its possible cause."""
        if self.local_mm <= ROUGHEST_MM:
            hint = cut_or_stand(self.mesh, self.directions)
            return RecognitionError(f"{hint} {reason}") if hint else reason
        return RecognitionError(
            f"the surface is rough by about {self.local_mm:.2g} mm, which would do for"
            f" {grade_for(self.mesh, self.local_mm)} at best; found no crank in it ({reason});"
            f" expected at most {ROUGHEST_MM:g} mm: scan it again, more finely, or decimate it less"
        )


class RoughViews:
    """Sections and bare cylinders of a rough mesh along the directions tried, for two searches if ``kept``.

    Turned vertices, most of a view's memory, are not kept, but turned again.
    """

    def __init__(self, rough: RoughMesh, *, kept: bool) -> None:
        self.rough, self._is_kept = rough, kept
        self._known: dict[bytes, tuple[SectionStack, list[CylinderRun]]] = {}

    def along(self, direction: Array) -> tuple[SectionStack, list[CylinderRun]]:
        """Return the sections along a direction (3,), and their bare cylinders."""
        key = direction.tobytes()
        if key in self._known:
            flat, runs = self._known[key]
            return replace(flat, vertices=rotated(self.rough.mesh.vertices, flat.turn)), runs
        long = rough_stack(self.rough.mesh, direction, self.rough.slack_mm)
        runs = rough_runs(long)
        if self._is_kept:
            self._known[key] = replace(long, vertices=np.zeros((0, 3))), runs
        return long, runs


@dataclass(frozen=True, eq=False)
class RoughCylinder:
    """A fitted cylinder, its points, and the fit.

    ``middle_pm_mm`` and ``width_pm_mm`` are the standard errors of its middle's height and its length.
    ``steps_mm`` are the heights at which steps to the faces next to it begin, below and above. ``bare_ends``
    are its ends if no face gives them.
    """

    run: CylinderRun
    region: WeightedPoints
    fit: Fit
    middle_pm_mm: float = 0.0
    width_pm_mm: float = 0.0
    steps_mm: tuple[float | None, float | None] = (None, None)
    bare_ends: tuple[End, End] | None = None


def cylinder_region(
    rough: RoughMesh, long: SectionStack, normals: Array, run: CylinderRun, slack: float, side: float = 1.0
) -> WeightedPoints:
    """Return the vertices on a cylinder, by the direction and place of its triangles."""
    rows = _triangles_on(rough, long, normals, run, slack, side)
    corners = np.unique(rough.mesh.triangles.take(rows, axis=0))
    points = long.vertices.take(corners, axis=0)
    trim = min(0.8, 0.1 * run.width)
    inside = (points[:, 2] > run.z_low + trim) & (points[:, 2] < run.z_high - trim)
    if np.count_nonzero(inside) >= MIN_POINTS:  # else of long facets, whose corners are all at its ends
        corners, points = corners[inside], points[inside]
    if len(corners) < MIN_POINTS:
        raise RecognitionError(
            f"the surface of a cylinder of {2.0 * run.radius:.4g} mm has only {len(corners)} points."
            " Scan it more finely, or decimate it less"
        )
    return WeightedPoints(points, rough.at_vertex.take(corners))


def _triangles_on(
    rough: RoughMesh, long: SectionStack, normals: Array, run: CylinderRun, slack: float, side: float = 1.0
) -> Indices:
    """Return the rows of triangles that lie on a cylinder and face outward (inward with ``side`` −1)."""
    away = np.hypot(long.vertices[:, 0] - run.centre[0], long.vertices[:, 1] - run.centre[1])
    z = long.vertices[:, 2]
    on = (np.abs(away - run.radius) < 2.0 * slack) & (z > run.z_low - END_MM) & (z < run.z_high + END_MM)
    a, b, c = rough.mesh.triangles.T
    rows = np.flatnonzero(on.take(a) & on.take(b) & on.take(c))
    middle = (
        long.vertices.take(rough.mesh.triangles.take(rows, axis=0), axis=0).mean(axis=1)[:, :2] - run.centre
    )
    outward = (normals.take(rows, axis=0)[:, :2] * middle).sum(axis=1) / run.radius
    keep: Indices = rows[(np.abs(normals[:, 2].take(rows)) < MAX_AXIAL_COMPONENT) & (side * outward > 0.9)]
    return keep


def fitted_cylinder(
    rough: RoughMesh, long: SectionStack, normals: Array, run: CylinderRun, slack: float
) -> RoughCylinder:
    """Return a cylinder fitted to its surface between its ends."""
    wide = replace(run, z_low=run.z_low - BEYOND_RUN_MM, z_high=run.z_high + BEYOND_RUN_MM)
    fit = fit_circle_along_z(cylinder_region(rough, long, normals, run, slack), run.centre, run.radius)
    here = replace(run, centre=fit.values[:2], radius=float(fit.values[2]))
    rows = rows_near(long.vertices, wide.z_low, wide.z_high)
    points = long.vertices.take(rows, axis=0)
    off = np.hypot(*(points[:, :2] - here.centre).T) - here.radius
    near = np.abs(off) < 4.0 * slack + 0.5
    areas = rough.at_vertex.take(rows[near])
    within = max(3.0 * fit.rms_mm, 0.03)
    low, high = _ends(points[near, 2], off[near], areas, here, within, rough.edge_mm)
    here = replace(here, z_low=low.last_mm, z_high=high.last_mm)
    region = cylinder_region(rough, long, normals, here, slack)
    fit = fit_circle_along_z(region, here.centre, here.radius)
    return RoughCylinder(
        replace(here, centre=fit.values[:2], radius=float(fit.values[2])),
        region,
        fit,
        bare_ends=(low.between, high.between),
    )


def fitted_bores(
    rough: RoughMesh, long: SectionStack, normals: Array, run: CylinderRun, slack: float
) -> RoughCylinder:
    """Return a crankpin fitted to its bores in the webs beside its gap."""
    deep = replace(
        run, z_low=run.z_low - BORE_REACH * run.radius, z_high=run.z_high + BORE_REACH * run.radius
    )
    region = cylinder_region(rough, long, normals, deep, slack, -1.0)
    fit = fit_circle_along_z(region, run.centre, run.radius)
    return RoughCylinder(replace(run, centre=fit.values[:2], radius=float(fit.values[2])), region, fit)


def fitted_bore(
    rough: RoughMesh, long: SectionStack, normals: Array, run: CylinderRun, slack: float
) -> RoughCylinder:
    """Return a bore fitted to its wall, which ends where its last points are."""
    deep = replace(run, z_low=run.z_low - BEYOND_RUN_MM, z_high=run.z_high + BEYOND_RUN_MM)
    fit = fit_circle_along_z(cylinder_region(rough, long, normals, deep, slack, -1.0), run.centre, run.radius)
    here = replace(deep, centre=fit.values[:2], radius=float(fit.values[2]))
    corners = np.unique(
        rough.mesh.triangles.take(_triangles_on(rough, long, normals, here, slack, -1.0), axis=0)
    )
    points = long.vertices.take(corners, axis=0)
    off = np.abs(np.hypot(*(points[:, :2] - here.centre).T) - here.radius)
    z = points[off <= max(3.0 * fit.rms_mm, 0.03), 2]
    low, high = float(z.min()), float(z.max())
    here = replace(here, z_low=low, z_high=high)
    region = cylinder_region(rough, long, normals, here, slack, -1.0)
    fit = fit_circle_along_z(region, here.centre, here.radius)
    pm = max(UNIFORM_SIGMA * rough.edge_mm, fit.rms_mm)
    return RoughCylinder(
        replace(here, centre=fit.values[:2], radius=float(fit.values[2])),
        region,
        fit,
        bare_ends=((low, pm), (high, pm)),
    )


@dataclass(frozen=True)
class _BareEnd:
    """The end of a cylinder by its points: by ``last_mm`` it has ended, from ``first_mm`` on it may have."""

    last_mm: float
    first_mm: float
    least_pm_mm: float

    @property
    def between(self) -> End:
        """Anywhere between the two."""
        apart = abs(self.last_mm - self.first_mm)
        return 0.5 * (self.last_mm + self.first_mm), max(self.least_pm_mm, UNIFORM_SIGMA * apart)


def _ends(
    z: Array, off: Array, areas: Array, run: CylinderRun, within: float, edge_mm: float
) -> tuple[_BareEnd, _BareEnd]:
    """Return the ends of a cylinder: heights where most of its surface leaves it, from the middle on.

    At an oil hole a little of it leaves it, in a fillet all does. Points count by their ``areas``: of a
    decimated scan most lie at edges of holes (a crankpin ended there, 3.5 mm short), and none in between.
    """
    size = max(END_PM_MM, run.width / 60.0)
    places = np.floor((z - run.z_mid) / size).astype(np.int64)
    first, order = int(places.min()), np.lexsort((off, places))
    area = np.bincount(places - first, areas)
    halves = np.cumsum(area) - 0.5 * area
    middle = np.abs(off[order].take(np.searchsorted(np.cumsum(areas[order]), halves).clip(max=len(off) - 1)))
    holds, told = middle <= within, area > THIN_RING_SHARE * 2.0 * math.pi * run.radius * size
    good = np.flatnonzero(holds & (area > 0.0)) + first
    bad = np.flatnonzero(~holds & told) + first
    half = 0.5 * run.width / size
    bad = np.array([place for place in bad if not _goes_on(int(place), good, half)], dtype=np.int64)
    sure = size * (np.flatnonzero(holds & told) + first + 0.5).astype(np.float64)
    on = (z - run.z_mid)[np.abs(off) <= within]
    below, above = bad[bad < -1], bad[bad > 0]
    left_low = -size * (float(below.max()) + 1.0) if len(below) else None
    left_high = size * float(above.min()) if len(above) else None
    half_mm, least_pm = 0.5 * run.width, max(size, UNIFORM_SIGMA * edge_mm)
    low, low_first = _end(-sure, -on, size, left_low, half_mm)
    high, high_first = _end(sure, on, size, left_high, half_mm)
    if low + high < half_mm:  # a groove or a dent near the middle is not an end
        least_pm = max(least_pm, UNIFORM_SIGMA * BEYOND_RUN_MM)
        low = low_first = high = high_first = half_mm
    return (
        _BareEnd(run.z_mid - low, run.z_mid - low_first, least_pm),
        _BareEnd(run.z_mid + high, run.z_mid + high_first, least_pm),
    )


def _end(sure: Array, on: Array, size: float, left_mm: float | None, whole_mm: float) -> tuple[float, float]:
    """Return by which distance from the middle a cylinder has ended, and from which on it may have.

    ``left_mm`` is the height at which most of the cylinder has ended, if it ends so. Else its last point is
    its end, except for points apart from where enough of it exists (``sure``). Where a bore or another
    cylinder crosses it, a few points are as far from its axis as it is; a hollow journal extended 1.5 mm into
    its web. ``whole_mm`` is the last section to show it whole: past an eccentric's face the rest of its shaft
    continues.
    """
    limit = math.inf if left_mm is None else left_mm
    begin = float(sure[sure < limit].max(initial=0.0)) - 0.5 * size
    beyond = np.sort(on[(on > begin) & (on < limit)])
    apart = np.flatnonzero(np.diff(beyond) > size)
    last = float(beyond[apart[0] if len(apart) else -1]) if len(beyond) else begin
    return (last, min(whole_mm, last)) if left_mm is None else (left_mm, last)


def _goes_on(place: int, good: Indices, half: float) -> bool:
    """Return whether most of a cylinder is there beyond a place; it reaches ``half`` places from its mid."""
    beyond = good[(good > place) & (good < half)] if place > 0 else good[(good < place) & (good > -half)]
    return len(beyond) >= max(GROOVE_PLACES, 0.5 * (half - abs(place)))


def covered_share(
    rough: RoughMesh, long: SectionStack, normals: Array, run: CylinderRun, slack: float, side: float = 1.0
) -> float:
    """Return the share of a cylinder's surface in the mesh, with ``side`` −1 a bore's; 0 without length."""
    if not run.width > 0.0:  # a disc's rim of one section: the die filer's arm, scanned with 0.02 mm of noise
        return 0.0
    rows = _triangles_on(rough, long, normals, run, slack, side)
    area = 0.5 * float(rough.mesh.doubled_areas.take(rows).sum())
    return area / (2.0 * math.pi * run.radius * run.width)
