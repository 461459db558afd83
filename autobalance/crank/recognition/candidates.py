"""Bare cylinders in a solid, and the directions in which its crank axis may lie."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from autobalance.crank.anatomy import Anatomy, Pin, Web
from autobalance.crank.datums import ScannedOutline, ScannedWeb
from autobalance.crank.recognition.cylinder_runs import ROUNDING, CylinderRun, find_runs
from autobalance.crank.recognition.rough_fits import OUTLIER, Fit, spread_of
from autobalance.crank.recognition.scan_cylinders import RoughCylinder, RoughMesh
from autobalance.crank.recognition.scan_planes import FittedCrank, RoughPlane
from autobalance.crank.recognition.section_stack import SectionStack, lengthwise, rotated
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Directions in which a solid's crank axis may lie, from its triangles' area vectors.


BIN_RAD = 0.02
"""Directions closer than this count as one at first; the best are refined afterwards."""
CROSSED_DIRECTIONS = 32
"""Number of the surface's directions that are crossed with each other: a cylinder's axis is square to any two
directions of its surface."""
MOST_BINS = 600
"""Directions of the surface that candidates are judged by; the others hold little area."""
SIDE_SINE = 0.01
"""A triangle is along an axis when the sine of its lean is below this (about half a degree)."""
CANDIDATES = 8
"""Axes tried before giving up."""


def axis_candidates(area_vectors: Array, side_sine: float = SIDE_SINE) -> Iterator[Array]:
    """Yield likely directions (3,) of the crank axis as unit vectors, likeliest first.

    ``side_sine`` is the sine of the lean of a triangle that still is along an axis.

    The likeliest axis is the one to which most of the surface is either parallel (journals, crankpins,
    rims) or square (webs' faces); a cylinder's surface counts, a flat's could belong to any of many axes.
    """
    length = np.linalg.norm(area_vectors, axis=1)
    keep = length > 0.0
    unit, weight = area_vectors[keep] / length[keep, None], length[keep] / length.sum()
    unit *= np.where(_upper(unit), 1.0, -1.0)[:, None]
    normals, areas = _binned(unit, weight)
    strong = normals[:CROSSED_DIRECTIONS]
    i, j = np.triu_indices(len(strong), 1)
    crossed = np.cross(strong[i], strong[j])
    size = np.linalg.norm(crossed, axis=1)
    axes = np.concatenate([strong, crossed[size > 0.2] / size[size > 0.2, None]])
    scores = _scores(axes, normals, areas, side_sine)
    chosen: list[Array] = []
    for place in np.argsort(-scores):
        if any(abs(float(axes[place] @ other)) > np.cos(BIN_RAD) for other in chosen):
            continue
        axis = _refined(axes[place], normals, areas)
        if all(abs(float(axis @ other)) < np.cos(BIN_RAD) for other in chosen):
            chosen.append(refined_direction(axis, unit, weight, side_sine))
            yield chosen[-1]
        if len(chosen) == CANDIDATES:
            return


def refined_direction(axis: Array, unit: Array, weight: Array, side_sine: float = SIDE_SINE) -> Array:
    """Return the direction to which the surface along ``axis`` is most nearly parallel."""
    for sine in (side_sine, 0.1 * side_sine, 0.01 * side_sine):
        along = np.abs(unit @ axis) < sine
        if not along.any():
            return axis
        axis = _least_direction(unit[along], weight[along], axis)
    return axis


def _upper(unit: Array) -> Array:
    x, y, z = unit.T
    upper: Array = (z > 0.0) | ((z == 0.0) & ((y > 0.0) | ((y == 0.0) & (x > 0.0))))
    return upper


def _binned(unit: Array, weight: Array) -> tuple[Array, Array]:
    """Return mean directions (k, 3) and weights (k,) of bins on the sphere, heaviest first."""
    cells = np.floor(unit / BIN_RAD).astype(np.int64)
    key = (cells[:, 0] * 1009 + cells[:, 1]) * 1009 + cells[:, 2]
    _, which = np.unique(key, return_inverse=True)
    areas: Array = np.bincount(which, weight).astype(np.float64)
    sums = np.stack([np.bincount(which, weight * column) for column in unit.T], axis=1)
    normals: Array = sums / np.linalg.norm(sums, axis=1)[:, None]
    order = np.argsort(-areas, kind="stable")[:MOST_BINS]
    return normals[order], areas[order]


def _scores(axes: Array, normals: Array, areas: Array, side_sine: float) -> Array:
    scores = np.zeros(len(axes))
    for begin in range(0, len(axes), 256):
        lean = np.abs(axes[begin : begin + 256] @ normals.T)
        along = lean < side_sine
        square = lean > 1.0 - 0.5 * side_sine**2
        scores[begin : begin + 256] = along @ areas + square @ areas
    return scores


def _refined(axis: Array, normals: Array, areas: Array) -> Array:
    along = np.abs(normals @ axis) < 2.0 * BIN_RAD
    return _least_direction(normals[along], areas[along], axis) if along.any() else axis


def _least_direction(unit: Array, weight: Array, axis: Array) -> Array:
    """Return the unit vector near ``axis`` that makes Σ w (n·d)² least."""
    second = (unit * weight[:, None]).T @ unit
    values, vectors = np.linalg.eigh(second)
    if values[1] <= 1e-9 * values[2]:  # the surface faces one way only: any direction in its plane would do
        return axis
    direction: Array = vectors[:, 0]
    return direction if abs(float(direction @ axis)) > 0.9 else axis


# Bare cylinders in a solid: candidates for a journal or a crankpin.


DIRECTIONS = 3
"""Number of directions tried where none is known."""


@dataclass(frozen=True, eq=False)
class CylinderCandidate:
    """A bare cylinder: its middle (3,) and direction (3,) in file coordinates, its size [mm]."""

    centre_mm: Array
    direction: Array
    diameter_mm: float
    width_mm: float

    def moved(self, frame: Array) -> Pin:
        """Return the cylinder in the rotor frame, along z there; ``frame`` (4, 4) leads to it."""
        centre = frame[:3, :3] @ self.centre_mm + frame[:3, 3]
        return Pin(centre, self.diameter_mm, self.width_mm)


def cylinder_candidates(mesh: Mesh, direction: Array | None = None) -> tuple[CylinderCandidate, ...]:
    """Return the bare cylinders along a direction (3,), or along the direction with the most of them.

    A cylinder is bare if no other metal is at its place along the direction: shafts and pins, no bores.
    """
    if direction is not None:
        return _along(mesh, direction)
    rows, weight = mesh.sample
    likely = islice(axis_candidates(weight[:, None] * mesh.area_vectors.take(rows, axis=0)), DIRECTIONS)
    return max((_along(mesh, each) for each in likely), key=_surface_mm2, default=())


def _surface_mm2(entry: Sequence[CylinderCandidate]) -> float:
    return sum(each.diameter_mm * each.width_mm for each in entry)


def _along(mesh: Mesh, direction: Array) -> tuple[CylinderCandidate, ...]:
    rounding = ROUNDING * float(np.abs(mesh.bounds).max())
    long = lengthwise(mesh, direction, rounding)
    return tuple(_candidate(long, run) for run in find_runs(long, rounding))


def _candidate(long: SectionStack, run: CylinderRun) -> CylinderCandidate:
    turn, shift = long.turn[:3, :3], long.turn[:3, 3]
    here = np.array([*run.centre, run.z_mid])
    return CylinderCandidate(turn.T @ (here - shift), turn[2], 2.0 * float(run.radius), float(run.width))


# Sections and bare cylinders of a mesh along each supposed axis, computed once.


WRITTEN_STEPS_MM = (0.1, 0.0254, 0.01, 0.00254, 0.001, 0.000254)
"""Steps of coordinates written with one to three decimals in mm, or three to five in inch."""
COARSE_STEP_MM = 0.1
"""A file with such a step has journals that are off by more than a scan's."""
FIRST_LOOKED_AT = 500
"""Most files are seen to have no such step by so many vertices."""


def rounding_of(mesh: Mesh) -> float:
    """Return the largest distance of a mesh's vertices from where they were meant, by its file's digits [mm].

    That is single precision's, or half a step of the last decimal in two directions across an axis.
    """
    return max(_single_mm(mesh), math.sqrt(0.5) * _written_step_mm(mesh))


def digits_warning(mesh: Mesh) -> str | None:
    """Return a warning of a mesh whose coordinates have one decimal; None with more."""
    step = _written_step_mm(mesh)
    if step < COARSE_STEP_MM:
        return None
    return (
        f"every coordinate is a multiple of {step:g} mm: the file was rounded. Diameters and places are known"
        f" to {math.sqrt(0.5) * step:.2g} mm, ends of journals at fillets and faces of webs to a millimetre"
        " or two. Export the crank with three decimals"
    )


def _single_mm(mesh: Mesh) -> float:
    """Return the rounding of single precision at a mesh's far end [mm]."""
    return ROUNDING * float(np.abs(mesh.bounds).max())


def _written_step_mm(mesh: Mesh) -> float:
    """Return the step of all coordinates, of those that writers leave; 0 without one."""
    single = _single_mm(mesh)
    for step in WRITTEN_STEPS_MM:
        if step > 4.0 * single and all(
            _is_written_in(some, step, single) for some in (mesh.vertices[:FIRST_LOOKED_AT], mesh.vertices)
        ):
            return step
    return 0.0


def _is_written_in(vertices: Array, step_mm: float, slack_mm: float) -> bool:
    """Return whether all coordinates are whole multiples of a step."""
    return float(np.abs(vertices - step_mm * np.round(vertices / step_mm)).max(initial=0.0)) <= slack_mm


class Views:
    """Sections and bare cylinders of a mesh along the directions tried.

    ``rough_mm`` is the vertices' largest distance from drawn surfaces, beside the file's rounding.

    A crank not recognised with crankpins is sought without them, along the same directions. Turned
    vertices, most of a view's memory, are not kept, but turned again.
    """

    def __init__(self, mesh: Mesh, rough_mm: float = 0.0) -> None:
        self.mesh, self.rough_mm = mesh, rough_mm
        self.rounding_mm = rough_mm + rounding_of(mesh)
        self._known: dict[bytes, tuple[SectionStack, list[CylinderRun]]] = {}

    def along(self, direction: Array) -> tuple[SectionStack, list[CylinderRun]]:
        """Return the sections along a direction (3,), and their bare cylinders."""
        key = direction.tobytes()
        if key in self._known:
            flat, runs = self._known[key]
            return replace(flat, vertices=rotated(self.mesh.vertices, flat.turn)), runs
        long = lengthwise(self.mesh, direction, self.rounding_mm, self.rough_mm)
        runs = find_runs(long, self.rounding_mm)
        self._known[key] = replace(long, vertices=np.zeros((0, 3))), runs
        return long, runs


# Collars beside a scanned web: a scan leaves open whether one is the web's end, or is on it.


MAX_OFFSET_RATIO = 0.2
"""A collar's middle is off its cylinder's by less than this share of the radius ..."""
MIN_FACE_RADIUS_RATIO = 0.9
"""... and its face begins beyond this share of it."""

Heights = tuple[float, ...]


def other_ends_mm(web: Web, mesh: Mesh, fitted: FittedCrank, apart_mm: float) -> tuple[Heights, Heights]:
    """Return other possible beginnings and ends of a web: at collars, and at the face on which they are.

    Heights in the rotor frame; a face less than ``apart_mm`` from the web's end is that end.
    """
    origin_mm = fitted.pins[0].run.z_mid
    middle = 0.5 * (web.z_min_mm + web.z_max_mm) + origin_mm
    below, above = (
        tuple(
            height - origin_mm
            for height in _steps(middle, side, mesh, fitted, apart_mm)
            if abs(height - origin_mm - end) > apart_mm
        )
        for side, end in ((-1.0, web.z_min_mm), (1.0, web.z_max_mm))
    )
    return below, above


def _steps(middle: float, side: float, mesh: Mesh, fitted: FittedCrank, apart_mm: float) -> list[float]:
    """Return the heights of the collars on one side of a web, and of the face behind them."""
    cylinders = (*fitted.journals, *fitted.pins)
    beside = [each for each in cylinders if side * (each.run.z_mid - middle) > 0.0]
    if not beside:
        return []
    nearest = min(beside, key=lambda each: abs(each.run.z_mid - middle))
    end = nearest.run.z_low if side > 0.0 else nearest.run.z_high
    arms = [float(np.linalg.norm(each.run.centre - nearest.run.centre)) for each in cylinders]
    reach = min(arm for arm in arms if arm > nearest.run.radius)
    facing = [
        plane
        for plane, _ in fitted.planes
        if side * plane.normal[2] > 0.0 and side * middle < side * plane.centroid[2] < side * end + apart_mm
    ]
    begins = nearest.steps_mm[0 if side > 0.0 else 1]
    steps = [] if begins is None else [begins]
    for plane in sorted(facing, key=lambda plane: -side * plane.centroid[2]):
        collar = _is_collar(plane, mesh, fitted, nearest, reach)
        if collar or steps:
            steps.append(float(plane.centroid[2]))
        if not collar:
            break
    return steps


def _is_collar(
    plane: RoughPlane, mesh: Mesh, fitted: FittedCrank, cylinder: RoughCylinder, reach_mm: float
) -> bool:
    """Return whether a face is a ring about a cylinder that stays short of the next one's middle."""
    run = cylinder.run
    corners = np.unique(mesh.triangles.take(plane.rows, axis=0))
    away = np.hypot(*(fitted.long.vertices.take(corners, axis=0)[:, :2] - run.centre).T)
    centred = float(np.linalg.norm(plane.centroid[:2] - run.centre)) < MAX_OFFSET_RATIO * run.radius
    return bool(centred and away.min() > MIN_FACE_RADIUS_RATIO * run.radius and away.max() < reach_mm)


# Rims of a scanned crank's counterweights by least squares: the farthest point is a peak of noise.


ON_RIM = (6.0, 0.1)
"""A rim's points lie within so many times the roughness, and this much [mm], below the farthest one."""
MIN_RADIAL_COMPONENT = 0.97
"""They face away from the axis by as much ..."""
MAX_AXIAL_COMPONENT = 0.25
"""... and along it by less than this."""
MAX_ROUGHNESS_RATIO = 2.5
"""Rims that are off a cylinder about the axis by more than so many times the roughness are left out."""
MIN_TRIANGLES = 24
"""Corners of a rim at least, for a cylinder to be fitted to them."""
END_HEIGHT_SIGMA_SHARE = 0.5
"""Uncertainty of a web's end, as a share of the distance to another face that may be that end."""


def with_rims(
    anatomy: Anatomy, rough: RoughMesh, normals: Array, fitted: FittedCrank
) -> tuple[Anatomy, tuple[ScannedWeb, ...]]:
    """Return an anatomy whose counterweights have fitted rims, and its webs' standard errors.

    ``normals`` (m, 3) are the triangles' smoothed directions in the turned axes.
    """
    origin_mm = fitted.pins[0].run.z_mid
    webs, sure = [], []
    for web in anatomy.webs:
        others = other_ends_mm(web, rough.mesh, fitted, rough.slack_mm)
        low_pm, high_pm = (
            math.hypot(
                fitted.height_pm_mm(end + origin_mm),
                END_HEIGHT_SIGMA_SHARE * max((abs(other - end) for other in there), default=0.0),
            )
            for end, there in zip((web.z_min_mm, web.z_max_mm), others, strict=True)
        )
        if web.outline is None:
            webs.append(web)
            sure.append(ScannedWeb(low_pm, high_pm, other_ends_mm=others))
            continue
        rim, rim_pm, rms = _rim(web, rough, normals, fitted, origin_mm)
        webs.append(replace(web, outline=replace(web.outline, rim_radius_mm=rim)))
        border = math.degrees(fitted.edge_mm / rim)
        outline = ScannedOutline(rim_pm, rms, border, math.hypot(low_pm, high_pm), 0.5 * border)
        sure.append(ScannedWeb(low_pm, high_pm, outline, other_ends_mm=others))
    return replace(anatomy, webs=tuple(webs)), tuple(sure)


def _rim(
    web: Web, rough: RoughMesh, normals: Array, fitted: FittedCrank, origin_mm: float
) -> tuple[float, float, float]:
    """Return a rim's radius, its standard error and the rms distance of its points [mm]."""
    assert web.outline is not None
    farthest = web.outline.rim_radius_mm
    vertices = fitted.long.vertices
    trim = min(1.0, 0.1 * (web.z_max_mm - web.z_min_mm))
    z = vertices[:, 2] - origin_mm
    arm = vertices[:, :2] - fitted.line.values[:2]
    away = np.hypot(*arm.T)
    local = min(rough.local_mm, 0.1)
    here = (z > web.z_min_mm + trim) & (z < web.z_max_mm - trim)
    here &= (away > farthest - ON_RIM[0] * local - ON_RIM[1]) & (away < farthest + 1e-6)
    triangles = rough.mesh.triangles
    rows = np.flatnonzero(here.take(triangles).all(axis=1))
    middle = arm.take(triangles.take(rows, axis=0), axis=0).mean(axis=1)
    outward = (normals.take(rows, axis=0)[:, :2] * middle).sum(axis=1) / np.hypot(*middle.T)
    rows = rows[(outward > MIN_RADIAL_COMPONENT) & (np.abs(normals[:, 2].take(rows)) < MAX_AXIAL_COMPONENT)]
    corners = np.unique(triangles.take(rows, axis=0))
    peak = OUTLIER * local
    if len(corners) < MIN_TRIANGLES:
        return farthest, peak, peak
    off, weights = away.take(corners), rough.at_vertex.take(corners)
    keep = np.ones(len(off), dtype=bool)
    for _ in range(3):
        radius = float(weights[keep] @ off[keep] / weights[keep].sum())
        keep = np.abs(off - radius) < OUTLIER * max(spread_of(off[keep]), 1e-9)
    fit = Fit(
        np.array([radius]),
        np.ones((int(keep.sum()), 1)),
        weights[keep],
        off[keep] - radius,
        vertices.take(corners[keep], axis=0),
    )
    typical = float(np.median([each.fit.rms_mm for each in (*fitted.journals, *fitted.pins)]))
    if fit.rms_mm > MAX_ROUGHNESS_RATIO * typical:
        return farthest, peak, fit.rms_mm
    return radius, fitted.noise.height_pm_mm(fit), fit.rms_mm
