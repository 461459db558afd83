"""How many seeds a test with random cranks takes: a few in every run, all of them in ``make fuzz``."""

from __future__ import annotations

import os

SWEPT = "AUTOBALANCE_FUZZ" in os.environ
"""Whether this is a sweep, which may take long."""


def seeds(always: int, swept: int) -> range:
    """Return seeds from 0: the first few, which cover the different cases, or in a sweep all of them."""
    return range(swept if SWEPT else always)
