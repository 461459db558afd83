"""A report as lines that a mechanic can read, from the report's own values."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from autobalance.balancing.sections import section, sections_in
from autobalance.crank.against import Against
from autobalance.declare import decoded
from autobalance.quantities import g
from autobalance.report.balance.headline import headline, why
from autobalance.report.balance.sections_text import against_text
from autobalance.report.balance.zero import Zero, ZeroChoice, corrections_text, cut_rows
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.tables import table, whole
from autobalance.types import Values
from autobalance.wording import degrees, is_unproven


def balance_text(
    report: Values,
    units: DisplayUnits,
    folder: Path | None = None,
    verbose: bool = False,
    zero: ZeroChoice = "keyway",
) -> str:
    """Return the summary of a balancing run: verdict, what to do, what is left; then cuts and unbalance.

    ``folder`` is that of the report: the crank's file is then named relative to the working folder. The rest
    (uncertainty, factor, forces, inertia) follows where it is ``verbose``.
    """
    origin = Zero.of(report, zero)
    parts = [
        "\n".join([*headline(report, units), *why(report, units), *_doubts_that_count(report, units)]),
        corrections_text(report, units, origin),
        _before_and_after(report, units, folder, origin),
        _bob_weights(report, units),
        _overbalance(report, units, origin),
        _external(report, units, origin),
        _assembly(report, units),
        *_sections(report),
        *(_details(report, units) if verbose else ()),
        _notes(report, units),
    ]
    return "\n\n".join(part for part in parts if part)


def _details(report: Values, units: DisplayUnits) -> Iterator[str]:
    """Yield what people look at where the first screen leaves a question."""
    yield _uncertainty(report, units)
    yield _factor(report, units)
    yield _forces(report)
    yield _changes(report, units)
    yield _oil(report, units)


def _sections(report: Values) -> Iterator[str]:
    """Yield the lines of the sections that add-ons have put into a report."""
    for key, found in sections_in(report):
        yield section(key).text(found)


def _assembly(report: Values, units: DisplayUnits) -> str:
    if not report.get("assembly"):
        return ""
    from autobalance.report.balance.sections_text import assembly_text

    return assembly_text(report["assembly"], units)


def _is_proven(report: Values) -> bool:
    return bool(report["outcome"] != "above_tolerance" and not is_unproven(report))


def _too_coarse(report: Values, units: DisplayUnits) -> list[str]:
    found = (report["crank"]["facet_error"] or {}).get("too_coarse")
    if not found:
        return []
    first, *others = in_units(found["text"], units).split("; ")
    return [f"  - {first}", *(f"    {each}" for each in others)]


def _doubts_that_count(report: Values, units: DisplayUnits) -> list[str]:
    """Return the reason that leaves a verdict open; empty if it is proven."""
    return _too_coarse(report, units) if is_unproven(report) else []


def _notes(report: Values, units: DisplayUnits) -> str:
    """Return the notes that change neither verdict nor cuts."""
    lines = [] if is_unproven(report) else _too_coarse(report, units)
    facets = report["crank"]["facet_error"] or {}
    if facets.get("correction") in {"applied", "mass_only"}:
        hidden = units.of_quantity(g(facets["mass_g"], "+.3g"))
        lines.append(f"  - chord error of the facets added to all measurements: {hidden}")
    lines += [f"  - {facets['reason']}"] if facets.get("reason") else []
    if "scan" in report["input"]:
        lines.append(f"  - mass and unbalance are those of the scan {report['input']['scan']['file']}")
        lines.append(against_text(decoded(Against, report["against"]), report["crank"]["mass_g"], units))
    return "\n".join(["Notes", *lines] if lines else [])


def input_path(report: Values, folder: Path | None) -> str:
    """Return the crank's file relative to the working folder; as in the report if its folder is unknown."""
    file = str(report["input"]["file"])
    if folder is None or report["input"]["file"] is None:
        return file
    try:
        return os.path.relpath(folder / file)
    except ValueError:  # another drive
        return file


def _before_and_after(report: Values, units: DisplayUnits, folder: Path | None, zero: Zero) -> str:
    tolerance = report["tolerance"]
    rows = [(f"Unbalance [{units.unbalance}]", "before", "after", "uncertain by", "permitted")]
    judged = "" if tolerance["judge"] == "dynamic" else " (not judged)"
    rows.append(
        (
            "  resultant",
            units.g_mm(report["initial"]["magnitude_g_mm"]),
            units.g_mm(report["residual"]["magnitude_g_mm"]),
            _plus_minus(report["residual"], units),
            units.g_mm(tolerance["permissible_g_mm"]),
        )
    )
    planes = zip(report["initial"]["planes"], report["residual"]["planes"], tolerance["planes"], strict=True)
    for before, after, plane in planes:
        rows.append(
            (
                f"  plane {plane['name']} (z {units.of_place(plane['z_mm'])}){judged}",
                units.g_mm(before["magnitude_g_mm"]),
                units.g_mm(after["magnitude_g_mm"]),
                _plus_minus(after, units),
                units.g_mm(plane["permissible_g_mm"]),
            )
        )
    return "\n".join(
        [
            table(rows),
            f"  {_heavy_spot(report['residual'], units, zero)}",
            f"  {whole(input_path(report, folder))}: {_judged_by(report, units)}",
            *_margin(report),
        ]
    )


def _judged_by(report: Values, units: DisplayUnits) -> str:
    tolerance, passes = report["tolerance"], len(report["steps"])
    return (
        f"G {tolerance['grade_mm_s']:g} at {tolerance['speed_rpm']:g} rpm, "
        f"rotor {units.of_mass(tolerance['rotor_mass_g'])}; {passes} pass{'' if passes == 1 else 'es'}"
    )


def _heavy_spot(residual: Values, units: DisplayUnits, zero: Zero) -> str:
    at = units.pointing(residual["magnitude_g_mm"], zero.ccw(residual["angle_deg"]))
    if not at:
        return "residual too small for an angle"
    return f"residual heavy spot{at} from {zero.name}, ccw seen from +z"


def _plus_minus(unbalance: Values, units: DisplayUnits) -> str:
    off = unbalance.get("uncertainty_g_mm")
    return "unknown" if off is None else f"± {units.g_mm(off)}"


def _uncertainty(report: Values, units: DisplayUnits) -> str:
    """Return the uncertainty of the resultant with its causes, the largest first; empty where unknown."""
    residual = report["residual"]
    if residual["uncertainty_g_mm"] is None:
        return ""
    shares = sorted(residual["uncertainty_shares_g_mm"].items(), key=lambda share: -share[1])
    rows = [("Uncertainty", f"± {units.of_unbalance(residual['uncertainty_g_mm'])}")]
    rows += [(f"  {cause}", f"± {units.of_unbalance(share)}") for cause, share in shares if share > 0.0]
    text = table(rows)
    if silent := residual.get("uncertainty_unstated"):
        text += f"\n  no tolerance given for {', '.join(silent)}: taken as 0"
    return text


def _margin(report: Values) -> list[str]:
    """Return the note on the uncertainty in the verdict; none where it does not count."""
    if report["tolerance"].get("margin", "none") == "none" or is_unproven(report):
        return []
    return ["  the verdict counts the uncertainty: both together must be within the permissible unbalance"]


def _bob_weights(report: Values, units: DisplayUnits) -> str:
    bob = report["engine"]["bob_weights"]
    listed = ", ".join(f"throw {each['throw']} {units.of_bob_weight(each['mass_g'])}" for each in bob)
    return f"Bob-weights: {listed}"


def _factor(report: Values, units: DisplayUnits) -> str:
    factor = report["balance_factor"]
    lines = ["Balance factor: " + _arrow(factor["initial"], factor["target"], factor["final"])]
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
        return f"{target:.4f} requested; the throws cancel, so the crank has no balance factor"
    return f"{initial:.4f} before, {final:.4f} after, {target:.4f} wanted"


def _external(report: Values, units: DisplayUnits, zero: Zero) -> str:
    """Return the unbalance that damper and flexplate or flywheel are to carry, with its tolerance."""
    parts = report.get("external")
    if not parts:
        return ""
    rows: list[Sequence[str]] = [("External part", "carries", f"at, from {zero.name}", "tolerance")]
    for each in parts:
        size, off = (units.of_unbalance(each[key]) for key in ("magnitude_g_mm", "pm_g_mm"))
        at = units.heavy_at(each["magnitude_g_mm"], zero.ccw(each["angle_deg"]))
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
    for key, name in zip(keys, ("maximum", "with the crank", "against it"), strict=True):
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


def _overbalance(report: Values, units: DisplayUnits, zero: Zero) -> str:
    left = report.get("overbalance")
    if left is None:
        return ""
    heavy = degrees(zero.ccw(left["angle_deg"]))
    lines = [
        f"Left for final drilling: {units.of_unbalance(left['magnitude_g_mm'])}, heavy side at {heavy} from "
        f"{zero.name} (the table above counts from there)"
    ]
    lines += [cut_rows("Last holes", left["last_holes"], units, zero)] if left["last_holes"] else []
    if left["predicted_g_mm"] is not None:
        lines.append(f"  after these holes {units.of_unbalance(left['predicted_g_mm'])} will be left")
    if left["reason"]:
        lines.append(f"  {left['reason']}")
    return "\n".join(lines)
