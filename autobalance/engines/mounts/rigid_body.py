"""An engine as a rigid body on its mounts, and the flexible frame below them."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from autobalance.errors import JobError, file_errors
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# A flexible frame below an engine's mounts, by its modes from a file of an FE program: CSV or UFF 55.
#
# With mass-normalised shapes Φ the frame's coordinates η follow η̈ + ω_m² (1 + 2iζ) η = Φᵀ f, with f the
# mounts' forces on it. A mount stretches by what its engine end moves more than its frame end, A q − Φ η.


COLUMNS = ("mode", "frequency_hz", "x_mm", "y_mm", "z_mm", "ux", "uy", "uz")
PER_ROOT_G = 1.0 / math.sqrt(1e3)
"""A mass-normalised shape of 1/√kg in 1/√g."""
MM_PER_UNIT = {"m": 1e3, "mm": 1.0}
G_PER_MASS_UNIT = {"m": 1e3, "mm": 1e6}
"""Mass unit beside N, s and the length: kg with m, tonnes with mm."""


@dataclass(frozen=True, eq=False)
class FrameModes:
    """Modes of a frame: frequencies (m,) [rad/s], damping ratios (m,), nodes (p, 3) [mm], shapes (m, p, 3).

    Shapes are mass-normalised, in 1/√g.
    """

    frequency_rad_s: Array
    damping_ratio: Array
    places_mm: Array
    shapes: Array

    def at(self, place_mm: Array, within_mm: float, what: str) -> Array:
        """Return the shapes (3, m) at the node next to a place.

        Raises
        ------
        JobError
            If no node is so near.
        """
        apart = np.linalg.norm(self.places_mm - np.asarray(place_mm), axis=1)
        nearest = int(np.argmin(apart))
        if apart[nearest] > within_mm:
            at = ", ".join(f"{each:.4g}" for each in self.places_mm[nearest])
            raise JobError(
                f"mounts.frame: no node within {within_mm:g} mm of {what}; the nearest is at [{at}],"
                f" {apart[nearest]:.4g} mm away"
            )
        return np.asarray(self.shapes[:, nearest].T)


def read_modes(path: Path, unit: str, damping_ratio: float) -> FrameModes:
    """Return the modes of a file: CSV by its ending, else UFF.

    Parameters
    ----------
    path : Path
    unit : {"m", "mm"}
        Length of a UFF file without its units (164).
    damping_ratio : float
        Of modes without their own.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it has no modes, or nodes without a place.
    """
    with file_errors(f"read the modes of the frame {path.name}"):
        text = path.read_text(encoding="utf-8", errors="replace")
    try:
        modes = (
            _csv(text, damping_ratio) if path.suffix.lower() == ".csv" else _uff(text, unit, damping_ratio)
        )
    except (KeyError, IndexError, ValueError) as error:
        raise JobError(f"{path.name} is not a readable file of modes: {error}") from None
    finite = all(np.isfinite(each).all() for each in (modes.frequency_rad_s, modes.places_mm, modes.shapes))
    if not len(modes.frequency_rad_s) or not finite or (modes.damping_ratio < 0.0).any():
        raise JobError(f"{path.name} has no modes, or numbers that are not finite, or negative damping")
    return modes


def _csv(text: str, usual: float) -> FrameModes:
    rows = list(csv.DictReader(text.splitlines()))
    missing = [name for name in COLUMNS if not rows or name not in rows[0]]
    if missing:
        raise ValueError(f"columns {', '.join(missing)} are missing")
    by_mode: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        by_mode.setdefault(row["mode"], []).append(row)
    first = next(iter(by_mode.values()))
    places = np.array([[float(row[name]) for name in COLUMNS[2:5]] for row in first])
    shapes = []
    for mode, listed in by_mode.items():
        own = np.array([[float(row[name]) for name in COLUMNS[2:5]] for row in listed])
        if own.shape != places.shape or np.abs(own - places).max() > 1e-6:
            raise ValueError(f"mode {mode} has other nodes than the first; each needs all, in one order")
        shapes.append([[float(row[name]) for name in COLUMNS[5:]] for row in listed])
    damping = [float(listed[0].get("damping_ratio") or usual) for listed in by_mode.values()]
    frequency = [float(listed[0]["frequency_hz"]) for listed in by_mode.values()]
    return FrameModes(
        2.0 * np.pi * np.array(frequency), np.array(damping), places, np.array(shapes) * PER_ROOT_G
    )


def _blocks(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the datasets of a universal file: number and lines."""
    inside: list[str] | None = None
    for line in text.splitlines():
        if line.strip() == "-1":
            if inside:
                yield int(inside[0].split()[0]), inside[1:]
            inside = [] if inside is None else None
        elif inside is not None:
            inside.append(line)


def _numbers(line: str) -> list[float]:
    return [float(word) for word in line.replace("D", "E").replace("d", "e").split()]


def _uff(text: str, unit: str, usual: float) -> FrameModes:
    mm, gram = MM_PER_UNIT[unit], G_PER_MASS_UNIT[unit]
    nodes: dict[int, list[float]] = {}
    modes: list[tuple[float, float, float, dict[int, list[float]]]] = []
    for number, lines in _blocks(text):
        if number == 164:
            length, force = _numbers(lines[1])[:2]
            mm, gram = 1e3 / length, 1e3 * length / force
        elif number == 15:
            nodes |= {int(line.split()[0]): _numbers(line)[4:7] for line in lines if line.strip()}
        elif number == 2411:
            pairs = zip(lines[::2], lines[1::2], strict=False)
            nodes |= {int(head.split()[0]): _numbers(place)[:3] for head, place in pairs}
        elif number == 55:
            modes.append(_mode(lines, usual))
    if not modes:
        raise ValueError("it has no dataset 55 of normal modes")
    labels = sorted(modes[0][3])
    unplaced = [label for label in labels if label not in nodes]
    if unplaced:
        raise ValueError(f"nodes {unplaced[:5]} of dataset 55 have no place (dataset 15 or 2411)")
    shapes = [
        np.array([of[label][:3] for label in labels]) / math.sqrt(mass * gram) for _, _, mass, of in modes
    ]
    return FrameModes(
        2.0 * np.pi * np.array([frequency for frequency, *_ in modes]),
        np.array([damping for _, damping, *_ in modes]),
        np.array([nodes[label] for label in labels]) * mm,
        np.array(shapes),
    )


def _mode(lines: Sequence[str], usual: float) -> tuple[float, float, float, dict[int, list[float]]]:
    """Return frequency [Hz], damping ratio, modal mass and shape by node of a dataset 55."""
    _, analysis, _, _, data_type, values = (int(word) for word in lines[5].split()[:6])
    if analysis != 2 or data_type != 2:
        raise ValueError("dataset 55 is not of real normal modes")
    frequency, mass, viscous, hysteretic = _numbers(lines[7])[:4]
    if not mass > 0.0:
        raise ValueError(f"a mode at {frequency:g} Hz has a modal mass of {mass:g}; must be > 0")
    damping = viscous or hysteretic / 2.0 or usual
    shape: dict[int, list[float]] = {}
    at = 8
    while at < len(lines) and lines[at].strip():
        label = int(lines[at].split()[0])
        row: list[float] = []
        while len(row) < values:
            at += 1
            row += _numbers(lines[at])
        shape[label] = row
        at += 1
    return frequency, damping, mass, shape


# An engine as a rigid body on its mounts: natural frequencies, and its response to the orders that shake it.
#
# The frame is the engine's: x, y, z of the rotor at crank angle 0, its origin on the crank axis. Unknowns
# are the displacement of the centre of mass and small turns about x, y, z. mm, g, s inside; forces in
# g·mm/s².


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
