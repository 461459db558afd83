"""A torsional chain as lines to read, from its JSON values."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.report.tables import table
from autobalance.types import Values

LISTED_ROWS = 12


def torsion_text(report: Values) -> str:
    parts = [
        _model(report["model"]),
        _throws(report.get("throws", [])),
        _train(report["model"]),
        _modes(report),
        _damping(report["damping"]),
        _critical(report),
        _response(report),
        _dampers(report["dampers"], report_excited=report["excited"]),
        _pendulum(report["pendulum"]),
    ]
    return "\n\n".join(part for part in parts if part)


def _model(model: Values) -> str:
    rows: list[Sequence[str]] = [("Station", "inertia", "stiffness to the next")]
    both = model["ker_wilson_N_m_rad"] is not None
    if model["links"] != [[at, at + 1] for at in range(1, len(model["stations"]))]:
        return _branched(model)
    if both:
        rows = [("Station", "inertia", "Ker Wilson", "Carter")]
    for at, (name, inertia) in enumerate(zip(model["stations"], model["inertias_kg_mm2"], strict=True)):
        springs = ("ker_wilson_N_m_rad", "carter_N_m_rad") if both else ("stiffness_N_m_rad",)
        cells = [f"{model[key][at]:.4g} N·m/rad" if at < len(model[key]) else "" for key in springs]
        rows.append((name, f"{inertia:.5g} kg·mm²", *cells))
    return table(rows)


def _branched(model: Values) -> str:
    """Return stations with their speeds, and the shafts between them."""
    stations: list[Sequence[str]] = [("Station", "", "inertia", "speed over station 1")]
    stations += [
        (f"{number}", name, f"{inertia:.5g} kg·mm²", f"{ratio:g}")
        for number, (name, inertia, ratio) in enumerate(
            zip(model["stations"], model["inertias_kg_mm2"], model["ratios"], strict=True), 1
        )
    ]
    shafts: list[Sequence[str]] = [("Shaft", "stiffness")]
    shafts += [
        (f"{a} to {b}", f"{stiffness:.4g} N·m/rad")
        for (a, b), stiffness in zip(model["links"], model["stiffness_N_m_rad"], strict=True)
    ]
    return "\n\n".join([table(stations), table(shafts)])


def _train(model: Values) -> str:
    """Return gears and couplings, empty without any."""
    rows = [
        f"Gear {gear['stations'][0]} to {gear['stations'][1]}: ratio {gear['ratio']:g}, "
        + ("rigid teeth" if gear["mesh_N_m_rad"] is None else f"teeth {gear['mesh_N_m_rad']:.4g} N·m/rad")
        for gear in model["gears"]
    ]
    rows += [
        f"Coupling behind station {each['station']}: {each['N_m_rad']:.4g} N·m/rad"
        f" at {each['mean_N_m']:.4g} N·m"
        for each in model["couplings"]
    ]
    return "\n".join(rows)


def _damping(damping: Values) -> str:
    if damping["ratio"] == 0.0 and not damping["dampers"]:
        return "Damping: none; peaks of the response have no limit and are not results"
    dampers = "the dampers given" if damping["dampers"] else ""
    modal = f"{100.0 * damping['ratio']:g} % of critical in every mode" if damping["ratio"] else ""
    return "Damping: " + ", ".join(each for each in (dampers, modal) if each)


def _throws(throws: Sequence[Values]) -> str:
    """Return the stiffness of each throw by both formulas and by finite elements; empty without these."""
    if not any(each["fem_N_m_rad"] is not None or each["fem_note"] for each in throws):
        return ""
    rows: list[Sequence[str]] = [("Throw", "Ker Wilson", "Carter", "its metal", "±", "formulas off by")]
    for each in throws:
        formulas = (each["ker_wilson_N_m_rad"], each["carter_N_m_rad"])
        head = (f"  {each['number']}", *(f"{value:.4g} N·m/rad" for value in formulas))
        metal = each["fem_N_m_rad"]
        if metal is None:
            rows.append((*head, "none", "", each["fem_note"]))
            continue
        off = ", ".join(f"{100.0 * (value / metal - 1.0):+.0f} %" for value in formulas)
        rows.append((*head, f"{metal:.4g} N·m/rad", f"{each['fem_error_N_m_rad']:.2g}", off))
    return table(rows)


def _modes(report: Values) -> str:
    metal = report.get("fem_natural_frequencies_hz")
    rows: list[Sequence[str]] = [
        ("Mode", "frequency", *(["by its metal"] if metal else []), "nodes", "shape")
    ]
    for number, mode in enumerate(report["modes"][:LISTED_ROWS], 1):
        shape = " ".join(f"{each:+.3f}" for each in mode["shape"][:LISTED_ROWS])
        own = [f"{metal[number - 1]:.2f} Hz"] if metal else []
        rows.append((str(number), f"{mode['frequency_hz']:.2f} Hz", *own, str(mode["nodes"]), shape))
    return table(rows) if len(rows) > 1 else "One inertia alone: nothing twists"


def _critical(report: Values) -> str:
    critical = report["critical"]
    if not report["excited"]:
        none = (
            "Nothing excites: neither [[excitation]] nor, in a job, [cycle] is given; no response is computed"
        )
        if not critical:
            return none + ", and no critical speed of an order is listed"
        return f"{none}\n{_listed(critical)}"
    if not critical:
        return "No order that something excites meets a natural frequency in the range of speeds"
    return _listed(critical)


def _listed(critical: Sequence[Values]) -> str:
    """Return the critical speeds as a table."""
    rows: list[Sequence[str]] = [("Critical", "order", "frequency", "torque", "stress", "phase sum")]
    rows += [
        (
            f"{each['speed_rpm']:.0f} rpm",
            f"{each['order']:g}",
            f"{each['frequency_hz']:.1f} Hz",
            "" if each["torque_N_m"] is None else f"{each['torque_N_m']:.4g} N·m",
            "" if each["stress_MPa"] is None else f"{each['stress_MPa']:.4g} MPa",
            "" if each["phase_sum"] is None else f"{each['phase_sum']:.3g}",
        )
        for each in critical[:LISTED_ROWS]
    ]
    more = len(critical) - LISTED_ROWS
    return table(rows) + (f"\n... and {more} more" if more > 0 else "")


def _response(report: Values) -> str:
    rows: list[Sequence[str]] = [("Order", "greatest twist", "torque", "stress", "at")]
    for each in report["response"]:
        known = [point for point in each["points"] if point["torque_N_m"] and None not in point["torque_N_m"]]
        if not known:
            continue
        point = max(known, key=lambda one: float(max(one["torque_N_m"])))
        stress = [value for value in point["stress_MPa"] if value is not None]
        rows.append(
            (
                f"{each['order']:g}",
                f"{max(point['twist_mrad']):.4g} mrad",
                f"{max(point['torque_N_m']):.4g} N·m",
                f"{max(stress):.4g} MPa" if stress else "",
                f"{point['speed_rpm']:.0f} rpm",
            )
        )
    return table(rows) if len(rows) > 1 else ""


def _strain(strain: Values | None, none: str) -> str:
    """Return the greatest strain of the crank's shafts."""
    if strain is None:
        return none
    stress = "" if strain["stress_MPa"] is None else f", {strain['stress_MPa']:.4g} MPa"
    return f"{strain['torque_N_m']:.4g} N·m{stress}, {strain['twist_mrad']:.4g} mrad"


def _dampers(dampers: Sequence[Values], *, report_excited: bool) -> str:
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
        rule = each["rule"]
        heat = max((one["heat_W"] for one in each["heat_W"] if one["heat_W"] is not None), default=0.0)
        usual = [] if rule["N_m_rad"] is None else [f"{rule['N_m_rad']:.4g} N·m/rad"]
        rows.append(
            (
                each["kind"] + (", tuned" if each["tuned"] else ""),
                f"{each['station']}",
                "" if each["N_m_rad"] is None else f"{each['N_m_rad']:.4g} N·m/rad",
                f"{each['N_m_s_rad']:.4g} N·m·s/rad",
                ", ".join([*usual, f"{rule['N_m_s_rad']:.4g} N·m·s/rad"]),
                _strain(each["greatest"], "no limit") if report_excited else "",
                _strain(each["greatest_without"], "undamped: no limit") if report_excited else "",
                f"{heat:.3g} W",
            )
        )
    return table(rows) if len(rows) > 1 else ""


def _pendulum(pendulum: Values | None) -> str:
    if pendulum is None:
        return ""
    length, inertia = pendulum["length_mm"], pendulum["inertia_kg_mm2"]
    return f"Pendulum of {length:.3f} mm, {inertia:.4g} kg·mm² about the crank axis"
