"""A beam rotor as lines to read, from its JSON values."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.report.tables import table
from autobalance.types import Values

SHOWN_MODES = 12
NO_WHIRL = "none"


def rotor_text(report: Values) -> str:
    parts = [
        _head(report),
        _criticals(report["criticals"]),
        _modes(report),
        _response(report["response"]),
        _sag(report["static"]),
        _balancing(report["balancing"]),
        _advice(report["advice"]),
        _run_up(report["run_up"]),
        *report.get("notes", []),
    ]
    return "\n\n".join(part for part in parts if part)


def _head(report: Values) -> str:
    free = report["rigid_body_modes"]
    lines = [
        f"Rotor of {report['mass_kg']:.4g} kg, centre of mass at z {report['centre_of_mass_mm']:.2f} mm,"
        f" {report['elements']} beam elements ({report['input']['beam']})"
    ]
    if free:
        lines.append(f"The bearings leave it free: {free} rigid-body modes, without frequency, are left out")
    return "\n".join(lines)


def _criticals(criticals: Sequence[Values]) -> str:
    if not criticals:
        return "No critical speed in the range looked at"
    rows: list[Sequence[str]] = [("Critical speed", "whirl", "log decrement")]
    rows += [
        (f"{each['speed_rpm']:.1f} rpm", each["whirl"] or NO_WHIRL, f"{each['log_decrement']:.5f}")
        for each in criticals
    ]
    return table(rows)


def _modes(report: Values) -> str:
    rows: list[Sequence[str]] = [("Mode", "frequency", "log decrement", "whirl")]
    rows += [
        (
            str(number),
            f"{each['frequency_hz']:.3f} Hz",
            f"{each['log_decrement']:.5f}",
            each["whirl"] or NO_WHIRL,
        )
        for number, each in enumerate(report["modes"][:SHOWN_MODES], 1)
    ]
    speed = report["campbell"][0]["speed_rpm"]
    return f"Modes at {speed:g} rpm\n" + table(rows) if len(rows) > 1 else "No mode that vibrates"


def _response(response: Sequence[Values]) -> str:
    rows: list[Sequence[str]] = [("Unbalance response", "greatest", "at")]
    for probe in response:
        known = [point for point in probe["points"] if point["major_um"] is not None]
        if not known:
            continue
        greatest = max(known, key=lambda point: float(point["major_um"]))
        if greatest["major_um"] > 0.0:
            rows.append(
                (
                    f"z {probe['z_mm']:.1f} mm",
                    f"{greatest['major_um']:.4g} µm",
                    f"{greatest['speed_rpm']:.0f} rpm",
                )
            )
    return table(rows) if len(rows) > 1 else ""


def _sag(static: Values) -> str:
    forces = [each for each in static["reactions"] if each["x_N"] or each["y_N"]]
    if not forces:
        return ""
    rows: list[Sequence[str]] = [("Bearing's force on the shaft", "x", "y")]
    rows += [(f"z {each['z_mm']:.1f} mm", f"{each['x_N']:.3f} N", f"{each['y_N']:.3f} N") for each in forces]
    deepest = max((abs(complex(each["x_um"], each["y_um"])) for each in static["deflections"]), default=0.0)
    return table(rows) + f"\nGreatest deflection under gravity {deepest:.4g} µm"


def _balancing(planes: Sequence[Values]) -> str:
    if not planes:
        return ""
    rows: list[Sequence[str]] = [("Unbalance to add", "amount", "angle")]
    rows += [
        (f"z {each['z_mm']:.1f} mm", f"{each['g_mm']:.3f} g·mm", f"{each['angle_deg']:.1f}°")
        for each in planes
    ]
    return table(rows)


def _advice(advice: Values) -> str:
    names = ", ".join(f"{each['letter']} ({each['name']})" for each in advice["procedures"])
    head = f"Balancing as a {advice['behaviour']} rotor, {advice['reason']}"
    return f"{head}: {advice['standard']} procedure {names}"


def _run_up(runs: Sequence[Values]) -> str:
    if not runs:
        return ""
    rows: list[Sequence[str]] = [("Run in time", "greatest", "at")]
    rows += [
        (f"z {each['z_mm']:.1f} mm", f"{each['greatest_um']:.4g} µm", f"{each['at_rpm']:.0f} rpm")
        for each in runs
    ]
    return table(rows)
