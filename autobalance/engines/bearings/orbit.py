"""Orbit of a journal in its film through a cycle: the mobility method and its steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from autobalance.engines.bearings.film import CONTACT_ECCENTRICITY_RATIO
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Booker's mobility of the short bearing: velocity of the journal under a force, in closed form.
#
# Seen from axes that turn with the mean speed of journal and bush, the film is squeezed only, with velocity
# V. The pressure is positive where V·e(α) > 0, half the circle around V. With V = ε̇/Ω and a force in units
# of η Ω R L³/c² the force of the journal on the bush is f = J V,
#
#     J = ∫ e eᵀ/(1 − ε cos u)³ du,    u from the line of centres, over that half circle.
#
# J has a closed form by Sommerfeld's substitution, cos u = (cos γ + ε)/(1 + ε cos γ). Its integrands become
# polynomials of cos γ and sin γ, and γ at both ends of the half circle is algebraic. Since the pressure ends
# at zero, J is also ∂f/∂V: Newton's method on f(V) = f is V ← J(V)⁻¹ f.


NEWTON_STEPS = 10
CONVERGED_CHANGE = 1e-3
"""Relative change after which the next step, its square, does not count."""
MAX_ECCENTRICITY_RATIO = 1.0 - 1e-6
"""Eccentricity ratio that stands for all beyond it: the film's force grows without bound there."""

Polar = tuple[Array, Array]
"""Components along the line of centres, and a quarter turn on."""
Symmetric = tuple[Array, Array, Array]
"""Entries rr, rt, tt."""


def half_film(ratio: Array, direction: Polar) -> Symmetric:
    """Return J of the half circle around a direction of squeezing.

    Parameters
    ----------
    ratio : (...) float
        Eccentricity ratio in [0, 1).
    direction : (...) float, (...) float
        Unit vector of V: along the line of centres, and a quarter turn on.

    Returns
    -------
    (...) float, (...) float, (...) float
        J_rr, J_rt, J_tt.

    Examples
    --------
    >>> J = half_film(np.array(0.0), (np.array(1.0), np.array(0.0)))
    >>> [round(float(each), 6) + 0.0 for each in J]
    [1.570796, 0.0, 1.570796]
    """
    return _half_film_at(ratio)(direction)


def _half_film_at(ratio: Array) -> Callable[[Polar], Symmetric]:
    """Return ``half_film`` at a ratio: what follows from that alone is computed once for all directions."""
    rest = (1.0 - ratio) * (1.0 + ratio)
    root = np.sqrt(rest)
    squared, doubled, rooted = ratio**2, 2.0 * ratio, ratio * root
    radial, under_rr, under_tt = 0.5 + squared, rest**2 * root, rest * root

    def half_film_of(direction: Polar) -> Symmetric:
        along, across = direction
        square = along**2
        beside = 1.0 - square
        gaps = 1.0 - squared * beside  # product of H at both ends of the half circle
        both, gaps_squared = rooted * along, gaps**2
        span = np.pi + np.arctan2(2.0 * both, 1.0 - squared * (1.0 + square))  # of γ
        double = both * (2.0 * beside - 2.0 + gaps) / gaps_squared
        rr = (radial * span + double + 4.0 * both / gaps) / under_rr
        rt = doubled * across**3 / gaps_squared
        tt = (0.5 * span - double) / under_tt
        return rr, rt, tt

    return half_film_of


def squeeze_velocity(ratio: Array, force: Polar, guess: Polar | None = None) -> Polar:
    """Return the squeeze velocity V that a force asks for: the inverse of f = J(V) V.

    Parameters
    ----------
    ratio : (...) float
        Eccentricity ratio in [0, 1).
    force : (...) float, (...) float
        Of the journal on the bush in units of η Ω R L³/c²: along the line of centres, a quarter turn on.
    guess : like ``force``, optional
        A velocity near the answer.

    Returns
    -------
    (...) float, (...) float
        V: ε̇/Ω in axes that turn with the mean speed.

    References
    ----------
    .. [1] J. F. Booker, Dynamically loaded journal bearings: mobility method of solution, J. Basic Eng. 87
       (1965) 537-546. His chart of the short bearing holds this function.
    """
    ratio = np.minimum(ratio, MAX_ECCENTRICITY_RATIO)
    radial, tangential = force
    velocity = _start(ratio, force) if guess is None else guess
    half_film_of, size = _half_film_at(ratio), np.hypot(*velocity)
    for _ in range(NEWTON_STEPS):
        safe = np.where(size > 0.0, size, 1.0)
        along = np.where(size > 0.0, velocity[0] / safe, 1.0)
        rr, rt, tt = half_film_of((along, velocity[1] / safe))
        det = rr * tt - rt**2
        new = (tt * radial - rt * tangential) / det, (rr * tangential - rt * radial) / det
        change = np.hypot(new[0] - velocity[0], new[1] - velocity[1])
        velocity, size = new, np.hypot(*new)
        if (change <= CONVERGED_CHANGE * size).all():
            break
    return velocity


def _start(ratio: Array, force: Polar) -> Polar:
    """Return Booker's fit: (1 − ξ)^2.5 along the force and −4 η (1 − ξ)^1.5/π across it, times 2/π.

    ξ and η are the journal's place along the force and across it. Within 12 %, so that three steps do.
    """
    size = np.hypot(*force)
    safe = np.where(size > 0.0, size, 1.0)
    cosine, sine = force[0] / safe, force[1] / safe
    along, across = ratio * cosine, -ratio * sine
    forward = 2.0 / np.pi * (1.0 - along) ** 2.5 * size
    sideways = -8.0 / np.pi**2 * across * (1.0 - along) ** 1.5 * size
    return forward * cosine - sideways * sine, forward * sine + sideways * cosine


# The path of a journal in its film through a cycle of loads: Booker's mobility method, periodic.
#
# Any number of bearings, speeds and loads go through at once: a case is a column. The journal's mass does
# not count; the film is the short bearing's, positive pressure only.


CYCLE_CHANGE_TOLERANCE = 2e-5
"""Change of the eccentricity ratio from one cycle to the next that counts as none."""
MOST_TURNS = 120
"""Turns after which an orbit that still changes is reported as not periodic."""
MAX_FILM_FORCE = 1e6
"""Force in units of η Ω R L³/c² that breaks any film within half a degree: its orbit is not computed."""
STEP_TOLERANCE = 5e-7
"""Tolerance of the eccentricity ratio in one step of the integration."""
NEWTON_TOLERANCE_RATIO = 0.1
"""Tolerance of the ratio, if a path is closed by Newton's method."""
CLOSING_STEPS = 12
RATIO_STEP = 1e-4
"""Step of the eccentricity ratio for the derivative of a cycle's end by its start."""


@dataclass(frozen=True, eq=False)
class Orbits:
    """Paths of journals in their films over one cycle.

    Angles (n,), places (n, k, 2) in the clearance, in the axes of the force; ``turns_to_settle`` (k,) is 0
    where the path does not repeat, ``contact`` (k,) whether it passes ``CONTACT_ECCENTRICITY_RATIO``.
    """

    angle_rad: Array
    eccentricity: Array
    clearance_m: Array
    moment_N_m: Array
    """Friction on the journal by angle (n, k)."""
    turns_to_settle: npt.NDArray[np.int64]
    off: Array | None = None
    """Change of the eccentricity ratio over the last cycle (k,)."""

    def case(self, number: int) -> Orbits:
        one = slice(number, number + 1)
        return Orbits(
            self.angle_rad,
            self.eccentricity[:, one],
            self.clearance_m[one],
            self.moment_N_m[:, one],
            self.turns_to_settle[one],
            None if self.off is None else self.off[one],
        )

    @property
    def ratio(self) -> Array:
        """Eccentricity ratio (n, k)."""
        return np.asarray(np.hypot(self.eccentricity[..., 0], self.eccentricity[..., 1]))

    @property
    def film_m(self) -> Array:
        """Smallest film at each angle (n, k)."""
        return self.clearance_m * (1.0 - self.ratio)

    @property
    def least_film_m(self) -> Array:
        """Smallest film of the cycle (k,)."""
        return np.asarray(self.film_m.min(axis=0))

    @property
    def least_at_rad(self) -> Array:
        """Angle of the least film (k,)."""
        return np.asarray(self.angle_rad[self.film_m.argmin(axis=0)])

    @property
    def mean_moment_N_m(self) -> Array:
        """Mean friction over the angle (k,)."""
        return np.asarray(self.moment_N_m.mean(axis=0))

    @property
    def contact(self) -> npt.NDArray[np.bool_]:
        """Whether the film breaks (k,)."""
        return np.asarray(self.ratio.max(axis=0) > CONTACT_ECCENTRICITY_RATIO)


def film_orbits(
    angle_rad: npt.ArrayLike,
    force_N: npt.ArrayLike,
    speed_rad_s: npt.ArrayLike,
    viscosity_Pa_s: npt.ArrayLike,
    diameter_m: npt.ArrayLike,
    length_m: npt.ArrayLike,
    clearance_m: npt.ArrayLike,
    bush_speed_rad_s: npt.ArrayLike = 0.0,
    most_turns: int | None = None,
) -> Orbits:
    """Return the periodic orbits of journals under loads by angle.

    Parameters
    ----------
    angle_rad : (n,) float
        In equal steps from the first one through one whole cycle, its end not repeated [rad].
    force_N : (n, 2) or (n, k, 2) float
        Of the journal on the bush, linear between angles, in axes that do not turn [N].
    speed_rad_s : float or (k,)
        Of the journal, positive in the sense from x to y [rad/s].
    viscosity_Pa_s, diameter_m, length_m, clearance_m : float or (k,)
        Dynamic viscosity [Pa·s]; then journal diameter, bearing length and radial clearance [m]. All are
        positive.
    bush_speed_rad_s : float, (k,) or (n, k)
        Of the bush about its own axis, in the same axes; by angle for a rod that swings [rad/s].
    most_turns : int, optional
        Turns after which a path that has not settled is closed by Newton's method; 120 where None.

    Returns
    -------
    Orbits

    References
    ----------
    .. [1] J. F. Booker, J. Basic Eng. 87 (1965) 537-546.
    """
    angle = np.asarray(angle_rad, dtype=float)
    force = np.asarray(force_N, dtype=float)
    force = force[:, None, :] if force.ndim == 2 else force
    speed, viscosity, diameter, length, clearance = (
        np.broadcast_to(np.asarray(each, dtype=float), force.shape[1:2])
        for each in (speed_rad_s, viscosity_Pa_s, diameter_m, length_m, clearance_m)
    )
    bush = np.broadcast_to(np.asarray(bush_speed_rad_s, dtype=float), force.shape[:2])
    radius = 0.5 * diameter
    unit = short_film_unit_n(viscosity, speed, radius, length, clearance)
    motion = _Motion(angle, force / unit[:, None], 0.5 * (1.0 + bush / speed))
    path, turns, off = _periodic(motion, MOST_TURNS if most_turns is None else most_turns)
    petroff = 2.0 * np.pi * viscosity * (speed - bush) * radius**3 * length / clearance
    pull = path[..., 1] * force[..., 0] - path[..., 0] * force[..., 1]
    ratio = np.minimum(np.hypot(path[..., 0], path[..., 1]), MAX_ECCENTRICITY_RATIO)
    moment = petroff / np.sqrt(1.0 - ratio**2) + 0.5 * clearance * pull
    return Orbits(angle, path, clearance, moment, turns, off)


def short_film_unit_n(
    viscosity_pa_s: Array | float,
    speed_rad_s: Array | float,
    radius_m: Array,
    length_m: Array,
    clearance_m: Array,
) -> Array:
    """Return η Ω R L³/c² [N]: the forces of short films scale with it."""
    return np.asarray(viscosity_pa_s * speed_rad_s * radius_m * length_m**3 / clearance_m**2)


@dataclass(frozen=True, eq=False)
class _Motion:
    """Forces in the film's unit (n, k, 2) over angles (n,); the surfaces' mean speed over Ω (n, k)."""

    angle: Array
    force: Array
    mean_speed: Array

    @property
    def step(self) -> float:
        return float(self.angle[1] - self.angle[0])

    def of(self, cases: npt.NDArray[np.int64]) -> _Motion:
        return _Motion(self.angle, self.force[:, cases], self.mean_speed[:, cases])


def _rate(motion: _Motion) -> Callable[[float, Array], Array]:
    """Return dε/dθ of states (2 k,) at an angle from the first one.

    Each search for the squeeze velocity begins at the one before.
    """
    before: tuple[Array, Array] | None = None

    def rate(angle: float, state: Array) -> Array:
        nonlocal before
        x, y = state.reshape(2, -1)
        place = angle / motion.step
        row = int(place)
        share, count = place - row, len(motion.angle)
        row, after = row % count, (row + 1) % count
        force = (1.0 - share) * motion.force[row] + share * motion.force[after]
        turning = (1.0 - share) * motion.mean_speed[row] + share * motion.mean_speed[after]
        ratio = np.hypot(x, y)
        safe = np.where(ratio > 0.0, ratio, 1.0)
        line = np.where(ratio > 0.0, x / safe, 1.0), y / safe
        guess = None if before is None else _turned(before, (line[0], -line[1]))
        polar = _turned((force[:, 0], force[:, 1]), (line[0], -line[1]))
        before = _turned(squeeze_velocity(ratio, polar, guess), line)
        return np.concatenate([before[0] - turning * y, before[1] + turning * x])

    return rate


def _turned(vector: Polar, by: Polar) -> Polar:
    """Return vectors turned by the angles of unit vectors."""
    return vector[0] * by[0] - vector[1] * by[1], vector[0] * by[1] + vector[1] * by[0]


def _periodic(motion: _Motion, most_turns: int) -> tuple[Array, npt.NDArray[np.int64], Array]:
    """Return periodic paths (n, k, 2), turns that each took, last changes (k,)."""
    count, cases = motion.force.shape[:2]
    size = np.hypot(motion.force[..., 0], motion.force[..., 1])
    hopeless = size.max(axis=0) > MAX_FILM_FORCE
    touching = motion.force / np.where(size > 0.0, size, 1.0)[..., None]
    path = np.where(hopeless[:, None], touching, 0.0)
    turns, off = np.zeros(cases, dtype=np.int64), np.zeros(cases)
    start = np.zeros((2, cases))
    left = np.nonzero(~hopeless)[0]
    each = max(round(count * motion.step / (2.0 * np.pi)), 1)
    for done in range(each, most_turns + 1, each):
        if not len(left):
            break
        passed, end = _cycle(motion.of(left), start[:, left])
        path[:, left] = passed
        change = np.hypot(*(end - start[:, left]))
        start[:, left] = end
        off[left] = change
        turns[left[change < CYCLE_CHANGE_TOLERANCE]] = done
        left = left[change >= CYCLE_CHANGE_TOLERANCE]
    if len(left):
        closed, turns_done, change = _closed(motion.of(left), start[:, left], each, most_turns)
        done_now = turns_done > 0
        path[:, left[done_now]] = closed[:, done_now]
        turns[left], off[left[done_now]] = turns_done, change[done_now]
    return path, turns, off


def _closed(
    motion: _Motion, start: Array, each: int, most_turns: int
) -> tuple[Array, npt.NDArray[np.int64], Array]:
    """Return unsettled paths, closed by Newton's method on the start (2, k) of a cycle.

    A path counts as periodic where neighbours tend to it; one that repels them no journal follows.
    """
    cases = start.shape[1]
    turns = np.zeros(cases, dtype=np.int64)
    most = 0.999 * CONTACT_ECCENTRICITY_RATIO
    for step in range(1, CLOSING_STEPS + 1):
        tried = np.concatenate(
            [
                start,
                start + np.array([[RATIO_STEP], [0.0]]),
                start + np.array([[0.0], [RATIO_STEP]]),
            ],
            axis=1,
        )
        paths, ends = _cycle(
            motion.of(np.tile(np.arange(cases), 3)), tried, NEWTON_TOLERANCE_RATIO * STEP_TOLERANCE
        )
        middle = ends[:, :cases]
        slopes = (
            np.stack([ends[:, cases : 2 * cases] - middle, ends[:, 2 * cases :] - middle], axis=1)
            / RATIO_STEP
        )
        slopes = np.moveaxis(slopes, -1, 0)
        change = middle - start
        off = np.hypot(*change)
        attracts = np.abs(np.linalg.eigvals(slopes)).max(axis=1) < 1.0
        turns[:] = np.where((off < CYCLE_CHANGE_TOLERANCE) & attracts, most_turns + 3 * each * step, 0)
        if (off < CYCLE_CHANGE_TOLERANCE).all() or step == CLOSING_STEPS:
            break
        moved = np.linalg.solve(np.eye(2) - slopes, change.T[..., None])[..., 0].T
        start = start + moved
        ratio = np.hypot(*start)
        start = start * np.minimum(1.0, most / np.where(ratio > 0.0, ratio, 1.0))
    return paths[:, :cases], turns, off


def _cycle(motion: _Motion, start: Array, accuracy: float = STEP_TOLERANCE) -> tuple[Array, Array]:
    """Return one cycle's path (n, k, 2) and its end (2, k)."""
    count, cases = motion.force.shape[:2]
    end = count * motion.step
    accuracy /= np.sqrt(2.0 * cases)  # the solver's measure is a mean over all cases
    solution = solve_ivp(
        _rate(motion),
        (0.0, end),
        start.ravel(),
        t_eval=np.append(np.arange(count) * motion.step, end),
        rtol=1e-13,
        atol=accuracy,
        first_step=1e-3 * motion.step,
    )
    states = solution.y.reshape(2, cases, count + 1)
    return np.moveaxis(states[..., :-1], (0, 1, 2), (2, 1, 0)), states[..., -1]
