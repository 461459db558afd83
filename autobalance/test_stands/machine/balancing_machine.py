"""Readings of balancing machines on a rigid rotor: hard and soft bearings, cradle, nodal points.

Forces [g·mm/s²], displacements [mm] and moments [g·mm²/s²] are complex amplitudes x + i y that turn with the
rotor; the argument is their angle in the rotor frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from autobalance.declare import DEGREES, NOT_NEGATIVE, PERCENT, Named
from autobalance.test_stands.bench.spun_rotor import SpunRotor


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
class Noise:
    """Standard deviations of a machine's readings in a plane."""

    unbalance_g_mm: Annotated[
        float, NOT_NEGATIVE, Named("g_mm"), "standard deviation of x and of y of each plane's reading"
    ] = 0.0
    gain: Annotated[float, PERCENT, NOT_NEGATIVE, "error of the reading's size"] = 0.0
    angle_rad: Annotated[float, DEGREES, NOT_NEGATIVE, "error of the reading's angle"] = 0.0


def noisy_readings(
    planes: tuple[complex, ...], noise: Noise, runs: int, seed: int
) -> list[tuple[complex, ...]]:
    """Return the readings of a machine with errors in each run: (1 + gain) U e^(i angle) + (x + i y).

    Errors are drawn again from normal distributions for each plane and each run.
    """
    draws = np.random.default_rng(seed).standard_normal((runs, len(planes), 4))
    gain, angle = noise.gain * draws[:, :, 0], noise.angle_rad * draws[:, :, 1]
    aside = noise.unbalance_g_mm * (draws[:, :, 2] + 1j * draws[:, :, 3])
    read = np.array(planes) * (1.0 + gain) * np.exp(1j * angle) + aside
    return [tuple(each) for each in read.tolist()]
