"""A further stage as lines to read: the cuts, and the reading that they follow from."""

from __future__ import annotations

from pathlib import Path

from autobalance.report.balance.text import balance_text
from autobalance.report.balance.zero import Zero, ZeroChoice
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balanced import BalancedReport
from autobalance.report.records.stage import StageUnbalance


def recut_text(
    report: BalancedReport,
    units: DisplayUnits,
    folder: Path | None = None,
    verbose: bool = False,
    zero: ZeroChoice = "keyway",
) -> str:
    """Return the summary of the cuts, then the reading beside the expected unbalance."""
    stage = report.stages[-1]
    serial = "" if stage.serial is None else f" of {stage.serial}"
    origin = Zero.of(report, zero)
    read, expected = (_unbalance(each, units, origin) for each in (stage.reading, stage.expected))
    bob_weights = ", ".join(units.of_bob_weight(each) for each in stage.bob_weights_g)
    lines = [
        balance_text(report, units, folder, verbose, zero),
        "",
        f"Stage {stage.stage}{serial}",
        f"  read      {read}",
        f"  expected  {expected}",
        f"  angles from {origin.name}; bob-weights fitted: {bob_weights}",
    ]
    return "\n".join(lines)


def _unbalance(values: StageUnbalance | None, units: DisplayUnits, zero: Zero) -> str:
    assert values is not None  # a stage after the first has both
    off = values.uncertainty_g_mm
    doubt = "" if off is None else f" ± {units.of_unbalance(off)}"
    return units.of_vector(values.magnitude_g_mm, zero.ccw(values.angle_deg), doubt)
