"""A machine's reading as the TOML file for ``recut``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.job.files.reading_keys import Convention
from autobalance.toml_files.text import toml_value

if TYPE_CHECKING:
    from autobalance.test_stands.machine.answer import MachineReport


def reading_toml(report: MachineReport) -> str:
    """Return the first reading of ``machine`` as TOML, in the machine's own way of counting angles."""
    reading = report.input["reading"]
    convention = Convention.of(reading)
    lines = [f"# Readings of the {report.input['kind']} machine, seed {report.input['seed']}, first run."]
    if report.serial is not None:
        lines.append(f"serial = {toml_value(report.serial)}")
    if report.input["speed_rpm"] is not None:
        lines.append(f"speed_rpm = {report.input['speed_rpm']!r}")
    if report.bob_weights_g is not None:
        lines.append(f"bob_weights_g = [{', '.join(repr(each) for each in report.bob_weights_g)}]")
    for key, what in (
        ("urr_percent", "unbalance reduction ratio"),
        ("umar_g_mm", "minimum achievable residual"),
    ):
        value = reading[key]
        lines.append(f"# {key}: {what} of the machine, to fill in" if value is None else f"{key} = {value!r}")
    lines += [
        f"rotation = {toml_value(convention.rotation)}",
        f"zero_deg = {convention.zero_deg!r}",
        f"reads = {toml_value(convention.reads)}",
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
