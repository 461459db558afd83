"""Limit that a listed hole misses at its own place, and the amount."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

from autobalance.correction.holes.cut import HoleCut
from autobalance.correction.refusals import ALL_AROUND, wall_missed
from autobalance.errors import CorrectionError

C = TypeVar("C", bound=HoleCut)


class _Limits(Protocol):
    @property
    def min_wall_mm(self) -> float: ...


def missed(
    there: Callable[..., Sequence[C]],
    is_kept: Callable[[C], bool],
    limits: _Limits,
    wall_left_mm: Callable[[C], float],
) -> str | None:
    """Return the limit that a hole misses, in words; None if it would not fit without its limits either.

    Parameters
    ----------
    there : callable
        Takes eased limits by name and returns the holes that fit at the place.
    is_kept : callable
        Whether one of these is the listed hole.
    wall_left_mm : callable
        The wall that it leaves at the least depth.
    """

    def eased(**limits_eased: Any) -> C | None:
        try:
            return next((cut for cut in there(**limits_eased) if is_kept(cut)), None)
        except CorrectionError:
            return None

    cut = eased(min_wall_mm=0.0)
    if cut is not None:
        return wall_missed(wall_left_mm(cut), limits.min_wall_mm)
    if eased(sectors_deg=ALL_AROUND) is not None:
        return "it lies outside of sectors_deg"
    return None
