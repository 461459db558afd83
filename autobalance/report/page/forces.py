"""The rows of the page's table of forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from autobalance.types import Report
from autobalance.wording import at

NEGLIGIBLE_ORDER = 0.05
"""Forces [N] and moments [N·m] of orders below it would show as 0.0, and are left out."""
FORCES = {
    "greatest_n": "Maximum force [N]",
    "greatest_inline_n": "Largest force along x, N",
    "greatest_transverse_n": "Largest force along y, N",
}
ORDER_FORCES = {
    "force_x_n": "along x, N",
    "force_y_n": "along y, N",
    "greatest_force_n": "maximum [N]",
    "greatest_moment_n_m": "maximum moment [N·m]",
}


def force_rows(report: Report) -> list[tuple[str, str]]:
    """Return path and name of each force that has values before and after, without orders that are zero."""
    forces = report.get("forces") or {}
    if not all(isinstance(forces.get(state), Mapping) for state in ("before", "after")):
        return []
    return [(path, name) for path, name in _rows(forces["before"]) if _is_shown(forces, path)]


def _is_shown(forces: Mapping[str, Any], path: str) -> bool:
    before, after = at(forces, f"before.{path}"), at(forces, f"after.{path}")
    if before is None or after is None:
        return False
    return not path.startswith("orders.") or max(abs(before), abs(after)) >= NEGLIGIBLE_ORDER


def _rows(forces: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, name in FORCES.items():
        if key in forces:
            yield key, name
    for k, order in enumerate(forces.get("orders", [])):
        for key, name in ORDER_FORCES.items():
            yield f"orders.{k}.{key}", f"Order {order['order']:g}: {name}"
