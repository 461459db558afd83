"""An engine as a rigid body on its mounts: natural frequencies, and its response to the orders that shake it.

The frame is the engine's: x, y, z of the rotor at crank angle 0, its origin on the crank axis. Unknowns are
the displacement of the centre of mass and small turns about x, y, z. mm, g, s inside; forces in g·mm/s².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from autobalance.types import Array, Complex


@dataclass(frozen=True, eq=False)
class Mount:
    """A mount at ``at_mm`` (3,) with stiffnesses (3,) along the frame's axes [g/s²] and a damping ratio."""

    at_mm: Array
    stiffness_g_s2: Array
    damping_ratio: float


@dataclass(frozen=True, eq=False)
class MountedEngine:
    """Mass [g], centre of mass (3,) [mm], inertia (3, 3) about it [g·mm²], and mounts.

    A mount's spring is complex, k (1 + 2 i ζ): its damping at any frequency is that of ζ at resonance.
    """

    mass_g: float
    centre_mm: Array
    inertia_g_mm2: Array
    mounts: tuple[Mount, ...]

    @cached_property
    def mass(self) -> Array:
        """Mass matrix (6, 6)."""
        total = np.zeros((6, 6))
        total[:3, :3] = self.mass_g * np.eye(3)
        total[3:, 3:] = self.inertia_g_mm2
        return total

    def moves(self, place_mm: Array) -> Array:
        """Return the displacement (3, 6) of a place by the six unknowns: u + φ × r."""
        x, y, z = np.asarray(place_mm) - self.centre_mm
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        return np.hstack([np.eye(3), turned])

    @cached_property
    def stiffness(self) -> Complex:
        """Complex stiffness matrix (6, 6)."""
        total = np.zeros((6, 6), dtype=np.complex128)
        for mount in self.mounts:
            rows = self.moves(mount.at_mm)
            spring = mount.stiffness_g_s2 * (1.0 + 2.0j * mount.damping_ratio)
            total += rows.T @ (spring[:, None] * rows)
        return total

    def modes(self) -> tuple[Array, Array]:
        """Return undamped natural frequencies (6,) [rad/s], ascending, and shapes (6, 6), columns.

        A shape's largest motion is 1: mm, or turns over the radius of gyration.
        """
        from scipy.linalg import eigh

        square, shapes = eigh(self.stiffness.real, self.mass)
        gyration = np.sqrt(np.trace(self.inertia_g_mm2) / (3.0 * self.mass_g))
        size = np.concatenate([np.ones(3), np.full(3, gyration)])[:, None]
        moved = shapes * size
        most = np.take_along_axis(moved, np.abs(moved).argmax(axis=0)[None, :], axis=0)
        return np.sqrt(np.maximum(square, 0.0)), np.asarray(shapes / most)

    def response(self, frequencies_rad_s: Array, wrenches: Complex) -> Complex:
        """Return the motion (k, 6) of the centre under forces and moments about the centre (k, 6)."""
        omega = np.asarray(frequencies_rad_s)[:, None, None]
        motion = np.linalg.solve(self.stiffness - omega**2 * self.mass, wrenches[..., None])
        return np.asarray(motion[..., 0])

    def wrench(self, force: Complex, moment_about_origin: Complex) -> Complex:
        """Return force and moment about the centre (..., 6) from those about the crank axis at z = 0."""
        moment = moment_about_origin - np.cross(self.centre_mm, force)
        return np.concatenate([force, moment], axis=-1)


def moment_of_orders(moment: Complex, torque: Complex) -> Complex:
    """Return the moment vector (..., 3) from Σ z F (..., 2) along the forces and the torque about z (...)."""
    return np.stack([-moment[..., 1], moment[..., 0], torque], axis=-1)


def rms(amplitudes: Sequence[Complex]) -> Array:
    """Return the root mean square (...) of the vectors (..., 3) of several orders together."""
    total = sum(0.5 * np.sum(np.abs(each) ** 2, axis=-1) for each in amplitudes)
    return np.asarray(np.sqrt(total))
