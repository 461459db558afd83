"""Arrays held against others as ``pytest.approx`` does it: many numbers in a hundredth of its time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def near(found: ArrayLike, wanted: ArrayLike, *, rel: float = 0.0, within: float = 1e-12) -> bool:
    """Return whether every number is within the share ``rel`` of what is wanted there, or ``within`` it."""
    one, other = np.asarray(found), np.asarray(wanted)
    if one.shape != other.shape:
        return False
    return bool((np.abs(one - other) <= np.maximum(rel * np.abs(other), within)).all())
