"""Continuation of earlier stages: the same tools in the same places first, then anywhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from autobalance.correction.contract import Cut, EarlierCut
from autobalance.correction.holes.drill_series import SAME_MM


def same_setups(cuts: Sequence[Cut], earlier: Sequence[EarlierCut]) -> Iterator[list[int]]:
    """Yield indices of cuts without a new set-up: first without a new place, then without a new tool."""
    again = [k for k, cut in enumerate(cuts) if _goes_on(cut, earlier)]
    same_tool = [k for k, cut in enumerate(cuts) if any(_is_tool_of(cut, each) for each in earlier)]
    for tier in (again, same_tool):
        if tier and len(tier) < len(cuts):
            yield tier


def _goes_on(cut: Cut, earlier: Sequence[EarlierCut]) -> bool:
    """Return whether a cut deepens a hole of an earlier stage with the drill that made it."""
    entry, site = getattr(cut, "first_entry_mm", None), getattr(cut, "site", None)
    if entry is None or site is None or not site.sunk_mm:
        return False
    return any(each.is_at(entry) and _is_tool_of(cut, each) for each in earlier)


def _is_tool_of(cut: Cut, earlier: EarlierCut) -> bool:
    diameter = getattr(cut, "diameter_mm", None)
    if diameter is None or earlier.diameter_mm is None:
        return False
    return abs(float(diameter) - earlier.diameter_mm) < SAME_MM
