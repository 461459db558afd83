"""Forces, shafts, parts and grades as lines to read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from autobalance.declare import ABSENT
from autobalance.report.display_units import DisplayUnits
from autobalance.report.engine.cycle_text import number
from autobalance.report.tables import table
from autobalance.units import G_MM2_PER_KG_MM2

if TYPE_CHECKING:
    from autobalance.engine.complete_balance import ShaftWeight
    from autobalance.engine.factor_advice import FactorAdvice
    from autobalance.engine.force_summary import CylinderLoads, InertiaLoads
    from autobalance.engine.whole_engine import ForceOrder
    from autobalance.machine_models.mounted_engine import MountedAnalysis
    from autobalance.report.records.forces import EngineState, ForcesReport
    from autobalance.report.records.grade import GradeReport
    from autobalance.report.records.parts import PartsReport, RodEnds, ThrowWeights
    from autobalance.report.records.shafts import Shaft, ShaftsReport

LEAST_SHOWN_N = 0.05
"""Forces [N] and moments [N·m] below which an order is left out."""


def forces_text(report: ForcesReport) -> str:
    """Return the summary of ``forces``: orders, bearing loads, and the effect of each factor."""
    parts = [
        f"{report.job['file']}: forces of inertia at {report.speed_rpm:g} rpm, without gas;"
        f" moments about z = {report.moments_about_z_mm:.2f} mm",
        *(_state(state) for state in report.states),
        _roll(report),
        _advice(report.factors),
        *([] if report.mounts is ABSENT else [_mounts(report.mounts)]),
    ]
    return "\n\n".join(parts)


def _mounts(mounts: MountedAnalysis) -> str:
    """Return natural frequencies on the mounts, and the greatest velocity of each place by factor."""
    names = [place.name for place in mounts.responses[0].places if not place.name.startswith("mount ")]
    rows: list[Sequence[str]] = [("On its mounts, greatest RMS velocity", *names)]
    for each in mounts.responses:
        greatest = {place.name: max(place.velocity_rms_mm_s) for place in each.places}
        rows.append((f"  factor {each.factor:g}", *(f"{greatest[name]:.3g} mm/s" for name in names)))
    lines = [
        "Natural frequencies on its mounts: "
        + ", ".join(f"{each / (2.0 * math.pi):.2f}" for each in mounts.natural_frequencies_rad_s)
        + " Hz",
        table(rows),
    ]
    for name, factor in mounts.best_factor_for.items():
        beyond = (
            ""
            if 0.0 <= factor <= 1.0
            else ", outside 0 to 1: the crank is over- or underbalanced for its mounts"
        )
        lines.append(f"  least at {name} with factor {factor:.2f}{beyond}")
    return "\n".join(lines)


def _state(state: EngineState) -> str:
    factor = state.balance_factor
    name = state.name + ("" if factor is None else f" (balance factor {factor:.4f})")
    force, loads = state.force, state.loads
    head = (
        f"{name}: greatest force {_newtons(force.greatest_n)}, along cylinder 1"
        f" {_newtons(force.greatest_inline_n)}, across {_newtons(force.greatest_transverse_n)}"
    )
    lines = [head, orders_table(force.orders)]
    if state.with_shafts is not ABSENT:
        lines.append("  With the job's balance shafts\n" + orders_table(state.with_shafts.orders))
    return "\n".join([*lines, _loads(loads)])


def _newtons(force_n: float | None) -> str:
    return number(force_n, ".0f", " N")


def _roll(report: ForcesReport) -> str:
    """Return the roll couple on the block, and its part beside the reaction of the torque."""
    roll = report.roll
    line = (
        f"Roll couple of inertia on the block: maximum {roll.greatest_n_m:.2f} N·m; without the reaction"
        f" of the torque {roll.greatest_besides_torque_n_m:.2f} N·m"
    )
    beside = report.states[0].with_shafts
    if beside is not ABSENT:
        left = beside.greatest_roll_besides_torque_n_m
        line += f" ({left:.2f} N·m with the job's balance shafts)"
        line += "\nForces, loads and the table of balance factors do not include the balance shafts."
    return line


def orders_table(orders: Sequence[ForceOrder]) -> str:
    """Return the orders that shake, in columns."""
    rows: list[Sequence[str]] = [
        ("  Order", "along x", "along y", "greatest", "forward", "backward", "moment")
    ]
    for order in orders:
        if order.greatest_force_n < LEAST_SHOWN_N and order.greatest_moment_n_m < LEAST_SHOWN_N:
            continue
        forces = (
            order.force_x_n,
            order.force_y_n,
            order.greatest_force_n,
            order.forward_n,
            order.backward_n,
        )
        cells = [f"{force:.1f} N" for force in forces]
        rows.append((f"  {order.order:g}", *cells, f"{order.greatest_moment_n_m:.2f} N·m"))
    return table(rows) if len(rows) > 1 else "  no order shakes"


def _loads(loads: InertiaLoads) -> str:
    rows = [("  Load over a turn", "greatest", "mean")]
    for main in loads.main_bearings:
        name = f"  main bearing {main.number} (z {main.z_mm:.1f} mm)"
        rows.append((name, f"{main.greatest_n:.0f} N", f"{main.mean_n:.0f} N"))
    for cylinder in loads.cylinders:
        for load, what in (
            (cylinder.crankpin, _big_end(cylinder)),
            (cylinder.master_bearing, "crankpin, master rod with its links, of"),
            (cylinder.wrist_pin, "wrist pin of"),
            (cylinder.wall, "wall of"),
        ):
            if load is ABSENT:
                continue
            rows.append(
                (
                    f"  {what} cylinder {cylinder.number}",
                    f"{load.greatest_n:.0f} N",
                    f"{load.mean_n:.0f} N",
                )
            )
    torque, support = loads.torque, loads.support
    if support is not None:
        place = f"  support (z {support.z_mm:.1f} mm)"
        force = f"{support.greatest_n:.0f} N", f"{support.mean_n:.0f} N"
        moment = f"{support.greatest_moment_n_m:.1f} N·m", f"{support.mean_moment_n_m:.1f} N·m"
        rows += [(f"{place}, force", *force), (f"{place}, moment", *moment)]
    note = "" if support is None else f"\n  {support.says}"
    return (
        table(rows)
        + f"\n  inertia torque {torque.least_n_m:.1f} to {torque.greatest_n_m:.1f} N·m, mean 0"
        + note
    )


def _big_end(cylinder: CylinderLoads) -> str:
    """Return the name of the load of a cylinder's rod at its big end."""
    if cylinder.big_end_on is not ABSENT:
        return "knuckle pin of"
    return "crankpin, rod of" if cylinder.master_bearing is ABSENT else "crankpin, master rod alone, of"


def _advice(advice: FactorAdvice) -> str:
    rows: list[Sequence[str]] = [
        ("Balance factor", "greatest", "along", "across", "rms", "moment", "of order 1", "at end mains")
    ]
    for row in advice.rows:
        sizes = (row.greatest_n, row.greatest_inline_n, row.greatest_transverse_n, row.rms_n)
        forces = [f"{size:.0f} N" for size in sizes]
        moments = [f"{size:.1f} N·m" for size in (row.greatest_moment_n_m, row.first_order_moment_n_m)]
        at_mains = f"{row.greatest_in_planes_n:.0f} N"
        rows.append((f"  {row.factor:.4f}", *forces, *moments, at_mains))
    best = [
        f"  least first order (exact): {_factor(advice.least_first_order)}",
        f"  least greatest force, all orders: {_factor(advice.least_greatest)}",
        f"  least force across cylinder 1: {_factor(advice.least_transverse)}",
        f"  for a mount that takes force across {advice.transverse_weight:g} times as badly as along: "
        + _factor(advice.for_mount),
        f"  least greatest moment: {_factor(advice.least_moment)}",
        "  force and couple together, least greatest force at the outermost mains: "
        + _factor(advice.least_in_planes),
    ]
    return "\n".join([table(rows), *best])


def _factor(value: float | None) -> str:
    return "none is better than another" if value is None else f"{value:.4f}"


# --- shafts -------------------------------------------------------------------------------------------------


def shafts_text(report: ShaftsReport, units: DisplayUnits) -> str:
    """Return the summary of ``shafts``: orders that shake, proposals, and the effect of the job's shafts."""
    parts = [
        f"{report.job['file']}: balance shafts at {report.speed_rpm:g} rpm, crank balanced to"
        f" {report.balance_factor:.4f}; moments about z = {report.moments_about_z_mm:.2f} mm",
        "Without shafts\n" + orders_table(report.without.orders),
    ]
    rows = [("Shafts that would cancel", "speed", "sense", "each", "phase", "where")]
    for offer in report.proposals:
        for shaft in offer.shafts:
            rows.append((f"  {offer.what}", *_shaft_cells(shaft, units), _where(shaft, units)))
        for pair in offer.couple_shafts:
            for each in pair.unbalances:
                cells = _turning(pair.order, pair.sense, each.product_g_mm, each.phase_deg, units)
                rows.append((f"  {offer.what}", *cells, f"z {units.of_length(each.z_mm)}"))
    parts.append(table(rows) if len(rows) > 1 else "No order that shafts could cancel is left.")
    if report.shafts:
        rows = [("Shafts of the job", "speed", "sense", "product", "phase", "where")]
        rows += [
            (f"  {number}", *_shaft_cells(shaft, units), _where(shaft, units))
            for number, shaft in enumerate(report.shafts, 1)
        ]
        lines = [table(rows)]
        for shaft in report.shafts:
            for weight in shaft.weights:
                lines.append(_bolted(weight, units))
        lines.append("Residual after the shafts\n" + orders_table(report.with_.orders))
        parts.append("\n".join(lines))
    parts.append(_shafts_roll(report))
    return "\n\n".join(parts)


def _shafts_roll(report: ShaftsReport) -> str:
    """Return the roll couple about the crank axis without shafts, with each proposal, and with the job's."""
    rows = [("Roll couple on the block, reaction of the torque left out", "maximum")]
    rows.append(("  without shafts", f"{report.without.greatest_roll_n_m:.2f} N·m"))
    rows += [
        (f"  with {offer.what} cancelled", f"{offer.greatest_roll_n_m:.2f} N·m")
        for offer in report.proposals
        if offer.shafts
    ]
    if report.shafts:
        rows.append(("  with the job's shafts", f"{report.with_.greatest_roll_n_m:.2f} N·m"))
        rows.append(("  the job's shafts alone", f"{report.with_.greatest_shaft_roll_n_m:.2f} N·m"))
    return table(rows)


def _where(shaft: Shaft, units: DisplayUnits) -> str:
    """Return the place of a shaft: along the axis, and beside it where it does not stand on it."""
    along = f"z {units.of_length(shaft.z_mm)}"
    x, y = shaft.place_mm
    return along if x == y == 0.0 else f"{along}, x {units.of_length(x)}, y {units.of_length(y)}"


def _shaft_cells(shaft: Shaft, units: DisplayUnits) -> tuple[str, str, str, str]:
    return _turning(shaft.order, shaft.sense, shaft.product_g_mm, shaft.phase_deg, units)


def _turning(
    order: int, sense: str, product_g_mm: float, phase_deg: float, units: DisplayUnits
) -> tuple[str, str, str, str]:
    """Return the cells of an unbalance on a shaft."""
    return f"{order} ×", sense, units.of_unbalance(product_g_mm), f"{phase_deg:.1f}°"


def _bolted(weight: ShaftWeight, units: DisplayUnits) -> str:
    drawn = units.of_mass(weight.cad_g)
    at = units.of_length(weight.eccentricity_mm)
    if weight.weighed_g is None or weight.deviation is None:
        return f"  {weight.name}: {drawn} drawn, not weighed, at {at}"
    return (
        f"  {weight.name}: {drawn} drawn, {units.of_mass(weight.weighed_g)} weighed"
        f" ({100.0 * weight.deviation:+.2f} %), at {at}"
    )


# --- parts --------------------------------------------------------------------------------------------------


def parts_text(report: PartsReport, units: DisplayUnits) -> str:
    """Return the roll-up of the parts and the bob-weights."""
    blocks: list[str] = [report.job["file"]]
    for throw in report.throws:
        rows = [(_throw_name(throw), "weight", "may be off by")]
        for weights, title in (
            (throw.rotating, "rotating, one rod"),
            (throw.reciprocating, "reciprocating, one rod"),
            (throw.crankpin, "on the crankpin"),
        ):
            rows += [
                (f"    {part.name}", units.of_mass(part.mass_g), _off(part.pm_g, units))
                for part in weights.parts
            ]
            rows.append((f"  {title}", units.of_mass(weights.mass_g), _off(weights.pm_g, units)))
        blocks.append(table(rows))
        blocks.append(
            f"  {throw.rods} rod{'s' * (throw.rods != 1)}; bob-weight at {throw.balance_factor:.4f}:"
            f" {units.of_mass(throw.bob_weight_g)}{_plus_minus(throw.bob_weight_pm_g, units)}"
            + (
                f"; with the crankpin fitted {units.of_mass(throw.bob_weight_pin_fitted_g)}"
                if throw.bob_weight_pin_fitted_g != throw.bob_weight_g
                else ""
            )
        )
    if report.rod is not None:
        blocks.append(_rod(report.rod, units))
    return "\n".join(blocks)


def _throw_name(throw: ThrowWeights) -> str:
    return "Throw" if throw.number is None else f"Throw {throw.number}"


def _off(pm_g: float, units: DisplayUnits) -> str:
    return f"± {units.of_mass(pm_g)}" if pm_g else ""


def _rod(rod: RodEnds, units: DisplayUnits) -> str:
    lines = [
        f"Bare rod: {units.of_mass(rod.big_end_g)} at the big end,"
        f" {units.of_mass(rod.small_end_g)} at the small end"
    ]
    if rod.centre_from_big_end_mm is not None:
        lines.append(f"  centre of mass {units.of_length(rod.centre_from_big_end_mm)} from the big end")
    if rod.couple_inertia_g_mm2 is not None:
        lines.append(
            f"  its two masses miss {rod.couple_inertia_g_mm2 / G_MM2_PER_KG_MM2:.1f} kg·mm² of inertia:"
            " the bearing loads count the couple"
        )
    return "\n".join(lines)


# --- grade --------------------------------------------------------------------------------------------------


def grade_text(report: GradeReport, units: DisplayUnits) -> str:
    """Return the permissible unbalance of a grade, or the grade of a residual, and the table of grades."""
    lines = []
    if report.permissible_g_mm is not None and report.rotor_mass_g is not None:
        lines.append(
            f"G {report.grade_mm_s:g} at {report.speed_rpm:g} rpm, rotor"
            f" {units.of_mass(report.rotor_mass_g)}: U_per"
            f" {units.of_unbalance(report.permissible_g_mm)},"
            f" e_per {report.specific_unbalance_um:.3f} µm"
        )
        if report.planes:
            shares = ", ".join(
                f"{plane.name} {units.of_unbalance(plane.permissible_g_mm)}" for plane in report.planes
            )
            lines.append(f"  in planes: {shares}")
    if report.achieved_grade_mm_s is not None and report.residual_g_mm is not None:
        listed = report.listed_grade_mm_s
        lines.append(
            f"{units.of_unbalance(report.residual_g_mm)} is G {report.achieved_grade_mm_s:.3f}"
            + ("; coarser than any listed grade" if listed is None else f"; meets G {listed:g}")
        )
    lines.append("")
    lines += [f"  G {row.grade_mm_s:<6g} {row.what}" for row in report.grades]
    return "\n".join(lines).strip("\n")


def _plus_minus(pm_g: float, units: DisplayUnits) -> str:
    """Return an uncertainty with its sign, or that none is stated."""
    return f" ± {units.of_mass(pm_g)}" if pm_g else ", uncertainty not stated"
