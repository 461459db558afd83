"""Random numbers for studies, and proportions and percentiles of samples."""

from __future__ import annotations

import hashlib
import math
from typing import Literal, Self

import numpy as np
from scipy.special import ndtri

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
