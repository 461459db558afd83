"""Description of a rotor on bearings: shaft sections, discs, supports, unbalances. SI units."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import G_MM, KG_MM2_OF_SI, MM, NOT_NEGATIVE, Degrees, Named
from autobalance.types import Array
from autobalance.units import STEEL_KG_M3
from autobalance.value_classes import dataclass

BeamTheory = Literal["timoshenko", "euler"]
Constraint = Literal["pinned", "clamped"]
Place = Annotated[float, MM, "place on the shaft, from its start"]


@dataclass(frozen=True)
class ShaftSection:
    """A cylinder or cone, solid or hollow; diameters run linearly from start to end.

    ``shear_factor`` 0 stands for Cowper's; ``elements`` 0 for the number that the accuracy needs.
    """

    length_m: float
    outer_start_m: float
    outer_end_m: float
    inner_start_m: float = 0.0
    inner_end_m: float = 0.0
    youngs_modulus_pa: float = 210e9
    shear_modulus_pa: float = 210e9 / 2.6
    density_kg_m3: float = STEEL_KG_M3
    shear_factor: float = 0.0
    elements: int = 0

    def diameters_m(self, share: Array) -> tuple[Array, Array]:
        """Return the outer and inner diameter at shares 0 to 1 of the length."""
        outer = self.outer_start_m + (self.outer_end_m - self.outer_start_m) * share
        inner = self.inner_start_m + (self.inner_end_m - self.inner_start_m) * share
        return outer, inner

    @property
    def poissons_ratio(self) -> float:
        """Poisson's ratio of an isotropic material with these moduli."""
        return self.youngs_modulus_pa / (2.0 * self.shear_modulus_pa) - 1.0


@dataclass(frozen=True)
class Disc:
    """A rigid disc at one place of the shaft."""

    z_m: Place
    mass_kg: Annotated[float, NOT_NEGATIVE, "mass"]
    polar_kg_m2: Annotated[float, KG_MM2_OF_SI, NOT_NEGATIVE, "moment of inertia about the shaft"] = 0.0
    diametral_kg_m2: Annotated[float, KG_MM2_OF_SI, NOT_NEGATIVE, "moment of inertia about a diameter"] = 0.0


@dataclass(frozen=True, eq=False)
class Bearing:
    """A support: rigid (``constraint``), or linear springs and dampers.

    ``stiffness_n_m`` and ``damping_n_s_m`` are (k, 2, 2), ``[[xx, xy], [yx, yy]]`` at each of
    ``speeds_rad_s`` (k,): the force on the shaft is −K (x, y) − C (ẋ, ẏ). They are linear between
    speeds and constant beyond the table.
    """

    z_m: float
    constraint: Constraint | None
    speeds_rad_s: Array
    stiffness_n_m: Array
    damping_n_s_m: Array

    @property
    def constant(self) -> bool:
        """Whether the coefficients are independent of the speed."""
        return len(self.speeds_rad_s) < 2

    def stiffness_at(self, speed_rad_s: float) -> Array:
        """Return the stiffness (2, 2) at a speed [N/m]."""
        return self._at(self.stiffness_n_m, speed_rad_s)

    def damping_at(self, speed_rad_s: float) -> Array:
        """Return the damping (2, 2) at a speed [N s/m]."""
        return self._at(self.damping_n_s_m, speed_rad_s)

    def _at(self, table: Array, speed_rad_s: float) -> Array:
        if self.constant:
            return np.asarray(table[0])
        flat = table.reshape(len(table), 4)
        return np.array([np.interp(speed_rad_s, self.speeds_rad_s, each) for each in flat.T]).reshape(2, 2)


def rigid_bearing(z_m: float, constraint: Constraint) -> Bearing:
    none = np.zeros((1, 2, 2))
    return Bearing(z_m, constraint, np.zeros(1), none, none)


def spring_bearing(z_m: float, stiffness_n_m: Array) -> Bearing:
    """Return a support of constant stiffness (2, 2) without damping."""
    return Bearing(z_m, None, np.zeros(1), np.array([stiffness_n_m]), np.zeros((1, 2, 2)))


@dataclass(frozen=True)
class PointUnbalance:
    """A point unbalance: mass × distance from the axis, at an angle of the rotor frame."""

    z_m: Place
    unbalance_kg_m: Annotated[float, G_MM, Named("g_mm"), "mass times distance from the axis"]
    angle_rad: Annotated[Degrees, "angle in the rotor frame"] = 0.0

    @property
    def phasor_kg_m(self) -> complex:
        """The unbalance as a complex number: x real, y imaginary."""
        return complex(self.unbalance_kg_m * np.exp(1j * self.angle_rad))


@dataclass(frozen=True)
class BeamRotor:
    """A shaft from z = 0 with its discs, bearings and unbalances.

    ``beam`` "euler" omits rotary inertia, shear and gyroscopic moments of the shaft; those of discs stay.
    """

    sections: tuple[ShaftSection, ...]
    discs: tuple[Disc, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    unbalances: tuple[PointUnbalance, ...] = ()
    beam: BeamTheory = "timoshenko"
    gravity_m_s2: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def length_m(self) -> float:
        """Length of the whole shaft."""
        return float(self.section_ends_m[-1])

    @cached_property
    def section_ends_m(self) -> Array:
        """Positions of the ends of the sections (n + 1,)."""
        return np.concatenate([[0.0], np.cumsum([each.length_m for each in self.sections])])

    @property
    def constant_bearings(self) -> bool:
        """Whether all bearings are independent of the speed."""
        return all(each.constant for each in self.bearings)

    def mass_and_moment(self) -> tuple[float, float]:
        """Return the mass [kg] and ∫ z dm [kg m] of shaft and discs, exact for cones."""
        points, weights = np.polynomial.legendre.leggauss(4)
        share, weights = 0.5 * (points + 1.0), 0.5 * weights
        mass = moment = 0.0
        for start, section in zip(self.section_ends_m, self.sections, strict=False):
            outer, inner = section.diameters_m(share)
            line = section.density_kg_m3 * np.pi / 4.0 * (outer**2 - inner**2) * section.length_m * weights
            mass += float(line.sum())
            moment += float(line @ (start + share * section.length_m))
        for disc in self.discs:
            mass += disc.mass_kg
            moment += disc.mass_kg * disc.z_m
        return mass, moment


def cowper_shear_factor(poissons_ratio: float, inner_over_outer: Array) -> Array:
    """Return Cowper's shear factor of a round or hollow round section.

    κ = 6(1+ν)(1+m²)² / ((7+6ν)(1+m²)² + (20+12ν)m²), m the inner over the outer diameter [1]_.

    References
    ----------
    .. [1] G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966) 335.

    Examples
    --------
    >>> round(float(cowper_shear_factor(0.3, np.zeros(1))[0]), 6)
    0.886364
    """
    nu, square = poissons_ratio, inner_over_outer**2
    both = (1.0 + square) ** 2
    return np.asarray(6.0 * (1.0 + nu) * both / ((7.0 + 6.0 * nu) * both + (20.0 + 12.0 * nu) * square))
