"""Balance factors as lines to read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from autobalance.engines.factor.answer import Candidate, FactorReport, Reach
from autobalance.report.display_units import DisplayUnits
from autobalance.report.tables import table

NAMES = {"least_peak": "smallest peak force"}
OUTCOMES = {
    "already_within_tolerance": "as it is",
    "within_tolerance": "within",
    "above_tolerance": "NOT REACHED",
}


def factor_text(report: FactorReport, units: DisplayUnits) -> str:
    """Return the present factor first, then what each candidate leaves and costs, then what to do."""
    crank = report.job["crankshaft"]["file"] or report.job["file"]
    name = Path(crank).name
    if report.present is None:
        head = f"{name}: no balance factor\n{report.reason}"
    else:
        head = f"{name}: balance factor {report.present:.4f} as it is, with these parts"
    parts = [f"{head}\n{report.layout}, stroke {units.of_length(report.stroke_mm)}"]
    if report.motion is not None:
        parts.append(_forces(report))
    parts.append(_costs(report.candidates, units))
    parts.append("Take one: --factor F with a crank's file, balance.factor in a job.")
    return "\n\n".join(parts)


def _name(each: Candidate) -> str:
    return f"  {NAMES.get(each.name, each.name)}"


def _forces(report: FactorReport) -> str:
    rows: list[Sequence[str]] = [("Force [N]", "factor", "maximum", "along", "across", "mains")]
    for each in report.candidates:
        forces = [each.greatest_n, each.along_n, each.across_n, max(each.mains_n, default=None)]
        shown = ("-" if force is None else f"{force:.0f}" for force in forces)
        rows.append((_name(each), f"{each.factor:.4f}", *shown))
    motion = "" if report.motion == "exact" else ", first order alone"
    return table(rows) + f"\n  inertia of the whole engine at {report.speed_rpm:g} rpm{motion}"


def _costs(candidates: Sequence[Candidate], units: DisplayUnits) -> str:
    unit = units.length
    rows: list[Sequence[str]] = [
        ("To reach it", "bob-weight", "outcome", "metal", f"deepest [{unit}]", "cuts")
    ]
    for each in candidates:
        bob = f"{each.bob_weights_g[0]:.2f} g" if each.bob_weights_g else "-"
        rows.append((_name(each), bob, *_reach(each.reach, units)))
    several = any(len(set(each.bob_weights_g)) > 1 for each in candidates)
    note = "\n  bob-weight of throw 1; --json has all" if several else ""
    if candidates and candidates[0].reach is None:
        note += "\n  grade and speed are open: nothing is planned"
    return table(rows) + note


def _reach(reach: Reach | None, units: DisplayUnits) -> tuple[str, str, str, str]:
    if reach is None:
        return ("-", "-", "-", "-")
    deepest = reach.deepest_mm / units.mm_per_length
    return (
        OUTCOMES[reach.outcome],
        f"{reach.metal_g:.1f} g",
        f"{deepest:.{units.length_digits}f}",
        str(reach.cuts),
    )
