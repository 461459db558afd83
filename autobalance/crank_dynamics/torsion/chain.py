"""Chains of inertias on torsion springs, and a crank as one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, ClassVar

import numpy as np

from autobalance.declare import KG_MM2_OF_SI, Named, NewtonMetres, NotNegative, Positive, record
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Chains of inertias on torsion springs: frequencies, modes, Holzer tables, forced response. SI units.


NODE = 1e-9
"""Amplitude of a node in a mode with a largest amplitude of 1."""


@dataclass(frozen=True, eq=False)
class TorsionChain:
    """Inertias (n,) one after another and the springs (n − 1,) between them; a spring of 0 parts the chain.

    ``to_ground_n_m_s`` (n,) and ``across_n_m_s`` (n − 1,) are viscous dampers [N·m·s/rad].
    """

    inertias_kg_m2: Array
    springs_n_m_rad: Array
    to_ground_n_m_s: Array
    across_n_m_s: Array

    @property
    def rigid_modes(self) -> int:
        """Number of freely turning pieces."""
        return 1 + int(np.count_nonzero(self.springs_n_m_rad == 0.0))

    def stiffness(self) -> Array:
        """Return the stiffness matrix (n, n)."""
        return _chained(self.springs_n_m_rad)

    def damping(self) -> Array:
        """Return the damping matrix (n, n)."""
        return np.asarray(np.diag(self.to_ground_n_m_s) + _chained(self.across_n_m_s))


@dataclass(frozen=True, eq=False)
class TorsionMode:
    """An undamped mode: ``shape`` (n,), its largest amplitude +1, and its number of nodes."""

    frequency_rad_s: float
    shape: Array
    nodes: int


@record
class HolzerRow:
    """A station of Holzer's table at one frequency, for an angle of 1 at the first station.

    None is what grew over all numbers, behind a spring of no stiffness.

    ``torque_n_m`` is Σ J ω² θ up to here, carried by the next spring; after the last station it is the
    remainder, zero at a natural frequency. ``twist_rad`` is that of the next spring.
    """

    schema_name: ClassVar[str] = "HolzerFigures"
    inertia_kg_m2: Annotated[NotNegative, KG_MM2_OF_SI]
    angle_rad: float | None
    inertia_torque_n_m: NewtonMetres | None
    torque_n_m: NewtonMetres | None
    twist_rad: float | None


def _chained(values: Array) -> Array:
    """Return the matrix of elements between neighbours."""
    total = np.zeros((len(values) + 1, len(values) + 1))
    for at, value in enumerate(values):
        total[at : at + 2, at : at + 2] += value * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return total


def torsion_modes(chain: TorsionChain) -> list[TorsionMode]:
    """Return the undamped elastic modes of a chain, ascending."""
    from scipy.linalg import eigh_tridiagonal

    root = 1.0 / np.sqrt(chain.inertias_kg_m2)
    stiffness = chain.stiffness()
    diagonal = np.diag(stiffness) * root**2
    beside = np.diag(stiffness, 1) * root[:-1] * root[1:]
    square, vectors = eigh_tridiagonal(diagonal, beside)
    modes = []
    for value, vector in list(zip(square, vectors.T, strict=True))[chain.rigid_modes :]:
        shape = root * vector
        shape = shape / shape[int(np.argmax(np.abs(shape)))]
        modes.append(TorsionMode(float(np.sqrt(value)), shape, _nodes(shape, chain.springs_n_m_rad)))
    return modes


def _nodes(shape: Array, springs: Array) -> int:
    """Return the number of connected neighbours that move against each other."""
    count, last = 0, 0.0
    for at, angle in enumerate(shape):
        if at and springs[at - 1] == 0.0:
            last = 0.0
        if abs(angle) > NODE:
            count += angle * last < 0.0
            last = angle
    return int(count)


def holzer_table(chain: TorsionChain, frequency_rad_s: float) -> list[HolzerRow]:
    """Return Holzer's table of a chain in one piece at a frequency.

    References
    ----------
    H. Holzer, Die Berechnung der Drehschwingungen, Springer 1921.

    Examples
    --------
    >>> two = TorsionChain(np.ones(2), np.ones(1), np.zeros(2), np.zeros(1))
    >>> abs(round(holzer_table(two, 2.0**0.5)[-1].torque_n_m, 12))
    0.0
    """
    rows, angle, torque = [], 1.0, 0.0
    for at, inertia in enumerate(chain.inertias_kg_m2):
        own = float(inertia) * frequency_rad_s**2 * angle
        torque += own
        last = at == len(chain.springs_n_m_rad)
        spring = 0.0 if last else float(chain.springs_n_m_rad[at])
        twist = None if last or spring == 0.0 else torque / spring
        rows.append(
            HolzerRow(
                inertia_kg_m2=float(inertia),
                angle_rad=_finite(angle),
                inertia_torque_n_m=_finite(own),
                torque_n_m=_finite(torque),
                twist_rad=_finite(twist),
            )
        )
        angle -= twist or 0.0
    return rows


def _finite(value: float | None) -> float | None:
    return value if value is not None and np.isfinite(value) else None


@dataclass(frozen=True, eq=False)
class TorsionResponse:
    """Peak amplitudes as complex numbers: angles (speeds, n), torques between neighbours (speeds, n − 1)."""

    angles_rad: Complex
    torques_n_m: Complex


def torsion_response(
    chain: TorsionChain,
    frequencies_rad_s: Array,
    torques_n_m: Complex,
    added_kg_m2: Sequence[tuple[int, float]] = (),
) -> TorsionResponse:
    """Return the steady response to torques at the stations.

    Parameters
    ----------
    chain : TorsionChain
    frequencies_rad_s : (k,) float
        Of the torques [rad/s].
    torques_n_m : (k, n) complex
        T cos(ωt + φ) as T exp(iφ).
    added_kg_m2 : sequence of (station from 0, inertia)
        Equivalent inertias of pendulums at this order; infinite where tuned to it: the station is
        still. Below zero the pendulum swings against it.

    Notes
    -----
    The torque between two stations is what spring and damper carry together, (k + iωc) times the twist. An
    undamped resonance gives NaN.
    """
    count = len(chain.inertias_kg_m2)
    inertia = chain.inertias_kg_m2.copy()
    still = [at for at, value in added_kg_m2 if not np.isfinite(value)]
    for at, value in added_kg_m2:
        inertia[at] += value if np.isfinite(value) else 0.0
    free = np.setdiff1d(np.arange(count), still)
    omega = np.asarray(frequencies_rad_s)[:, None, None]
    dynamic = chain.stiffness() + 1j * omega * chain.damping() - omega**2 * np.diag(inertia)
    angles = np.zeros((len(frequencies_rad_s), count), dtype=complex)
    for row, matrix in enumerate(dynamic[:, free[:, None], free[None, :]]):
        try:
            angles[row, free] = np.linalg.solve(matrix, torques_n_m[row, free])
        except np.linalg.LinAlgError:
            angles[row] = np.nan
    carried = chain.springs_n_m_rad + 1j * omega[:, 0] * chain.across_n_m_s
    return TorsionResponse(angles, np.asarray(carried * (angles[:, 1:] - angles[:, :-1])))


def shear_stress_pa(torque_n_m: Array, diameter_m: float) -> Array:
    """Return the nominal shear stress at the surface of a round shaft, 16 T/(π D³) [Pa].

    Examples
    --------
    >>> round(float(shear_stress_pa(np.array(100.0), 0.03)) / 1e6, 3)
    18.863
    """
    return np.asarray(16.0 * torque_n_m / (np.pi * diameter_m**3))


def pendulum_inertia_kg_m2(mass_kg: float, distance_m: float, tuned_order: float, order: float) -> float:
    """Return the equivalent inertia of a pendulum in small swing at an order of the speed.

    m (R + L)²/(1 − n² L/R) with L = R/tuned²: infinite at the order it is tuned to [1]_.

    References
    ----------
    .. [1] J. P. Den Hartog, Mechanical Vibrations, 4th ed. 1956, section 5.9.

    Examples
    --------
    >>> pendulum_inertia_kg_m2(1.0, 0.08, 2.0, 0.0)
    0.010000000000000002
    """
    length = distance_m / tuned_order**2
    whole = mass_kg * (distance_m + length) ** 2
    rest = 1.0 - (order / tuned_order) ** 2
    return np.inf if abs(rest) < 1e-12 else whole / rest


# A crank as a torsional chain: the stiffness of its throws by two published formulas, inertias by station.
#
# Stations are the first main journal (with a damper), every throw, the last main journal (with a flywheel).
# A throw is elastic from the middle of the journal before it to the middle of the journal after it, and its
# inertia is in its middle: between two stations lie two half throws.


MIN_EQUIVALENT_LENGTH = 1e-12
"""Smallest Le [1/mm³]: that of a solid shaft of 1 m diameter and 1 mm length."""


@dataclass(frozen=True)
class ThrowShape:
    """Dimensions of a throw for its stiffness, all mm; bores 0 where solid.

    ``journal_length_mm`` is that of one whole main journal between webs: half of each of its neighbours';
    ``pin_length_mm`` that of the crankpin between webs. ``web_breadth_mm`` is across the throw.
    """

    journal_mm: Positive
    journal_bore_mm: NotNegative
    journal_length_mm: NotNegative
    pin_mm: Annotated[Positive, Named("crankpin_mm")]
    pin_bore_mm: Annotated[NotNegative, Named("crankpin_bore_mm")]
    pin_length_mm: Annotated[NotNegative, Named("crankpin_length_mm")]
    crank_radius_mm: Positive
    web_thickness_mm: Positive
    web_breadth_mm: Positive

    @property
    def _journal4(self) -> float:
        return self.journal_mm**4 - self.journal_bore_mm**4

    @property
    def _pin4(self) -> float:
        return self.pin_mm**4 - self.pin_bore_mm**4

    @property
    def _web4(self) -> float:
        return self.web_thickness_mm * self.web_breadth_mm**3

    def ker_wilson_per_mm3(self) -> float:
        """Return Ker Wilson's equivalent length over D⁴ of a shaft as stiff as the throw [1/mm³].

        Examples
        --------
        >>> throw = ThrowShape(60, 0, 40, 50, 0, 30, 45, 20, 90)
        >>> round(math.pi * 80e3 / (32 * throw.ker_wilson_per_mm3()) / 1e3)
        541065
        """
        return (
            (self.journal_length_mm + 0.4 * self.journal_mm) / self._journal4
            + (self.pin_length_mm + 0.4 * self.pin_mm) / self._pin4
            + (self.crank_radius_mm - 0.2 * (self.journal_mm + self.pin_mm)) / self._web4
        )

    def carter_per_mm3(self) -> float:
        """Return Carter's equivalent length over D⁴ of a shaft as stiff as the throw [1/mm³]."""
        return (
            (self.journal_length_mm + 0.8 * self.web_thickness_mm) / self._journal4
            + 0.75 * self.pin_length_mm / self._pin4
            + 1.5 * self.crank_radius_mm / self._web4
        )


def throw_stiffness_n_m_rad(length_per_mm3: float, shear_modulus_mpa: float) -> float:
    """Return k = π G/(32 Le) of a throw [N·m/rad].

    Parameters
    ----------
    length_per_mm3 : float
        Le, the equivalent length over the fourth power of its diameter [1/mm³].
    shear_modulus_mpa : float
        G [MPa].

    References
    ----------
    W. Ker Wilson, Practical Solution of Torsional Vibration Problems, vol. 1; B. C. Carter, Engineering 126
    (1928) 36. Both are fits to measured crankshafts, right to some 10 to 20 %.

    Raises
    ------
    ValueError
        If the length is not positive: the webs are so broad that the formula does not hold.
    """
    if not length_per_mm3 > MIN_EQUIVALENT_LENGTH:
        raise ValueError("the formula gives a throw without torsional flexibility")
    return math.pi * shear_modulus_mpa / (32.0 * length_per_mm3) * 1e-3


def springs_between(throws_n_m_rad: Sequence[float]) -> Array:
    """Return the springs (throws + 1,) between first main, throws and last main."""
    half = 0.5 / np.asarray(throws_n_m_rad)
    ends = np.concatenate([[0.0], half, [0.0]])
    return np.asarray(1.0 / (ends[:-1] + ends[1:]))
