"""Comparison of a typed axis, journals and crankpins with the cylinders that the file has there.

The cylinder is sought in the triangles themselves, without the recognised ones: it may be a bore, a scan's
rough surface, or one that recognition passed over.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autobalance.crank.anatomy import (
    Anatomy,
    AxisFound,
    Cylinder,
    CylinderFound,
    Overrides,
    PinHint,
    Typed,
)
from autobalance.crank.recognition.circles import AT_A_TIME, distances, fit_circle
from autobalance.crank.recognition.cylinder_runs import ON_CYLINDER, CylinderRun, densest
from autobalance.crank.recognition.doubts import UPRIGHT
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.errors import RecognitionError
from autobalance.solid.mesh.mesh import Mesh, least_and_greatest
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

LEAST_COVER = 0.25
"""Smallest share of a typed cylinder that a surface covers to be the one that is meant."""
COVER_OF_ANOTHER = 0.6
"""... of one of another diameter, as the bearing surfaces have: a web's hub about the axis covers half ..."""
ANOTHER_SIZE = 0.1
"""... which differs by more than this share."""
SIZE_RATIO = 2.2
"""Diameters differ by at most this factor: a disc web about the axis is three times as wide as a journal."""
REACH_RATIO = 2.5
"""Surface is sought within so many typed radii."""
LEAST_REACH = 1e-3
"""A triangle counts if it reaches this share of the typed width into it, or by half: fillets touch the end by
a file's digits, and have more corners than the cylinder."""
PAIRS, SAMPLE = 400, 1500
"""Pairs of triangles whose normals meet in an axis, and triangles on which each axis is tried."""
LEAST_ANGLE = 0.3
"""Smallest difference of a pair's unit normals: nearly parallel ones meet anywhere."""
VOTE_RATIO = 0.12
"""A triangle votes for an axis that its normal passes by less than this share of the radius: a third of the
width of one of 24 facets."""
COARSE_VOTE_RATIO = 0.8
"""... or its middle is beside the axis by less than this share: a facet of a pentagon."""
CORNER_RATIO = 0.3
"""Corners of a pentagon are so much farther out than its sides, as a share of their distance."""
MAX_RESIDUAL_RATIO = 0.02
"""Vertices are on a cylinder when they are off it by less than this share of the radius."""
MEDIANS = 5.0
"""Largest distance from it of those that count in its fit, in medians; scattered ones all count."""
HALVINGS = 8
LEAST_VERTICES = 6
"""Vertices of a cylinder at least: three make a circle, and as many show that it is one."""
RINGS = (1e-2, 2e-3, 4e-4, 1e-4)
"""Widths of the ring in which most vertices are, one after the other, as shares of the radius."""
LEAST_EXACT = 0.2
"""A model's cylinder has this share of its vertices exactly on it; a pin with two oil holes has a third."""
SQUARE = (0.03, 0.01, 1.0)
"""Normals of a cylinder are square to its direction within the first two, one after the other: those of a
fillet's first facets are not."""
MAX_SLOPE = 0.1
"""A typed direction may lean by this much."""
GAP_RATIO = 0.3
"""Triangles of one cylinder leave at most this share of its radius open along it: oil holes and grooves."""
BESIDE_RATIO = 2.0
"""Bores of a crankpin that is not in the file are sought beside it along so many of its radii."""
SAME_MM = 0.02
"""Typed values agree with the file within this, or within ..."""
ROUGHNESS_RATIO = 3.0
"""... so many times the file's own roughness,"""
SAME_DIRECTION_DEG = 0.01
"""Directions agree within this: 0.02 mm over 100 mm."""
SAME_DIAMETER_SHARE, SAME_DIAMETER_MM = 0.005, 0.1
"""a diameter within this share and this length."""


class NothingThereError(RecognitionError):
    """Lack of a surface where a job types a cylinder."""

    def __init__(self, key: str, place: int, hint: PinHint, radius_mm: float) -> None:
        x, y, z = hint.centre_mm
        super().__init__(
            f"{key}[{place}] is a cylinder of {2.0 * radius_mm:.4g} mm at [{x:.6g}, {y:.6g}, {z:.6g}] mm; "
            "the file has no surface that covers a quarter of it"
        )


@dataclass(frozen=True, eq=False)
class _Surface:
    """Upright triangles near a cylinder: rows, middles and unit normals (k, 2), areas (k,) in its stretch."""

    rows: Indices
    middles: Array
    normals: Array
    areas: Array

    def of(self, chosen: NDArray[np.bool_]) -> _Surface:
        return _Surface(self.rows[chosen], self.middles[chosen], self.normals[chosen], self.areas[chosen])


@dataclass(frozen=True, eq=False)
class _Fit:
    """A cylinder fitted to the surface at a typed one; ``cover``: its share of the typed one's stretch."""

    run: CylinderRun
    is_bore: bool
    cover: float
    rms_mm: float

    def apart_mm(self, typed: CylinderRun) -> float:
        return float(np.linalg.norm(self.run.centre - typed.centre)) + abs(self.run.radius - typed.radius)


class TypedComparison:
    """Comparison of a job's own statements with a mesh in its turned axes.

    Parameters
    ----------
    mesh : Mesh
    long : SectionStack
        Of the same mesh.
    rounding_mm : float
        Of the file's coordinates.
    """

    def __init__(self, mesh: Mesh, long: SectionStack, rounding_mm: float) -> None:
        self.mesh, self.long, self.rounding_mm = mesh, long, rounding_mm
        z = long.vertices[:, 2]
        self.low, self.high = least_and_greatest(z, mesh.triangles)
        vectors = 0.5 * mesh.area_vectors @ long.turn[:3, :3].T
        self.areas = 0.5 * mesh.doubled_areas
        self.upright = np.abs(vectors[:, 2]) < UPRIGHT * self.areas
        self.vectors = vectors[:, :2]

    def found(self, typed: CylinderRun, beside: bool = False) -> _Fit | None:
        """Return the cylinder nearest to a typed one; of several equal ones the one that covers most.

        With ``beside`` it may be a bore in the webs next to it, too.
        """
        fits = self._fits(typed, (typed.z_low, typed.z_high))
        if beside and not fits:
            reach = BESIDE_RATIO * typed.radius
            stretches = ((typed.z_low - reach, typed.z_low), (typed.z_high, typed.z_high + reach))
            fits = [fit for low_high in stretches for fit in self._fits(typed, low_high) if fit.is_bore]
        return min(fits, key=lambda fit: (fit.apart_mm(typed), -fit.cover), default=None)

    def _fits(self, typed: CylinderRun, stretch: tuple[float, float]) -> list[_Fit]:
        surface = self._surface(typed, stretch)
        fine = self._fits_to(surface, typed, stretch, VOTE_RATIO)
        return fine or self._fits_to(surface, typed, stretch, COARSE_VOTE_RATIO)

    def _fits_to(
        self, surface: _Surface, typed: CylinderRun, stretch: tuple[float, float], aside: float
    ) -> list[_Fit]:
        fits: list[_Fit] = []
        for _ in range(3):  # outside, bore, web beside it
            best = _voted(surface, aside)
            if best is None:
                break
            centre, radius, mine = best
            fit = self._fitted(surface.of(mine), centre, radius, stretch)
            surface = surface.of(~mine)
            if fit is not None and _is_meant(fit, typed):
                fits.append(fit)
        return fits

    def _surface(self, typed: CylinderRun, stretch: tuple[float, float]) -> _Surface:
        low, high = stretch
        rows = np.flatnonzero(self.upright & (self.high > low) & (self.low < high))
        corners = self.long.vertices.take(self.mesh.triangles.take(rows, axis=0), axis=0)
        middles = corners[..., :2].mean(axis=1)
        near = np.hypot(*(middles - typed.centre).T) < REACH_RATIO * typed.radius
        rows, middles = rows[near], middles[near]
        tall = np.maximum(self.high[rows] - self.low[rows], 1e-12)
        inside = np.minimum(self.high[rows], high) - np.maximum(self.low[rows], low)
        reach = inside > np.minimum(LEAST_REACH * (high - low), 0.5 * tall)
        rows, middles, tall, inside = rows[reach], middles[reach], tall[reach], inside[reach]
        areas = self.areas[rows] * np.clip(inside / tall, 0.0, 1.0)
        vectors = self.vectors[rows]
        normals = vectors / np.maximum(np.hypot(*vectors.T), 1e-300)[:, None]
        return _Surface(rows, middles, normals, areas)

    def _fitted(
        self, surface: _Surface, centre: Array, radius: float, stretch: tuple[float, float]
    ) -> _Fit | None:
        """Return the cylinder through the vertices of triangles that voted for it.

        It follows the surface's own direction: that of a typed axis may lean.
        """
        corners = np.unique(self.mesh.triangles.take(surface.rows, axis=0))
        slope = self._slope(surface.rows)
        middle = 0.5 * (stretch[0] + stretch[1])
        points = self._upright(corners, slope, middle)
        near = (
            np.abs(distances(points, centre) - abs(radius)) <= CORNER_RATIO * abs(radius) + self.rounding_mm
        )
        if near.sum() < LEAST_VERTICES:
            return None
        centre, size, rms = _round(points[near], centre, abs(radius), self.rounding_mm)
        upright = self._upright(slice(None), slope, middle)
        ends = self._ends(upright, centre, size, radius < 0.0, stretch, MEDIANS * rms)
        if ends is None:
            return None
        on = corners[np.abs(distances(points, centre) - size) <= MAX_RESIDUAL_RATIO * size + self.rounding_mm]
        mine = np.isin(self.mesh.triangles.take(surface.rows, axis=0), on).all(axis=1)
        wide = max(stretch[1] - stretch[0], 1e-9)
        cover = float(surface.areas[mine].sum()) / (2.0 * math.pi * size * wide)
        return _Fit(CylinderRun(centre, size, *ends), radius < 0.0, cover, rms)

    def _slope(self, rows: Indices) -> Array:
        """Return the slopes (2,) of x and y along the direction that is square to triangles' normals."""
        vectors = self.mesh.area_vectors.take(rows, axis=0) @ self.long.turn[:3, :3].T
        units = vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None]
        square = np.ones(len(vectors), dtype=bool)
        for limit in SQUARE:
            along = np.linalg.eigh(units[square].T @ vectors[square])[1][:, 0]
            square = np.abs(units @ along) < limit
        slope: Array = along[:2] / along[2] if abs(along[2]) > UPRIGHT else np.zeros(2)
        return slope if math.hypot(*slope) < MAX_SLOPE else np.zeros(2)

    def _upright(self, rows: Indices | slice, slope: Array, middle_mm: float) -> Array:
        """Return vertices (k, 3), moved across so that a direction is upright; one height is kept."""
        points = np.array(self.long.vertices[rows])
        points[:, :2] -= (points[:, 2:] - middle_mm) * slope
        return points

    def _ends(
        self,
        vertices: Array,
        centre: Array,
        size: float,
        is_bore: bool,
        stretch: tuple[float, float],
        rough_mm: float,
    ) -> tuple[float, float] | None:
        """Return beginning and end of a cylinder's surface along z: the stretch of it at the typed place."""
        on = np.abs(distances(vertices, centre) - size) <= max(1e-4 * size, rough_mm) + self.rounding_mm
        rows = np.flatnonzero(on.take(self.mesh.triangles).all(axis=1) & self.upright)
        arms = vertices.take(self.mesh.triangles.take(rows, axis=0), axis=0)[..., :2].mean(axis=1) - centre
        outward = (arms * self.vectors[rows]).sum(axis=1) > 0.0
        rows = rows[outward != is_bore]
        if len(rows) == 0:
            return None
        order = np.argsort(self.low[rows])
        low, high = self.low[rows][order], np.maximum.accumulate(self.high[rows][order])
        breaks = np.flatnonzero(low[1:] > high[:-1] + GAP_RATIO * size)
        begins, finishes = np.append(0, breaks + 1), np.append(breaks, len(low) - 1)
        pieces = [(float(low[a]), float(high[b])) for a, b in zip(begins, finishes, strict=True)]
        return max(pieces, key=lambda piece: min(piece[1], stretch[1]) - max(piece[0], stretch[0]))


def _round(points: Array, centre: Array, size: float, rounding_mm: float) -> tuple[Array, float, float]:
    """Return centre, radius and root mean square distance of the circle that points (k, 2 or more) show.

    Vertices of a model are on it exactly, those of an oil hole's rim within: then it is the ring that most
    are on. Points of a rough surface all count except for the farthest.
    """
    centre, size = fit_circle(points[:, :2])
    for share in RINGS:
        away = distances(points, centre)
        ring = np.abs(away - densest(away, share * size, size)) <= share * size + rounding_mm
        if ring.sum() < LEAST_VERTICES:
            break
        centre, size = fit_circle(points[ring, :2])
    exact = np.abs(distances(points, centre) - size) <= ON_CYLINDER * size + rounding_mm
    if exact.sum() >= max(LEAST_VERTICES, LEAST_EXACT * len(points)):
        centre, size = fit_circle(points[exact, :2])
        off = distances(points[exact], centre) - size
        return centre, size, float(np.sqrt(np.mean(off**2)))
    centre, size = fit_circle(points[:, :2])
    for _ in range(HALVINGS):
        off = np.abs(distances(points, centre) - size)
        centre, size = fit_circle(points[off <= float(np.median(off)) + rounding_mm, :2])
    off = np.abs(distances(points, centre) - size)
    near = off <= MEDIANS * float(np.median(off)) + rounding_mm
    centre, size = fit_circle(points[near, :2])
    return centre, size, float(np.sqrt(np.mean((distances(points[near], centre) - size) ** 2)))


def _voted(surface: _Surface, aside: float) -> tuple[Array, float, NDArray[np.bool_]] | None:
    """Return centre, radius (below 0 of a bore) and triangles of the axis that most surface is about."""
    total = float(surface.areas.sum())
    if len(surface.rows) < 6 or not total > 0.0:
        return None
    rng = np.random.default_rng(len(surface.rows))
    share = surface.areas / total
    one, two = rng.choice(len(share), (2, PAIRS), p=share)
    turn = surface.normals[one] - surface.normals[two]
    size = np.maximum((turn**2).sum(axis=1), 1e-12)
    radii = ((surface.middles[one] - surface.middles[two]) * turn).sum(axis=1) / size
    ahead = surface.middles[one] - radii[:, None] * surface.normals[one]
    centres = 0.5 * (ahead + surface.middles[two] - radii[:, None] * surface.normals[two])
    good = (size > LEAST_ANGLE**2) & (np.abs(radii) > 1e-6)
    centres, radii = centres[good], radii[good]
    if len(radii) == 0:
        return None
    some = np.arange(len(share))
    if len(some) > SAMPLE:
        some = rng.choice(len(share), SAMPLE, replace=False, p=share)
    middles, normals, weight = surface.middles[some], surface.normals[some], surface.areas[some]
    rows, votes = max(1, AT_A_TIME // len(some)), np.zeros(len(radii))
    for begin in range(0, len(radii), rows):
        few = slice(begin, begin + rows)
        agree = _agree(middles, normals, centres[few], radii[few], aside)
        votes[few] = [float(weight @ each) for each in agree]
    best = int(np.argmax(votes))
    chosen = slice(best, best + 1)
    mine = _agree(surface.middles, surface.normals, centres[chosen], radii[chosen], aside)[0]
    return centres[best], float(radii[best]), mine


def _agree(middles: Array, normals: Array, centres: Array, radii: Array, aside: float) -> NDArray[np.bool_]:
    """Mark for each axis (rows) the triangles that face it at its radius, ``aside`` by at most that share."""
    (x, y), (u, v) = np.ascontiguousarray(middles.T), np.ascontiguousarray(normals.T)
    at_x, at_y = centres.T[:, :, None]
    arm_x, arm_y = x - at_x, y - at_y
    along = arm_x * u + arm_y * v - radii[:, None]
    across = arm_x * v - arm_y * u
    most = np.array([(VOTE_RATIO * radius) ** 2 for radius in radii])
    agree: NDArray[np.bool_] = along**2 + (across * VOTE_RATIO / aside) ** 2 < most[:, None]
    return agree


def _is_meant(fit: _Fit, typed: CylinderRun) -> bool:
    ratio = fit.run.radius / typed.radius
    least = COVER_OF_ANOTHER if abs(ratio - 1.0) > ANOTHER_SIZE else LEAST_COVER
    beside = float(np.linalg.norm(fit.run.centre - typed.centre))
    return (
        1.0 / SIZE_RATIO < ratio < SIZE_RATIO
        and beside < max(fit.run.radius, typed.radius)
        and fit.cover >= least
    )


# --- journals and crankpins ---------------------------------------------------------------------------------


def typed_and_found(
    mesh: Mesh,
    long: SectionStack,
    layout: JournalLayout,
    overrides: Overrides,
    rounding_mm: float,
    to_rotor: Array,
) -> Typed:
    """Return the features of the file at the axis, journals and crankpins that a job types.

    Parameters
    ----------
    mesh : Mesh
    long : SectionStack
        Of the same mesh.
    layout : JournalLayout
        Of the crank, typed or recognised.
    overrides : Overrides
    rounding_mm : float
        Of the file's coordinates.
    to_rotor : (4, 4) float
        From the turned axes to the rotor frame.

    Raises
    ------
    NothingThereError
        If the file has no surface that covers a quarter of a typed cylinder.
    """
    typed = (overrides.axis_point_mm, overrides.axis_direction, overrides.crankpins, overrides.main_journals)
    if all(each is None for each in typed):
        return Typed()
    comparison = TypedComparison(mesh, long, rounding_mm)
    place = _Placing(comparison, to_rotor)
    in_file = overrides.crankpin_in_file is True
    journals = place.all("main_journals", overrides.main_journals, layout.journals, False)
    pins = place.all("crankpins", overrides.crankpins, layout.pins, not in_file)
    axis = None
    if overrides.axis_point_mm is not None or overrides.axis_direction is not None:
        axis = place.axis(layout.journals if journals is None else None)
    return Typed(
        axis_point=overrides.axis_point_mm is not None,
        axis_direction=overrides.axis_direction is not None,
        axis=axis,
        main_journals=journals,
        crankpins=pins,
    )


class _Placing:
    """Cylinders found for typed ones, placed in the rotor frame."""

    def __init__(self, comparison: TypedComparison, to_rotor: Array) -> None:
        self.comparison, self.to_rotor = comparison, to_rotor
        self.fits: dict[str, list[_Fit]] = {}

    def axis(self, recognised: Sequence[CylinderRun] | None) -> AxisFound | None:
        """Return the line through the main journals found, or recognised; None without any."""
        fits = self.fits.get("main_journals", [])
        if recognised is not None:
            fits = [fit for run in recognised if (fit := self.comparison.found(run)) is not None]
        if not fits:
            return None
        centres = np.array([[*fit.run.centre, fit.run.z_mid] for fit in fits])
        centres = centres @ self.to_rotor[:3, :3].T + self.to_rotor[:3, 3]
        widest = max((fit.run for fit in fits), key=lambda run: run.width)
        rough_mm = max(fit.rms_mm for fit in fits)
        return AxisFound(centres, 2.0 * widest.radius, max(SAME_MM, ROUGHNESS_RATIO * rough_mm))

    def all(
        self, key: str, hints: Sequence[PinHint] | None, runs: Sequence[CylinderRun], may_lack: bool
    ) -> tuple[CylinderFound, ...] | None:
        """Return the find for each hint, in the order of the numbered ``runs``; None without hints."""
        if hints is None:
            return None
        long = self.comparison.long
        order = sorted(range(len(hints)), key=lambda n: float(long.placed(hints[n].centre_mm)[2]))
        found: list[CylinderFound] = []
        self.fits[key] = []
        for place, run in zip(order, runs, strict=True):
            hint = hints[place]
            typed = _typed_run(long, hint, run)
            fit = self.comparison.found(typed, may_lack)
            if fit is None:
                raise NothingThereError(key, place, hint, typed.radius)
            self.fits[key].append(fit)
            found.append(self._found(fit, hint, typed, place))
        return tuple(found)

    def _found(self, fit: _Fit, hint: PinHint, typed: CylinderRun, place: int) -> CylinderFound:
        centre = np.array([*fit.run.centre, fit.run.z_mid])
        slack = max(SAME_MM, ROUGHNESS_RATIO * fit.rms_mm)
        low, high = fit.run.z_low - typed.z_low, typed.z_high - fit.run.z_high
        ends_mm = slack + self.comparison.long.blur_mm
        along = 0.0
        if hint.width_mm is not None and max(low, high) > ends_mm and abs(low - high) > 2.0 * ends_mm:
            along = fit.run.z_mid - typed.z_mid
        back, shift = self.comparison.long.turn[:3, :3], self.comparison.long.turn[:3, 3]
        return CylinderFound(
            centre_mm=self.to_rotor[:3, :3] @ centre + self.to_rotor[:3, 3],
            diameter_mm=2.0 * fit.run.radius,
            width_mm=fit.run.width,
            kind="bore" if fit.is_bore else "outside",
            hint=place,
            typed_mm=self.to_rotor[:3, :3] @ np.array([*typed.centre, typed.z_mid]) + self.to_rotor[:3, 3],
            typed_diameter_mm=hint.diameter_mm,
            along_mm=along,
            within_mm=slack,
            centre_in_file_mm=back.T @ (centre - shift),
        )


def _typed_run(long: SectionStack, hint: PinHint, run: CylinderRun) -> CylinderRun:
    """Return a hint as a cylinder, completed from the one that was taken there."""
    centre = long.placed(hint.centre_mm)
    radius = run.radius if hint.diameter_mm is None else 0.5 * hint.diameter_mm
    if hint.width_mm is None:
        return replace(run, centre=centre[:2], radius=radius)
    half = 0.5 * hint.width_mm
    return CylinderRun(centre[:2], radius, float(centre[2]) - half, float(centre[2]) + half)


# --- refusals -----------------------------------------------------------------------------------------------


def contradictions(anatomy: Anatomy, overrides: Overrides) -> list[str]:
    """Return in what a job's own statements differ from a crank as recognised without them, in words.

    Parameters
    ----------
    anatomy : Anatomy
        Recognised without them.
    overrides : Overrides
    """
    texts = list(_other_axis(anatomy, overrides))
    back = anatomy.rotor_to_file
    for key, hints in (("main_journals", overrides.main_journals), ("crankpins", overrides.crankpins)):
        for place, hint in enumerate(hints or ()):
            at = anatomy.file_to_rotor[:3, :3] @ hint.centre_mm + anatomy.file_to_rotor[:3, 3]
            near = min(anatomy.cylinders, key=lambda each: _away_mm(each, at, hint), default=None)
            if near is None:
                continue
            aside = float(np.hypot(*(near.centre_mm[:2] - at[:2])))
            thicker = 0.0 if hint.diameter_mm is None else abs(near.diameter_mm - hint.diameter_mm)
            along = abs(float(near.centre_mm[2]) - float(at[2]))
            if aside <= SAME_MM and thicker <= SAME_DIAMETER_MM and along <= 0.5 * near.width_mm:
                continue
            x, y, z = np.round(back[:3, :3] @ near.centre_mm + back[:3, 3], 4) + 0.0
            kind = "bore" if near.kind == "bore" else "cylinder"
            texts.append(
                f"the nearest {kind} to {key}[{place}] has {near.diameter_mm:.4g} mm at [{x:.6g}, {y:.6g}, "
                f"{z:.6g}] mm and is {near.width_mm:.4g} mm wide, {math.hypot(aside, along):.3g} mm away"
            )
    return texts


def _other_axis(anatomy: Anatomy, overrides: Overrides) -> Iterator[str]:
    axis, point = anatomy.rotor_to_file[:3, 2], anatomy.rotor_to_file[:3, 3]
    if overrides.axis_direction is not None and np.any(overrides.axis_direction):
        typed = overrides.axis_direction / np.linalg.norm(overrides.axis_direction)
        lean = math.degrees(math.asin(min(1.0, float(np.linalg.norm(np.cross(axis, typed))))))
        if lean > SAME_DIRECTION_DEG:
            x, y, z = np.round(axis, 6) + 0.0
            yield f"axis_direction leans by {lean:.3g}° from the file's axis, [{x:.6g}, {y:.6g}, {z:.6g}]"
    if overrides.axis_point_mm is not None:
        off = float(np.linalg.norm(np.cross(axis, overrides.axis_point_mm - point)))
        if off > SAME_MM:
            x, y, z = np.round(point, 4) + 0.0
            yield f"axis_point_mm is {off:.3g} mm off the file's axis through [{x:.6g}, {y:.6g}, {z:.6g}] mm"


def _away_mm(each: Cylinder, at: Array, hint: PinHint) -> float:
    """Return the distance of a typed cylinder from one of the file: aside, beyond its ends, and in size."""
    along = max(0.0, abs(float(each.centre_mm[2] - at[2])) - 0.5 * each.width_mm)
    size = 0.0 if hint.diameter_mm is None else 0.5 * abs(each.diameter_mm - hint.diameter_mm)
    return math.hypot(float(np.hypot(*(each.centre_mm[:2] - at[:2]))), along) + size
