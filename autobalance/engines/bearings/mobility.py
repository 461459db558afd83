"""Booker's mobility of the short bearing: velocity of the journal under a force, in closed form.

Seen from axes that turn with the mean speed of journal and bush, the film is squeezed only, with velocity V.
The pressure is positive where V·e(α) > 0, half the circle around V. With V = ε̇/Ω and a force in units of η Ω
R L³/c² the force of the journal on the bush is f = J V,

    J = ∫ e eᵀ/(1 − ε cos u)³ du,    u from the line of centres, over that half circle.

J has a closed form by Sommerfeld's substitution, cos u = (cos γ + ε)/(1 + ε cos γ). Its integrands become
polynomials of cos γ and sin γ, and γ at both ends of the half circle is algebraic. Since the pressure ends at
zero, J is also ∂f/∂V: Newton's method on f(V) = f is V ← J(V)⁻¹ f.
"""

from __future__ import annotations

import numpy as np

from autobalance.types import Array

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
    along, across = direction
    rest = (1.0 - ratio) * (1.0 + ratio)
    root = np.sqrt(rest)
    square = along**2
    gaps = 1.0 - ratio**2 * (1.0 - square)  # product of H at both ends of the half circle
    both = ratio * root * along
    span = np.pi + np.arctan2(2.0 * both, 1.0 - ratio**2 * (1.0 + square))  # of γ
    double = both * (2.0 * (1.0 - square) - 2.0 + gaps) / gaps**2
    rr = ((0.5 + ratio**2) * span + double + 4.0 * both / gaps) / (rest**2 * root)
    rt = 2.0 * ratio * across**3 / gaps**2
    tt = (0.5 * span - double) / (rest * root)
    return rr, rt, tt


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
    for _ in range(NEWTON_STEPS):
        size = np.hypot(*velocity)
        safe = np.where(size > 0.0, size, 1.0)
        along = np.where(size > 0.0, velocity[0] / safe, 1.0)
        rr, rt, tt = half_film(ratio, (along, velocity[1] / safe))
        det = rr * tt - rt**2
        new = (tt * radial - rt * tangential) / det, (rr * tangential - rt * radial) / det
        change = np.hypot(new[0] - velocity[0], new[1] - velocity[1])
        velocity = new
        if (change <= CONVERGED_CHANGE * np.hypot(*new)).all():
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
