"""A connecting rod measured in its solid: eyes, mass, end weights, inertia, and their uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from autobalance.crank.recognition.rod_eyes import RodEyes, find_eyes
from autobalance.errors import RecognitionError
from autobalance.rigid_rotor.moments import Moments
from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.chordal_error.of_mesh import chordal_error_of_mesh
from autobalance.solid.formats.read import Source
from autobalance.solid.slicing.slab import Slab
from autobalance.units import N_M_PER_G_MM2_S2

TURN_RAD = np.radians(np.arange(0.0, 360.0, 0.25))

X_TO_Z = np.array([[0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""Takes a rod's x, which runs along it, to z."""
ROUNDING = 1e-7
"""Corners this near to a cut, as a share of the rod's diagonal, lie on it."""


@dataclass(frozen=True)
class RodUncertainty:
    """Uncertainty of a rod's masses from its facets and its density [g]."""

    mass_g: float
    big_end_g: float
    small_end_g: float


@dataclass(frozen=True, eq=False)
class MeasuredRod:
    """A connecting rod's solid, recognised and measured.

    Attributes
    ----------
    source : Source
    eyes : RodEyes
    density_g_mm3, density_pm_g_mm3 : float
        Density and its uncertainty.
    moments : Moments
        In the rod's axes (origin in the big end, x to the small end, z along the eyes); what the facets hide
        of round surfaces is added.
    facets : ChordalError
    """

    source: Source
    eyes: RodEyes
    density_g_mm3: float
    density_pm_g_mm3: float
    moments: Moments
    facets: ChordalError

    @cached_property
    def rod(self) -> ConnectingRod:
        """The rod of the lever rule."""
        small = np.array([self.eyes.length_mm, 0.0, 0.0])
        try:
            return ConnectingRod.from_solid(self.moments, np.zeros(3), small)
        except ValueError as error:
            raise RecognitionError(f"no connecting rod: {error}") from None

    @property
    def about_centre(self) -> Moments:
        """Moments about the rod's centre of mass, in the directions of the rod's axes."""
        placement = np.eye(4)
        placement[:3, 3] = -self.moments.centre_mm
        return self.moments.moved(placement)

    def missed_couple(self, stroke_mm: float, speed_rad_s: float) -> tuple[float, float]:
        """Return the largest couple that two masses leave out [N·m], and its crank angle [rad].

        Raises
        ------
        ValueError
            If a rod of this length cannot have that stroke.
        """
        swing = SliderCrank(0.5 * stroke_mm, self.rod.length_mm).motion(TURN_RAD).ddtilt * speed_rad_s**2
        place = int(np.argmax(np.abs(swing)))
        couple = self.rod.couple_inertia_g_mm2 * float(swing[place]) * N_M_PER_G_MM2_S2
        return abs(couple), float(TURN_RAD[place])

    @property
    def volume_mm3(self) -> float:
        """Volume inside the true surfaces [mm³]."""
        return self.moments.mass_g / self.density_g_mm3

    @property
    def uncertainty(self) -> RodUncertainty:
        """Uncertainty from facets and density; no less than either alone.

        The small end weighs ∫ x dm / l, so the bar of the first moment about the big end counts there; that
        and the bar of the mass count at the big end.
        """
        off = self.density_pm_g_mm3 / self.density_g_mm3
        at_small = self.facets.unbalance_bar_g_mm / self.eyes.length_mm
        return RodUncertainty(
            math.hypot(self.facets.mass_bar_g, off * self.rod.mass_g),
            math.hypot(self.facets.mass_bar_g + at_small, off * self.rod.big_end_g),
            math.hypot(at_small, off * self.rod.small_end_g),
        )

    @cached_property
    def cut_halves_g(self) -> tuple[float, float]:
        """Big and small piece of the rod cut at its centre of mass; the lever rule is better [g]."""
        placed = self.source.solid.mesh.moved(X_TO_Z @ self.eyes.file_to_rod)
        slab = Slab(placed.vertices, placed.triangles, ROUNDING * placed.diagonal_mm)
        low, high = float(placed.bounds[0, 2]), float(placed.bounds[1, 2])
        cut = self.rod.centre_from_big_end_mm
        big, small = (slab.moments(part, 1.0).mass_g for part in ((low - 1.0, cut), (cut, high + 1.0)))
        share = small / (big + small)
        mass = self.rod.mass_g
        return (1.0 - share) * mass, share * mass


def measure_rod(source: Source, density_g_mm3: float, density_pm_g_mm3: float = 0.0) -> MeasuredRod:
    """Recognise a connecting rod in a checked solid and measure it.

    Parameters
    ----------
    source : Source
        The solid, as ``solid.formats.read`` gives it.
    density_g_mm3, density_pm_g_mm3 : float
        Density and its uncertainty [g/mm³].

    Raises
    ------
    RecognitionError
        If the solid is not a connecting rod.
    """
    cylinders = () if source.surfaces is None else source.surfaces.cylinders
    eyes = find_eyes(source.solid.mesh, source.moments(1.0).centre_mm, cylinders)
    moments = source.moments(density_g_mm3, eyes.file_to_rod)
    if source.exact is not None:  # measured on the true surfaces
        from autobalance.solid.cad.doubt import doubt_of

        facets = doubt_of(source.exact.gaps, density_g_mm3, eyes.file_to_rod)
    else:
        facets = chordal_error_of_mesh(source.solid.mesh, density_g_mm3, eyes.file_to_rod)
    rod = MeasuredRod(source, eyes, density_g_mm3, density_pm_g_mm3, moments + facets.missing, facets)
    rod.rod  # noqa: B018  refuses a centre of mass beyond the eyes now
    return rod
