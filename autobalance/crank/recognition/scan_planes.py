"""Plane faces of a scanned crank, and the certainty of surfaces fitted to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from autobalance.crank.datums import ScanFit, ScannedCylinder, ScannedFace, ScannedWeb
from autobalance.crank.recognition.rough_fits import Fit, Noise, WeightedPoints, fit_plane, spread_of
from autobalance.crank.recognition.scan_cylinders import RoughCylinder
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.solid.mesh.mesh import Mesh, compacted, numbered_components
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Plane faces of a scanned crank that are square to its axis: located by height, fitted, grown.


MIN_AXIAL_COMPONENT = 0.97
"""A triangle may belong to a plane square to the axis when its smoothed direction has this much along it."""
BIN_MM = 0.05
"""Height of a bin [mm] of the histogram of areas: as high as the least distance that planes may have."""
LEAST_AREA_SHARE = 1.5e-3
"""Planes smaller than this share of the surface are of no use."""
MAX_PLANE_DISTANCE = (4.0, 0.05)
"""A plane's triangles lie within so many times the local roughness, and this much more [mm]."""
MAX_FIT_SIGMAS = 4.0
"""... and of the fitted plane within so many times what its own points spread."""


@dataclass(frozen=True, eq=False)
class RoughPlane:
    """A plane face: the mesh's triangles, its fit in the turned axes, its middle (3,) there and its area."""

    rows: Indices
    fit: Fit
    centroid: Array
    normal: Array
    area_mm2: float

    @property
    def rms_mm(self) -> float:
        """Root mean square of its points' distances from the plane [mm]."""
        return self.fit.rms_mm

    @property
    def flatness_mm(self) -> float:
        """Distance of the two planes that hold 95 % of its area [mm]."""
        order = np.argsort(self.fit.residuals)
        share = np.cumsum(self.fit.weights[order]) / self.fit.weights.sum()
        low, high = np.searchsorted(share, [0.025, 0.975])
        ends = self.fit.residuals[order[[low, min(high, len(order) - 1)]]]
        return float(ends[1] - ends[0])


def rough_planes(
    mesh: Mesh, vertices: Array, directions: Array, at_vertex: Array, local_mm: float
) -> tuple[RoughPlane, ...]:
    """Return the planes square to z of a scanned mesh, the largest first.

    Parameters
    ----------
    mesh : Mesh
    vertices : (n, 3) float
        Its vertices, turned so that the axis is z [mm].
    directions : (m, 3) float
        Smoothed directions of its triangles, turned likewise.
    at_vertex : (n,) float
        Area that each vertex stands for.
    local_mm : float
        Its local roughness.
    """
    area = 0.5 * mesh.doubled_areas
    least = LEAST_AREA_SHARE * float(area.sum())
    thick = MAX_PLANE_DISTANCE[0] * local_mm + MAX_PLANE_DISTANCE[1]
    planes: list[RoughPlane] = []
    for side in (1.0, -1.0):
        rows = np.flatnonzero(side * directions[:, 2] > MIN_AXIAL_COMPONENT)
        if len(rows) == 0:
            continue
        height = vertices[:, 2].take(mesh.triangles.take(rows, axis=0)).mean(axis=1)
        for group in _groups(mesh, rows, height, area.take(rows), thick, least):
            plane = _plane(mesh, vertices, rows, group, area, at_vertex, side)
            if plane is not None and plane.area_mm2 >= least:
                planes.append(plane)
    return tuple(sorted(planes, key=lambda plane: -plane.area_mm2))


def _groups(
    mesh: Mesh, rows: Indices, height: Array, area: Array, thick: float, least: float
) -> Iterator[Indices]:
    """Yield connected triangles (places in ``rows``) about the heights where most area lies."""
    free = np.ones(len(rows), dtype=bool)
    low = float(height.min()) - 1.0
    width = max(1, round(thick / BIN_MM))
    for _ in range(60):
        share = np.bincount(((height - low) / BIN_MM).astype(np.int64), np.where(free, area, 0.0))
        dense = np.convolve(share, np.ones(width), mode="same")
        if float(dense.max(initial=0.0)) < 0.5 * least:
            return
        peak = low + (int(np.argmax(dense)) + 0.5) * BIN_MM
        near = np.flatnonzero(free & (np.abs(height - peak) < thick))
        free[near] = False
        used, corners = compacted(mesh.triangles.take(rows[near], axis=0), len(mesh.vertices))
        number, count = numbered_components(corners, int(used.sum()))
        label = number.take(corners[:, 0])
        size = np.bincount(label, area[near], count)
        for one in np.flatnonzero(size > 0.5 * least):
            yield near[label == one]


def _plane(
    mesh: Mesh, vertices: Array, rows: Indices, group: Indices, area: Array, at_vertex: Array, side: float
) -> RoughPlane | None:
    corners = np.unique(mesh.triangles.take(rows[group], axis=0))
    fit = fit_plane(WeightedPoints(vertices.take(corners, axis=0), at_vertex.take(corners)))
    if len(fit.points) < 8:
        return None
    inside = np.zeros(len(mesh.vertices), dtype=bool)
    middle = fit.weights @ fit.points / fit.weights.sum()
    off = vertices.take(corners, axis=0) - middle
    away = off[:, 2] - off[:, :2] @ fit.values[1:]
    inside[corners] = np.abs(away) < MAX_FIT_SIGMAS * max(spread_of(fit.residuals), 1e-6)
    members = rows[group][inside.take(mesh.triangles.take(rows[group], axis=0)).sum(axis=1) >= 2]
    if len(members) == 0:
        return None
    normal = side * np.array([-fit.values[1], -fit.values[2], 1.0])
    size = area.take(members)
    centres = vertices.take(mesh.triangles.take(members, axis=0), axis=0).mean(axis=1)
    centroid = size @ centres / size.sum()
    centroid[2] = middle[2] + (centroid[:2] - middle[:2]) @ fit.values[1:]
    return RoughPlane(members, fit, centroid, normal / np.linalg.norm(normal), float(size.sum()))


# Certainty of surfaces fitted to a scan: standard errors from residuals that neighbours share.


@dataclass(frozen=True, eq=False)
class FittedCrank:
    """A scanned crank's fitted surfaces, in the turned axes.

    ``line`` is the common axis, ``axis_at`` its place (2,) at each cylinder's middle; ``planes`` have the
    standard errors of their heights [mm], ``noise`` is common to all errors.
    """

    long: SectionStack
    line: Fit
    journals: tuple[RoughCylinder, ...]
    pins: tuple[RoughCylinder, ...]
    axis_at: Sequence[Array]
    planes: Sequence[tuple[RoughPlane, float]]
    noise: Noise
    edge_mm: float

    @property
    def origin_pm_mm(self) -> float:
        """Standard error of the height of crankpin 1, from which z counts [mm]."""
        return self.pins[0].middle_pm_mm

    def axis_covariance_at(self, z_mm: float) -> Array:
        """Return the covariance (2, 2) of the axis' place at a height."""
        covariance = self.noise.of(self.line)
        lever = np.array([1.0, z_mm - self.line.middle_mm])
        return np.array(
            [[lever @ covariance[np.ix_([i, i + 2], [k, k + 2])] @ lever for k in range(2)] for i in range(2)]
        )

    def lean_pm_mm(self, place_mm: Array) -> float:
        """Return the standard error of a place's (2,) height over crankpin 1 from the axis' direction."""
        arm = place_mm[:2] - self.pins[0].run.centre
        return math.sqrt(max(float(arm @ self.slopes_covariance @ arm), 0.0))

    @cached_property
    def slopes_covariance(self) -> Array:
        """Covariance (2, 2) of the axis' slopes."""
        slopes: Array = self.noise.of(self.line)[2:4, 2:4]
        return slopes

    def height_pm_mm(self, z_mm: float) -> float:
        """Return the standard error of a face's height over crankpin 1; without a plane a section's step."""
        near = [
            math.hypot(pm, self.lean_pm_mm(plane.centroid))
            for plane, pm in self.planes
            if abs(plane.centroid[2] - z_mm) < 1e-6
        ]
        own = max(near) if near else self.long.blur_mm / 3.0
        return math.hypot(own, self.origin_pm_mm)


def scan_fit(fitted: FittedCrank, webs: Sequence[ScannedWeb]) -> ScanFit:
    """Return a scanned crank's fit with its standard errors, in the rotor frame."""
    line, noise = fitted.line, fitted.noise
    covariance = noise.of(line)
    journals, pins = fitted.journals, fitted.pins
    arms = [each.run.centre - at for each, at in zip((*journals, *pins), fitted.axis_at, strict=True)]
    own = [noise.of(each.fit) for each in (*journals, *pins)]
    places = [
        own[number][:2, :2] + fitted.axis_covariance_at(each.run.z_mid)
        for number, each in enumerate((*journals, *pins))
    ]
    along, across = _by_direction(arms[len(journals) :], places[len(journals) :])
    radii = [float(np.linalg.norm(arm)) for arm in arms[len(journals) :]]
    angles = [pm / radius for pm, radius in zip(across, radii, strict=True)]
    turned = [angles[0], *(math.hypot(angle, angles[0]) for angle in angles[1:])]
    x_axis = arms[len(journals)] / radii[0]
    frame = np.array([x_axis, [-x_axis[1], x_axis[0]]])
    fits = [each.fit for each in (*journals, *pins)]
    cylinders = []
    for number, each in enumerate((*journals, *pins)):
        rotor = frame @ places[number] @ frame.T
        centre_pm = np.sqrt(np.maximum(np.diag(rotor), 0.0))
        if number >= len(journals):  # about the axis it turns with crankpin 1, which settles x
            arm, turn = frame @ arms[number], angles[0]
            centre_pm = np.hypot(centre_pm, turn * np.abs([arm[1], arm[0]]))
        height_pm = math.hypot(each.middle_pm_mm, fitted.origin_pm_mm, fitted.lean_pm_mm(each.run.centre))
        centre_pm = np.array([*centre_pm, height_pm])
        if number == len(journals):
            centre_pm[1:] = 0.0
        cylinders.append(
            ScannedCylinder(
                centre_pm,
                2.0 * math.sqrt(max(float(own[number][2, 2]), 0.0)),
                each.width_pm_mm,
                each.fit.rms_mm,
                _out_of_round_mm(each),
                2.0 * float(np.linalg.norm(arms[number])) if number < len(journals) else None,
            )
        )
    weights = np.array([fit.weights.sum() for fit in fits])
    squares = np.array([fit.rms_mm**2 for fit in fits])
    return ScanFit(
        math.sqrt(float(weights @ squares / weights.sum())),
        fitted.noise.fields,
        math.sqrt(float(max(np.linalg.eigvalsh(covariance[:2, :2])[-1], 0.0))),
        math.degrees(math.sqrt(float(max(np.linalg.eigvalsh(covariance[2:4, 2:4])[-1], 0.0)))),
        line.middle_mm - pins[0].run.z_mid,
        tuple(cylinders[: len(journals)]),
        tuple(cylinders[len(journals) :]),
        tuple(along),
        tuple(math.degrees(angle) for angle in turned),
        tuple(webs),
        tuple(
            scanned_face(
                plane,
                noise,
                fitted.long.turn,
                math.hypot(pm, fitted.origin_pm_mm, fitted.lean_pm_mm(plane.centroid)),
                fitted.edge_mm,
            )
            for plane, pm in fitted.planes
        ),
    )


def _by_direction(arms: Sequence[Array], places: Sequence[Array]) -> tuple[list[float], list[float]]:
    """Return standard errors of crankpins' places, away from the axis and across."""
    both = []
    for arm, covariance in zip(arms, places, strict=True):
        unit = arm / np.linalg.norm(arm)
        both.append(
            [
                math.sqrt(max(float(way @ covariance @ way), 0.0))
                for way in (unit, np.array([-unit[1], unit[0]]))
            ]
        )
    return [pm[0] for pm in both], [pm[1] for pm in both]


def scanned_face(
    plane: RoughPlane, noise: Noise, turn: Array, height_pm_mm: float, edge_mm: float
) -> ScannedFace:
    """Return a plane in the file's axes, fitted in axes to which ``turn`` (4, 4) leads from there.

    ``height_pm_mm`` is the standard error of its height, ``edge_mm`` a triangle's edge.
    """
    back, shift = turn[:3, :3].T, turn[:3, 3]
    slopes = noise.of(plane.fit)[1:, 1:]
    border_pm = 0.5 * edge_mm
    return ScannedFace(
        plane.rows,
        back @ plane.normal,
        back @ (plane.centroid - shift),
        plane.area_mm2,
        np.array([border_pm, border_pm, height_pm_mm]),
        math.degrees(math.sqrt(float(max(np.linalg.eigvalsh(slopes)[-1], 0.0)))),
        plane.rms_mm,
        plane.flatness_mm,
    )


def _out_of_round_mm(each: RoughCylinder) -> float:
    """Return largest less smallest radius of the mean section, of up to five waves a turn."""
    fit = each.fit
    angle = np.arctan2(fit.points[:, 1] - each.run.centre[1], fit.points[:, 0] - each.run.centre[0])
    turns = np.arange(2, 6)
    rows = np.concatenate([np.cos(np.outer(angle, turns)), np.sin(np.outer(angle, turns))], axis=1)
    left = rows.T * fit.weights
    size = np.linalg.lstsq(left @ rows, left @ fit.residuals, rcond=None)[0]
    around = np.linspace(0.0, 2.0 * math.pi, 360, endpoint=False)
    section = (
        np.concatenate([np.cos(np.outer(around, turns)), np.sin(np.outer(around, turns))], axis=1) @ size
    )
    return float(np.ptp(section))
