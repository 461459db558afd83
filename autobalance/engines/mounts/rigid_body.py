"""An engine as a rigid body on its mounts: natural frequencies, and its response to the orders that shake it.

The frame is the engine's: x, y, z of the rotor at crank angle 0, its origin on the crank axis. Unknowns are
the displacement of the centre of mass and small turns about x, y, z. mm, g, s inside; forces in g·mm/s².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from autobalance.engines.mounts.frame import FrameModes
from autobalance.types import Array, Complex


@dataclass(frozen=True, eq=False)
class Mount:
    """A mount at ``at_mm`` (3,) with stiffnesses (3,) along the frame's axes [g/s²] and its damping.

    ``loss_by_rad_s`` (p, 2): loss factors at frequencies, straight between and constant beyond, in place of
    the damping ratio; ``viscous_g_s`` (3,): a damper beside the spring.
    """

    at_mm: Array
    stiffness_g_s2: Array
    damping_ratio: float
    loss_by_rad_s: Array | None = None
    viscous_g_s: Array | None = None

    @property
    def is_constant(self) -> bool:
        """Whether the complex spring is the same at all frequencies."""
        return self.loss_by_rad_s is None and self.viscous_g_s is None

    def spring_g_s2(self, frequencies_rad_s: Array) -> Complex:
        """Return the complex stiffness (k, 3) at frequencies (k,), k (1 + iη) + iωc with η = 2ζ [g/s²]."""
        omega = np.asarray(frequencies_rad_s, dtype=np.float64)
        loss = np.full(omega.shape, 2.0 * self.damping_ratio)
        if self.loss_by_rad_s is not None:
            loss = np.interp(omega, *self.loss_by_rad_s.T)
        spring: Complex = self.stiffness_g_s2 * (1.0 + 1j * loss[:, None])
        return spring if self.viscous_g_s is None else spring + 1j * omega[:, None] * self.viscous_g_s


@dataclass(frozen=True, eq=False)
class MountedEngine:
    """Mass [g], centre of mass (3,) [mm], inertia (3, 3) about it [g·mm²], and mounts.

    On a flexible frame, ``frame`` has its modes and ``on_frame`` (3, m) their shapes at each mount: the
    unknowns are then the engine's six and the frame's m.

    A mount's spring is complex, k (1 + 2 i ζ): its damping at any frequency is that of ζ at resonance.
    """

    mass_g: float
    centre_mm: Array
    inertia_g_mm2: Array
    mounts: tuple[Mount, ...]
    frame: FrameModes | None = None
    on_frame: tuple[Array, ...] = ()

    @property
    def unknowns(self) -> int:
        """Number of unknowns, 6 + m."""
        return 6 if self.frame is None else 6 + len(self.frame.frequency_rad_s)

    @cached_property
    def mass(self) -> Array:
        """Mass matrix (6 + m, 6 + m)."""
        total = np.eye(self.unknowns)
        total[:6, :6] = 0.0
        total[:3, :3] = self.mass_g * np.eye(3)
        total[3:6, 3:6] = self.inertia_g_mm2
        return total

    def moves(self, place_mm: Array) -> Array:
        """Return the displacement (3, 6 + m) of a place of the engine by the unknowns: u + φ × r."""
        x, y, z = np.asarray(place_mm) - self.centre_mm
        turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
        return np.hstack([np.eye(3), turned, np.zeros((3, self.unknowns - 6))])

    def frame_moves(self, shapes: Array) -> Array:
        """Return the displacement (3, 6 + m) of a place of the frame, whose shapes (3, m) are known there."""
        return np.hstack([np.zeros((3, 6)), shapes])

    def stretches(self, number: int) -> Array:
        """Return the stretch (3, 6 + m) of a mount (from 0) by the unknowns."""
        rows = self.moves(self.mounts[number].at_mm)
        return rows if self.frame is None else rows - self.frame_moves(self.on_frame[number])

    @cached_property
    def _of_frame(self) -> Complex:
        """Complex stiffness (6 + m, 6 + m) of the frame's modes alone."""
        total = np.zeros((self.unknowns, self.unknowns), dtype=np.complex128)
        if self.frame is not None:
            loss = 1.0 + 2.0j * self.frame.damping_ratio
            total[6:, 6:] = np.diag(self.frame.frequency_rad_s**2 * loss)
        return total

    @cached_property
    def stiffness(self) -> Complex:
        """Complex stiffness matrix (6 + m, 6 + m)."""
        total = self._of_frame.copy()
        for number, mount in enumerate(self.mounts):
            rows = self.stretches(number)
            spring = mount.stiffness_g_s2 * (1.0 + 2.0j * mount.damping_ratio)
            total += rows.T @ (spring[:, None] * rows)
        return total

    def stiffness_at(self, frequencies_rad_s: Array) -> Complex:
        """Return the complex stiffness at frequencies (k, 6 + m, 6 + m); (6 + m, 6 + m) if constant."""
        if all(each.is_constant for each in self.mounts):
            return self.stiffness
        total = np.tile(self._of_frame, (len(frequencies_rad_s), 1, 1))
        for number, mount in enumerate(self.mounts):
            rows = self.stretches(number)
            total += np.einsum("ai,ka,aj->kij", rows, mount.spring_g_s2(frequencies_rad_s), rows)
        return total

    def modes(self) -> tuple[Array, Array]:
        """Return undamped natural frequencies (6 + m,) [rad/s], ascending, and shapes (6, 6 + m), columns.

        A shape's largest motion is 1: mm, or turns over the radius of gyration.
        """
        from scipy.linalg import eigh

        square, shapes = eigh(self.stiffness.real, self.mass)
        gyration = np.sqrt(np.trace(self.inertia_g_mm2) / (3.0 * self.mass_g))
        size = np.concatenate([np.ones(3), np.full(3, gyration)])[:, None]
        shapes = shapes[:6]
        moved = shapes * size
        most = np.take_along_axis(moved, np.abs(moved).argmax(axis=0)[None, :], axis=0)
        return np.sqrt(np.maximum(square, 0.0)), np.asarray(shapes / most)

    def response(self, frequencies_rad_s: Array, wrenches: Complex) -> Complex:
        """Return the unknowns (k, 6 + m) under forces and moments about the centre (k, 6)."""
        omega = np.asarray(frequencies_rad_s)[:, None, None]
        pushed = np.zeros((len(wrenches), self.unknowns), dtype=np.complex128)
        pushed[:, :6] = wrenches
        motion = np.linalg.solve(self.stiffness_at(omega[:, 0, 0]) - omega**2 * self.mass, pushed[..., None])
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
