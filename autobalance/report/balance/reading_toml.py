"""A machine's reading, or the unbalance by trial weights, as the TOML file for ``recut``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.job.files.reading_keys import Convention

if TYPE_CHECKING:
    from autobalance.report.records.influence import InfluenceReport
    from autobalance.report.records.machine import MachineReport


def reading_toml(report: MachineReport) -> str:
    """Return the first reading of ``machine`` as TOML, in the machine's own way of counting angles."""
    reading = report.input["reading"]
    convention = Convention.of(reading)
    lines = [f"# Readings of the {report.input['kind']} machine, seed {report.input['seed']}, first run."]
    if report.serial is not None:
        lines.append(f"serial = {_text(report.serial)}")
    if report.input["speed_rpm"] is not None:
        lines.append(f"speed_rpm = {report.input['speed_rpm']!r}")
    if report.bob_weights_g is not None:
        lines.append(f"bob_weights_g = [{', '.join(repr(each) for each in report.bob_weights_g)}]")
    for key, what in (("urr_percent", "unbalance reduction ratio"), ("umar_g_mm", "least residual")):
        value = reading[key]
        lines.append(f"# {key}: {what} of the machine, to fill in" if value is None else f"{key} = {value!r}")
    lines += [
        f"rotation = {_text(convention.rotation)}",
        f"zero_deg = {convention.zero_deg!r}",
        f"reads = {_text(convention.reads)}",
    ]
    for plane in report.runs[0].planes:
        lines += ["", "[[plane]]"]
        if plane.z_mm is not None:
            lines.append(f"z_mm = {plane.z_mm!r}")
        lines += [
            f"g_mm = {plane.g_mm!r}",
            f"angle_deg = {convention.machine_deg(plane.angle_deg)!r}",
        ]
    return "\n".join(lines) + "\n"


def unbalance_toml(report: InfluenceReport) -> str:
    """Return the unbalance from ``influence`` as a reading, heavy where its weights come off."""
    reading = report.input["reading"]
    lines = ["# The unbalance that trial weights and influence coefficients found."]
    if reading["serial"] is not None:
        lines.append(f"serial = {_text(reading['serial'])}")
    if reading["speed_rpm"] is not None:
        lines.append(f"speed_rpm = {reading['speed_rpm']!r}")
    if reading["bob_weights_g"] is not None:
        lines.append(f"bob_weights_g = [{', '.join(repr(each) for each in reading['bob_weights_g'])}]")
    lines += [
        f"attached_fitted = {'true' if reading['attached_fitted'] else 'false'}",
        f"urr_percent = {reading['urr_percent']!r}",
        f"umar_g_mm = {reading['umar_g_mm']!r}",
        f"rotation = {_text(reading['rotation'])}",
        f"zero_deg = {reading['zero_deg']!r}",
        'reads = "heavy"',
    ]
    for number, weight in enumerate(report.corrections):
        lines += ["", "[[plane]]"]
        if reading["at"] is not None:
            lines.append(f"at = {_text(reading['at'][number])}")
        if reading["z_mm"] is not None:
            lines.append(f"z_mm = {reading['z_mm'][number]!r}")
        lines += [f"g_mm = {weight.g_mm!r}", f"angle_deg = {weight.remove_angle_deg!r}"]
    return "\n".join(lines) + "\n"


def _text(value: str) -> str:
    """Return a TOML basic string."""
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in escaped) + '"'
