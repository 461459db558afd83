"""A report as lines that a mechanic can read, from the report's own values."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from autobalance.balancing.sections import section, sections_in
from autobalance.declare import ABSENT, present
from autobalance.quantities import g
from autobalance.report.balance.headline import headline, why
from autobalance.report.balance.sections_text import against_text
from autobalance.report.balance.zero import Zero, ZeroChoice, corrections_text, cut_rows
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.records.balance import Plane, Unbalance
from autobalance.report.records.balanced import BalancedReport
from autobalance.report.records.stage import StageUnbalance
from autobalance.report.tables import table, whole
from autobalance.running_gear.roll import ShakingForce
from autobalance.running_gear.whole_engine import ForceOrder
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.wording import degrees


def balance_text(
    report: BalancedReport,
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


def _details(report: BalancedReport, units: DisplayUnits) -> Iterator[str]:
    """Yield what people look at where the first screen leaves a question."""
    yield _uncertainty(report, units)
    yield _factor(report, units)
    yield _forces(report)
    yield _changes(report, units)
    yield _oil(report, units)


def _sections(report: BalancedReport) -> Iterator[str]:
    """Yield the lines of the sections that add-ons have put into a report."""
    for key, found in sections_in(report.of_addons):
        yield section(key).text(found)


def _assembly(report: BalancedReport, units: DisplayUnits) -> str:
    if not report.assembly:
        return ""
    from autobalance.report.balance.sections_text import assembly_text

    return assembly_text(report.assembly, units)


def _too_coarse(report: BalancedReport, units: DisplayUnits) -> list[str]:
    facets = report.crank.facet_error
    if facets is None or facets.too_coarse is None:
        return []
    first, *others = in_units(facets.too_coarse.text, units).split("; ")
    return [f"  - {first}", *(f"    {each}" for each in others)]


def _doubts_that_count(report: BalancedReport, units: DisplayUnits) -> list[str]:
    """Return the reason that leaves a verdict open; empty if it is proven."""
    return _too_coarse(report, units) if report.is_unproven else []


def _notes(report: BalancedReport, units: DisplayUnits) -> str:
    """Return the notes that change neither verdict nor cuts."""
    lines = [] if report.is_unproven else _too_coarse(report, units)
    facets = report.crank.facet_error
    if facets is not None and facets.correction in {"applied", "mass_only"}:
        hidden = units.of_quantity(g(facets.mass_g, "+.3g"))
        lines.append(f"  - chord error of the facets added to all measurements: {hidden}")
    lines += [f"  - {facets.reason}"] if facets is not None and facets.reason else []
    if report.input.scan is not ABSENT:
        lines.append(f"  - mass and unbalance are those of the scan {report.input.scan.file}")
        lines.append(against_text(present(report.against), report.crank.body.mass_g, units))
    return "\n".join(["Notes", *lines] if lines else [])


def input_path(report: BalancedReport, folder: Path | None) -> str:
    """Return the crank's file relative to the working folder; as in the report if its folder is unknown."""
    file = str(report.input.file)
    if folder is None or report.input.file is None:
        return file
    try:
        return os.path.relpath(folder / file)
    except ValueError:  # another drive
        return file


def _before_and_after(report: BalancedReport, units: DisplayUnits, folder: Path | None, zero: Zero) -> str:
    tolerance = report.tolerance
    rows = [(f"Unbalance [{units.unbalance}]", "before", "after", "uncertain by", "permitted")]
    judged = "" if tolerance.judge == "dynamic" else " (not judged)"
    rows.append(
        (
            "  resultant",
            units.g_mm(report.initial.magnitude_g_mm),
            units.g_mm(report.residual.magnitude_g_mm),
            _plus_minus(report.residual, units),
            units.g_mm(tolerance.permissible_g_mm),
        )
    )
    planes = zip(report.initial.planes, report.residual.planes, tolerance.planes, strict=True)
    for before, after, plane in planes:
        rows.append(
            (
                f"  plane {plane.name} (z {units.of_place(plane.z_mm)}){judged}",
                units.g_mm(before.magnitude_g_mm),
                units.g_mm(after.magnitude_g_mm),
                _plus_minus(after, units),
                units.g_mm(plane.permissible_g_mm),
            )
        )
    return "\n".join(
        [
            table(rows),
            f"  {_heavy_spot(report.residual, units, zero)}",
            f"  {whole(input_path(report, folder))}: {_judged_by(report, units)}",
            *_margin(report),
        ]
    )


def _judged_by(report: BalancedReport, units: DisplayUnits) -> str:
    tolerance, passes = report.tolerance, len(report.steps)
    return (
        f"G {tolerance.grade_mm_s:g} at {tolerance.speed_rpm:g} rpm, "
        f"rotor {units.of_mass(tolerance.rotor_mass_g)}; {passes} pass{'' if passes == 1 else 'es'}"
    )


def _heavy_spot(residual: Unbalance, units: DisplayUnits, zero: Zero) -> str:
    at = units.pointing(residual.magnitude_g_mm, zero.ccw(residual.angle_deg))
    if not at:
        return "residual too small for an angle"
    return f"residual heavy spot{at} from {zero.name}, ccw seen from +z"


def _plus_minus(unbalance: Unbalance | Plane, units: DisplayUnits) -> str:
    off = present(unbalance.uncertainty_g_mm)
    return "unknown" if off is None else f"± {units.g_mm(off)}"


def _uncertainty(report: BalancedReport, units: DisplayUnits) -> str:
    """Return the uncertainty of the resultant with its causes, the largest first; empty where unknown."""
    residual = report.residual
    if residual.uncertainty_g_mm is None:
        return ""
    shares = sorted((residual.uncertainty_shares_g_mm or {}).items(), key=lambda share: -share[1])
    rows = [("Uncertainty", f"± {units.of_unbalance(residual.uncertainty_g_mm)}")]
    rows += [(f"  {cause}", f"± {units.of_unbalance(share)}") for cause, share in shares if share > 0.0]
    text = table(rows)
    if silent := present(residual.uncertainty_unstated):
        text += f"\n  no tolerance given for {', '.join(silent)}: taken as 0"
    return text


def _margin(report: BalancedReport) -> list[str]:
    """Return the note on the uncertainty in the verdict; none where it does not count."""
    if not report.tolerance.counts_uncertainty or report.is_unproven:
        return []
    return ["  the verdict counts the uncertainty: both together must be within the permissible unbalance"]


def _bob_weights(report: BalancedReport, units: DisplayUnits) -> str:
    bob = report.engine.bob_weights
    listed = ", ".join(f"throw {each.throw} {units.of_bob_weight(each.mass_g)}" for each in bob)
    return f"Bob-weights: {listed}"


def _factor(report: BalancedReport, units: DisplayUnits) -> str:
    factor = report.balance_factor
    lines = ["Balance factor: " + _arrow(factor.initial, factor.target, factor.final)]
    if (web := report.counterweight) is not None:
        product = web.product_g_mm
        lines.append(
            f"  counterweights {units.of_mass(web.mass_g)} at {units.of_length(web.radius_mm)}: "
            f"{units.of_unbalance(product.initial)} before, {units.of_unbalance(product.final)} after, "
            f"{units.of_unbalance(product.target)} wanted"
        )
    return "\n".join(lines)


def _arrow(initial: float | None, target: float, final: float | None) -> str:
    if initial is None or final is None:
        return f"{target:.4f} requested; the throws cancel, so the crank has no balance factor"
    return f"{initial:.4f} before, {final:.4f} after, {target:.4f} wanted"


def _external(report: BalancedReport, units: DisplayUnits, zero: Zero) -> str:
    """Return the unbalance that damper and flexplate or flywheel are to carry, with its tolerance."""
    if not report.external:
        return ""
    rows: list[Sequence[str]] = [("External part", "carries", f"at, from {zero.name}", "tolerance")]
    for each in report.external:
        size, off = units.of_unbalance(each.magnitude_g_mm), units.of_unbalance(each.pm_g_mm)
        at = units.heavy_at(each.magnitude_g_mm, zero.ccw(each.angle_deg))
        rows.append((f"  {each.name}", size, at, f"± {off}"))
    return table(rows)


def _oil(report: BalancedReport, units: DisplayUnits) -> str:
    """Return the mass of the oil, and its share in the bob-weights."""
    if not report.oil:
        return ""
    all_of_it = units.of_mass(sum(each.mass_g for each in report.oil))
    in_bobs = units.of_mass(sum(each.on_crankpin_g for each in report.oil))
    return f"Oil in bores and drillings: {all_of_it}; in the bob-weights {in_bobs}"


def _forces(report: BalancedReport) -> str:
    forces = report.forces
    if forces is None:
        return ""
    both = [_first_order(each) for each in (forces.before, forces.after)]
    rows: list[Sequence[str]] = [
        ("First order", "before", "after"),
        ("  maximum", *(f"{each.greatest_force_n:.0f} N" for each in both)),
        ("  with the crank", *(f"{each.forward_n:.0f} N" for each in both)),
        ("  against it", *(f"{each.backward_n:.0f} N" for each in both)),
    ]
    if forces.after.greatest_n is not None:
        rows.append(("  all orders", *(f"{each.greatest_n:.0f} N" for each in (forces.before, forces.after))))
    return table(rows) + f"\n  shaking force of inertia at {forces.speed_rpm:g} rpm"


def _first_order(force: ShakingForce) -> ForceOrder:
    return next(order for order in force.orders if order.order == 1.0)


def _changes(report: BalancedReport, units: DisplayUnits) -> str:
    if not report.corrections:
        return ""
    removed = sum(each.removed_mass_g for each in report.corrections)
    word = "removed" if removed >= 0.0 else "added"
    before = report.crank.body.polar_inertia_kg_mm2
    change = report.inertia_change_g_mm2 / G_MM2_PER_KG_MM2
    return (
        f"Metal {word}: {units.of_mass(abs(removed))}, crank {units.of_mass(report.crank.body.mass_g)}; "
        f"polar inertia {units.of_inertia(before, 2)}, {units.of_inertia(change, 2, '+')} "
        f"({100.0 * change / before:+.2f} %)"
    )


def _overbalance(report: BalancedReport, units: DisplayUnits, zero: Zero) -> str:
    left = report.overbalance
    if left is None:
        return ""
    heavy = degrees(zero.ccw(left.angle_deg))
    lines = [
        f"Left for final drilling: {units.of_unbalance(left.magnitude_g_mm)}, heavy side at {heavy} from "
        f"{zero.name} (the table above counts from there)"
    ]
    lines += [cut_rows("Last holes", left.last_holes, units, zero)] if left.last_holes else []
    if left.predicted_g_mm is not None:
        lines.append(f"  after these holes {units.of_unbalance(left.predicted_g_mm)} will be left")
    if left.reason:
        lines.append(f"  {left.reason}")
    return "\n".join(lines)


# A further stage: the cuts, and the reading that they follow from.


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
    read, expected = (_as_read(each, units, origin) for each in (stage.reading, stage.expected))
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


def _as_read(values: StageUnbalance | None, units: DisplayUnits, zero: Zero) -> str:
    assert values is not None  # a stage after the first has both
    off = values.uncertainty_g_mm
    doubt = "" if off is None else f" ± {units.of_unbalance(off)}"
    return units.of_vector(values.magnitude_g_mm, zero.ccw(values.angle_deg), doubt)
