"""Uncertainty of a scan: noise that neighbours share, skin, scale, the fitted axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field

import numpy as np

from autobalance.crank.datums import ScanFit
from autobalance.rigid_rotor.unbalance import Moments, Places, Share, Unbalance, root_sum
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.roughness import smoothed_normals
from autobalance.types import Array
from autobalance.value_classes import dataclass

PATCHES = 900
"""The surface is looked at in about so many patches."""
TWO_AXES_SIGMAS_95 = 2.45
"""Factor for two errors at right angles, each of one standard deviation: 95 % together are within it."""
ONE_AXIS_SIGMAS_95 = 1.96


@dataclass(frozen=True, eq=False)
class ScanUncertainty:
    """Uncertainty of the unbalance by the scan (95 %).

    Attributes
    ----------
    at_random : Share
        Of noise and of the fitted axis.
    acting : (k, 2) float
        What a millimetre of skin, and a scale that is off by 1, do to resultant and planes.
    skin_and_scale : (2, 2) float
        Their covariance.
    places : (float, float), optional
        Where planes A and B are [mm].
    """

    at_random: Share
    acting: Array
    skin_and_scale: Array
    places: Places

    @property
    def share(self) -> Share:
        """Contribution of the scan to the uncertainty budget before any cut."""
        return self.after(())

    def after(self, rates: Sequence[Moments]) -> Share:
        """Return the share of the budget once cuts are made that change so much with a millimetre of depth.

        Skin is metal that is missing. Depths that count from the metal leave it on the new faces too; tools
        that are where they are take it off with them: the greater of both counts.
        """
        whole = self._evenly(self.acting)
        if not rates:
            return root_sum([self.at_random, whole], self.places)
        moved = np.zeros(len(self.acting))
        for rate in rates:
            moved += _vectors(rate, self.places) * (1.0 if rate.mass_g <= 0.0 else -1.0)
        cut = self._evenly(self.acting + np.stack([moved, np.zeros(len(moved))], axis=1))
        pairs = zip(whole.planes_g_mm, cut.planes_g_mm, strict=True)
        greater = Share(
            max(whole.resultant_g_mm, cut.resultant_g_mm), tuple(max(one, other) for one, other in pairs)
        )
        return root_sum([self.at_random, greater], self.places)

    def _evenly(self, acting: Array) -> Share:
        sizes = [
            ONE_AXIS_SIGMAS_95 * math.sqrt(max(float(np.trace(rows @ self.skin_and_scale @ rows.T)), 0.0))
            for rows in (acting[number : number + 2] for number in range(0, len(acting), 2))
        ]
        return Share(sizes[0], tuple(sizes[1:]))


def _vectors(change: Moments, places: Places) -> Array:
    """Return the effect of a change on the resultant and the planes (2 [+ 4])."""
    unbalance = Unbalance.of(change)
    planes = () if places is None else unbalance.in_planes(*places)
    return np.concatenate([unbalance.resultant_g_mm, *planes])


@dataclass(frozen=True, eq=False)
class Patches:
    """A scan's surface as patches: middles (p, 3) and areas (p,) [mm, mm²], and the diagonal of its box.

    ``mass_noise`` keeps the variance of the mass by fit and density, ``noise`` the covariance of the
    unbalance by these and the planes: the table of distances takes long, and both need it.
    """

    middle: Array
    area: Array
    diagonal_mm: float
    mass_noise: dict[tuple[ScanFit, float], float] = field(default_factory=dict, repr=False)
    noise: dict[tuple[ScanFit, float, Places], Array] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, mesh: Mesh) -> Patches:
        """Return the patches of a mesh, in its coordinates."""
        area = 0.5 * mesh.doubled_areas
        middle = mesh.vertices.take(mesh.triangles, axis=0).mean(axis=1)
        size = math.sqrt(float(area.sum()) / PATCHES)
        facing = np.floor((smoothed_normals(mesh, 1) + 1.0) * 1.49).astype(np.int64)
        cells = np.floor((middle - mesh.bounds[0]) / size).astype(np.int64)
        key = cells @ np.array([1 << 40, 1 << 25, 1 << 10]) + facing @ np.array([16, 4, 1])
        number = np.unique(key, return_inverse=True)[1]
        total = np.bincount(number, area)
        places = [np.bincount(number, area * column) / np.maximum(total, 1e-300) for column in middle.T]
        return cls(np.stack(places, axis=1), np.asarray(total, dtype=np.float64), mesh.diagonal_mm)


def scan_uncertainty(
    surface: Patches,
    fit: ScanFit,
    crank: Moments,
    density_g_mm3: float,
    accuracy_mm: float | None,
    places: Places = None,
    skin_and_scale: Array | None = None,
) -> ScanUncertainty:
    """Return the uncertainty of the crank's unbalance by the scan.

    Parameters
    ----------
    surface : Patches
        In the rotor frame.
    fit : ScanFit
    crank : Moments
        Of the bare crank, rotor frame.
    density_g_mm3 : float
        Density [g/mm³].
    accuracy_mm : float or None
        Of the scanner, 95 %: an even skin, and the same over the whole crank as scale. None: the roughness
        is in.
    places : (float, float), optional
        Where planes A and B are [mm].
    skin_and_scale : (2, 2) float, optional
        Covariance of the scanner's skin [mm] and scale, where they were calibrated; None: what the accuracy
        leaves open of them.
    """
    levers = _levers(surface, places) * density_g_mm3
    noise = surface.noise.get((fit, density_g_mm3, places))
    if noise is None:
        even = np.full((1, len(surface.area)), density_g_mm3)
        noise, mass = _noise_covariances(surface, fit, levers, even)
        surface.noise[fit, density_g_mm3, places] = noise
        surface.mass_noise[fit, density_g_mm3] = float(mass[0, 0])
    if skin_and_scale is None:
        skin_and_scale = _open(surface, fit, accuracy_mm)
    acting = np.stack([levers @ surface.area, 4.0 * _vectors(crank, places)], axis=1)
    vectors = [_lengths(noise, number) for number in range(0, len(noise), 2)]
    shares = [
        Share(vectors[0], tuple(vectors[1:])),
        _of_axis(crank, fit, places),
        Share.of(crank.scaled(ONE_AXIS_SIGMAS_95 * math.radians(fit.angle_pm_deg[0])), places),
    ]
    return ScanUncertainty(root_sum(shares, places), acting, skin_and_scale, places)


def mass_pm_g(
    surface: Patches, fit: ScanFit, mass_g: float, density_g_mm3: float, accuracy_mm: float | None
) -> float:
    """Return within what 95 % of the masses lie that noise, skin and scale make of one crank [g]."""
    acting = np.array([density_g_mm3 * float(surface.area.sum()), 3.0 * mass_g])
    even = float(acting @ _open(surface, fit, accuracy_mm) @ acting)
    return math.hypot(ONE_AXIS_SIGMAS_95 * math.sqrt(even), mass_noise_g(surface, fit, density_g_mm3))


def mass_noise_g(surface: Patches, fit: ScanFit, density_g_mm3: float) -> float:
    """Return within what 95 % of the masses are that noise alone makes of one crank [g]."""
    known = surface.mass_noise.get((fit, density_g_mm3))
    if known is None:
        (mass,) = _noise_covariances(surface, fit, np.full((1, len(surface.area)), density_g_mm3))
        known = surface.mass_noise[fit, density_g_mm3] = float(mass[0, 0])
    return ONE_AXIS_SIGMAS_95 * math.sqrt(max(known, 0.0))


def _open(surface: Patches, fit: ScanFit, accuracy_mm: float | None) -> Array:
    """Return the covariance (2, 2) of skin and scale; the roughness replaces a missing accuracy."""
    return systematic(fit.roughness_mm if accuracy_mm is None else accuracy_mm, surface.diagonal_mm)


def systematic(accuracy_mm: float, diagonal_mm: float) -> Array:
    """Return the covariance (2, 2) of skin [mm] and scale that a scanner's accuracy (95 %) leaves open."""
    return np.diag(
        [(accuracy_mm / ONE_AXIS_SIGMAS_95) ** 2, (accuracy_mm / diagonal_mm / ONE_AXIS_SIGMAS_95) ** 2]
    )


def _levers(surface: Patches, places: Places) -> Array:
    """Return the effect of a unit of metal at each patch on resultant and planes (2 [+ 4], p)."""
    x, y, z = surface.middle.T
    rows = [x, y]
    if places is not None:
        upper = (z - places[0]) / (places[1] - places[0])
        rows += [(1.0 - upper) * x, (1.0 - upper) * y, upper * x, upper * y]
    return np.stack(rows)


AT_ONCE = 128
"""Rows of the table of distances that are made at a time: they fit the processor's cache."""


def _noise_covariances(surface: Patches, fit: ScanFit, *levers: Array) -> list[Array]:
    """Return for each table of levers (k, p) the covariance of what noise does to their sums (k, k)."""
    from scipy.spatial.distance import cdist  # not before: drawn cranks need no SciPy here

    acting = [each * surface.area for each in levers]
    kernels = [(kernel, deviation) for kernel, deviation in fit.noise if deviation > 0.0]
    covariances = [np.zeros((len(each), len(each))) for each in levers]
    for first in range(0, len(surface.area), AT_ONCE):  # each pair once: the other half is the transpose
        rows = slice(first, first + AT_ONCE)
        squared = cdist(surface.middle[rows], surface.middle[first:], "sqeuclidean")
        own = np.arange(len(squared))
        for kernel, deviation in kernels:
            alike = kernel.likeness(squared)
            alike[own, own] = kernel.share_of_mean(surface.area[rows])
            alike[:, : len(own)] *= 0.5  # pairs of these rows stand there twice
            for covariance, each in zip(covariances, acting, strict=True):
                half = deviation**2 * (each[:, rows] @ alike @ each[:, first:].T)
                np.add(covariance, half + half.T, out=covariance)
    return covariances


def _lengths(covariance: Array, first: int) -> float:
    """Return within what 95 % of a vector are whose components have two of the rows."""
    block = covariance[first : first + 2, first : first + 2]
    return TWO_AXES_SIGMAS_95 * math.sqrt(max(float(np.linalg.eigvalsh(block)[-1]), 0.0))


def _of_axis(crank: Moments, fit: ScanFit, places: Places) -> Share:
    """Return the effect of the axis' standard errors: everything lies off it by as much."""
    offset, slope = (
        TWO_AXES_SIGMAS_95 * fit.axis_offset_mm,
        TWO_AXES_SIGMAS_95 * math.radians(fit.axis_angle_deg),
    )
    z0, first, second = fit.axis_middle_mm, float(crank.first_g_mm[2]), float(crank.second_g_mm2[2, 2])
    lever = first - z0 * crank.mass_g
    resultant = math.hypot(offset * crank.mass_g, slope * lever)
    if places is None:
        return Share(resultant)
    span = places[1] - places[0]
    planes = []
    for far, sign in ((places[1], -1.0), (places[0], 1.0)):
        carried = sign * (first - far * crank.mass_g) / span
        tilted = sign * (second - (far + z0) * first + far * z0 * crank.mass_g) / span
        planes.append(math.hypot(offset * carried, slope * tilted))
    return Share(resultant, tuple(planes))
