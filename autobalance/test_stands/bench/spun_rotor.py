"""A rigid rotor on a balancing machine: mass, centre, inertia, unbalance and its kind.

Vectors across the axis are complex: x + i y, so an angle is an argument and turning is a factor. mm, g, s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from autobalance.types import Array
from autobalance.value_classes import dataclass

UnbalanceKind = Literal["balanced", "static", "couple", "quasi_static", "dynamic"]

ROUNDING_SHARE = 1e-9
"""Share of the sum of the parts' sizes below which the remainder of parts that cancel is rounding."""


@dataclass(frozen=True)
class PlanarUnbalance:
    """An unbalance [g·mm], complex, in a plane at z, without mass."""

    z_mm: float
    unbalance_g_mm: complex


@dataclass(frozen=True)
class PointMass:
    """A mass [g] at a place, x + i y [mm] across the axis."""

    mass_g: float
    offset_mm: complex
    z_mm: float


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rotor without added masses and unbalances.

    ``second_g_mm2`` is ∫ r rᵀ dm about its own centre of mass, (3, 3), None where unknown; instead only
    ``transverse_g_mm2`` about the same point may be known.
    """

    mass_g: float
    z_mm: float
    unbalance_g_mm: complex = 0j
    moment_g_mm2: complex = 0j
    transverse_g_mm2: float | None = None
    second_g_mm2: Array | None = None


def axisymmetric(
    mass_g: float, z_mm: float, transverse_g_mm2: float | None, polar_g_mm2: float | None
) -> RigidBody:
    """Return a balanced rotor from its inertias about its centre of mass, each None where unknown."""
    if transverse_g_mm2 is None or polar_g_mm2 is None:
        return RigidBody(mass_g, z_mm, transverse_g_mm2=transverse_g_mm2)
    across, along = 0.5 * polar_g_mm2, transverse_g_mm2 - 0.5 * polar_g_mm2
    return RigidBody(
        mass_g, z_mm, transverse_g_mm2=transverse_g_mm2, second_g_mm2=np.diag([across, across, along])
    )


@dataclass(frozen=True, eq=False)
class SpunRotor:
    """A rotor with all its masses and unbalances.

    ``unbalance_g_mm`` is ∫ (x + i y) dm, ``moment_g_mm2`` ∫ z (x + i y) dm about the rotor's z = 0.
    ``transverse_g_mm2`` and ``second_g_mm2`` (∫ r rᵀ dm) are about the centre of mass. ``size_g_mm`` and
    ``lever_mm`` are the scales of its parts, for rounding.
    """

    mass_g: float
    z_mm: float
    unbalance_g_mm: complex
    moment_g_mm2: complex
    transverse_g_mm2: float | None
    second_g_mm2: Array | None
    size_g_mm: float
    lever_mm: float

    @property
    def couple_g_mm2(self) -> complex:
        """Return the moment of the unbalance about the plane of the centre of mass."""
        return self.moment_g_mm2 - self.z_mm * self.unbalance_g_mm

    def in_planes(self, z_A: float, z_B: float) -> tuple[complex, complex]:
        """Return the equivalent unbalances in two planes: (z_B U − P)/(z_B − z_A) and the rest of U."""
        in_A = (z_B * self.unbalance_g_mm - self.moment_g_mm2) / (z_B - z_A)
        return in_A, self.unbalance_g_mm - in_A

    @property
    def kind(self) -> UnbalanceKind:
        """Return the kind of unbalance by ISO 21940-1."""
        resultant, couple = self.unbalance_g_mm, self.couple_g_mm2
        no_resultant = abs(resultant) <= ROUNDING_SHARE * self.size_g_mm
        no_couple = abs(couple) <= ROUNDING_SHARE * self.size_g_mm * self.lever_mm
        if no_couple:
            return "balanced" if no_resultant else "static"
        if no_resultant:
            return "couple"
        across = abs((couple * resultant.conjugate()).imag) / abs(resultant)
        in_line = across <= ROUNDING_SHARE * self.size_g_mm * self.lever_mm
        return "quasi_static" if in_line else "dynamic"

    @property
    def principal_axis_rad(self) -> float | None:
        """Return the tilt of the principal axis of inertia nearest to z; None if inertia is unknown.

        The principal axes are the eigenvectors of ∫ r rᵀ dm about the centre of mass.
        """
        if self.second_g_mm2 is None:
            return None
        _, axes = np.linalg.eigh(self.second_g_mm2)
        nearest = axes[:, int(np.argmax(np.abs(axes[2])))]
        return float(math.atan2(math.hypot(nearest[0], nearest[1]), abs(nearest[2])))


def spun_rotor(
    body: RigidBody, unbalances: Sequence[PlanarUnbalance], masses: Sequence[PointMass]
) -> SpunRotor:
    """Return a rotor with unbalances and point masses on it.

    Parameters
    ----------
    body : RigidBody
    unbalances : sequence of PlanarUnbalance
    masses : sequence of PointMass

    Raises
    ------
    ValueError
        If the total mass is not positive.

    Examples
    --------
    Two equal masses opposite each other, in two planes, are a couple:

    >>> pair = [PointMass(1.0, 10.0, -20.0), PointMass(1.0, -10.0, 20.0)]
    >>> rotor = spun_rotor(RigidBody(100.0, 0.0), [], pair)
    >>> rotor.kind, rotor.moment_g_mm2
    ('couple', (-400+0j))
    """
    mass = body.mass_g + sum(each.mass_g for each in masses)
    if not mass > 0.0:
        raise ValueError(f"the rotor's mass is {mass:g} g; must be > 0")
    centre = (body.mass_g * body.z_mm + sum(each.mass_g * each.z_mm for each in masses)) / mass
    parts = [(each.z_mm, each.unbalance_g_mm) for each in unbalances]
    parts += [(each.z_mm, each.mass_g * each.offset_mm) for each in masses]
    unbalance = body.unbalance_g_mm + sum(u for _, u in parts)
    moment = body.moment_g_mm2 + sum(z * u for z, u in parts)
    own = body.moment_g_mm2 - body.z_mm * body.unbalance_g_mm
    levers = [abs(z - centre) for z, u in parts if u] + [abs(body.z_mm - centre), 1.0]
    return SpunRotor(
        mass,
        centre,
        complex(unbalance),
        complex(moment),
        _transverse(body, masses, centre),
        _second(body, masses, centre, complex(unbalance), complex(moment), mass),
        abs(body.unbalance_g_mm) + sum(abs(u) for _, u in parts) + abs(own) / max(levers),
        max(levers),
    )


def _transverse(body: RigidBody, masses: Sequence[PointMass], centre: float) -> float | None:
    """Return the mean inertia about transverse lines through the centre of mass, None where unknown."""
    if body.transverse_g_mm2 is None:
        return None
    on_top = sum(
        each.mass_g * ((each.z_mm - centre) ** 2 + 0.5 * abs(each.offset_mm) ** 2) for each in masses
    )
    return body.transverse_g_mm2 + body.mass_g * (body.z_mm - centre) ** 2 + on_top


def _second(
    body: RigidBody,
    masses: Sequence[PointMass],
    centre: float,
    unbalance: complex,
    moment: complex,
    mass: float,
) -> Array | None:
    if body.second_g_mm2 is None:
        return None
    second = body.second_g_mm2.copy()
    second[2, 2] += body.mass_g * (body.z_mm - centre) ** 2
    for each in masses:
        at = np.array([each.offset_mm.real, each.offset_mm.imag, each.z_mm - centre])
        second += each.mass_g * np.outer(at, at)
    aside = np.array([unbalance.real, unbalance.imag]) / mass
    second[:2, :2] -= mass * np.outer(aside, aside)
    couple = moment - centre * unbalance
    second[0, 2] = second[2, 0] = couple.real
    second[1, 2] = second[2, 1] = couple.imag
    return second
