"""Suggestions for a wanted balance factor or inertia, as lines to read."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.types import Values


def suggestions_text(suggestions: Values | None) -> str:
    """Return the suggestions of a report; empty where it has none."""
    if suggestions is None:
        return ""
    targets, now = suggestions["wanted"], suggestions["now"]
    aims = " and ".join(_quantities(targets))
    lines = [f"For {aims}, instead of {' and '.join(_quantities(now, targets))}:"]
    lines += [line for each in suggestions["found"] for line in _suggestion(each, targets)]
    if not suggestions["found"]:
        lines.append("  no change that was tried reaches it")
    lines += [f"  not {_name(each['kind'])}: {each['reason']}" for each in suggestions["refused"]]
    return "\n".join(lines)


def _suggestion(each: Values, targets: Values) -> Sequence[str]:
    leaves = each["leaves"]
    reached = "" if each["reached"] else ", not quite the target"
    measured = " and ".join(_quantities(leaves, {**targets, "inertia_kg_mm2": 1.0}))
    if each["kind"] in ("hole", "weight", "rim"):
        name = each["text"]
    else:
        name = each["text"][0].upper() + each["text"][1:]
    return (f"  {name}", f"    tried: {measured}, {leaves['mass_change_g']:+.1f} g{reached}")


def _quantities(values: Values, where: Values | None = None) -> list[str]:
    """Return balance factor and inertia in words, each only where ``where`` has it."""
    where = values if where is None else where
    factor, inertia = values["balance_factor"], values["inertia_kg_mm2"]
    words = []
    if factor is not None and where["balance_factor"] is not None:
        words.append(f"balance factor {100.0 * factor:.2f} %")
    if inertia is not None and where["inertia_kg_mm2"] is not None:
        words.append(f"{inertia:.6g} kg·mm²")
    return words


def _name(kind: str) -> str:
    return kind.replace("_and_", " and ").replace("_", " ")
