"""A report as lines that a mechanic can read, from the report's own values."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from autobalance.balancing.sections import section, sections_in
from autobalance.correction.holes import drill_words
from autobalance.declare import decoded
from autobalance.quantities import g
from autobalance.report.balance.kinds import angle_deg, verb
from autobalance.report.balance.relaxation_text import relaxation_lines
from autobalance.report.balance.scan_text import against_text
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.records.against import Against
from autobalance.report.tables import table
from autobalance.types import Values
from autobalance.wording import NOT_PROVEN, degrees, is_unproven

OUTCOMES = {
    "within_tolerance": "WITHIN TOLERANCE",
    "already_within_tolerance": "WITHIN TOLERANCE ALREADY: nothing to cut",
    "above_tolerance": "ABOVE TOLERANCE",
}


def unproven(report: Values) -> str:
    """Return the words after the verdict where the uncertainty leaves it open; else empty."""
    return NOT_PROVEN.upper() if is_unproven(report) else ""


def balance_text(report: Values, units: DisplayUnits, folder: Path | None = None) -> str:
    """Return the summary of a balancing run: the verdict, the cuts, before and after.

    ``folder`` is that of the report: the crank's file is then named relative to the working folder.
    """
    parts = [
        _heading(report, units, folder),
        _corrections(report, units),
        _before_and_after(report, units),
        _factor(report, units),
        _forces(report),
        *_sections(report),
        _changes(report, units),
        _overbalance(report, units),
        _external(report, units),
        _oil(report, units),
        _assembly(report, units),
    ]
    return "\n\n".join(part for part in parts if part)


def _sections(report: Values) -> Iterator[str]:
    """Yield the lines of the sections that add-ons have put into a report."""
    for key, found in sections_in(report):
        yield section(key).text(found)


def _assembly(report: Values, units: DisplayUnits) -> str:
    if not report.get("assembly"):
        return ""
    from autobalance.report.balance.assembly_text import assembly_text

    return assembly_text(report["assembly"], units)


def _heading(report: Values, units: DisplayUnits, folder: Path | None) -> str:
    lines = [f"{input_path(report, folder)}: {OUTCOMES[report['outcome']]}{unproven(report)}"]
    lines += [in_units(report["reason"], units)] if report["reason"] else []
    lines += [f"  {in_units(line, units)}" for line in relaxation_lines(report)]
    facets = report["crank"]["facet_error"] or {}
    lines += [in_units(facets["too_coarse"]["text"], units)] if facets.get("too_coarse") else []
    if facets.get("correction") in {"applied", "mass_only"}:
        hidden = units.of_quantity(g(facets["mass_g"], "+.3g"))
        lines.append(f"chord error of the facets added to all measurements: {hidden}")
    lines += [facets["reason"]] if facets.get("reason") else []
    if "scan" in report["input"]:
        lines.append(f"mass and unbalance are those of the scan {report['input']['scan']['file']}")
        lines.append(against_text(decoded(Against, report["against"]), report["crank"]["mass_g"], units))
    return "\n".join(lines)


def input_path(report: Values, folder: Path | None) -> str:
    """Return the crank's file relative to the working folder; as in the report if its folder is unknown."""
    file = str(report["input"]["file"])
    if folder is None or report["input"]["file"] is None:
        return file
    try:
        return os.path.relpath(folder / file)
    except ValueError:  # another drive
        return file


LESS_THAN_A_SIDE_DEG = 179.0
"""Span below which the part of a face is named."""


def remarks(report: Values) -> tuple[str, ...]:
    """Return the lines beneath the cuts: places that they weaken, then notes."""
    return (*(report.get("weak_places") or ()), *(report.get("notes") or ()))


def _corrections(report: Values, units: DisplayUnits) -> str:
    if not report["corrections"]:
        return ""
    notes = [f"  {in_units(remark, units)}" for remark in remarks(report)]
    return "\n".join(["Cuts to make"] + [_correction(each, units) for each in report["corrections"]] + notes)


def _correction(correction: Values, units: DisplayUnits) -> str:
    what = verb(correction)
    if correction.get("diameter_mm") is not None:
        what += f" ⌀{units.of_length(correction['diameter_mm'])}"
        drill = drill_words.called(correction)
        what += f" ({drill})" if drill and drill not in what else ""
    where = [f"face {correction['face']}"] if correction["face"] is not None else []
    sector = correction.get("sector_deg")
    start, end = sector if isinstance(sector, list | tuple) else (0.0, 360.0)  # may be one angle
    if 0.0 < (end - start) % 360.0 < LESS_THAN_A_SIDE_DEG:
        where.append(f"its part from {degrees(start)} to {degrees(end)}")
    where += [f"web {correction['web']}"] if correction["web"] is not None else []
    if (angle := angle_deg(correction)) is not None:
        where.append(f"at {degrees(angle)}")
    size = units.of_length(abs(correction["depth_mm"]))
    if old_mm := correction.get("deepened_from_mm"):
        size += f" deeper, to {units.of_length(old_mm + correction['depth_mm'])}"
    off = units.of_mass(abs(correction["removed_mass_g"]))
    return (
        f"  {correction['number']:>2}. {what} {', '.join(where)}: {size} "
        f"({off} {'off' if correction['removed_mass_g'] >= 0.0 else 'on'}, centre "
        f"{units.of_length(correction['radius_mm'])} from the axis, "
        f"z {units.of_length(correction['position_mm'][2])})"
    )


def _before_and_after(report: Values, units: DisplayUnits) -> str:
    tolerance = report["tolerance"]
    passes = len(report["steps"])
    rows = [("Unbalance", "before", "after", "uncertain by", "permitted")]
    judged = "" if tolerance["judge"] == "dynamic" else " (not judged)"
    rows.append(
        (
            "  resultant",
            units.of_unbalance(report["initial"]["magnitude_g_mm"]),
            units.of_unbalance(report["residual"]["magnitude_g_mm"]),
            _plus_minus(report["residual"], units),
            units.of_unbalance(tolerance["permissible_g_mm"]),
        )
    )
    planes = zip(report["initial"]["planes"], report["residual"]["planes"], tolerance["planes"], strict=True)
    for before, after, plane in planes:
        rows.append(
            (
                f"  plane {plane['name']} (z {units.of_length(plane['z_mm'])}){judged}",
                units.of_unbalance(before["magnitude_g_mm"]),
                units.of_unbalance(after["magnitude_g_mm"]),
                _plus_minus(after, units),
                units.of_unbalance(plane["permissible_g_mm"]),
            )
        )
    return (
        table(rows)
        + f"\n  {_heavy_spot(report['residual'], units)};"
        + f" G {tolerance['grade_mm_s']:g} at {tolerance['speed_rpm']:g} rpm,"
        + f" rotor {units.of_mass(tolerance['rotor_mass_g'])}; {passes} pass{'' if passes == 1 else 'es'}"
        + _uncertainty(report["residual"], units)
        + _margin(report)
    )


def _heavy_spot(residual: Values, units: DisplayUnits) -> str:
    at = units.pointing(residual["magnitude_g_mm"], residual["angle_deg"])
    return (
        f"residual heavy spot{at} from throw 1, counter-clockwise seen from +z"
        if at
        else "no heavy spot is left"
    )


def _plus_minus(unbalance: Values, units: DisplayUnits) -> str:
    off = unbalance.get("uncertainty_g_mm")
    return "unknown" if off is None else f"± {units.of_unbalance(off)}"


def _uncertainty(residual: Values, units: DisplayUnits) -> str:
    """Return the uncertainty of the resultant with its causes, the largest first; empty where unknown."""
    if residual["uncertainty_g_mm"] is None:
        return ""
    shares = sorted(residual["uncertainty_shares_g_mm"].items(), key=lambda share: -share[1])
    listed = ", ".join(f"{cause} {units.of_unbalance(share)}" for cause, share in shares if share > 0.0)
    text = f"\n  uncertain by ± {units.of_unbalance(residual['uncertainty_g_mm'])}: {listed or 'nothing'}"
    if silent := residual.get("uncertainty_unstated"):
        text += f"\n  not stated in the job and not counted: {', '.join(silent)}"
    return text


def _margin(report: Values) -> str:
    """Return the note on the uncertainty in the verdict; empty where it neither counts nor would matter."""
    if is_unproven(report) and report["reason"]:
        about = {doubt["about"] for doubt in report["crank"].get("doubts", ())}
        meant = "the main journal" if about <= {"main_journal"} else "the shaft"
        return f"\n  not proven: the verdict hangs on which cylinder is {meant} (--strict: 4)"
    if is_unproven(report):
        return "\n  not proven: residual plus uncertainty exceeds the permissible unbalance (--strict: 4)"
    if report["tolerance"].get("margin", "none") == "none":
        return ""
    return "\n  the verdict counts the uncertainty: both together must be within the permissible unbalance"


def _factor(report: Values, units: DisplayUnits) -> str:
    factor, bob = report["balance_factor"], report["engine"]["bob_weights"]
    lines = ["Balance factor: " + _arrow(factor["initial"], factor["target"], factor["final"])]
    lines.append(
        "  bob-weights: " + ", ".join(f"throw {b['throw']} {units.of_bob_weight(b['mass_g'])}" for b in bob)
    )
    if report["counterweight"] is not None:
        web = report["counterweight"]
        product = web["product_g_mm"]
        lines.append(
            f"  counterweights {units.of_mass(web['mass_g'])} at {units.of_length(web['radius_mm'])}: "
            f"{units.of_unbalance(product['initial'])} before, {units.of_unbalance(product['final'])} after, "
            f"{units.of_unbalance(product['target'])} wanted"
        )
    return "\n".join(lines)


def _arrow(initial: float | None, target: float, final: float | None) -> str:
    if initial is None or final is None:
        return f"{target:.4f} asked for; the throws cancel each other out, so the crank has none"
    return f"{initial:.4f} before, {final:.4f} after, {target:.4f} wanted"


def _external(report: Values, units: DisplayUnits) -> str:
    """Return the unbalance that damper and flexplate or flywheel are to carry, with its tolerance."""
    parts = report.get("external")
    if not parts:
        return ""
    rows: list[Sequence[str]] = [("External part", "carries", "at", "may be off")]
    for each in parts:
        size, off = (units.of_unbalance(each[key]) for key in ("magnitude_g_mm", "pm_g_mm"))
        at = units.heavy_at(each["magnitude_g_mm"], each["angle_deg"])
        rows.append((f"  {each['name']}", size, at, f"± {off}"))
    return table(rows)


def _oil(report: Values, units: DisplayUnits) -> str:
    """Return the mass of the oil, and its share in the bob-weights."""
    oil = report.get("oil")
    if not oil:
        return ""
    all_of_it, in_bobs = (
        units.of_mass(sum(each[key] for each in oil)) for key in ("mass_g", "on_crankpin_g")
    )
    return f"Oil in bores and drillings: {all_of_it}; in the bob-weights {in_bobs}"


def _forces(report: Values) -> str:
    forces = report.get("forces")
    if forces is None:
        return ""
    before, after = (_first_order(forces[key]) for key in ("before", "after"))
    keys = ("greatest_force_n", "forward_n", "backward_n")
    rows: list[Sequence[str]] = [("First order", "before", "after")]
    for key, name in zip(keys, ("greatest", "with the crank", "against it"), strict=True):
        rows.append((f"  {name}", f"{before[key]:.0f} N", f"{after[key]:.0f} N"))
    if forces["after"]["greatest_n"] is not None:
        rows.append(("  all orders", *(f"{forces[key]['greatest_n']:.0f} N" for key in ("before", "after"))))
    return table(rows) + f"\n  shaking force of inertia at {forces['speed_rpm']:g} rpm"


def _first_order(force: Values) -> Values:
    first: Values = next(order for order in force["orders"] if order["order"] == 1.0)
    return first


def _changes(report: Values, units: DisplayUnits) -> str:
    if not report["corrections"]:
        return ""
    removed = sum(each["removed_mass_g"] for each in report["corrections"])
    word = "removed" if removed >= 0.0 else "added"
    before = report["crank"]["polar_inertia_kg_mm2"]
    change = report["inertia_change_kg_mm2"]
    return (
        f"Metal {word}: {units.of_mass(abs(removed))}, crank {units.of_mass(report['crank']['mass_g'])}; "
        f"polar inertia {units.of_inertia(before, 2)}, {units.of_inertia(change, 2, '+')} "
        f"({100.0 * change / before:+.2f} %)"
    )


def _overbalance(report: Values, units: DisplayUnits) -> str:
    left = report.get("overbalance")
    if left is None:
        return ""
    lines = [
        f"Left for final drilling: {units.of_unbalance(left['magnitude_g_mm'])} with the heavy side at "
        f"{degrees(left['angle_deg'])} (the table above counts from there)"
    ]
    lines += [_correction(each, units) for each in left["last_holes"]]
    if left["predicted_g_mm"] is not None:
        lines.append(f"  after these holes {units.of_unbalance(left['predicted_g_mm'])} will be left")
    if left["reason"]:
        lines.append(f"  {left['reason']}")
    return "\n".join(lines)
