"""Pressure of an oil film: Reynolds' equation in a finite and in a short bearing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csc_array, diags_array, kron
from scipy.sparse.linalg import SuperLU, splu

from autobalance.engines.bearings.film import Boundary, FilmModel, Pressure, UnitFilm
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Reynolds' equation of a plain bearing of any length, on a grid of finite volumes.
#
# Around, the cells are equal in Sommerfeld's angle γ, 1 + ε cos θ = (1 − ε²)/(1 − ε cos γ), which gathers
# them where the film is thin. A few dozen cells resolve a film of 1 % of the clearance. Along, half the
# length is enough, and the cells are equal in s, Z = z/(L/2) = sin(π s/2), which gathers them at the open
# end. The pressure is in units of 6 η Ω (R/c)², with g = dθ/dγ and λ = L/D,
#
#     ∂γ(H³/g ∂γP) + g/λ² H³ ∂²P/∂Z² = ∂γH + 2 g ∂H/∂t/Ω.


Flags = npt.NDArray[np.bool_]
PRESSURE_UNIT = 6.0
"""The pressure here in units of η Ω (R/c)²."""
ACTIVE_SET_STEPS = 100


def reynolds(
    slenderness: float, boundary: Boundary = "reynolds", grid: tuple[int, int] = (120, 40)
) -> FilmModel:
    """Return the film of a finite bearing as a function of the eccentricity ratio.

    The error falls with the square of the cells' size.

    Parameters
    ----------
    slenderness : float
        Length over diameter, positive.
    boundary : {"half", "reynolds", "full"}
        How the film ends.
    grid : (int, int)
        Cells around and along, at least 8 and 4.
    """

    def film(ratio: float) -> UnitFilm:
        return _solve(_Grid.of(ratio, slenderness, grid), boundary)

    return film


@dataclass(frozen=True, eq=False)
class _Grid:
    """The film's geometry at the nodes, and the matrix of minus Reynolds' left side."""

    ratio: float
    slenderness: float
    angle: Array
    """θ at the nodes (n,)."""
    metric: Array
    """dθ/dγ at the nodes (n,)."""
    face_angle: Array
    """θ half a cell on from each node (n,)."""
    face_metric: Array
    step: float
    """Step in γ [rad]."""
    place: Array
    """Z of the nodes inside (m,)."""
    cell: Array
    """Length along of the nodes' cells (m,)."""
    weight: Array
    """Weights of the nodes in an integral over half the length (m,)."""

    @classmethod
    def of(cls, ratio: float, slenderness: float, grid: tuple[int, int]) -> _Grid:
        around, along = grid
        step = 2.0 * np.pi / around
        gamma = step * np.arange(around, dtype=np.float64)
        middle = along % 2 == 0  # a node in the middle plane; else it lies between two
        stretched = (np.arange(along // 2) + (0.0 if middle else 0.5)) * np.pi / along
        place = np.sin(stretched)
        edges = 0.5 * (place + np.append(place[1:], 1.0))
        weight = np.cos(stretched) * np.pi / along
        weight[0] *= 0.5 if middle else 1.0
        return cls(
            ratio,
            slenderness,
            *_sommerfeld(gamma, ratio),
            *_sommerfeld(gamma + 0.5 * step, ratio),
            step,
            place,
            np.diff(edges, prepend=0.0),
            weight,
        )

    def matrix(self, at_faces: Array, at_nodes: Array) -> csc_array:
        """Return minus the left side for any film power: H³, or its change; unknowns (n m,), angle first."""
        flow = at_faces / self.face_metric / self.step
        before = np.roll(flow, 1)
        n = len(self.angle)
        here = np.arange(n)
        places = np.concatenate([here, here, here]), np.concatenate([here, (here + 1) % n, here - 1])
        places[1][places[1] < 0] += n
        around = coo_array((np.concatenate([flow + before, -flow, -before]), places), shape=(n, n))
        between = 1.0 / np.diff(self.place, append=1.0)
        beside = (-between[:-1]).tolist()
        diagonal = (between + np.append(0.0, between[:-1])).tolist()
        along = diags_array([beside, diagonal, beside], offsets=[-1, 0, 1])
        cross = at_nodes * self.metric * self.step / self.slenderness**2
        return csc_array(
            kron(around, diags_array(self.cell)) + kron(diags_array(cross), along), dtype=np.float64
        )

    def source(self, around: Array) -> Array:
        """Return minus a source by angle, spread over a cell of γ and along the length."""
        return np.outer(-around, self.cell).ravel()

    def wedge(self, film_at_faces: Array) -> Array:
        """Return the change of the film over each cell."""
        return np.asarray(film_at_faces - np.roll(film_at_faces, 1))

    def by_angle(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return values of the unknowns (n m,) as (n, m)."""
        return values.reshape(len(self.angle), len(self.place))

    def force(self, pressure: Array) -> tuple[float, float]:
        """Return the radial and tangential force on the journal of pressures (n, m)."""
        lines = pressure @ self.weight * self.metric * self.step * PRESSURE_UNIT
        return float(lines @ np.cos(self.angle)), float(lines @ np.sin(self.angle))

    def side_flow(self, pressure: Array) -> float:
        """Return the flow out of both ends in units of Ω R L c, if there is pressure."""
        last, before = 1.0 - self.place[-1], 1.0 - self.place[-2]
        slope = pressure[:, -1] * before / last - pressure[:, -2] * last / before
        slope /= before - last
        out = np.where(pressure[:, -1] > 0.0, (1.0 + self.ratio * np.cos(self.angle)) ** 3 * slope, 0.0)
        return float(out @ self.metric) * self.step / (2.0 * self.slenderness**2)

    def middle(self, pressure: Array) -> Array:
        """Return the pressure (n,) in the middle plane."""
        first, second = self.place[:2] ** 2
        return np.asarray((pressure[:, 0] * second - pressure[:, 1] * first) / (second - first))


def _sommerfeld(gamma: Array, ratio: float) -> tuple[Array, Array]:
    """Return θ and dθ/dγ of Sommerfeld's angle γ."""
    rest = 1.0 - ratio * np.cos(gamma)
    root = np.sqrt(1.0 - ratio**2)
    angle = np.arctan2(root * np.sin(gamma), np.cos(gamma) - ratio)
    return np.mod(angle, 2.0 * np.pi), root / rest


def _solve(grid: _Grid, boundary: Boundary) -> UnitFilm:
    cos_faces, cos_nodes = np.cos(grid.face_angle), np.cos(grid.angle)
    faces, nodes = 1.0 + grid.ratio * cos_faces, 1.0 + grid.ratio * cos_nodes
    film = _Solution.of(grid, grid.matrix(faces**3, nodes**3), grid.source(grid.wedge(faces)), boundary)
    thicker = grid.matrix(3.0 * faces**2 * cos_faces, 3.0 * nodes**2 * cos_nodes)
    slope, squeeze = film.changes(
        grid.source(grid.wedge(cos_faces)) - thicker @ film.solved,
        grid.source(2.0 * cos_nodes * grid.metric * grid.step),
    )
    radial, tangential = grid.force(film.pressure)
    radial_slope, tangential_slope = grid.force(slope)
    radial_squeeze, tangential_squeeze = grid.force(squeeze)
    return UnitFilm(
        grid.ratio,
        radial,
        tangential,
        radial_slope,
        tangential_slope,
        radial_squeeze,
        tangential_squeeze,
        grid.side_flow(film.pressure),
        _greatest(grid, film.pressure) * PRESSURE_UNIT,
        Pressure(grid.angle, grid.place, film.pressure * PRESSURE_UNIT),
    )


@dataclass(frozen=True, eq=False)
class _Solution:
    """The film's pressure, and the equation of its small changes."""

    grid: _Grid
    matrix: csc_array
    solved: Array
    """Pressures (n m,) before any are cut."""
    pressure: Array
    """Pressures that count (n, m)."""
    free: Flags
    """Whether the equation holds at a node (n m,)."""
    cover: Array
    """Share of each node's cell whose pressure counts (n, m)."""

    @classmethod
    def of(cls, grid: _Grid, matrix: csc_array, right: Array, boundary: Boundary) -> _Solution:
        if boundary == "reynolds":
            pressure, free = _obstacle(matrix, right, _first_guess(grid))
            matrix = csc_array(matrix + diags_array(_edges(grid, pressure, free, right)))
            return cls(grid, matrix, pressure, grid.by_angle(pressure), free, grid.by_angle(free * 1.0))
        full = _factor(matrix).solve(right)
        everywhere, field = np.ones(len(right), dtype=bool), grid.by_angle(full)
        if boundary == "full":
            return cls(grid, matrix, full, field, everywhere, np.ones(field.shape))
        return cls(grid, matrix, full, np.maximum(field, 0.0), everywhere, _positive_share(field))

    def changes(self, *rights: Array) -> tuple[Array, ...]:
        """Return the pressure's change (n, m) for each change of the right side, on the same film."""
        solver = _factor(self.matrix[self.free][:, self.free])
        changes = np.zeros((len(rights), len(self.free)))
        changes[:, self.free] = [solver.solve(right[self.free]) for right in rights]
        return tuple(self.grid.by_angle(change) * self.cover for change in changes)


def _positive_share(pressure: Array) -> Array:
    """Return the share of each node's cell in which pressures (n, m), linear between nodes, are positive."""
    share = np.zeros(pressure.shape)
    for neighbour in (np.roll(pressure, -1, axis=0), np.roll(pressure, 1, axis=0)):
        rise = np.abs(pressure - neighbour)
        crossing = np.where(
            (pressure * neighbour <= 0.0) & (rise > 0.0),
            np.abs(pressure) / np.where(rise > 0.0, rise, 1.0),
            1.0,
        )
        inside = np.minimum(2.0 * crossing, 1.0)
        share += 0.5 * np.where(pressure > 0.0, inside, 1.0 - inside)
        both_out = (pressure <= 0.0) & (neighbour <= 0.0)
        share -= 0.5 * np.where(both_out, 1.0 - inside, 0.0)
    return share


def _edges(grid: _Grid, pressure: Array, free: Flags, right: Array) -> Array:
    """Return the addition to the diagonal where the film ends between two nodes of the angle.

    The pressure ends as a parabola, ½ s d²/a; so the distance d to the edge, where changes of the pressure
    vanish, follows from the last pressure and is not a whole cell.
    """
    inside, last = grid.by_angle(free), grid.by_angle(pressure)
    flow = (1.0 + grid.ratio * np.cos(grid.face_angle)) ** 3 / grid.face_metric / grid.step
    source = -grid.by_angle(right) / grid.cell
    gain = np.zeros(last.shape)
    for shift, face in ((-1, flow), (1, np.roll(flow, 1))):
        ends = inside & ~np.roll(inside, shift, axis=0) & (source > 0.0)
        cells = np.sqrt(2.0 * face[:, None] * last / np.where(ends, source, 1.0))
        share = 1.0 / np.clip(cells, 0.1, 2.0) - 1.0
        gain += np.where(ends, face[:, None] * share, 0.0) * grid.cell
    return gain.ravel()


def _factor(matrix: csc_array) -> SuperLU:
    return splu(
        csc_array(matrix),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


def _first_guess(grid: _Grid) -> Flags:
    """Return the half film and a little more: too long a film shrinks faster than a short one grows."""
    around = len(grid.angle)
    place = np.arange(around)
    more = around // 10
    inside = (place <= around // 2 + more) | (place >= around - more)
    return np.repeat(inside, len(grid.place))


def _obstacle(matrix: csc_array, right: Array, free: Flags) -> tuple[Array, Flags]:
    """Return p ≥ 0 with A p ≥ b and one of both equal everywhere, and where p > 0, by active sets."""
    for _ in range(ACTIVE_SET_STEPS):
        pressure = np.zeros(len(right))
        pressure[free] = _factor(matrix[free][:, free]).solve(right[free])
        now = np.where(free, pressure > 0.0, matrix @ pressure < right)
        if np.array_equal(now, free):
            break
        free = now  # rounding may let a cell of no pressure come and go: the last set is as good
    return np.maximum(pressure, 0.0), free


def _greatest(grid: _Grid, pressure: Array) -> float:
    """Return the largest pressure in the middle of the length, by a parabola through the highest nodes."""
    middle = grid.middle(pressure)
    top = int(np.argmax(middle))
    before, at, after = middle[top - 1], middle[top], middle[(top + 1) % len(middle)]
    bend = before - 2.0 * at + after
    return float(at - (after - before) ** 2 / (8.0 * bend)) if bend < 0.0 else float(at)


# Ocvirk's short bearing: the film's pressure by closed form, parabolic along the bearing.
#
# The half film from the widest gap to the narrowest one carries, however the journal moves.


POINTS = (121, 21)
"""Number of points of the pressure that is kept for plots."""


def ocvirk(slenderness: float) -> FilmModel:
    """Return the film of a short bearing as a function of the eccentricity ratio.

    Radial force −4 λ² ε²/(1 − ε²)², tangential λ² π ε/(1 − ε²)^1.5, with λ = L/D. The load's Sommerfeld
    number is S λ² = (1 − ε²)²/(π ε √(π² (1 − ε²) + 16 ε²)). Its attitude is tan φ = π √(1 − ε²)/(4 ε).

    Parameters
    ----------
    slenderness : float
        Length over diameter, positive.

    References
    ----------
    .. [1] F. W. Ocvirk, Short-bearing approximation for full journal bearings, NACA TN 2808 (1952).

    Examples
    --------
    >>> film = ocvirk(0.25)(0.4)
    >>> round(film.sommerfeld * 0.25**2, 5), round(math.degrees(film.attitude_rad), 2)
    (0.17046, 60.94)
    """

    def film(ratio: float) -> UnitFilm:
        short = 4.0 * slenderness**2
        rest = 1.0 - ratio**2
        pressure = _pressure(ratio, slenderness)
        return UnitFilm(
            ratio,
            radial=-short * ratio**2 / rest**2,
            tangential=short * math.pi * ratio / (4.0 * rest**1.5),
            radial_slope=-short * 2.0 * ratio * (1.0 + ratio**2) / rest**3,
            tangential_slope=short * math.pi * (1.0 + 2.0 * ratio**2) / (4.0 * rest**2.5),
            radial_squeeze=-short * math.pi * (1.0 + 2.0 * ratio**2) / (2.0 * rest**2.5),
            tangential_squeeze=short * 2.0 * ratio / rest**2,
            side_flow=ratio,
            greatest_pressure=_greatest_of_short(ratio, slenderness),
            pressure=pressure,
        )

    return film


def _greatest_of_short(ratio: float, slenderness: float) -> float:
    """Return the largest pressure, at cos θ = (1 − √(1 + 24 ε²))/(4 ε) in the middle of the length."""
    cosine = -6.0 * ratio / (1.0 + math.sqrt(1.0 + 24.0 * ratio**2))
    sine = math.sqrt(1.0 - cosine**2)
    return 3.0 * slenderness**2 * ratio * sine / (1.0 + ratio * cosine) ** 3


def _pressure(ratio: float, slenderness: float) -> Pressure:
    around, along = POINTS
    angle, place = np.linspace(0.0, 2.0 * np.pi, around), np.linspace(0.0, 1.0, along)
    middle = 3.0 * slenderness**2 * ratio * np.sin(angle) / (1.0 + ratio * np.cos(angle)) ** 3
    return Pressure(angle, place, np.outer(np.maximum(middle, 0.0), 1.0 - place**2))
