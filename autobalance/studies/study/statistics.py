"""Random numbers for studies, and proportions and percentiles of samples."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from typing import Literal, Self

import numpy as np
from scipy.special import ndtri

from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Random numbers for studies: each cause has its own stream, each crank its own place in it.
#
# A stream follows from the seed and its name alone. So a crank is the same for any number of cranks, other
# causes and workers.


Distribution = Literal["normal", "rectangular"]
Sampling = Literal["random", "latin_hypercube"]

Z_95 = 1.959964
"""Half-width of 95 % of the standard normal distribution."""
BLOCK = 4096
"""Numbers drawn at once: a stream is the same for any part of it."""


def standard_deviation(pm: float, distribution: Distribution) -> float:
    """Return the standard deviation of what a ± stands for: 95 % within (normal), or all (rectangular)."""
    return pm / Z_95 if distribution == "normal" else pm / math.sqrt(3.0)


def uniform(seed: int, stream: str, count: int, sampling: Sampling = "random") -> Array:
    """Return ``count`` numbers in (0, 1) of a stream.

    Examples
    --------
    >>> bool((uniform(1, "a", 5000)[:10] == uniform(1, "a", 10)).all())
    True
    """
    if sampling == "latin_hypercube":
        order = _generator(seed, f"{stream} order", 0).permutation(count)
        return _open((order + uniform(seed, stream, count)) / count)
    blocks = [_generator(seed, stream, number).random(BLOCK) for number in range(-(-count // BLOCK))]
    return _open(np.concatenate([np.zeros(0), *blocks])[:count])


def deviations(
    seed: int, stream: str, count: int, pm: float, distribution: Distribution, sampling: Sampling = "random"
) -> Array:
    """Return ``count`` deviations from nominal of what is known to ± ``pm``."""
    share = uniform(seed, stream, count, sampling)
    spread = standard_deviation(pm, distribution)
    standard: Array = ndtri(share) if distribution == "normal" else math.sqrt(3.0) * (2.0 * share - 1.0)
    drawn: Array = standard * spread
    return drawn


def offsets(
    seed: int, stream: str, count: int, pm: float, distribution: Distribution, sampling: Sampling = "random"
) -> Array:
    """Return ``count`` vectors (n, 2): lengths as ``deviations`` draws them, in evenly drawn directions."""
    length = deviations(seed, f"{stream} length", count, pm, distribution, sampling)
    angle = math.tau * uniform(seed, f"{stream} direction", count, sampling)
    drawn: Array = length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return drawn


def _generator(seed: int, stream: str, block: int) -> np.random.Generator:
    word = int.from_bytes(hashlib.sha256(stream.encode()).digest()[:16], "little")
    return np.random.Generator(np.random.Philox(np.random.SeedSequence([seed, word, block])))


def _open(share: Array) -> Array:
    """Keep numbers off 0 and 1, where the normal distribution has no value."""
    inside: Array = np.clip(share, 2.0**-54, 1.0 - 2.0**-53)
    return inside


# Proportions and percentiles of samples.


PERCENTILES = (1, 5, 25, 50, 75, 95, 99)


def wilson_interval(hits: int, count: int) -> tuple[float, float]:
    """Return Wilson's score interval of a proportion.

    References
    ----------
    Wilson, J. Am. Stat. Assoc. 22 (1927) 209.

    Examples
    --------
    >>> low, high = wilson_interval(10, 10)
    >>> round(low, 4), high
    (0.7225, 1.0)
    """
    share, z2 = hits / count, Z_95 * Z_95
    centre = share + 0.5 * z2 / count
    reach = Z_95 * math.sqrt(share * (1.0 - share) / count + 0.25 * z2 / count**2)
    low, high = ((centre + sign * reach) / (1.0 + z2 / count) for sign in (-1.0, 1.0))
    return (0.0 if hits == 0 else max(low, 0.0)), (1.0 if hits == count else min(high, 1.0))


@dataclass(frozen=True)
class Percentiles:
    """Percentiles of a sample."""

    p1: float
    p5: float
    p25: float
    p50: float
    p75: float
    p95: float
    p99: float

    @classmethod
    def of(cls, values: Array) -> Self:
        """Return the percentiles of a sample (n,)."""
        return cls(*(float(each) for each in np.percentile(values, PERCENTILES)))


# Effect of each uncertain number on a crank's unbalance, to first order: effects that add.
#
# The state of a crank is (Uₓ, U_y, Pₓ, P_y), the resultant [g·mm] and the moment about z = 0 [g·mm²].


@dataclass(frozen=True, eq=False)
class Draw:
    """One uncertain number, or one uncertain vector of two.

    Attributes
    ----------
    cause : str
        What it belongs to: ``engine.rotating_g.bearing``.
    label : str
        The cause, and which of several: ``engine.rotating_g.bearing[throw 2]``.
    unit : str
        Of ``pm`` and ``nominal``.
    pm : float
        How far it may be off.
    distribution : {"normal", "rectangular"}
    effect : (1, 4) or (2, 4) float
        Change of the state per unit, of the number or of each component of the vector.
    nominal : float
        The number's own value; a vector's is zero.
    axes : (str, str)
        Names of a vector's components.
    """

    cause: str
    label: str
    unit: str
    pm: float
    distribution: Distribution
    effect: Array
    nominal: float = 0.0
    axes: tuple[str, str] = ("x", "y")

    @property
    def is_vector(self) -> bool:
        return len(self.effect) == 2

    @property
    def columns(self) -> list[str]:
        """Names of its columns in a series."""
        return [f"{self.label}.{axis}" for axis in self.axes] if self.is_vector else [self.label]

    @property
    def variance(self) -> float:
        """Variance of the number, or of each component of the vector."""
        spread = standard_deviation(self.pm, self.distribution) ** 2
        return 0.5 * spread if self.is_vector else spread

    @property
    def covariance(self) -> Array:
        """Covariance (4, 4) that it makes of the state."""
        covariance: Array = self.variance * self.effect.T @ self.effect
        return covariance

    def changes(self, deviations: Array) -> Array:
        """Return the state's changes (n, 4) by deviations (n, 1) or (n, 2).

        Without a matrix product: its sums may differ in the last bit with the number of rows.
        """
        total: Array = deviations[:, :1] * self.effect[0]
        return total + deviations[:, 1:] * self.effect[1] if self.is_vector else total

    def sampled(self, seed: int, count: int, sampling: Sampling, stream: str = "") -> Array:
        """Return deviations (n, 1) or (n, 2) from nominal; ``stream`` begins the name of another sample."""
        draw = offsets if self.is_vector else deviations
        draws = draw(seed, stream + self.label, count, self.pm, self.distribution, sampling)
        return draws.reshape(count, -1)


def state_of(unbalance: Unbalance) -> Array:
    """Return the state (4,) of an unbalance."""
    return unbalance.components


def effect_of(change: Moments) -> Array:
    """Return the state's change (4,) by a change of the moments."""
    return state_of(Unbalance.of(change))


def shift_effect(body: Moments, axes: Array) -> Array:
    """Return the state's change (k, 4) per millimetre that a body is shifted along each of ``axes`` (k, 3).

    ∫ r rᵀ dm changes by v fᵀ + f vᵀ, f = ∫ r dm.
    """
    first = body.first_g_mm
    resultant = body.mass_g * axes[:, :2]
    moment = axes[:, :2] * first[2] + np.outer(axes[:, 2], first[:2])
    return np.concatenate([resultant, moment], axis=1)


def turn_effect(body: Moments, about_mm: Array, axes: Array) -> Array:
    """Return the state's change (k, 4) per radian that a body is turned about each of ``axes`` (k, 3).

    Each point moves by ω × (r − p), p the point ``about_mm`` (3,).
    """
    rows = []
    for axis in axes:
        spin = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
        first = spin @ (body.first_g_mm - body.mass_g * about_mm)
        moved = spin @ (body.second_g_mm2 - np.outer(about_mm, body.first_g_mm))
        second = moved + moved.T
        rows.append([*first[:2], *second[:2, 2]])
    return np.array(rows)


def axis_effect(body: Moments, places_mm: tuple[float, float], at: int) -> Array:
    """Return the state's change (2, 4) per millimetre that one of two journals lies off the axis in x, y.

    The true axis joins the journals, so a slice at z is off it by minus the share that the journal has there.
    """
    far = places_mm[1 - at]
    lever = places_mm[at] - far
    zeroth, first, second = body.mass_g, float(body.first_g_mm[2]), float(body.second_g_mm2[2, 2])
    resultant = -(first - far * zeroth) / lever
    moment = -(second - far * first) / lever
    return np.array([[resultant, 0.0, moment, 0.0], [0.0, resultant, 0.0, moment]])


@dataclass(frozen=True, eq=False)
class LinearModel:
    """A crank as planned, what is uncertain about it, and what it is judged against.

    Attributes
    ----------
    nominal : (4,) float
        State of the crank as planned.
    draws : sequence of Draw
    tolerance : Tolerance
    """

    nominal: Array
    draws: Sequence[Draw]
    tolerance: Tolerance

    def covariance(self) -> Array:
        """Return the covariance (4, 4) of the state."""
        total = np.zeros((4, 4))
        for draw in self.draws:
            total = total + draw.covariance
        return total

    def states(self, deviations: Mapping[str, Array]) -> Array:
        """Return the states (n, 4) of cranks with deviations by label."""
        states = self.nominal
        for draw in self.draws:
            states = states + draw.changes(deviations[draw.label])
        return states

    def used_shares(self, states: Array) -> Array:
        """Return the largest of what is judged over its permissible value, of each state (n,)."""
        shares = [np.hypot(states[:, 0], states[:, 1]) / self.tolerance.permissible_g_mm]
        if self.tolerance.judge == "dynamic":
            for magnitude, plane in zip(self.plane_magnitudes(states), self.tolerance.planes, strict=True):
                shares.append(magnitude / plane.permissible_g_mm)
        greatest: Array = np.maximum.reduce(shares)
        return greatest

    def plane_magnitudes(self, states: Array) -> list[Array]:
        """Return the unbalance (n,) seen in each tolerance plane."""
        vectors = (states @ weights.T for weights in plane_weights(self.tolerance.places_mm))
        return [np.hypot(vector[:, 0], vector[:, 1]) for vector in vectors]


def plane_weights(places_mm: tuple[float, float] | None) -> list[Array]:
    """Return the matrix (2, 4) that makes each plane's unbalance of a state; none without planes."""
    if places_mm is None:
        return []
    a, b = places_mm
    eye = np.eye(2)
    in_a = np.concatenate([b * eye, -eye], axis=1) / (b - a)
    return [in_a, np.concatenate([eye, np.zeros((2, 2))], axis=1) - in_a]


def linear_spread_g_mm(covariance: Array) -> float:
    """Return 1.959964 √trace of the covariance of the resultant."""
    return Z_95 * math.sqrt(float(np.trace(covariance[:2, :2])))


@dataclass(frozen=True)
class Contribution:
    """Part of one cause in the spread."""

    name: str
    pm: float
    unit: str
    distribution: Distribution
    share: float
    plane_shares: tuple[float, float] | None
    effect_g_mm: tuple[float, float] | None


def contributions(model: LinearModel) -> list[Contribution]:
    """Return each cause's part of the trace of the resultant's covariance, and of each plane's, falling."""
    total = model.covariance()
    planes = plane_weights(model.tolerance.places_mm)
    shares_of = []
    for cause in dict.fromkeys(draw.cause for draw in model.draws):
        own = [draw for draw in model.draws if draw.cause == cause]
        covariance = sum((draw.covariance for draw in own), np.zeros((4, 4)))
        shares = [_part(weights @ covariance @ weights.T, weights @ total @ weights.T) for weights in planes]
        widest = max(own, key=lambda draw: draw.pm)
        shares_of.append(
            Contribution(
                cause,
                widest.pm,
                widest.unit,
                widest.distribution,
                _part(covariance[:2, :2], total[:2, :2]),
                (shares[0], shares[1]) if shares else None,
                None if widest.is_vector else _at_ends(model.nominal, own),
            )
        )
    return sorted(shares_of, key=lambda each: -each.share)


def _part(own: Array, total: Array) -> float:
    whole = float(np.trace(total))
    return float(np.trace(own)) / whole if whole > 0.0 else 0.0


def _at_ends(nominal: Array, draws: Sequence[Draw]) -> tuple[float, float]:
    """Return the resultant's magnitude with every draw of a cause at −pm and at +pm."""
    moved = sum((draw.pm * draw.effect[0] for draw in draws), np.zeros(4))
    low, high = (nominal + sign * moved for sign in (-1.0, 1.0))
    return math.hypot(*low[:2]), math.hypot(*high[:2])
