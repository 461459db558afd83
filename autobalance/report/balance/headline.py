"""First lines of a summary, and the limits that would reach the tolerance."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from itertools import groupby

from autobalance.declare import present
from autobalance.planning.relaxation import Relaxation
from autobalance.quantities import Text, g, joined, said
from autobalance.report.balance.kinds import apart
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.wording import listed_numbers

# Settings of ``--set`` that would reach the tolerance, as lines for people.


def relaxation_lines(report: BalancedReport) -> list[Text]:
    """Return a line for each relaxation that changes the job: its settings, and the result they lead to."""
    return [_line(each) for each in report.relaxations if each.changes]


def _line(relaxation: Relaxation) -> Text:
    settings = " ".join(
        "--set " + shlex.quote(f"{change.key}={json.dumps(change.proposed, ensure_ascii=False)}")
        for change in relaxation.changes
    )
    comes_to: list[str] = [f"leaves {relaxation.used_share:.2f} of the permissible value"]
    metal_g = relaxation.metal_g
    comes_to += [] if metal_g is None else [said("{} of metal in all", g(metal_g, ".1f"))]
    comes_to += [] if relaxation.tried else ["not tried"]
    return said("{}: {}", settings, joined(", ", comes_to))


# First lines of a summary: the verdict, what to do, what is left of what is permitted; then why.


OUTCOMES = {
    "within_tolerance": "WITHIN TOLERANCE",
    "already_within_tolerance": "WITHIN TOLERANCE ALREADY",
    "above_tolerance": "ABOVE TOLERANCE",
}
FACTOR_DIGITS = (2, 4)
"""Decimals of a balance factor, and those used if two factors read the same with fewer."""
CLAUSE = "; "


def headline(report: BalancedReport, units: DisplayUnits) -> list[str]:
    """Return the three lines of the answer: verdict, next step, and residual."""
    return [_verdict(report), _to_do(report, units), _left(report, units)]


def why(report: BalancedReport, units: DisplayUnits) -> list[str]:
    """Return the reason of a verdict, a line for each clause, then the settings that would help."""
    lines = [f"  - {clause}" for clause in _clauses(report, units)]
    lines += [f"  - {in_units(line, units)}" for line in relaxation_lines(report)]
    if not report.is_above:
        return [*_unproven(report), *lines]
    said_already = f"  - {_remedy(report, units)}"
    return [line for line in lines if line != said_already]


def _verdict(report: BalancedReport) -> str:
    if report.is_above:
        return OUTCOMES["above_tolerance"]
    return OUTCOMES[report.shown_outcome] + (", NOT PROVEN" if report.is_unproven else ", proven")


def _to_do(report: BalancedReport, units: DisplayUnits) -> str:
    if report.is_above:
        return f"{_factors(report)}; to be within tolerance: {_remedy(report, units)}"
    return f"{_factors(report)}: {_cuts(report.corrections, units) or 'nothing to cut'}"


def _remedy(report: BalancedReport, units: DisplayUnits) -> str:
    """Return the remedies that reach the tolerance: settings if there are any, else the end of the reason."""
    lines = relaxation_lines(report)
    return in_units(lines[0], units) if lines else "; ".join(_clauses(report, units)[-1:])


def _clauses(report: BalancedReport, units: DisplayUnits) -> list[str]:
    reason = in_units(report.reason, units) if report.reason else ""
    return [clause for clause in reason.split(CLAUSE) if clause]


def _factors(report: BalancedReport) -> str:
    factor = report.balance_factor
    if factor.initial is None or factor.final is None:
        return "throws cancel, no balance factor"
    before, after = (round(each, FACTOR_DIGITS[1]) + 0.0 for each in (factor.initial, factor.final))
    few, many = FACTOR_DIGITS
    if f"{before:.{many}f}" == f"{after:.{many}f}":
        return f"factor {after:.{many}f}"
    digits = few if f"{before:.{few}f}" != f"{after:.{few}f}" else many
    return f"factor {before:.{digits}f} → {after:.{digits}f}"


def _cuts(corrections: Sequence[Cut], units: DisplayUnits) -> str:
    """Return the cuts in a few words: tool, webs, number, depths, and the metal that they take."""
    kinds = groupby(sorted(corrections, key=_tool), key=_tool)
    words = ", ".join(_cuts_alike(list(alike), units) for _, alike in kinds)
    off, on = (sum(each.removed_mass_g for each in some) for some in apart(corrections))
    amounts = [f"{units.of_mass(abs(off))}{' added' * (off < 0.0)}"] if off else []
    amounts += [f"{units.of_mass(abs(on))} added"] if on else []
    return f"{words} ({', '.join(amounts)})" if words else ""


def _tool(correction: Cut) -> tuple[str, float]:
    return correction.of_kind.verb, correction.diameter_mm or 0.0


def _cuts_alike(alike: Sequence[Cut], units: DisplayUnits) -> str:
    diameter = alike[0].diameter_mm
    tool = "" if diameter is None else f" ⌀{units.of_size(diameter)}"
    webs = sorted({web for each in alike for web in each.all_webs})
    place = f" web{'s' * (len(webs) > 1)} {listed_numbers(webs)}" if webs else ""
    depths = sorted(abs(each.depth_mm) for each in alike)
    first, last = units.of_size(depths[0]), units.of_size(depths[-1])
    depth = first if first == last else f"{first.partition(' ')[0]} to {last}"
    count = f", {len(alike)} {alike[0].of_kind.piece}s of {depth}" if len(alike) > 1 else f", {depth}"
    return f"{alike[0].of_kind.verb}{tool}{place}{count}"


def _left(report: BalancedReport, units: DisplayUnits) -> str:
    """Return the judged residual nearest to its limit, with its uncertainty."""
    place, left, permitted = report.tolerance.worst(report.residual)
    off = report.residual.uncertainty_g_mm
    for plane in report.residual.planes:
        if place == f"plane {plane.name}":
            off = present(plane.uncertainty_g_mm)
    doubt = "" if off is None else f" ± {units.g_mm(off)}"
    return f"left {units.g_mm(left)}{doubt} of {units.of_unbalance(permitted)} permitted ({place})"


def _unproven(report: BalancedReport) -> list[str]:
    """Return the reason of an unproven verdict; empty if it is proven or above tolerance."""
    if not report.is_unproven:
        return []
    if report.reason:
        about = {doubt.about for doubt in report.crank.doubts}
        meant = "the main journal" if about <= {"main_journal"} else "the shaft"
        return [f"  not proven: the verdict depends on which cylinder is {meant} (--strict: 4)"]
    return ["  not proven: residual plus uncertainty exceeds the permissible unbalance (--strict: 4)"]
