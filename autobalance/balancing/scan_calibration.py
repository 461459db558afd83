"""Skin and scale of a scan, from what a scale and a micrometer say of the same crank.

A scan is the crank times ``scale``, with ``skin_mm`` of metal on it that is missing. Mass and diameters are
linear in both, and in how much more metal the scan's facets hide than was estimated: weighted least squares
gives all three. What is known of them before anything is measured are three more observations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from functools import cached_property
from typing import Annotated

import numpy as np

from autobalance.balancing.scan_uncertainty import ONE_AXIS_SIGMAS_95, Patches, mass_noise_g, systematic
from autobalance.crank.anatomy import Anatomy, Pin
from autobalance.declare import KG_M3, UNWRITTEN, NotNegative, Positive
from autobalance.errors import JobError
from autobalance.job.model import Calibrate, CrankReadings
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.value_classes import dataclass

OPEN_SKIN_MM, OPEN_SCALE = 0.5, 2e-3
"""Uncertainty left by a scanner of unknown accuracy, 95 %: sprayed powder, no calibration."""
SAME_DIAMETER = 0.02
"""A micrometer reading is of the journals whose diameters differ from it by less than this share."""
CONTRADICTION_SIGMAS = 3.0
"""Readings that differ by more than so many standard deviations contradict each other."""
LEAST_SIGMA = 1e-6
"""Smallest uncertainty of readings that claim to be exact, in mm or g."""
ODD_MASS = 0.01
"""Share below which masses of a scanner of unknown accuracy do not differ."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Calibration of a scan by scale and micrometer; "none" where neither was used.

    Half-widths (``pm``) are of 95 %. ``mass_pm_g`` is that of the mass as calibrated, ``covariance`` (2, 2)
    that of skin [mm] and scale, ``added`` what the calibration adds to the moments measured at
    ``density_g_mm3``, rotor frame.
    """

    by: Calibrate
    skin_mm: Annotated[float, "how far the scanned surface lies outside the crank's"]
    skin_pm_mm: NotNegative
    scale: Annotated[Positive, "of the scan: its lengths over the crank's"]
    scale_pm: NotNegative
    density_g_mm3: Annotated[Positive, KG_M3]
    mass_difference_g: Annotated[float | None, "of the scan as it came less the scale's; null: not weighed"]
    mass_pm_g: Annotated[float, UNWRITTEN]
    covariance: Annotated[Array, UNWRITTEN]
    added: Annotated[Moments, UNWRITTEN] = field(default_factory=Moments.zero)
    contradictions: Sequence[str] = ()


@dataclass(frozen=True, eq=False)
class Scanned:
    """A measured crank whose readings are looked at.

    ``moments`` are in the rotor frame, ``facets`` what its triangles hide and moments do not have yet (None:
    nothing). ``accuracy_mm`` is the scanner's, ``density_pm`` the share by which the density may be off.
    """

    mesh: Mesh
    anatomy: Anatomy
    density_g_mm3: float
    moments: Moments
    facets: ChordalError | None
    accuracy_mm: float | None = None
    density_pm: float = 0.0

    @property
    def whole(self) -> Moments:
        """Moments with what the facets hide."""
        return self.moments + self.missing

    @property
    def missing(self) -> Moments:
        """Moments of the metal that the facets hide."""
        return Moments.zero() if self.facets is None else self.facets.missing

    @cached_property
    def noise_pm_g(self) -> float:
        """Uncertainty of the mass by noise (95 %) [g]."""
        scan = self.anatomy.scan
        return 0.0 if scan is None else mass_noise_g(Patches.of(self.mesh), scan, self.density_g_mm3)

    @property
    def mass_pm_g(self) -> float:
        """Uncertainty of the mass by noise and facets (95 %) [g]."""
        return math.hypot(self.noise_pm_g, 0.0 if self.facets is None else self.facets.mass_bar_g)

    @property
    def open(self) -> Array:
        """Covariance (3, 3) of skin, scale and the facets' share before anything is measured."""
        covariance = np.diag(
            [(OPEN_SKIN_MM / ONE_AXIS_SIGMAS_95) ** 2, (OPEN_SCALE / ONE_AXIS_SIGMAS_95) ** 2, 1.0]
        )
        if self.accuracy_mm is not None:
            covariance[:2, :2] = systematic(self.accuracy_mm, self.mesh.diagonal_mm)
        if self.facets is not None and self.facets.missing.mass_g != 0.0:
            covariance[2, 2] = (self.facets.mass_bar_g / self.facets.missing.mass_g / ONE_AXIS_SIGMAS_95) ** 2
        return covariance


@dataclass(frozen=True, eq=False)
class _Observation:
    """``off`` = ``row`` · (skin, scale − 1, share by which the facets hide more), give or take ``sigma``."""

    name: str
    row: tuple[float, float, float]
    off: float
    sigma: float


def calibration_of(crank: Scanned, readings: CrankReadings) -> Calibration | None:
    """Return the calibration of a scan by readings of the crank; None if nothing was measured.

    Raises
    ------
    JobError
        If a diameter was measured that no journal has.
    """
    if not readings.any:
        return None
    skin = _skin(crank)
    seen = [*_diameters(crank, readings)]
    weighed = readings.weighed_g
    whole, missing = crank.whole, crank.missing
    if weighed is not None and readings.calibrate != "density":
        sigma = max(math.hypot(readings.weighed_pm_g, crank.noise_pm_g) / ONE_AXIS_SIGMAS_95, LEAST_SIGMA)
        row = (skin.mass_g, 3.0 * whole.mass_g, -missing.mass_g)
        seen.append(_Observation("mass", row, whole.mass_g - weighed, sigma))
    values, covariance = _solved(crank, seen)
    off = _moved(whole, skin, values)
    density, added = crank.density_g_mm3, Moments.zero()
    if readings.calibrate != "none":
        added = missing.scaled(1.0 + float(values[2])) - off
    if readings.calibrate == "density" and weighed is not None:
        share = weighed / (crank.moments.mass_g + added.mass_g)
        density, added = share * density, added.scaled(share)
    covariance = covariance[:2, :2]
    pm = ONE_AXIS_SIGMAS_95 * np.sqrt(np.diag(covariance))
    difference = None if weighed is None else whole.mass_g - weighed
    odd = [*_odd_diameters(seen, values), *_odd_mass(crank, readings, skin)]
    return Calibration(
        readings.calibrate,
        float(values[0]),
        float(pm[0]),
        1.0 + float(values[1]),
        float(pm[1]),
        density,
        difference,
        _mass_pm_g(crank, readings, skin),
        covariance,
        added,
        tuple(odd),
    )


def _mass_pm_g(crank: Scanned, readings: CrankReadings, skin: Moments) -> float:
    """Return the half-width (95 %) of the mass as calibrated.

    What a scale reads corrects the share ``k`` of what skin, scale and facets leave open.
    """
    if readings.calibrate == "density" and readings.weighed_g is not None:
        return readings.weighed_pm_g
    row = np.array([skin.mass_g, 3.0 * crank.whole.mass_g, -crank.missing.mass_g])
    _, covariance = _solved(crank, _diameters(crank, readings))
    of_scan, noise = float(row @ covariance @ row), (crank.noise_pm_g / ONE_AXIS_SIGMAS_95) ** 2
    if readings.weighed_g is None:
        return ONE_AXIS_SIGMAS_95 * math.sqrt(of_scan + noise)
    weighed = (readings.weighed_pm_g / ONE_AXIS_SIGMAS_95) ** 2
    denser = (crank.density_pm * crank.moments.mass_g / ONE_AXIS_SIGMAS_95) ** 2
    k = of_scan / max(of_scan + noise + weighed, LEAST_SIGMA**2)
    return ONE_AXIS_SIGMAS_95 * math.sqrt((1.0 - k) ** 2 * (of_scan + noise + denser) + k**2 * weighed)


def _skin(crank: Scanned) -> Moments:
    """Return the moments of a millimetre of metal all over the surface, rotor frame [per mm]."""
    placed = crank.mesh.moved(crank.anatomy.file_to_rotor)
    mass = 0.5 * crank.density_g_mm3 * placed.doubled_areas
    corners = placed.corners
    middle = corners.mean(axis=1)
    ends = np.einsum("m,mki,mkj->ij", mass, corners, corners) / 12.0
    second = ends + 0.75 * (middle * mass[:, None]).T @ middle
    return Moments(float(mass.sum()), mass @ middle, second)


def _diameters(crank: Scanned, readings: CrankReadings) -> list[_Observation]:
    pins: dict[str, Sequence[Pin]] = {
        "main_journal": crank.anatomy.main_journals,
        "crankpin": [throw.crankpin for throw in crank.anatomy.throws],
    }
    scan = crank.anatomy.scan
    sure = {} if scan is None else {"main_journal": scan.journals, "crankpin": scan.crankpins}
    observations = []
    for name, size in readings.micrometer_mm.items():
        alike = [
            number
            for number, pin in enumerate(pins[name])
            if abs(pin.diameter_mm - size) < SAME_DIAMETER * size
        ]
        if not alike:
            there = ", ".join(f"{pin.diameter_mm:.4g}" for pin in pins[name])
            raise JobError(
                f"crankshaft.micrometer_mm.{name} is {size:g}; found diameters of {there or 'none'} mm; "
                "expected one of them to within 2 %"
            )
        mean = float(np.mean([pins[name][number].diameter_mm for number in alike]))
        of_fit = math.hypot(*(sure[name][number].diameter_pm_mm for number in alike)) if sure else 0.0
        sigma = math.hypot(readings.micrometer_pm_mm / ONE_AXIS_SIGMAS_95, of_fit / len(alike))
        observations.append(_Observation(name, (2.0, mean, 0.0), mean - size, max(sigma, LEAST_SIGMA)))
    return observations


def _solved(crank: Scanned, seen: Sequence[_Observation]) -> tuple[Array, Array]:
    """Return the three unknowns and their covariance, with the uncertainty of the density in it."""
    rows = np.array([each.row for each in seen]).reshape(-1, 3)
    weights = np.array([each.sigma for each in seen]) ** -2.0
    covariance = np.linalg.inv(np.linalg.inv(crank.open) + rows.T @ (rows * weights[:, None]))
    gain = covariance @ rows.T * weights
    values = gain @ np.array([each.off for each in seen])
    for number, each in enumerate(seen):
        if each.name == "mass":
            heavier = crank.density_pm * crank.moments.mass_g / ONE_AXIS_SIGMAS_95
            covariance = covariance + heavier**2 * np.outer(gain[:, number], gain[:, number])
    return np.asarray(values), np.asarray(covariance)


def _moved(body: Moments, skin: Moments, values: Array) -> Moments:
    """Return the change of a body's moments by skin and scale."""
    by = float(values[1])
    stretched = Moments(3.0 * by * body.mass_g, 4.0 * by * body.first_g_mm, 5.0 * by * body.second_g_mm2)
    return skin.scaled(float(values[0])) + stretched


def _odd_diameters(seen: Sequence[_Observation], values: Array) -> list[str]:
    lines = []
    for each in seen:
        left = each.off - float(np.dot(each.row, values))
        if each.name != "mass" and abs(left) > CONTRADICTION_SIGMAS * each.sigma + 1e-3:
            larger = "larger" if left > 0.0 else "smaller"
            lines.append(
                f"the scan's {each.name.replace('_', ' ')} is {abs(left):.3f} mm {larger} than by micrometer,"
                " beyond an even skin and a scale: another place, wear, or another crank"
            )
    return lines


def _odd_mass(crank: Scanned, readings: CrankReadings, skin: Moments) -> list[str]:
    """Say of a mass that differs by more than scanner, scale and density may be off."""
    if readings.weighed_g is None:
        return []
    whole = crank.whole.mass_g
    even = np.array([skin.mass_g, 3.0 * whole, 0.0])
    left = whole - readings.weighed_g
    known = bool(readings.micrometer_mm) and readings.calibrate != "density"
    if known:  # diameters say what skin and scale are: no mass is to be made up by more
        alone, open_yet = _solved(crank, _diameters(crank, readings))
        left -= float(even @ alone)
    else:
        open_yet = crank.open
    limit = math.hypot(
        ONE_AXIS_SIGMAS_95 * math.sqrt(float(even @ open_yet @ even)),
        readings.weighed_pm_g,
        crank.mass_pm_g,
        crank.density_pm * whole,
    )
    if crank.accuracy_mm is None and not known:
        limit = ODD_MASS * whole
    if abs(left) <= limit:
        return []
    heavier = "heavier" if left > 0.0 else "lighter"
    unseen = "a bore that the scanner did not see" if left > 0.0 else "a bore that was closed too deep"
    return [
        f"the scan is {100.0 * abs(left) / readings.weighed_g:.2g} % {heavier} than on the scale:"
        f" {unseen}, another density, or another crank"
    ]
