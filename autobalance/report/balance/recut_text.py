"""A further stage as lines to read: the reading, and the cuts."""

from __future__ import annotations

from autobalance.report.balance.text import balance_text
from autobalance.report.display_units import DisplayUnits
from autobalance.types import Values


def recut_text(report: Values, units: DisplayUnits) -> str:
    """Return the reading beside the expected unbalance, then the summary of the cuts."""
    stage = report["stages"][-1]
    serial = "" if stage["serial"] is None else f" of {stage['serial']}"
    read, expected = (_unbalance(stage[key], units) for key in ("reading", "expected"))
    bob_weights = ", ".join(units.of_mass(each) for each in stage["bob_weights_g"])
    lines = [
        f"Stage {stage['stage']}{serial}: read {read}, expected {expected}",
        f"Bob-weights fitted: {bob_weights}",
        "",
        balance_text(report, units),
    ]
    return "\n".join(lines)


def _unbalance(values: Values, units: DisplayUnits) -> str:
    off = values["uncertainty_g_mm"]
    doubt = "" if off is None else f" ± {units.of_unbalance(off)}"
    return units.of_vector(values["magnitude_g_mm"], values["angle_deg"], doubt)
