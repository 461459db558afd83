"""Oil film of a journal bearing with feeds under pressure, and a squeeze film."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from autobalance.engines.bearings.fed_mesh import BushMesh, Conductances, conductances
from autobalance.engines.bearings.film import (
    CONTACT_ECCENTRICITY_RATIO,
    NO_THRESHOLD,
    Boundary,
    JournalBearing,
    WhirlThreshold,
    turning,
    whirl_threshold,
)
from autobalance.engines.bearings.oil import Capillary, Feed, Orifice
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Oil film of a journal bearing with recesses, grooves or holes under pressure: hydrostatic and hybrid.
#
# A journal at **e** from the bush's centre leaves the gap h = c − e_x cos θ − e_y sin θ, with θ from the
# load's direction (x) in the sense of turning. On finite volumes of the developed bush, whose lines run
# along the edges of all feeds,
#
#     Σ_neighbours G (p − p′) = −½ Ω R Δz [h] − ∂h/∂t R Δθ Δz,   G = h³/(12 η) × breadth/distance,
#
# and a feed is one cell of one pressure whose outflow is what its restrictor lets in. ``wedge`` off leaves
# out the term of Ω (a hydrostatic bearing). Means of cos θ and sin θ over each cell make the moment of the
# pressure on the journal exactly ½ **e** × **F**, and the balance of power an identity of the discrete
# equations.


Flags = npt.NDArray[np.bool_]
SWEEPS = 200
"""Largest number of solutions for restrictors and the film's edge together."""
ROUNDING = 1e-12
"""Part of a force over which the direction of the journal's place is no more than rounding."""
SETTLED = 1e-12
"""Relative change of a feed's pressure between two solutions that ends them."""


@dataclass(frozen=True, eq=False)
class FedBearing:
    """A journal bearing with feeds, its oil and speed; ``density_kg_m3`` is of no importance to the film."""

    bearing: JournalBearing
    feeds: tuple[Feed, ...]
    viscosity_Pa_s: float
    speed_rad_s: float
    wedge: bool = True
    boundary: Boundary = "reynolds"


@dataclass(frozen=True, eq=False)
class FedFilm:
    """The film at one place of the journal, SI; matrices are −∂F_i/∂x_j and −∂F_i/∂ẋ_j, x along the load.

    ``feed_pressure_Pa`` and ``feed_flow_m3_s`` are by feed; ``side_flow_m3_s`` leaves at both ends.
    ``energy_error`` is the power that is missing in the balance over all of it; None with a film cut off.
    """

    case: FedBearing
    mesh: BushMesh
    eccentricity: Array
    """Place of the journal over the clearance (2,)."""
    unknowns: Array
    """Pressures of feeds and cells between them, as solved."""
    pressure_Pa: Array
    """(n, m)"""
    force_N: Array
    stiffness_N_m: Array
    damping_N_s_m: Array
    feed_pressure_Pa: Array
    feed_flow_m3_s: Array
    side_flow_m3_s: float
    moment_N_m: float
    dissipated_W: float
    kept: Flags
    """Unknowns whose equation holds."""

    @property
    def eccentricity_ratio(self) -> float:
        return float(np.hypot(*self.eccentricity))

    @property
    def attitude_rad(self) -> float:
        """Angle from the load's direction, x, to the line of centres in the sense of turning."""
        return (
            float(np.arctan2(self.eccentricity[1], self.eccentricity[0])) if self.eccentricity.any() else 0.0
        )

    @property
    def load_N(self) -> float:
        """Load along x that the film carries."""
        return -float(self.force_N[0])

    @property
    def supplied_m3_s(self) -> float:
        """Flow through all feeds."""
        return float(self.feed_flow_m3_s.sum())

    @property
    def pumping_W(self) -> float:
        """Power of the pump: supply pressure times flow; with a given flow, the feed's pressure times it."""
        return float(self._upstream @ self.feed_flow_m3_s)

    @property
    def _upstream(self) -> Array:
        given = [isinstance(feed.restrictor, Capillary | Orifice) for feed in self.case.feeds]
        supply = np.array([feed.pressure_Pa for feed in self.case.feeds])
        return np.where(given, supply, self.feed_pressure_Pa) if len(supply) else np.zeros(0)

    @property
    def heat_W(self) -> float:
        """Power that becomes heat in film and restrictors: friction's and the pump's."""
        return self.moment_N_m * self.case.speed_rad_s + self.pumping_W

    @property
    def energy_error(self) -> float | None:
        """Power that enters less what shear, flow and restrictors turn to heat, over what enters."""
        if self.case.boundary == "half" or not self.heat_W > 0.0:
            return None
        throttled = float((self._upstream - self.feed_pressure_Pa) @ self.feed_flow_m3_s)
        return abs(self.heat_W - self.dissipated_W - throttled) / self.heat_W

    @property
    def whirl(self) -> WhirlThreshold:
        """Threshold of oil whirl; none at rest."""
        speed = self.case.speed_rad_s
        return whirl_threshold(self.stiffness_N_m, self.damping_N_s_m, speed) if speed > 0.0 else NO_THRESHOLD

    @property
    def sommerfeld(self) -> float | None:
        """Sommerfeld number, None without speed or load."""
        speed, bearing = self.case.speed_rad_s, self.case.bearing
        if not (speed > 0.0 and self.load_N > 0.0):
            return None
        return bearing.force_unit_N(self.case.viscosity_Pa_s, speed) / (math.pi * self.load_N)

    def turned(self, load_rad: float) -> tuple[Array, Array]:
        """Return stiffness and damping in axes in which the load is at an angle from x [rad]."""
        turn = turning(load_rad)
        return turn @ self.stiffness_N_m @ turn.T, turn @ self.damping_N_s_m @ turn.T

    @property
    def least_film_m(self) -> float:
        return self.case.bearing.clearance_m * (1.0 - self.eccentricity_ratio)

    @property
    def greatest_pressure_Pa(self) -> float:
        return float(self.pressure_Pa.max())


# --- one place of the journal -------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Balance:
    """Flow balance: outflow = ``source`` + inflow of feeds; ``pinned`` feeds have their pressure."""

    case: FedBearing
    flows: Conductances
    source: Array
    pinned: Flags

    def let_in(self, pressure: Array) -> tuple[Array, Array]:
        """Return the flow of each unknown's feed, 0 of none, and minus its slope by the pressure."""
        flow, slope = np.zeros((2, len(self.source)))
        for k, feed in enumerate(self.case.feeds):
            if feed.restrictor is not None:
                flow[k], slope[k] = feed.restrictor.flow(feed.pressure_Pa - float(pressure[k]))
        return flow, slope

    def solved(self, start: Array, kept: Flags) -> tuple[Array, Flags]:
        """Return the pressures of all unknowns, and whose equation holds."""
        ends, feeds = self.case.boundary == "reynolds", len(self.case.feeds)
        pressure = start
        for _ in range(SWEEPS):
            before = pressure
            flow, slope = self.let_in(before)
            right = self.source + flow + slope * before
            matrix = csc_array(self.flows.matrix + diags_array(slope))
            pressure = np.where(self.pinned, before, 0.0)
            free = kept & ~self.pinned
            pressure[free] = _solve(matrix, free, (right - matrix @ pressure)[free])
            now = np.where(free, pressure > 0.0, matrix @ pressure < right) | self.pinned if ends else kept
            moved = np.abs(pressure - before)[:feeds]
            settled = bool((moved <= SETTLED * np.abs(pressure).max(initial=1.0)).all())
            if settled and np.array_equal(now, kept):
                break
            kept = now
        return (np.maximum(pressure, 0.0) if ends else pressure), kept

    def change(self, pressure: Array, kept: Flags, right: Array) -> Array:
        """Return the pressures' change (k,) by a change of the right side."""
        _, slope = self.let_in(pressure)
        free = kept & ~self.pinned
        change = np.zeros(len(right))
        change[free] = _solve(csc_array(self.flows.matrix + diags_array(slope)), free, right[free])
        return change


def _solve(matrix: csc_array, free: Flags, right: Array) -> Array:
    solver = splu(
        csc_array(matrix[free][:, free]),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(solver.solve(right))


def fed_film(case: FedBearing, mesh: BushMesh, eccentricity: Array, guess: FedFilm | None = None) -> FedFilm:
    """Return the film at a place of the journal's centre.

    Parameters
    ----------
    case : FedBearing
    mesh : BushMesh
        Of the same bearing and feeds.
    eccentricity : (2,) float
        Of the journal over the clearance, x along the load; its size below 1.
    guess : FedFilm, optional
        Of a neighbouring place.
    """
    bearing, radius = case.bearing, case.bearing.radius_m
    clearance, whirl = bearing.clearance_m, 0.5 * case.speed_rad_s * radius if case.wedge else 0.0
    offset = clearance * np.asarray(eccentricity, dtype=np.float64)

    def gap(angle: Array) -> Array:
        return np.asarray(clearance - offset[0] * np.cos(angle) - offset[1] * np.sin(angle))

    at_edges, at_cells = gap(mesh.edges[1:]), gap(mesh.angle)
    unit = 12.0 * case.viscosity_Pa_s
    wedges = [-whirl * np.outer(mesh.sine, mesh.breadth), whirl * np.outer(mesh.cosine, mesh.breadth)]
    feeds = case.feeds
    balance = _Balance(
        case,
        conductances(mesh, at_edges**3 / unit, at_cells**3 / unit),
        mesh.summed(offset[0] * wedges[0] + offset[1] * wedges[1]),
        np.arange(int(mesh.unknown.max()) + 1) < 0,
    )
    balance.pinned[: len(feeds)] = [feed.restrictor is None for feed in feeds]
    start, kept = np.zeros(len(balance.source)), np.ones(len(balance.source), dtype=bool)
    start[: len(feeds)] = [feed.pressure_Pa * (1.0 if feed.restrictor is None else 0.5) for feed in feeds]
    if guess is not None:
        start, kept = np.where(balance.pinned, start, guess.unknowns), guess.kept
    solved, kept = balance.solved(start, kept)
    counted = np.maximum(solved, 0.0) if case.boundary == "half" else solved
    pressure = counted[mesh.unknown]

    def slope_of_force(right: Array) -> Array:
        change = balance.change(solved, kept, right)
        if case.boundary == "half":
            change = np.where(solved > 0.0, change, 0.0)
        return mesh.force(change[mesh.unknown])

    stiffness, damping = np.zeros((2, 2, 2))
    for i, wave in enumerate((np.cos, np.sin)):
        thinner = conductances(
            mesh,
            -3.0 * at_edges**2 * wave(mesh.edges[1:]) / unit,
            -3.0 * at_cells**2 * wave(mesh.angle) / unit,
        )
        stiffness[:, i] = -slope_of_force(mesh.summed(wedges[i]) - thinner.matrix @ solved)
        closing = np.outer((mesh.cosine, mesh.sine)[i] * radius, mesh.breadth)
        damping[:, i] = -slope_of_force(mesh.summed(closing))
    flow = balance.let_in(solved)[0] + np.where(
        balance.pinned, balance.flows.matrix @ solved - balance.source, 0.0
    )
    force = mesh.force(pressure)
    shear = _shear_N_m(case, mesh, gap)
    lever = 0.5 * float(offset[0] * force[1] - offset[1] * force[0]) if case.wedge else 0.0
    if abs(lever) < ROUNDING * clearance * float(np.abs(force).max()):
        lever = 0.0
    moment = shear + lever
    return FedFilm(
        case, mesh, offset / clearance, solved, pressure, force, stiffness, damping,
        solved[: len(feeds)], flow[: len(feeds)], float(balance.flows.out @ np.maximum(solved, 0.0)), moment,
        shear * case.speed_rad_s + float(solved @ (balance.flows.matrix @ solved)), kept,
    )  # fmt: skip


def _shear_N_m(case: FedBearing, mesh: BushMesh, gap: Callable[[Array], Array]) -> float:
    """Return the moment of shear in a clearance full of oil: η Ω R³ ∫dθ dz/h, fourfold in a closed recess."""
    low, high = mesh.edges[:-1], mesh.edges[1:]
    unit = case.viscosity_Pa_s * case.speed_rad_s * case.bearing.radius_m**3

    def over(extra_m: float) -> Array:
        inverse = 1.0 / (gap(low) + extra_m) + 4.0 / (gap(mesh.angle) + extra_m) + 1.0 / (gap(high) + extra_m)
        return np.asarray((high - low) * inverse / 6.0)

    lines = np.outer(over(0.0), mesh.breadth) * (mesh.feed_at < 0)
    total = float(lines.sum())
    for number, feed in enumerate(case.feeds):
        if feed.depth_m is not None:
            total += 4.0 * float(
                (np.outer(over(feed.depth_m), mesh.breadth) * (mesh.feed_at == number)).sum()
            )
    return unit * total


# --- the place of the journal -------------------------------------------------------------------------------

STEPS = 60
HALVINGS = 8
NEAR = 1e-10
"""Force out of balance over the load's or, without one, over that of the feeds' pressure."""
STARTS = ((0.0, 0.0), (0.3, 0.8), (0.6, 0.6), (0.85, 0.4), (0.95, 0.3))
"""Eccentricity ratios and attitudes [rad] from which the journal's place is sought."""


def fed_film_at_load(
    case: FedBearing, mesh: BushMesh, load_N: float, guess: FedFilm | None = None
) -> FedFilm | None:
    """Return the film that carries a load along x; None where none does short of contact."""
    starts = [np.array([r * math.cos(a), r * math.sin(a)]) for r, a in STARTS]
    for start in [*([] if guess is None else [guess.eccentricity]), *starts]:
        found = _balanced(case, mesh, load_N, start, guess)
        if found is not None:
            return found
    return None


def _balanced(
    case: FedBearing, mesh: BushMesh, load_N: float, start: Array, guess: FedFilm | None
) -> FedFilm | None:
    """Return the film where Newton's method ends, its steps halved until the missing force shrinks."""
    load, clearance = np.array([load_N, 0.0]), case.bearing.clearance_m
    scale = max(load_N, *(_strength(case, feed) for feed in case.feeds), 1e-12)
    film = fed_film(case, mesh, start, guess)
    for _ in range(STEPS):
        missing = film.force_N + load
        size = float(np.hypot(*missing))
        if size <= NEAR * scale:
            return film if film.eccentricity_ratio <= CONTACT_ECCENTRICITY_RATIO else None
        try:
            step = np.linalg.solve(film.stiffness_N_m * clearance, missing)
        except np.linalg.LinAlgError:
            return None
        step *= min(1.0, 0.3 / float(np.hypot(*step)))
        for _ in range(HALVINGS):
            ratio = float(np.hypot(*(film.eccentricity + step)))
            if ratio < 0.5 * (1.0 + CONTACT_ECCENTRICITY_RATIO):
                tried = fed_film(case, mesh, film.eccentricity + step, film)
                if float(np.hypot(*(tried.force_N + load))) < size:
                    break
            step = 0.5 * step
        else:
            return film if size <= 1e3 * NEAR * scale else None
        film = tried
    return None


def _strength(case: FedBearing, feed: Feed) -> float:
    return feed.pressure_Pa * feed.length_m * feed.width_rad * case.bearing.radius_m


def fed_film_at_eccentricity(
    case: FedBearing, mesh: BushMesh, ratio: float, guess: FedFilm | None = None
) -> FedFilm | None:
    """Return the film at an eccentricity ratio, at the attitude at which it carries along x; None: at none.

    At a ratio of 0 the journal is in the middle, wherever the film's force points.
    """
    if ratio > CONTACT_ECCENTRICITY_RATIO:
        return None
    if ratio == 0.0:
        return fed_film(case, mesh, np.zeros(2), guess)

    def at(attitude: float, near: FedFilm | None) -> FedFilm:
        return fed_film(case, mesh, ratio * np.array([math.cos(attitude), math.sin(attitude)]), near)

    attitude = math.atan(math.pi * math.sqrt(1.0 - ratio**2) / (4.0 * ratio)) if case.wedge else 0.0
    film = at(attitude, guess)
    for _ in range(STEPS):
        along, across = film.force_N
        turn = case.bearing.clearance_m * np.array([-film.eccentricity[1], film.eccentricity[0]])
        slope = -float(film.stiffness_N_m[1] @ turn)
        if abs(across) <= NEAR * abs(along):
            return film if along < 0.0 else None
        attitude -= max(-0.3, min(0.3, across / slope)) if slope else 0.1
        film = at(attitude, film)
    return film if abs(film.force_N[1]) <= 1e3 * NEAR * abs(film.force_N[0]) and film.load_N > 0.0 else None


# Squeeze film between parallel rectangular plates: stiffness and damping.


TERMS = np.arange(1.0, 400.0, 2.0)
"""Odd numbers of the series; what is left out is below 1e-11 of its sum."""


def stiffness_N_m(load_N: float, film_m: float) -> float:
    """Return 3 W/H: the slope of a load that goes as H⁻³.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 7.4.

    Examples
    --------
    >>> stiffness_N_m(500.0, 2e-5)
    75000000.0
    """
    return 3.0 * load_N / film_m


def uniform_pressure_damping_N_s_m(
    viscosity_Pa_s: float, length_m: float, width_m: float, film_m: float
) -> float:
    """Return 3 η A²/(H³ (Z/L + L/Z)), the source's damping.

    It takes the pressure as uniform over the whole area A = L Z, which makes it 3 times (a strip) to 3.56
    times (a square) what Reynolds' equation gives.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 7.5.

    Examples
    --------
    >>> round(uniform_pressure_damping_N_s_m(0.01, 0.02, 0.02, 2e-5))
    300000
    """
    shape = width_m / length_m + length_m / width_m
    return 3.0 * viscosity_Pa_s * (length_m * width_m) ** 2 / (film_m**3 * shape)


def damping_N_s_m(viscosity_Pa_s: float, length_m: float, width_m: float, film_m: float) -> float:
    """Return the damping of a rectangular plate from Reynolds' equation, by its series.

    η a b³/H³ (1 − 192/π⁵ (b/a) Σ tanh(n π a/(2 b))/n⁵), n odd, a the longer side.

    Examples
    --------
    >>> round(damping_N_s_m(0.01, 0.02, 0.02, 2e-5), 3)
    84346.209
    """
    a, b = max(length_m, width_m), min(length_m, width_m)
    series = float(np.sum(np.tanh(TERMS * np.pi * a / (2.0 * b)) / TERMS**5))
    share = 1.0 - 192.0 / np.pi**5 * (b / a) * series
    return float(viscosity_Pa_s * a * b**3 / film_m**3 * share)
