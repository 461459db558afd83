"""The stack of washers that makes up a weight."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

STEP_G = 0.01
"""Weights that differ by less are one."""
MOST_STEPS = 200_000


def stack(wanted_g: float, washers_g: Sequence[float]) -> tuple[dict[float, int], float]:
    """Return the number of each washer nearest to a weight, fewest washers first, and the rest [g].

    The heaviest washers make up most of it; the rest is the exact optimum, any number of each, to
    ``STEP_G``. What is left is below 0 where the stack is too heavy.

    Examples
    --------
    >>> counts, left = stack(37.4, [1.0, 2.0, 5.0, 10.0])
    >>> counts, round(left, 6)
    ({10.0: 3, 5.0: 1, 2.0: 1}, 0.4)
    """
    sizes = sorted({float(each) for each in washers_g if each >= STEP_G}, reverse=True)
    if not sizes or wanted_g <= 0.0:
        return {}, wanted_g
    heaviest = sizes[0]
    before = max(0, math.floor(wanted_g / heaviest) - 2)
    rest = wanted_g - before * heaviest
    step = max(STEP_G, (rest + heaviest) / MOST_STEPS)
    steps = np.array([max(1, round(size / step)) for size in sizes])
    top = math.ceil((rest + heaviest) / step)
    fewest, last = np.full(top + 1, np.iinfo(np.int64).max // 2), np.full(top + 1, -1)
    fewest[0] = 0
    for k, long in enumerate(steps):
        for start in range(min(long, top + 1)):  # along each chain of equal remainders, in one sweep
            chain = fewest[start::long]
            counts = np.minimum.accumulate(chain - np.arange(len(chain))) + np.arange(len(chain))
            better = counts < chain
            fewest[start::long][better] = counts[better]
            last[start::long][better] = k
    reached = np.flatnonzero(fewest < np.iinfo(np.int64).max // 2)
    away = np.abs(reached * step - rest)
    best = int(reached[np.lexsort((fewest[reached], np.round(away / step)))[0]])
    by_size = dict.fromkeys(sizes, 0) | {heaviest: before}
    while best > 0:
        by_size[sizes[last[best]]] += 1
        best -= int(steps[last[best]])
    counts_by_size = {size: count for size, count in by_size.items() if count}
    return counts_by_size, wanted_g - sum(size * count for size, count in counts_by_size.items())
