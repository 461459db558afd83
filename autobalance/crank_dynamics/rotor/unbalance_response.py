"""Steady response of a rotor to its unbalance, and its sag under gravity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Self

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError, solve_banded
from scipy.sparse.linalg import splu

from autobalance.crank_dynamics.rotor.matrices import RotorMatrices
from autobalance.crank_dynamics.rotor.phasors import phase_rad, place_m
from autobalance.crank_dynamics.rotor.reduction import rigid_body_modes
from autobalance.declare import UM, Degrees, Mm, Newtons, NotNegative, Rpm, Um, record
from autobalance.types import Array, Complex


@record
class OrbitPoint:
    """The orbit of a place at a speed; None if it has no steady response.

    x = ``x_m`` cos(Ωt + ``x_phase_rad``), likewise y. Half the ellipse's axes: ``major_m``, and ``minor_m``,
    negative where the orbit runs backward.
    """

    speed_rad_s: Rpm
    x_m: Annotated[NotNegative, UM] | None = None
    x_phase_rad: Degrees | None = None
    y_m: Annotated[NotNegative, UM] | None = None
    y_phase_rad: Degrees | None = None
    major_m: Annotated[NotNegative, UM] | None = None
    minor_m: Um | None = None

    @classmethod
    def of(cls, speed_rad_s: float, x_m: complex, y_m: complex) -> Self:
        """Return the orbit x = Re(x_m exp iΩt), likewise y."""
        if not np.isfinite([x_m, y_m]).all():
            return cls(speed_rad_s=speed_rad_s)
        forward, backward = abs(x_m + 1j * y_m), abs(x_m - 1j * y_m)
        return cls(
            speed_rad_s=speed_rad_s,
            x_m=abs(x_m),
            x_phase_rad=phase_rad(x_m),
            y_m=abs(y_m),
            y_phase_rad=phase_rad(y_m),
            major_m=0.5 * (forward + backward),
            minor_m=0.5 * (forward - backward),
        )


@record
class Response:
    """The orbits of a probe over the speeds."""

    z_m: Mm
    points: Sequence[OrbitPoint]

    @property
    def greatest(self) -> OrbitPoint | None:
        """The orbit with the longest axis; None if there is no steady response."""
        known = [point for point in self.points if point.major_m is not None]
        return max(known, key=lambda point: point.major_m or 0.0, default=None)


def unbalance_response(
    matrices: RotorMatrices,
    speeds_rad_s: Array,
    places_m: Sequence[float],
    unbalances: Sequence[tuple[float, complex]] | None = None,
) -> list[Response]:
    """Return the steady orbits under unbalances, at each place.

    Parameters
    ----------
    matrices : RotorMatrices
    speeds_rad_s : (k,) float
        [rad/s].
    places_m : sequence of float
        Stations of the matrices [m].
    unbalances : sequence of (z [m], kg m as a complex number), optional
        Default: the rotor's own.
    """
    if unbalances is None:
        unbalances = [(each.z_m, each.phasor_kg_m) for each in matrices.rotor.unbalances]
    load = matrices.unbalance_phasor(list(unbalances))
    at = np.array([matrices.deflection_at[matrices.node_at(z)] for z in places_m], dtype=int)
    band = _Band(matrices)
    deflections = np.zeros((len(speeds_rad_s), 2, len(at)), dtype=complex)
    for row, speed in enumerate(speeds_rad_s):
        try:
            answer = band.solve(float(speed), speed**2 * load)
        except LinAlgError:  # an undamped rotor exactly on its critical speed
            answer = np.full(len(load), np.nan, dtype=complex)
        for plane in (0, 1):
            deflections[row, plane] = np.where(at >= 0, answer[2 * at + plane], 0.0)
    return [
        Response(
            z_m=place_m(z),
            points=[
                OrbitPoint.of(float(speed), complex(x), complex(y))
                for speed, (x, y) in zip(speeds_rad_s, deflections[:, :, at_place], strict=True)
            ],
        )
        for at_place, z in enumerate(places_m)
    ]


class _Band:
    """The dynamic stiffness K + iΩC − Ω²M, stored by diagonals."""

    def __init__(self, matrices: RotorMatrices) -> None:
        self.matrices = matrices
        parts = [matrices.mass, matrices.gyroscopic, matrices.shaft_stiffness]
        self.width = max(1, *(int(np.abs(np.subtract(*each.nonzero())).max(initial=0)) for each in parts))
        self.mass, self.gyroscopic, self.stiffness = (self._diagonals(each) for each in parts)
        self.constant = matrices.rotor.constant_bearings
        self.springs = self._diagonals(matrices.bearing_stiffness(0.0))
        self.dampers = self._diagonals(matrices.bearing_damping(0.0))

    def _diagonals(self, matrix: sparse.csc_matrix) -> Array:
        entries = matrix.tocoo()
        stored = np.zeros((2 * self.width + 1, matrix.shape[1]))
        stored[self.width + entries.row - entries.col, entries.col] = entries.data
        return stored

    def solve(self, speed_rad_s: float, load: Complex) -> Complex:
        springs, dampers = self.springs, self.dampers
        if not self.constant:
            springs = self._diagonals(self.matrices.bearing_stiffness(speed_rad_s))
            dampers = self._diagonals(self.matrices.bearing_damping(speed_rad_s))
        real = self.stiffness + springs - speed_rad_s**2 * self.mass
        imaginary = speed_rad_s * (speed_rad_s * self.gyroscopic + dampers)
        bands = (self.width, self.width)
        answer: Complex = solve_banded(
            bands, real + 1j * imaginary, load, overwrite_ab=True, check_finite=False
        )
        return answer


@record
class Deflection:
    """Deflection of the rotor by gravity at a place."""

    z_m: Mm
    x_m: Um
    y_m: Um


@record
class Reaction:
    """A bearing's force on the shaft under gravity; None if nothing holds it."""

    z_m: Mm
    x_n: Newtons | None
    y_n: Newtons | None


@record
class Static:
    """The rotor under gravity."""

    deflections: Sequence[Deflection]
    reactions: Sequence[Reaction]


def sag(matrices: RotorMatrices, speed_rad_s: float) -> Static:
    """Return the sag under the rotor's gravity; without deflections if nothing holds the rotor against it.

    The stiffness of bearings is that at ``speed_rad_s``. The weight acts along the shaft, exactly.
    """
    rotor = matrices.rotor
    gravity = np.array(rotor.gravity_m_s2)
    bearings = len(rotor.bearings)
    if not gravity.any():
        return _static(matrices, np.zeros((len(matrices.shape_z_m), 2)), np.zeros((bearings, 2)))
    if rigid_body_modes(matrices):
        free = [Reaction(z_m=place_m(each.z_m), x_n=None, y_n=None) for each in rotor.bearings]
        return Static(deflections=(), reactions=free)
    weight = np.outer(matrices.load_1, gravity)
    answer = splu(matrices.stiffness(speed_rad_s)).solve(weight.ravel()).reshape(-1, 2)
    whole = np.zeros((len(matrices.full_load_1), 2))
    whole[matrices.free] = answer
    held = matrices.full_stiffness_1 @ whole - np.outer(matrices.full_load_1, gravity)
    reactions = np.zeros((bearings, 2))
    for row, bearing in enumerate(rotor.bearings):
        node = matrices.node_at(bearing.z_m)
        if bearing.constraint is not None:
            reactions[row] = held[matrices.first_unknown[node]]
        elif matrices.deflection_at[node] >= 0:
            reactions[row] = -bearing.stiffness_at(speed_rad_s) @ answer[matrices.deflection_at[node]]
    return _static(matrices, np.asarray(matrices.shape @ answer), reactions)


def _static(matrices: RotorMatrices, deflections_m: Array, reactions_n: Array) -> Static:
    """Return deflections (m, 2) along the rotor and the forces (b, 2) of its bearings."""
    return Static(
        deflections=[
            Deflection(z_m=place_m(z), x_m=float(x), y_m=float(y))
            for z, (x, y) in zip(matrices.shape_z_m, deflections_m, strict=True)
        ],
        reactions=[
            Reaction(z_m=place_m(each.z_m), x_n=float(x), y_n=float(y))
            for each, (x, y) in zip(matrices.rotor.bearings, reactions_n, strict=True)
        ],
    )
