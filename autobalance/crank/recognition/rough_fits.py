"""Least-squares surfaces of a scan's regions, and their certainty when neighbouring errors are correlated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from autobalance.crank.datums import NoiseKernel
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

OUTLIER = 3.5
"""Points that are off a surface by more than so many standard deviations (of the middle ones) are not part
of it: dents, drillings, edges."""
NO_OUTLIER = 5e-4
"""... except for those that are off a drawn cylinder by less than this share of its radius."""
LEAST_IN_PLANE = 0.5
"""If the points near a plane represent less than this share of the area, points are counted by area. Faces of
v-hacd's crank have few corners, and the many vertices of fine rounds next to them are all off."""
ROUNDS = 5
"""Fits, each without the outliers of the last: these tilt or move it at first."""
WAVES_MM = (18.0, 25.6, 36.0, 51.2, 72.0, 102.0)
"""Lengths of waves that a scan's surface may have besides. The largest faces of a crank are as wide as the
longest: of longer ones they show nothing."""
PATCHES = 220
"""Number of patches, about, over which a region's errors are averaged."""
REACHES_MM = (0.8, 1.6, 3.2, 6.4, 12.8, 25.6, 51.2)
"""Errors are modelled as a sum of fields correlated over these distances, and an uncorrelated part. Errors of
scanners are correlated over up to 40 mm: a journal shows little of such waves, and they move it most."""
LIKELIHOOD_PATCHES = 70
"""Number of patches, about, of a region from which the fields' variances are estimated."""
MOST_ROUNDS, MOST_STEP, STILL = 20, 1.5, 0.02
"""The variances are refined so often, by so many powers of e at a time, or until they change by less."""
LEAST_VARIANCE = 1e-7
"""Share of the residuals' variance that counts as none."""
PRIOR_INFORMATION = 0.1
"""Prior of the logarithm of each variance before a residual is seen: it may be anything within a factor of
20."""
DOUBT_SIGMAS = 2.0
"""Variances of fitted values are widened by so many of their standard errors: the length of waves is known
badly from short journals. Without this, axes of simulated cranks erred by up to three standard errors (RMS)
if errors were correlated over 40 mm; with it, by 0.6 to 1.2."""


@dataclass(frozen=True, eq=False)
class WeightedPoints:
    """Points (n, 3) of one surface, and their weights (n,) by area."""

    points: Array
    weights: Array


@dataclass(frozen=True, eq=False)
class Fit:
    """Least squares over points: values (k,), their influence on the points ``rows`` (n, k), and residuals.

    ``residuals`` (n,) are the points' distances [mm] at the ``points`` (n, 3) that counted; ``middle_mm`` is
    the z that a line's slopes are about.
    """

    values: Array
    rows: Array
    weights: Array
    residuals: Array
    points: Array
    middle_mm: float = 0.0

    @property
    def rms_mm(self) -> float:
        """Root mean square of the residuals [mm]."""
        return float(math.sqrt(float(self.weights @ self.residuals**2) / float(self.weights.sum())))


def spread_of(residuals: Array) -> float:
    """Return the standard deviation of residuals from their median absolute deviation [mm]."""
    return 1.4826 * float(np.median(np.abs(residuals - np.median(residuals))))


def weighted(rows: Array, target: Array, weights: Array) -> Array:
    left = rows.T * weights
    return np.asarray(np.linalg.lstsq(left @ rows, left @ target, rcond=None)[0], dtype=np.float64)


def fit_line(regions: Sequence[WeightedPoints], starts: Sequence[tuple[Array, float]]) -> Fit:
    """Return the fit of one axis through cylinders nearly along z, each with a separate radius.

    ``values`` are x and y of the axis at the points' mean z, its slopes, and the radii; the residuals are
    outward.

    Parameters
    ----------
    regions : sequence of WeightedPoints
    starts : sequence of (centre (2,), radius)
        Estimates of each [mm].
    """
    points = np.concatenate([region.points for region in regions])
    weights = np.concatenate([region.weights for region in regions])
    owner = np.repeat(np.arange(len(regions)), [len(region.points) for region in regions])
    z0 = float(np.mean([region.points[:, 2].mean() for region in regions]))
    values = np.concatenate(
        [np.mean([c for c, _ in starts], axis=0), [0.0, 0.0], [radius for _, radius in starts]]
    )
    keep = np.ones(len(points), dtype=bool)
    is_of = (owner[:, None] == np.arange(len(regions))).astype(np.float64)
    lever = points[:, 2] - z0
    for _ in range(ROUNDS):
        arm = points[:, :2] - values[:2] - lever[:, None] * values[2:4]
        away = np.hypot(*arm.T)
        unit = arm / away[:, None]
        off = away - values[4:][owner]
        rows = np.column_stack([unit, unit * lever[:, None], is_of])
        keep = np.abs(off - np.median(off)) < OUTLIER * max(spread_of(off), 1e-9)
        values = values + weighted(rows[keep], off[keep], weights[keep])
    arm = points[:, :2] - values[:2] - lever[:, None] * values[2:4]
    off = np.hypot(*arm.T) - values[4:][owner]
    keep &= np.abs(off) < 2.0 * OUTLIER * max(spread_of(off), 1e-9)
    return Fit(values, rows[keep], weights[keep], off[keep], points[keep], z0)


def fit_circle_along_z(region: WeightedPoints, centre: Array, radius: float) -> Fit:
    """Return the fit of a cylinder along z: ``values`` are x and y of its centre, and its radius."""
    points, weights = region.points, region.weights
    values = np.array([*centre, radius])
    keep = np.ones(len(points), dtype=bool)
    for _ in range(ROUNDS):
        arm = points[:, :2] - values[:2]
        away = np.hypot(*arm.T)
        rows = np.column_stack([arm / away[:, None], np.ones(len(points))])
        off = away - values[2]
        keep = np.abs(off - np.median(off)) < OUTLIER * max(spread_of(off), 1e-9)
        values = values + weighted(rows[keep], off[keep], weights[keep])
    off = np.hypot(*(points[:, :2] - values[:2]).T) - values[2]
    return Fit(values, rows[keep], weights[keep], off[keep], points[keep])


def fit_tilted_circle(region: WeightedPoints, centre: Array, radius: float) -> Fit:
    """Return the fit of a cylinder nearly along z: ``values`` are centre x and y, radius, and slopes."""
    points, weights = region.points, region.weights
    middle = float(0.5 * (points[:, 2].min() + points[:, 2].max()))
    arm = points[:, :2] - centre
    away = np.hypot(*arm.T)
    unit, lever = arm / away[:, None], points[:, 2] - middle
    rows = np.column_stack([unit, np.ones(len(points)), unit * lever[:, None]])
    off = away - radius
    keep, left = weights > 0.0, off
    for _ in range(ROUNDS):  # without outliers from the beginning: one at an end would tilt all
        apart = np.abs(left - np.median(left[keep]))
        near = (weights > 0.0) & (apart < max(OUTLIER * spread_of(left[keep]), NO_OUTLIER * radius))
        keep = near if weights[near].sum() > 0.5 * weights.sum() else keep
        values = weighted(rows[keep], off[keep], weights[keep])
        left = off - rows @ values
    fitted = values + np.array([*centre, radius, 0.0, 0.0])
    return Fit(fitted, rows[keep], weights[keep], left[keep], points[keep], middle)


def fit_plane(region: WeightedPoints) -> Fit:
    """Return the fit of a plane nearly square to z: ``values`` are height at the points' mean, and slopes."""
    points, weights = region.points, region.weights
    middle = weights @ points[:, :2] / weights.sum()
    rows = np.column_stack([np.ones(len(points)), points[:, :2] - middle])
    keep = np.ones(len(points), dtype=bool)
    values = np.zeros(3)
    for _ in range(ROUNDS):
        values = weighted(rows[keep], points[keep, 2], weights[keep])
        off = points[:, 2] - rows @ values
        near = np.abs(off) < OUTLIER * max(spread_of(off[keep]), 1e-9)
        if not weights[near].sum() > LEAST_IN_PLANE * weights.sum():
            near = np.abs(off) < OUTLIER * max(1.4826 * _weighted_median(np.abs(off), weights), 1e-9)
        keep = near
    return Fit(values, rows[keep], weights[keep], off[keep], points[keep])


def _weighted_median(values: Array, weights: Array) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, 0.5 * total[-1])]])


# --- errors that neighbours share -------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class _Patches:
    """A fit's points in patches: places (p, 3), weights (p,), rows (p, k), residuals and counts (p,)."""

    places: Array
    weights: Array
    rows: Array
    residuals: Array
    counts: Array

    @property
    def solver(self) -> Array:
        """Matrix (k, p) from errors of patches to errors of values."""
        left = self.rows.T * self.weights
        return np.asarray(np.linalg.lstsq(left @ self.rows, left, rcond=None)[0], dtype=np.float64)

    @property
    def distances(self) -> Array:
        away: Array = np.linalg.norm(self.places[:, None] - self.places[None], axis=2)
        return away


def _patches(fit: Fit, about: int = PATCHES) -> _Patches:
    """Return the points of a fit averaged in cells of space, ``about`` so many of them."""
    extent = np.ptp(fit.points, axis=0)
    size = max(math.sqrt(2.0 * float(np.sort(extent)[1:].prod()) / about), 1e-6)
    for _ in range(6):
        cells = np.floor((fit.points - fit.points.min(axis=0)) / size).astype(np.int64)
        number = np.unique(cells @ np.array([1 << 40, 1 << 20, 1]), return_inverse=True)[1]
        count = int(number.max()) + 1
        if count <= 1.6 * about:
            break
        size *= 1.25
    weight = np.bincount(number, fit.weights)

    def mean(column: Array) -> Array:
        means: Array = np.bincount(number, fit.weights * column) / weight
        return means

    return _Patches(
        np.stack([mean(column) for column in fit.points.T], axis=1),
        np.asarray(weight, dtype=np.float64),
        np.stack([mean(column) for column in fit.rows.T], axis=1),
        mean(fit.residuals),
        np.asarray(np.bincount(number), dtype=np.float64),
    )


REACHES = tuple(NoiseKernel(reach) for reach in REACHES_MM)
WAVES = (*REACHES[:-1], *(NoiseKernel(length, is_wave=True) for length in WAVES_MM))


@dataclass(frozen=True, eq=False)
class Noise:
    """Likeness of errors at two places: variances (b,) of fields with some ``kernels``, and of white noise.

    ``doubt`` (b, b) is the covariance of the variances' logarithms; None where they are known.
    """

    variances: Array
    doubt: Array | None = None
    kernels: tuple[NoiseKernel, ...] = REACHES

    def of(self, fit: Fit) -> Array:
        """Return the covariance (k, k) of a fit's values, widened by what is uncertain of the noise."""
        if fit not in self._known:
            self._known[fit] = self._covariance(fit)
        return self._known[fit]

    @cached_property
    def _known(self) -> dict[Fit, Array]:
        """Covariances by fit: that of an axis is needed at every place along it."""
        return {}

    def _covariance(self, fit: Fit) -> Array:
        patches = _patches(fit)
        solver = patches.solver
        parts = [
            variance * (solver @ basis @ solver.T)
            for variance, basis in zip(self.variances, _bases(patches, self.kernels), strict=True)
        ]
        covariance: Array = np.sum(parts, axis=0)
        if self.doubt is None:
            return covariance
        own = np.array([np.diag(part) for part in parts])
        spread = np.sqrt(np.maximum(np.einsum("bi,bc,ci->i", own, self.doubt, own), 0.0))
        wider = np.sqrt(1.0 + DOUBT_SIGMAS * spread / np.maximum(np.diag(covariance), 1e-300))
        widened: Array = covariance * np.outer(wider, wider)
        return widened

    def height_pm_mm(self, fit: Fit) -> float:
        """Return the standard error of a fit's first value, a plane's height [mm]."""
        return math.sqrt(max(float(self.of(fit)[0, 0]), 0.0))

    @property
    def fields(self) -> tuple[tuple[NoiseKernel, float], ...]:
        """Kernel and standard deviation [mm] of each field; white noise of a million vertices is nothing."""
        deviations = np.sqrt(np.maximum(self.variances[:-1], 0.0)).tolist()
        return tuple(zip(self.kernels, deviations, strict=True))


def _bases(patches: _Patches, kernels: Sequence[NoiseKernel]) -> list[Array]:
    squared = patches.distances**2
    return [*(kernel.likeness(squared) for kernel in kernels), np.diag(1.0 / patches.counts)]


def noise_of(fits: Sequence[Fit], kernels: tuple[NoiseKernel, ...] = REACHES) -> Noise:
    """Return the noise of many fits together, from what of their residuals the fits could not remove.

    Restricted maximum likelihood of the fields' variances, refined by Fisher's scoring of their logarithms.

    References
    ----------
    H. D. Patterson, R. Thompson: Recovery of inter-block information when block sizes are unequal.
    Biometrika 58 (1971), 545-554.
    """
    seen = [found for fit in fits if (found := _contrasts(fit, kernels)) is not None]
    typical = float(np.mean([left @ left / len(left) for left, _ in seen])) if seen else 0.0
    count = len(kernels) + 1
    if typical <= 0.0:
        return Noise(np.zeros(count), kernels=kernels)
    logs = np.full(count, math.log(typical / count))
    for _ in range(MOST_ROUNDS):
        slope, information = _likelihood(seen, np.exp(logs), typical)
        step = np.linalg.solve(information, slope)
        logs += np.clip(step, -MOST_STEP, MOST_STEP)
        logs = np.maximum(logs, math.log(LEAST_VARIANCE * typical))
        if np.abs(step).max() < STILL:
            break
    information = _likelihood(seen, np.exp(logs), typical)[1]
    return Noise(np.exp(logs), np.asarray(np.linalg.inv(information), dtype=np.float64), kernels)


def _contrasts(fit: Fit, kernels: Sequence[NoiseKernel]) -> tuple[Array, list[Array]] | None:
    """Return sums of residuals (c,) to which no change of a fit's values adds, with the fields' parts (c, c).

    None where the fit explains everything.
    """
    patches = _patches(fit, LIKELIHOOD_PATCHES)
    rank = patches.rows.shape[1]
    if len(patches.counts) <= rank:
        return None
    across = np.linalg.qr(patches.rows, mode="complete")[0][:, rank:].T
    return across @ patches.residuals, [across @ basis @ across.T for basis in _bases(patches, kernels)]


def _likelihood(
    seen: Sequence[tuple[Array, list[Array]]], variances: Array, typical: float
) -> tuple[Array, Array]:
    """Return the likelihood's slope (b,) by the logarithms of the variances, and its information (b, b)."""
    slope = np.zeros(len(variances))
    information = np.zeros((len(variances), len(variances)))
    for left, parts in seen:
        covariance = sum(variance * part for variance, part in zip(variances, parts, strict=True))
        inverse = np.linalg.inv(covariance + 1e-9 * typical * np.eye(len(left)))
        force = inverse @ left
        shares = [variance * (inverse @ part) for variance, part in zip(variances, parts, strict=True)]
        slope += 0.5 * np.array(
            [
                variance * (force @ part @ force) - np.trace(share)
                for variance, part, share in zip(variances, parts, shares, strict=True)
            ]
        )
        rows, columns = (np.array([each.ravel() for each in way]) for way in (shares, [s.T for s in shares]))
        information += 0.5 * rows @ columns.T
    return slope, information + PRIOR_INFORMATION * np.eye(len(variances))


def rows_near(points: Array, low: float, high: float) -> Indices:
    """Return the numbers of points (n, 3) between two heights."""
    rows: Indices = np.flatnonzero((points[:, 2] >= low) & (points[:, 2] <= high))
    return rows
