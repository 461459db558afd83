"""Suggestions for a wanted balance factor or inertia, as lines to read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from autobalance.report.records.stage import Suggestion, Suggestions, SuggestionState, SuggestionWanted
from autobalance.units import G_MM2_PER_KG_MM2


def suggestions_text(suggestions: Suggestions | None) -> str:
    """Return the suggestions of a report; empty without any."""
    if suggestions is None:
        return ""
    targets = suggestions.wanted
    aims = " and ".join(_quantities(targets))
    lines = [f"For {aims}, instead of {' and '.join(_quantities(suggestions.now, targets))}:"]
    lines += [line for each in suggestions.found for line in _suggestion(each, targets)]
    if not suggestions.found:
        lines.append("  no change that was tried reaches it")
    lines += [f"  not {_name(each.kind)}: {each.reason}" for each in suggestions.refused]
    return "\n".join(lines)


def _suggestion(each: Suggestion, targets: SuggestionWanted) -> Sequence[str]:
    reached = "" if each.reached else ", not quite the target"
    state = each.leaves.state
    measured = " and ".join(_quantities(state, replace(targets, inertia_g_mm2=state.inertia_g_mm2)))
    name = each.text if each.kind in ("hole", "weight", "rim") else each.text[0].upper() + each.text[1:]
    return (f"  {name}", f"    tried: {measured}, {each.leaves.mass_change_g:+.1f} g{reached}")


def _quantities(
    values: SuggestionWanted | SuggestionState, where: SuggestionWanted | None = None
) -> list[str]:
    """Return balance factor and inertia in words, each only where ``where`` has it."""
    asked = values if where is None else where
    factor, inertia = values.balance_factor, values.inertia_g_mm2
    words = []
    if factor is not None and asked.balance_factor is not None:
        words.append(f"balance factor {100.0 * factor:.2f} %")
    if inertia is not None and asked.inertia_g_mm2 is not None:
        words.append(f"{inertia / G_MM2_PER_KG_MM2:.6g} kg·mm²")
    return words


def _name(kind: str) -> str:
    return kind.replace("_and_", " and ").replace("_", " ")
