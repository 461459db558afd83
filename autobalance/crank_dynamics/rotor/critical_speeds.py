"""Critical speeds: of a spinning rotor, and over a common stiffness of its bearings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Annotated, ClassVar, Self

import numpy as np
from scipy import sparse
from scipy.optimize import brentq
from scipy.sparse.linalg import splu

from autobalance.crank_dynamics.rotor.beam_element import REFINED_DEGREE, mesh_of, wave_number_per_m
from autobalance.crank_dynamics.rotor.beam_rotor import BeamRotor, Bearing, spring_bearing
from autobalance.crank_dynamics.rotor.matrices import (
    ReducedRotor,
    RotorMatrices,
    Sparse,
    planar_modes,
    reduced_rotor,
    rotor_matrices,
)
from autobalance.crank_dynamics.rotor.whirl_modes import (
    MAX_DAMPING_RATIO,
    Whirl,
    WhirlMode,
    frequencies_with_zeros,
    modes_at,
    refined,
    whirl_of_orbits,
)
from autobalance.declare import INLINE, Count, Mm, Ordinal, Positive, Rpm, record
from autobalance.errors import JobError
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Preparation of a rotor: matrices and a reduction for the required frequencies and speeds.


MESH_ERROR = 5e-6
"""Share of a frequency that the mesh may be off: half of the promised accuracy."""
REDUCTION_ERROR = 1e-5
"""Relative error of frequencies in Campbell diagrams; single modes and critical speeds have less."""
MOST_STIFF = 1e13
"""Largest ratio of the shaft's stiffness to a bearing's: rounding leaves three digits of the bearing."""
KEPT_FREQUENCIES = 4.0
"""Highest frequency of the modes kept in a reduction, as a multiple of the highest of interest."""
SPARE_MODES = 2
TRIES = 5


@record
class RotorMass:
    """Mass, its centre, and how the rotor was divided."""

    mass_kg: Positive
    centre_of_mass_m: Mm
    elements: Ordinal
    rigid_body_modes: Count


@dataclass(frozen=True, eq=False)
class PreparedRotor:
    """A rotor ready for analysis: whole matrices for loads, reduced ones for modes."""

    matrices: RotorMatrices
    reduced: ReducedRotor
    top_rad_s: float

    @property
    def rotor(self) -> BeamRotor:
        return self.matrices.rotor

    @property
    def elements(self) -> int:
        return len(self.matrices.nodes_m) - 1

    @property
    def mass(self) -> RotorMass:
        mass, moment = self.rotor.mass_and_moment()
        return RotorMass(
            mass_kg=mass,
            centre_of_mass_m=moment / mass,
            elements=self.elements,
            rigid_body_modes=self.reduced.rigid_body_modes,
        )


def prepared(
    rotor: BeamRotor, top_speed_rad_s: float, modes: int, stations_m: Iterable[float] = ()
) -> PreparedRotor:
    """Return a rotor divided into elements and reduced.

    Parameters
    ----------
    rotor : BeamRotor
    top_speed_rad_s : float
        Highest speed of interest [rad/s].
    modes : int
        Number of modes of interest at each speed; planar pairs are two.
    stations_m : iterable of float
        Places that must be nodes, besides discs, bearings and unbalances [m].

    Raises
    ------
    JobError
        If a bearing is lost in the rounding of the shaft's stiffness.
    """
    stations = _stations(rotor, stations_m)
    matrices, top = _divided(rotor, stations, top_speed_rad_s, modes)
    _check_rounding(matrices)
    keep = KEPT_FREQUENCIES * top
    for _ in range(TRIES):
        reduced = reduced_rotor(matrices, keep, least=modes + SPARE_MODES)
        coarse = modes_at(reduced, top_speed_rad_s, modes)[:: max(1, modes // 4)]
        better = refined(reduced, top_speed_rad_s, coarse)
        off = [
            abs(a.eigenvalue - b.eigenvalue) / abs(b.eigenvalue) for a, b in zip(coarse, better, strict=True)
        ]
        if max(off, default=0.0) <= REDUCTION_ERROR or reduced.basis.shape[1] >= matrices.size_1:
            break
        keep *= 1.5
    return PreparedRotor(matrices, reduced, top)


def _check_rounding(matrices: RotorMatrices) -> None:
    """Refuse bearings whose stiffness is lost in the rounding of the shaft's.

    Raises
    ------
    JobError
        If a bearing's is.
    """
    shaft = float(matrices.stiffness_1.diagonal().max(initial=0.0))
    for number, bearing in enumerate(matrices.rotor.bearings, 1):
        direct = np.diagonal(bearing.stiffness_n_m, axis1=1, axis2=2)
        least = float(direct[direct > 0.0].min(initial=np.inf))
        if shaft > MOST_STIFF * least:
            raise JobError(
                f"the shaft's elements are {shaft / least:.0e} times as stiff as bearing[{number}];"
                f" expected at most {MOST_STIFF:.0e} times: take a rigid rotor, or fewer and softer sections"
            )


def _stations(rotor: BeamRotor, more_m: Iterable[float]) -> Array:
    own = [each.z_m for group in (rotor.discs, rotor.bearings, rotor.unbalances) for each in group]
    return np.unique([*own, *more_m])


def _divided(
    rotor: BeamRotor, stations: Array, top_speed_rad_s: float, modes: int
) -> tuple[RotorMatrices, float]:
    """Return matrices with the planar frequencies of interest converged, and the highest of these."""
    planar = -(-modes // 2) + SPARE_MODES
    top = max(top_speed_rad_s, _first_guess_rad_s(rotor, planar))
    finer = 1.0
    for _ in range(TRIES):
        matrices = rotor_matrices(rotor, mesh_of(rotor, stations, top, REFINED_DEGREE, finer))
        frequency, _, _ = planar_modes(matrices)
        top_needed = max(top_speed_rad_s, float(frequency[:planar][-1]))
        if all(section.elements for section in rotor.sections):
            return matrices, top_needed
        if not 0.5 * top <= top_needed <= 1.02 * top:
            top = 1.01 * top_needed
            continue
        closer, _, _ = planar_modes(
            rotor_matrices(rotor, mesh_of(rotor, stations, top, REFINED_DEGREE + 1, finer))
        )
        count = min(planar, len(frequency), len(closer))
        known = closer[:count] > 1e-3 * top
        off = np.abs(frequency[:count][known] / closer[:count][known] - 1.0)
        if off.max(initial=0.0) <= MESH_ERROR:
            break
        finer *= 1.5
    return matrices, top_needed


def _first_guess_rad_s(rotor: BeamRotor, planar: int) -> float:
    """Return the frequency of ``planar`` + 1 half waves on the bare shaft."""
    low, high = 1e-3, 1e9
    for _ in range(60):
        middle = np.sqrt(low * high)
        phase = sum(wave_number_per_m(each, middle, rotor.beam) * each.length_m for each in rotor.sections)
        low, high = (low, middle) if phase > np.pi * (planar + 1) else (middle, high)
    return float(low)


# Critical speeds: speeds equal to a damped frequency of the spinning rotor.


SCANNED_SPEEDS = 120
"""Number of speeds at which frequencies are compared with the speed, without a direct solution."""
EQUAL_SPEED_SHARE = 1e-8
"""Largest relative difference of two critical speeds reported as one."""
SECANT_STEPS = 4


@dataclass(frozen=True)
class CriticalSpeed:
    """A speed that excites a mode by its own unbalance, with the mode's whirl and decrement there."""

    schema_name: ClassVar[str] = "Critical"
    speed_rad_s: Rpm
    whirl: Whirl
    log_decrement: float


@record
class Criticals:
    """Critical speeds, bare and with whirl and decrement."""

    critical_speeds_rad_s: Sequence[Rpm]
    criticals: Sequence[CriticalSpeed]

    @classmethod
    def of(cls, criticals: Sequence[CriticalSpeed]) -> Self:
        return cls(critical_speeds_rad_s=[each.speed_rad_s for each in criticals], criticals=criticals)


def critical_speeds(prepared: PreparedRotor, upper_rad_s: float) -> list[CriticalSpeed]:
    """Return all critical speeds up to a limit, ascending, of any whirl.

    Without damping and with constant bearings λ = iΩ makes the eigenproblem a linear one,
    (K − Ω² (M − iG)) x = 0, solved at once; otherwise each frequency's crossing with the speed is sought.
    """
    if upper_rad_s <= 0.0:
        return []
    reduced = reduced_rotor(prepared.matrices, KEPT_FREQUENCIES * upper_rad_s, least=SPARE_MODES)
    if prepared.rotor.constant_bearings and reduced.conservative(0.0):
        criticals = _direct(reduced, upper_rad_s)
    else:
        criticals = _searched(reduced, upper_rad_s)
    criticals.sort(key=lambda each: each.speed_rad_s)
    return _pairs_as_one(criticals)


def _pairs_as_one(criticals: list[CriticalSpeed]) -> list[CriticalSpeed]:
    """Return critical speeds with two at one speed merged: motion in any plane, whirl None.

    Where forward and backward whirl have one frequency, the whirls of the two are arbitrary.
    """
    kept: list[CriticalSpeed] = []
    for each in criticals:
        if kept and each.speed_rad_s - kept[-1].speed_rad_s <= EQUAL_SPEED_SHARE * each.speed_rad_s:
            kept[-1] = CriticalSpeed(kept[-1].speed_rad_s, None, kept[-1].log_decrement)
        else:
            kept.append(each)
    return kept


# --- constant bearings without damping ----------------------------------------------------------------------


def _direct(reduced: ReducedRotor, upper_rad_s: float) -> list[CriticalSpeed]:
    matrices = reduced.matrices
    speeds, vectors = synchronous(reduced)
    stiffness = matrices.stiffness(0.0)

    def inert(vector: Complex) -> Complex:
        return np.asarray(matrices.mass @ vector - 1j * (matrices.gyroscopic @ vector), dtype=complex)

    criticals = []
    for speed, vector in zip(speeds, vectors.T, strict=True):
        if speed > 1.01 * upper_rad_s:
            continue
        square, full = float(speed**2), reduced.expand(vector)
        for _ in range(2):
            try:
                full = _solved(
                    stiffness - square * matrices.mass,
                    sparse.csc_matrix(square * matrices.gyroscopic),
                    inert(full),
                )
            except RuntimeError:  # singular to the last digit: the speed is exact
                break
            full = full / np.linalg.norm(full)
            strain = np.vdot(full, np.asarray(stiffness @ full, dtype=complex))
            square = float((strain / np.vdot(full, inert(full))).real)
        if square**0.5 <= upper_rad_s:
            criticals.append(CriticalSpeed(square**0.5, whirl_of_orbits(*matrices.deflections(full)), 0.0))
    return criticals


def _solved(real: Sparse, imaginary: Sparse, load: Complex) -> Complex:
    """Return the solution x of (real + i imaginary) x = load."""
    turned = sparse.csc_matrix((1j * imaginary.data, imaginary.indices, imaginary.indptr), imaginary.shape)
    dynamic = sparse.csc_matrix(real.astype(np.complex128) + turned)
    return np.asarray(splu(dynamic).solve(load), dtype=complex)


def synchronous(reduced: ReducedRotor) -> tuple[Array, Complex]:
    """Return the speeds [rad/s] of synchronous whirl of an undamped rotor, and the reduced vectors."""
    stiffness = reduced.stiffness(0.0)
    gyroscopic = reduced.damping(1.0) - reduced.damping(0.0)
    if not reduced.planes_apart(gyroscopic, stiffness):
        return _definite(stiffness, np.eye(len(stiffness)) - 1j * gyroscopic, reduced.rigid_body_modes)
    speeds, vectors = [], []
    for plane in (0, 1):
        own, shapes = _definite(
            stiffness[plane::2, plane::2], np.eye(len(stiffness) // 2, dtype=complex), None
        )
        both = np.zeros((len(stiffness), len(own)), dtype=complex)
        both[plane::2] = shapes
        speeds.append(own)
        vectors.append(both)
    return np.concatenate(speeds), np.hstack(vectors)


def _definite(stiffness: Array, inertia: Complex, rigid: int | None) -> tuple[Array, Complex]:
    """Return Ω and x of K x = Ω² A x for Ω² > 0, K symmetric, A Hermitian and perhaps indefinite.

    Rigid-body motions, on which K is zero, are removed: K is definite on the rest. Negative springs may leave
    K indefinite; their effect on a rotor at rest is not a critical speed.
    """
    energy, modes = np.linalg.eigh(stiffness)
    still = energy < 1e-12 * energy[-1] if rigid is None else np.arange(len(energy)) < rigid
    free, bent = modes[:, still], modes[:, ~still]
    lift = bent.astype(complex)
    if free.shape[1]:
        lift = bent - free @ (np.linalg.pinv(free.T @ inertia @ free) @ (free.T @ inertia @ bent))
    if (energy[~still] > 0.0).all():
        root = 1.0 / np.sqrt(energy[~still])
        flexibility, mix = np.linalg.eigh(root[:, None] * (lift.conj().T @ inertia @ lift) * root)
        real = flexibility > 1e-14 * np.abs(flexibility).max(initial=0.0)
        return 1.0 / np.sqrt(flexibility[real]), lift @ (root[:, None] * mix[:, real])
    values, mix = np.linalg.eig(np.linalg.solve(stiffness.astype(complex), inertia))
    real = (values.real > 0.0) & (np.abs(values.imag) < 1e-9 * np.abs(values))
    return 1.0 / np.sqrt(values[real].real), mix[:, real]


# --- anything else ------------------------------------------------------------------------------------------


def _searched(reduced: ReducedRotor, upper_rad_s: float) -> list[CriticalSpeed]:
    speeds = upper_rad_s * np.linspace(1e-4, 1.0, SCANNED_SPEEDS + 1)
    above = np.array([frequencies_with_zeros(reduced, float(speed))[0] - speed for speed in speeds])
    criticals = []
    for step, branch in zip(*np.nonzero((above[:-1] > 0.0) != (above[1:] > 0.0)), strict=True):

        def beyond(speed: float, branch: int = int(branch)) -> float:
            return float(frequencies_with_zeros(reduced, speed)[0][branch]) - speed

        speed = float(brentq(beyond, speeds[step], speeds[step + 1], xtol=1e-8 * upper_rad_s, rtol=1e-9))
        if frequencies_with_zeros(reduced, speed)[1][int(branch)] <= MAX_DAMPING_RATIO:
            critical = _on_the_line(reduced, speed)
            if critical is not None:
                criticals.append(critical)
    return criticals


def _on_the_line(reduced: ReducedRotor, speed_rad_s: float) -> CriticalSpeed | None:
    """Return the critical speed by the whole matrices near one by the reduced matrices; None without one."""

    def nearest(speed: float, to: float) -> WhirlMode | None:
        modes = modes_at(reduced, speed, 4 * reduced.basis.shape[1])
        return min(modes, key=lambda each: abs(each.frequency_rad_s - to), default=None)

    mode = nearest(speed_rad_s, speed_rad_s)
    if mode is None or abs(mode.frequency_rad_s - speed_rad_s) > 1e-4 * speed_rad_s:
        return None
    mode = refined(reduced, speed_rad_s, [mode])[0]
    before, off = None, mode.frequency_rad_s - speed_rad_s
    for _ in range(SECANT_STEPS):
        if abs(off) <= 1e-10 * speed_rad_s:
            break
        slope = -1.0 if before is None else (off - before[1]) / (speed_rad_s - before[0])
        before = (speed_rad_s, off)
        speed_rad_s -= off / slope
        mode = refined(reduced, speed_rad_s, [mode])[0]
        off = mode.frequency_rad_s - speed_rad_s
    return CriticalSpeed(speed_rad_s, mode.whirl, mode.log_decrement)


# Undamped critical speed map: critical speeds over a common stiffness of all bearings.


@record
class StiffnessRow:
    """Critical speeds without damping at one stiffness of the bearings."""

    k_n_m: Positive
    criticals: Annotated[Criticals, INLINE]


def undamped_map(
    rotor: BeamRotor, stiffnesses_n_m: Array, upper_rad_s: float, modes: int
) -> list[StiffnessRow]:
    """Return the critical speeds at each common stiffness (k,) of the elastic bearings; rigid ones stay.

    Damping, cross coupling and differences between the directions are left out. Mesh and reduction are
    renewed once per decade of stiffness.
    """
    rows = []
    ready, ready_for = None, 0.0
    for stiffness in stiffnesses_n_m:
        same = replace(rotor, bearings=tuple(_replaced(each, float(stiffness)) for each in rotor.bearings))
        if ready is None or stiffness > 10.0 * ready_for:
            ready, ready_for = prepared(same, upper_rad_s, modes, []), float(stiffness)
        matrices = replace(ready.matrices, rotor=same)
        reduced = replace(ready.reduced, matrices=matrices)
        criticals = critical_speeds(replace(ready, matrices=matrices, reduced=reduced), upper_rad_s)
        rows.append(StiffnessRow(k_n_m=float(stiffness), criticals=Criticals.of(criticals)))
    return rows


def _replaced(bearing: Bearing, stiffness_n_m: float) -> Bearing:
    if bearing.constraint is not None:
        return bearing
    return spring_bearing(bearing.z_m, stiffness_n_m * np.eye(2))
