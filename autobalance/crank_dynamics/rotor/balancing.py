"""Modal balancing of rotors with flexible behaviour, and the procedures of ISO 21940-12."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

import numpy as np

from autobalance.crank_dynamics.rotor.critical_speeds import EQUAL_SPEED_SHARE, CriticalSpeed
from autobalance.crank_dynamics.rotor.matrices import ReducedRotor
from autobalance.crank_dynamics.rotor.whirl_modes import phase_rad, place_m
from autobalance.declare import G_MM, Count, Degrees, Mm, Named, NotNegative, record
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Procedures of ISO 21940-12 for rotors with flexible behaviour, and the choice among them for a rotor.


RIGID_BELOW = 0.7
"""Largest ratio of service speed to first critical speed of a rotor usually taken as rigid."""


@dataclass(frozen=True)
class Procedure:
    """A procedure with its letter in ISO 21940-12, table 1 (formerly ISO 11342)."""

    letter: str
    name: str


PROCEDURES = (
    Procedure("A", "single-plane balancing"),
    Procedure("B", "two-plane balancing"),
    Procedure("C", "individual component balancing prior to assembly"),
    Procedure("D", "balancing subsequent to controlling initial unbalance"),
    Procedure("E", "balancing in stages during assembly"),
    Procedure("F", "balancing in optimum planes"),
    Procedure("G", "multiple speed balancing"),
    Procedure("H", "service speed balancing"),
    Procedure("I", "fixed speed balancing"),
)


@dataclass(frozen=True)
class BalancingAdvice:
    """The balancing procedures that fit the service speed."""

    behaviour: str
    reason: str
    planes: Count
    standard: Literal["ISO 21940-12"]
    procedures: tuple[Procedure, ...]


def advice(service_speed_rad_s: float, criticals: Sequence[CriticalSpeed]) -> BalancingAdvice:
    """Return the procedures that fit a service speed, and the planes of modal balancing (N + 2).

    Only critical speeds driven by unbalance count: those of forward whirl or of motion in a plane.
    """
    driven = [each.speed_rad_s for each in criticals if each.whirl in ("forward", None, "mixed")]
    if not driven or service_speed_rad_s <= RIGID_BELOW * driven[0]:
        reason = f"the service speed is at most {100 * RIGID_BELOW:.0f} % of the first critical speed"
        if not driven:
            reason = "no critical speed that unbalance drives was found"
        return _advice("rigid", reason, 2, "AB")
    passed = sum(1 for each in driven if each <= service_speed_rad_s)
    near = max(1, passed)
    planes = near + 2
    if not passed:
        reason = "the service speed is near the first critical speed, below it"
        return _advice("flexible, one mode", reason, planes, "CDEFH")
    reason = (
        f"the rotor passes {passed} critical speed{'s' if passed > 1 else ''} on its way to service speed"
    )
    return _advice("flexible", reason, planes, "G" if passed > 1 else "FG")


def _advice(behaviour: str, reason: str, planes: int, letters: str) -> BalancingAdvice:
    procedures = tuple(each for each in PROCEDURES if each.letter in letters)
    return BalancingAdvice(behaviour, reason, planes, "ISO 21940-12", procedures)


# Modal balancing: unbalances in a few planes that remove the excitation of the lowest modes.
#
# An unbalance U(z) excites a planar mode φ by ∫ φ U dz. N planes balance N modes and, as a balanced mode
# stays so, later modes keep the earlier ones balanced [1]_. With two planes more
# resultant and moment vanish as well, so that the bearings of a slow rotor feel nothing (N + 2) [2]_.
#
# References
# ----------
# .. [1] R. E. D. Bishop, G. M. L. Gladwell, The vibration and balancing of an unbalanced flexible rotor,
#    J. Mech. Eng. Sci. 1 (1959) 66.
# .. [2] W. Kellenberger, Should a flexible rotor be balanced in N or (N + 2) planes?,
#    J. Eng. Ind. 94 (1972) 548.


MIN_SINGULAR_VALUE_RATIO = 1e-9
"""Smallest over largest singular value below which the planes cannot balance the modes."""


@record
class AddedUnbalance:
    """The unbalance to add in a plane."""

    z_m: Mm
    kg_m: Annotated[NotNegative, G_MM, Named("g_mm")]
    angle_rad: Degrees

    @classmethod
    def of(cls, z_m: float, phasor_kg_m: complex) -> Self:
        return cls(z_m=place_m(z_m), kg_m=abs(phasor_kg_m), angle_rad=phase_rad(phasor_kg_m))


def modal_shapes(reduced: ReducedRotor, count: int) -> tuple[Array, Complex]:
    """Return frequencies [rad/s] and shapes (count, n) of the lowest undamped planar modes at rest.

    A shape is complex, φx − iφy over a plane's unknowns: its product with a complex unbalance is the mode's
    excitation. The two modes of a plane pair have one shape and count once.
    """
    stiffness = reduced.stiffness(0.0)
    stiffness = 0.5 * (stiffness + stiffness.T)
    if reduced.planes_apart(stiffness, stiffness):
        energy, vectors = [], []
        for plane in (0, 1):
            own, modes = np.linalg.eigh(stiffness[plane::2, plane::2])
            whole = np.zeros((len(stiffness), len(own)))
            whole[plane::2] = modes
            energy.append(own)
            vectors.append(whole)
        square, shapes = np.concatenate(energy), np.hstack(vectors)
    else:
        square, shapes = np.linalg.eigh(stiffness)
    order = np.argsort(square, kind="stable")[reduced.rigid_body_modes :]
    elastic_modes: list[tuple[float, Complex]] = []
    for at in order:
        shape: Complex = (reduced.basis @ (shapes[0::2, at] - 1j * shapes[1::2, at])).astype(complex)
        if len(elastic_modes) < count and not any(
            _same(float(square[at]), shape, each) for each in elastic_modes[-2:]
        ):
            elastic_modes.append((float(square[at]), shape))
    if elastic_modes and elastic_modes[0][0] < 0.0:
        raise ValueError("the bearings let the shaft fly off at rest: it has no modes")
    return np.sqrt([each for each, _ in elastic_modes]), np.array([shape for _, shape in elastic_modes])


def _same(square: float, shape: Complex, other: tuple[float, Complex]) -> bool:
    """Return whether two modes are the same motion in two planes."""
    alike = abs(np.vdot(shape, other[1])) / (np.linalg.norm(shape) * np.linalg.norm(other[1]))
    return bool(abs(square / other[0] - 1.0) <= 1e3 * EQUAL_SPEED_SHARE and alike > 1.0 - 1e-6)


def modal_correction(
    reduced: ReducedRotor,
    planes_m: Sequence[float],
    modes: int,
    rigid: bool,
    unbalances: Sequence[tuple[float, complex]],
) -> Complex:
    """Return the unbalances (planes,) to add [kg m as complex numbers].

    Parameters
    ----------
    reduced : ReducedRotor
        Reduced rotor with a node at each plane.
    planes_m : sequence of float
        Correction planes [m].
    modes : int
        Number of the lowest planar modes to balance.
    rigid : bool
        Whether resultant and moment shall vanish too (N + 2 planes).
    unbalances : sequence of (z [m], kg m as a complex number)
        Present unbalances.

    Raises
    ------
    ValueError
        If the planes are too few, or lie where they cannot reach the modes. With more planes than
        necessary the least correction (sum of squares) is returned.
    """
    least_planes = modes + (2 if rigid else 0)
    if len(planes_m) < least_planes:
        what = f"{modes} mode{'s' if modes > 1 else ''}" + (" with resultant and moment" if rigid else "")
        raise ValueError(f"{len(planes_m)} planes given; {what} need {least_planes}")
    there = np.array([z for z, _ in unbalances])
    amount = np.array([phasor for _, phasor in unbalances], dtype=complex)
    at_planes = _conditions(reduced, np.array(planes_m), modes, rigid)
    at_unbalances = _conditions(reduced, there, modes, rigid)
    scale = np.linalg.norm(at_planes, axis=1, keepdims=True)
    if not (scale > 0.0).all():
        raise ValueError("the planes lie in nodes of a mode and cannot reach it")
    strength = np.linalg.svd(at_planes / scale, compute_uv=False)
    if strength[-1] < MIN_SINGULAR_VALUE_RATIO * strength[0]:
        raise ValueError("the planes cannot reach the modes one by one: two lie together, or all in nodes")
    correction, *_ = np.linalg.lstsq(at_planes / scale, -(at_unbalances @ amount) / scale[:, 0], rcond=None)
    return np.asarray(correction)


def _conditions(reduced: ReducedRotor, z_m: Array, modes: int, rigid: bool) -> Complex:
    """Return the excitation (conditions, k) of each condition by a unit unbalance at each place."""
    matrices = reduced.matrices
    _, shapes = modal_shapes(reduced, modes)
    at = np.array([matrices.deflection_at[matrices.node_at(z)] for z in z_m], dtype=int)
    rows = np.where(at >= 0, shapes[:, at], 0.0) if len(at) else np.zeros((len(shapes), 0))
    if not rigid:
        return np.asarray(rows, dtype=complex)
    arms = z_m / matrices.rotor.length_m
    return np.vstack([rows, np.ones_like(arms), arms]).astype(complex)
