"""Readings of balancing machines and of the static stand on a rigid rotor, and the depth to drill."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from autobalance.declare import (
    DEGREES,
    KG_M3,
    NOT_NEGATIVE,
    PERCENT,
    POSITIVE,
    Degrees,
    Named,
    NotNegative,
    Range,
)
from autobalance.test_stands.bench.spun_rotor import SpunRotor
from autobalance.units import G_PER_MM3_PER_KG_M3, STEEL_KG_M3
from autobalance.value_classes import dataclass

# Readings of balancing machines on a rigid rotor: hard and soft bearings, cradle, nodal points.
#
# Forces [g·mm/s²], displacements [mm] and moments [g·mm²/s²] are complex amplitudes x + i y that turn with
# the rotor; the argument is their angle in the rotor frame.


def support_forces(
    rotor: SpunRotor, bearings_mm: tuple[float, float], speed_rad_s: float
) -> tuple[complex, complex]:
    """Return the forces on two rigid supports: ω² (z_2 U − P)/(z_2 − z_1), and the rest of ω² U."""
    first, second = rotor.in_planes(*bearings_mm)
    return speed_rad_s**2 * first, speed_rad_s**2 * second


def cradle_moments(
    rotor: SpunRotor, pivots_mm: tuple[float, float], speed_rad_s: float
) -> tuple[complex, complex]:
    """Return the moments about two pivots used in turn: ω² (P − z U).

    An unbalance in the plane of the pivot has no lever and no reading.
    """
    first, second = (rotor.moment_g_mm2 - z * rotor.unbalance_g_mm for z in pivots_mm)
    return speed_rad_s**2 * first, speed_rad_s**2 * second


def free_displacement(rotor: SpunRotor, z_mm: float) -> complex:
    """Return the displacement of a free rotor at a place of its axis, the same at any speed.

    x(z) = −U/m − (z − z_G)(P − z_G U)/I_t. Needs the transverse inertia.
    """
    assert rotor.transverse_g_mm2 is not None
    shift = rotor.unbalance_g_mm / rotor.mass_g
    return -shift - (z_mm - rotor.z_mm) * rotor.couple_g_mm2 / rotor.transverse_g_mm2


def sprung_displacements(
    rotor: SpunRotor, bearings_mm: tuple[float, float], stiffness_g_s2: float, speed_rad_s: float
) -> tuple[complex, complex]:
    """Return the displacements at two equal springs in the plane of motion, without damping.

    (K − ω² M) q = ω² (U, P − z_G U) with q = (displacement of the centre of mass, tilt); without stiffness
    this is ``free_displacement``.

    Raises
    ------
    ValueError
        If the speed is a natural frequency of the rotor on its springs.
    """
    assert rotor.transverse_g_mm2 is not None
    levers = np.array(bearings_mm) - rotor.z_mm
    rows = np.stack([np.ones(2), levers], axis=1)
    stiffness = stiffness_g_s2 * rows.T @ rows
    inertia = speed_rad_s**2 * np.diag([rotor.mass_g, rotor.transverse_g_mm2])
    scale = np.sqrt(np.outer(np.diag(inertia), np.diag(inertia)))
    system = (stiffness - inertia) / scale
    load = speed_rad_s**2 * np.array([rotor.unbalance_g_mm, rotor.couple_g_mm2])
    if np.linalg.cond(system) > 1e9:
        raise ValueError("the speed is a natural frequency of the rotor on its supports")
    root = np.sqrt(np.diag(inertia))
    motion = np.linalg.solve(system, load / root) / root
    first, second = (complex(each) for each in rows @ motion)
    return first, second


def node_mm(rotor: SpunRotor, plane_mm: float) -> float:
    """Return the z of a free rotor's node under an unbalance in one plane: z_G − I_t/(m (z − z_G)).

    Raises
    ------
    ValueError If the plane goes through the centre of mass: all of the axis moves by the same amount.
    """
    assert rotor.transverse_g_mm2 is not None
    lever = plane_mm - rotor.z_mm
    if abs(lever) < 1e-9:
        raise ValueError("the plane goes through the centre of mass; an unbalance in it has no node")
    return rotor.z_mm - rotor.transverse_g_mm2 / (rotor.mass_g * lever)


@dataclass(frozen=True)
class ReadingNoise:
    """Standard deviations of a machine's readings in a plane."""

    unbalance_g_mm: Annotated[
        float, NOT_NEGATIVE, Named("g_mm"), "standard deviation of x and of y of each plane's reading"
    ] = 0.0
    gain: Annotated[float, PERCENT, NOT_NEGATIVE, "error of the reading's size"] = 0.0
    angle_rad: Annotated[float, DEGREES, NOT_NEGATIVE, "error of the reading's angle"] = 0.0


def noisy_readings(
    planes: tuple[complex, ...], noise: ReadingNoise, runs: int, seed: int
) -> list[tuple[complex, ...]]:
    """Return the readings of a machine with errors in each run: (1 + gain) U e^(i angle) + (x + i y).

    Errors are drawn again from normal distributions for each plane and each run.
    """
    draws = np.random.default_rng(seed).standard_normal((runs, len(planes), 4))
    gain, angle = noise.gain * draws[:, :, 0], noise.angle_rad * draws[:, :, 1]
    aside = noise.unbalance_g_mm * (draws[:, :, 2] + 1j * draws[:, :, 3])
    read = np.array(planes) * (1.0 + gain) * np.exp(1j * angle) + aside
    return [tuple(each) for each in read.tolist()]


# The static stand: a rotor on level rails or rollers rolls until its heavy side is down. mm, g, s.


STANDARD_GRAVITY_MM_S2 = 9806.65


@dataclass(frozen=True)
class StaticStand:
    """Behaviour of a rotor on the stand; None where it does not move, or does not get there."""

    rolls: bool
    least_g_mm: NotNegative
    rest_within_rad: Degrees | None
    roll_time_s: NotNegative | None


def static_stand(
    unbalance_g_mm: float,
    mass_g: float,
    friction_lever_mm: float,
    journal_radius_mm: float,
    start_rad: float,
    polar_g_mm2: float | None,
) -> StaticStand:
    """Return whether a rotor rolls on the stand, the tolerance of its rest, and the time to it.

    It rolls when |U| > m f, and rests within asin(m f/|U|) about heavy side down.

    Parameters
    ----------
    unbalance_g_mm : float
        Size of the resultant.
    mass_g : float
        Of the rotor.
    friction_lever_mm : float
        Lever f of rolling friction: a moment m g f opposes the motion.
    journal_radius_mm : float
        Radius of the rolling journals.
    start_rad : float
        Angle of the heavy side to straight down at the release.
    polar_g_mm2 : float or None
        Inertia about the axis; None where unknown.
    """
    least = mass_g * friction_lever_mm
    if not unbalance_g_mm > least:
        return StaticStand(False, least, None, None)
    inertia = None if polar_g_mm2 is None else polar_g_mm2 + mass_g * journal_radius_mm**2
    time_s = None if inertia is None else roll_time_s(unbalance_g_mm, least, inertia, start_rad)
    return StaticStand(True, least, math.asin(least / unbalance_g_mm), time_s)


def roll_time_s(
    unbalance_g_mm: float, least_g_mm: float, inertia_g_mm2: float, start_rad: float
) -> float | None:
    """Return the time from rest at an angle to heavy side down: I θ̈ = −U g sin θ + m f g while θ falls.

    By energy ½ I θ̇² = g h(θ), h = U (cos θ − cos θ₀) − m f (θ₀ − θ); the time is ∫ dθ/√(2 g h/I). With
    θ = θ₀ − s² the integrand has no pole at the start. None if it does not start, or stops on the way.
    """

    def released(theta: float) -> float:
        # cos θ − cos θ₀ as a product: no digits are lost near the start.
        fall = 2.0 * math.sin(0.5 * (start_rad + theta)) * math.sin(0.5 * (start_rad - theta))
        return unbalance_g_mm * fall - least_g_mm * (start_rad - theta)

    pull = unbalance_g_mm * math.sin(start_rad) - least_g_mm
    # h has one maximum on the way, so it is positive all along if it is at the end.
    if not (pull > 0.0 and released(0.0) > 0.0):
        return None

    def slowness(s: float) -> float:
        return 2.0 / math.sqrt(pull) if s == 0.0 else 2.0 * s / math.sqrt(released(start_rad - s * s))

    total, _ = quad(slowness, 0.0, math.sqrt(start_rad), epsabs=0.0, epsrel=1e-10, limit=200)
    return float(total) * math.sqrt(inertia_g_mm2 / (2.0 * STANDARD_GRAVITY_MM_S2))


# Drilling depth for the removal of an unbalance: closed forms on a flat entry. mm, g.


POINT = Range("must be > 0 and ≤ 180", above=0.0, most=180.0)
HoleDirection = Literal["radial", "axial"]


@dataclass(frozen=True)
class DrillPlace:
    """A drill at a radius: into a flat rim towards the axis, or along the axis."""

    diameter_mm: Annotated[float, POSITIVE, "diameter of the drill"]
    radius_mm: Annotated[
        float, POSITIVE, "radius of the rim, taken as flat; axial: radius of the hole's centre"
    ]
    point_angle_rad: Annotated[float, DEGREES, POINT, "point angle of the drill"] = DEGREES.read(118.0)
    density_g_mm3: Annotated[float, KG_M3, POSITIVE, "density of the metal"] = (
        STEEL_KG_M3 * G_PER_MM3_PER_KG_M3
    )
    direction: Annotated[HoleDirection, "into the rim, or along the axis"] = "radial"

    @property
    def point_mm(self) -> float:
        """Height of the drill's point."""
        return 0.5 * self.diameter_mm / math.tan(0.5 * self.point_angle_rad)

    def unbalance_g_mm(self, depth_mm: float) -> float:
        """Return the unbalance that a hole removes; the depth is of the full diameter, less the point."""
        area = 0.25 * math.pi * self.diameter_mm**2
        full, point = area * depth_mm, area * self.point_mm / 3.0
        if self.direction == "axial":
            return self.density_g_mm3 * (full + point) * self.radius_mm
        at_full = self.radius_mm - 0.5 * depth_mm
        at_point = self.radius_mm - depth_mm - 0.25 * self.point_mm
        return self.density_g_mm3 * (full * at_full + point * at_point)

    def depth_mm(self, unbalance_g_mm: float) -> float | None:
        """Return the depth that removes an unbalance; None without such a depth.

        The point alone may remove more; a radial hole removes most when its point reaches the axis.
        """
        deepest = self.radius_mm - self.point_mm if self.direction == "radial" else math.inf
        if self.direction == "axial":
            per_mm = self.density_g_mm3 * 0.25 * math.pi * self.diameter_mm**2 * self.radius_mm
            depth = unbalance_g_mm / per_mm - self.point_mm / 3.0
            return depth if depth >= 0.0 else None
        if deepest <= 0.0 or not self.unbalance_g_mm(0.0) <= unbalance_g_mm <= self.unbalance_g_mm(deepest):
            return None
        return float(brentq(lambda d: self.unbalance_g_mm(d) - unbalance_g_mm, 0.0, deepest, xtol=1e-12))
