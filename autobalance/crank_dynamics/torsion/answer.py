"""The report of `torsion`, and its text and plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from autobalance.crank_dynamics.torsion.dampers import DamperFigures
from autobalance.crank_dynamics.torsion.figures import (
    AbsorberSize,
    Damping,
    ThrowFigures,
    TorsionModeFigures,
    TrainFigures,
)
from autobalance.crank_dynamics.torsion.run_up import RunUpFigures
from autobalance.crank_dynamics.torsion.strains import CriticalOrder, OrderPeak, OrderResponse, ShaftStrain
from autobalance.declare import (
    ABSENT,
    HERTZ,
    KG_MM2_OF_SI,
    MM,
    MPA,
    MRAD,
    OMITTED,
    RPM,
    Absent,
    Hertz,
    record,
)
from autobalance.report.plots import Curve, Plot, drawn, lines, style
from autobalance.report.records.answers import Head
from autobalance.report.tables import table

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# The report of `torsion`: kg·mm², Hz, mrad, N·m, MPa; None where a thing does not apply.


@record
class TorsionReport(Head):
    """Torsional vibration of a crank, or of a chain."""

    command: Literal["torsion"] = "torsion"
    job_set: Sequence[str] | Absent = ABSENT
    input: Annotated[Mapping[str, Any], "job or chain, defaults filled in"]
    model: TrainFigures
    damping: Damping
    excited: bool
    natural_frequencies_rad_s: Sequence[Hertz]
    modes: Sequence[TorsionModeFigures]
    critical: Sequence[CriticalOrder]
    peaks: Sequence[OrderPeak]
    response: Sequence[OrderResponse]
    pendulum: AbsorberSize | None
    dampers: Sequence[DamperFigures]
    fem_natural_frequencies_rad_s: Sequence[Hertz] | Absent | None = ABSENT
    throws: Annotated[Sequence[ThrowFigures], "of a job's crank"] | Absent = ABSENT
    run_up: Annotated[RunUpFigures | None, OMITTED] = None
    warnings: Sequence[str] | Absent = ABSENT


# A torsional chain as lines to read.


LISTED_ROWS = 12


def torsion_text(report: TorsionReport) -> str:
    parts = [
        _model(report.model),
        "" if report.throws is ABSENT else _throws(report.throws),
        _train(report.model),
        _modes(report),
        _damping(report.damping),
        _critical(report),
        _response(report.response),
        _dampers(report.dampers, report_excited=report.excited),
        _pendulum(report.pendulum),
        "" if report.run_up is None else _run_up(report.run_up),
    ]
    return "\n\n".join(part for part in parts if part)


def _run_up(found: RunUpFigures) -> str:
    low, high = RPM.written(found.from_rad_s), RPM.written(found.to_rad_s)
    head = f"Run-up from {low:g} to {high:g} rpm at {found.rate_rpm_s:g} rpm/s, {found.duration_s:.3g} s"
    rows: list[Sequence[str]] = [("  Shaft", "maximum torque", "at", "steady", "at", "stress")]
    for each in found.shafts:
        steady, at = each.steady_torque_n_m, each.steady_at_rad_s
        rows.append(
            (
                f"  {each.between}",
                f"{each.greatest_torque_n_m:.1f} N·m",
                f"{RPM.written(each.at_rad_s):.0f} rpm",
                "no limit" if steady is None else f"{steady:.1f} N·m",
                "" if at is None else f"{RPM.written(at):.0f} rpm",
                "" if each.greatest_stress_pa is None else f"{MPA.written(each.greatest_stress_pa):.1f} MPa",
            )
        )
    nonlinear = "; couplings and friction non-linear" if found.nonlinear else ""
    return "\n".join([head + nonlinear, table(rows)])


def _stiffness(n_m_rad: float) -> str:
    return f"{n_m_rad:.4g} N·m/rad"


def _inertia(kg_m2: float) -> str:
    return f"{KG_MM2_OF_SI.written(kg_m2):.5g} kg·mm²"


def _model(model: TrainFigures) -> str:
    if [list(each) for each in model.links] != [[at, at + 1] for at in range(1, len(model.stations))]:
        return _branched(model)
    heads, springs = ["stiffness to the next"], [model.stiffness_N_m_rad]
    if model.ker_wilson_N_m_rad is not None and model.carter_N_m_rad is not None:
        heads, springs = ["Ker Wilson", "Carter"], [model.ker_wilson_N_m_rad, model.carter_N_m_rad]
    rows: list[Sequence[str]] = [("Station", "inertia", *heads)]
    for at, (name, inertia) in enumerate(zip(model.stations, model.inertias_kg_m2, strict=True)):
        cells = [_stiffness(each[at]) if at < len(each) else "" for each in springs]
        rows.append((name, _inertia(inertia), *cells))
    return table(rows)


def _branched(model: TrainFigures) -> str:
    """Return stations with their speeds, and the shafts between them."""
    stations: list[Sequence[str]] = [("Station", "", "inertia", "speed over station 1")]
    stations += [
        (f"{number}", name, _inertia(inertia), f"{ratio:g}")
        for number, (name, inertia, ratio) in enumerate(
            zip(model.stations, model.inertias_kg_m2, model.ratios, strict=True), 1
        )
    ]
    shafts: list[Sequence[str]] = [("Shaft", "stiffness")]
    shafts += [
        (f"{a} to {b}", _stiffness(stiffness))
        for (a, b), stiffness in zip(model.links, model.stiffness_N_m_rad, strict=True)
    ]
    return "\n\n".join([table(stations), table(shafts)])


def _train(model: TrainFigures) -> str:
    """Return gears and couplings, empty without any."""
    rows = [
        f"Gear {gear.stations[0]} to {gear.stations[1]}: ratio {gear.ratio:g}, "
        + ("rigid teeth" if gear.mesh_N_m_rad is None else f"teeth {_stiffness(gear.mesh_N_m_rad)}")
        for gear in model.gears
    ]
    rows += [
        f"Coupling behind station {each.station}: {_stiffness(each.N_m_rad)} at {each.mean_N_m:.4g} N·m"
        for each in model.couplings
    ]
    return "\n".join(rows)


def _damping(damping: Damping) -> str:
    if damping.is_none:
        return "Damping: none; peaks of the response have no limit and are not results"
    dampers = "the dampers given" if damping.dampers else ""
    modal = f"{100.0 * damping.ratio:g} % of critical in every mode" if damping.ratio else ""
    return "Damping: " + ", ".join(each for each in (dampers, modal) if each)


def _throws(throws: Sequence[ThrowFigures]) -> str:
    """Return the stiffness of each throw by both formulas and by finite elements; empty without these."""
    if not any(each.fem_N_m_rad is not None or each.fem_note for each in throws):
        return ""
    rows: list[Sequence[str]] = [("Throw", "Ker Wilson", "Carter", "its metal", "±", "formulas off by")]
    for each in throws:
        formulas = (each.ker_wilson_N_m_rad, each.carter_N_m_rad)
        head = (f"  {each.number}", *map(_stiffness, formulas))
        metal = each.fem_N_m_rad
        if metal is None:
            rows.append((*head, "none", "", each.fem_note or ""))
            continue
        off = ", ".join(f"{100.0 * (value / metal - 1.0):+.0f} %" for value in formulas)
        rows.append((*head, _stiffness(metal), f"{each.fem_error_N_m_rad:.2g}", off))
    return table(rows)


def _modes(report: TorsionReport) -> str:
    metal = report.fem_natural_frequencies_rad_s
    known = () if metal is ABSENT or metal is None else metal
    rows: list[Sequence[str]] = [
        ("Mode", "frequency", *(["by its metal"] if known else []), "nodes", "shape")
    ]
    for number, mode in enumerate(report.modes[:LISTED_ROWS], 1):
        shape = " ".join(f"{each:+.3f}" for each in mode.shape[:LISTED_ROWS])
        own = [f"{HERTZ.written(known[number - 1]):.2f} Hz"] if known else []
        frequency = f"{HERTZ.written(mode.frequency_rad_s):.2f} Hz"
        rows.append((str(number), frequency, *own, str(mode.nodes), shape))
    return table(rows) if len(rows) > 1 else "One inertia alone: nothing twists"


def _critical(report: TorsionReport) -> str:
    critical = report.critical
    if not report.excited:
        none = (
            "Nothing excites: neither [[excitation]] nor, in a job, [cycle] is given; no response is computed"
        )
        if not critical:
            return none + ", and no critical speed of an order is listed"
        return f"{none}\n{_listed(critical)}"
    if not critical:
        return "No order that something excites meets a natural frequency in the range of speeds"
    return _listed(critical)


def _listed(critical: Sequence[CriticalOrder]) -> str:
    """Return the critical speeds as a table."""
    rows: list[Sequence[str]] = [("Critical", "order", "frequency", "torque", "stress", "phase sum")]
    rows += [
        (
            f"{RPM.written(each.speed_rad_s):.0f} rpm",
            f"{each.order:g}",
            f"{HERTZ.written(each.frequency_rad_s):.1f} Hz",
            "" if each.torque_n_m is None else f"{each.torque_n_m:.4g} N·m",
            "" if each.stress_pa is None else f"{MPA.written(each.stress_pa):.4g} MPa",
            "" if each.phase_sum is None else f"{each.phase_sum:.3g}",
        )
        for each in critical[:LISTED_ROWS]
    ]
    more = len(critical) - LISTED_ROWS
    return table(rows) + (f"\n... and {more} more" if more > 0 else "")


def _response(response: Sequence[OrderResponse]) -> str:
    rows: list[Sequence[str]] = [("Order", "maximum twist", "torque", "stress", "at")]
    for each in response:
        known = [point for point in each.points if point.greatest_n_m is not None]
        if not known:
            continue
        point = max(known, key=lambda one: one.greatest_n_m or 0.0)
        stress = [value for value in point.stress_pa if value is not None]
        twist = max(value for value in point.twist_rad if value is not None)
        rows.append(
            (
                f"{each.order:g}",
                f"{MRAD.written(twist):.4g} mrad",
                f"{point.greatest_n_m:.4g} N·m",
                f"{MPA.written(max(stress)):.4g} MPa" if stress else "",
                f"{RPM.written(point.speed_rad_s):.0f} rpm",
            )
        )
    return table(rows) if len(rows) > 1 else ""


def _strain(strain: ShaftStrain | None, none: str) -> str:
    """Return the largest strain of the crank's shafts."""
    if strain is None:
        return none
    stress = "" if strain.stress_pa is None else f", {MPA.written(strain.stress_pa):.4g} MPa"
    return f"{strain.torque_n_m:.4g} N·m{stress}, {MRAD.written(strain.twist_rad):.4g} mrad"


def _dampers(dampers: Sequence[DamperFigures], *, report_excited: bool) -> str:
    """Return the dampers, beside the values of the rules for one inertia on one spring."""
    rows: list[Sequence[str]] = [
        (
            "Damper",
            "at",
            "stiffness",
            "damping",
            "by the rule",
            "crank's shafts",
            "without it",
            "heat at most",
        )
    ]
    for each in dampers:
        rule = each.rule
        heat = max((one.heat_W for one in each.heat_W if one.heat_W is not None), default=0.0)
        usual = [] if rule.N_m_rad is None else [_stiffness(rule.N_m_rad)]
        rows.append(
            (
                each.kind + (", tuned" if each.tuned else ""),
                f"{each.station}",
                "" if each.N_m_rad is None else _stiffness(each.N_m_rad),
                f"{each.N_m_s_rad:.4g} N·m·s/rad",
                ", ".join([*usual, f"{rule.N_m_s_rad:.4g} N·m·s/rad"]),
                _strain(each.greatest, "no limit") if report_excited else "",
                _strain(each.greatest_without, "undamped: no limit") if report_excited else "",
                f"{heat:.3g} W",
            )
        )
    return table(rows) if len(rows) > 1 else ""


def _pendulum(pendulum: AbsorberSize | None) -> str:
    if pendulum is None:
        return ""
    length, inertia = MM.written(pendulum.length_m), KG_MM2_OF_SI.written(pendulum.inertia_kg_m2)
    return f"Pendulum of {length:.3f} mm, {inertia:.4g} kg·mm² about the crank axis"


# Plots of a torsional chain: mode shapes, torques over the speed.


DRAWN_MODES = 5
MIN_UPRIGHT_STATIONS = 12
"""Fewest stations with upright names."""
MAX_MARKED_SPEEDS = 30
"""Most critical speeds drawn, the largest torque first."""


def torsion_plots(report: TorsionReport) -> dict[str, Plot]:
    """Return the plots by name, as far as the report has their values."""
    plots_drawn = {}
    if report.modes:
        plots_drawn["torsion-modes"] = _plot_modes(report)
    if report.response:
        plots_drawn["torsion-torque"] = _torques(report.response, report.damping)
    if any(each.heat_W for each in report.dampers) and len(report.dampers[0].heat_W) > 1:
        plots_drawn["torsion-damper-heat"] = _heat(report.dampers)
    if report.critical:
        plots_drawn["torsion-critical"] = _critical_map(report)
    if report.run_up is not None:
        plots_drawn["torsion-run-up"] = _plot_run_up(report.run_up)
    return plots_drawn


def _plot_run_up(found: RunUpFigures) -> Plot:
    """Return torque over the speed through the run-up and steady, of the shaft with the largest torque."""
    worst = max(range(len(found.shafts)), key=lambda link: found.shafts[link].greatest_torque_n_m)
    speeds = np.array([RPM.written(each.speed_rad_s) for each in found.points])
    passed = np.array([each.torque_n_m[worst] for each in found.points], dtype=np.float64)
    steady = np.array([each.steady_torque_n_m[worst] for each in found.points], dtype=np.float64)
    curves = [Curve(f"run-up, {found.rate_rpm_s:g} rpm/s", speeds, passed), Curve("steady", speeds, steady)]
    title = f"Run-up: shaft {found.shafts[worst].between}"
    return lines(title, ("speed [1/min]", "maximum torque [N·m]"), curves)


def _plot_modes(report: TorsionReport) -> Plot:
    """Return mode shapes by the names of their stations, a line along each shaft; gears end a line."""
    names = report.model.stations
    joined = {(low, high) for low, high in report.model.links}
    ends = [number for number in range(1, len(names)) if (number, number + 1) not in joined]

    def draw(axes: Axes) -> None:
        for number, mode in enumerate(report.modes[:DRAWN_MODES]):
            places = np.insert(np.arange(1.0, len(names) + 1.0), ends, np.nan)
            shape = np.insert(np.array(mode.shape, dtype=float), ends, np.nan)
            axes.plot(
                places,
                shape,
                label=f"{HERTZ.written(mode.frequency_rad_s):.1f} Hz",
                marker=".",
                **style(number),
            )
        axes.axhline(0.0, color="0.4", linewidth=0.8)
        for each in ends:
            axes.axvline(each + 0.5, color="0.6", linewidth=0.8, linestyle=":")
        axes.set_xticks(
            range(1, len(names) + 1), names, rotation=30 if len(names) < MIN_UPRIGHT_STATIONS else 90
        )
        axes.set_xlabel("station")

    return drawn("Torsional modes", "angle, maximum 1 [-]", draw)


def _heat(dampers: Sequence[DamperFigures]) -> Plot:
    curves = []
    for number, each in enumerate(dampers, 1):
        speeds = np.array([RPM.written(one.speed_rad_s) for one in each.heat_W])
        heat = np.array([np.nan if one.heat_W is None else one.heat_W for one in each.heat_W])
        curves.append(Curve(f"damper {number}, {each.kind}", speeds, heat))
    return lines("Heat of the dampers", ("speed [1/min]", "heat [W]"), curves)


def _critical_map(report: TorsionReport) -> Plot:
    """Return natural frequencies over the speed with the orders' rays; a dot's area grows with the torque."""
    critical = report.critical
    low, high = (float(each) for each in report.input["speed_rpm"])
    most = max((each.torque_n_m or 0.0 for each in critical), default=0.0)
    shown = sorted(critical, key=lambda each: -(each.torque_n_m or 0.0))[:MAX_MARKED_SPEEDS]
    orders = sorted({each.order for each in shown})
    frequencies = sorted({HERTZ.written(each.frequency_rad_s) for each in critical})
    top = 1.15 * max(frequencies)

    def draw(axes: Axes) -> None:
        for frequency in frequencies:
            axes.plot([low, high], [frequency] * 2, color="black", linewidth=1.4)
        for order in orders:
            end = min(high, 60.0 * 0.97 * top / order)
            axes.plot([low, end], [order * low / 60.0, order * end / 60.0], color="0.6", linewidth=0.8)
            axes.annotate(f" {order:g}", (end, order * end / 60.0), fontsize="small", color="0.35")
        for each in shown:
            share = (each.torque_n_m or 0.0) / most if most else 0.0
            speed, frequency = RPM.written(each.speed_rad_s), HERTZ.written(each.frequency_rad_s)
            axes.scatter(speed, frequency, s=12.0 + 160.0 * share, color="#d55e00")
        axes.set_xlim(low, high + 0.05 * (high - low))
        axes.set_ylim(0.0, top)
        axes.set_xlabel("speed [1/min]")

    area = "; dots grow with the torque" if most else ""
    return drawn(f"Critical speeds by order{area}", "natural frequency [Hz]", draw)


def _torques(response: Sequence[OrderResponse], damping: Damping) -> Plot:
    """Return the largest torque along the chain over the speed, for the strongest orders."""
    curves = []
    for each in response:
        speeds = np.array([RPM.written(point.speed_rad_s) for point in each.points])
        torques = [max((t for t in point.torque_n_m if t is not None), default=0.0) for point in each.points]
        curves.append(Curve(f"order {each.order:g}", speeds, np.array(torques)))
    curves.sort(key=lambda curve: -float(curve.y.max()))
    labels = ("speed [1/min]", "maximum torque [N·m]")
    title = "Torsional response, undamped: peaks have no limit" if damping.is_none else "Torsional response"
    return lines(title, labels, curves[:DRAWN_MODES])
