"""The unbalance by trial weights as the TOML file for ``recut``."""

from __future__ import annotations

from autobalance.test_stands.influence.answer import InfluenceReport
from autobalance.toml_files.text import toml_value


def unbalance_toml(report: InfluenceReport) -> str:
    """Return the unbalance from ``influence`` as a reading, heavy where its weights are removed."""
    reading = report.input["reading"]
    lines = ["# The unbalance that trial weights and influence coefficients found."]
    if reading["serial"] is not None:
        lines.append(f"serial = {toml_value(reading['serial'])}")
    if reading["speed_rpm"] is not None:
        lines.append(f"speed_rpm = {reading['speed_rpm']!r}")
    if reading["bob_weights_g"] is not None:
        lines.append(f"bob_weights_g = [{', '.join(repr(each) for each in reading['bob_weights_g'])}]")
    lines += [
        f"attached_fitted = {'true' if reading['attached_fitted'] else 'false'}",
        f"urr_percent = {reading['urr_percent']!r}",
        f"umar_g_mm = {reading['umar_g_mm']!r}",
        f"rotation = {toml_value(reading['rotation'])}",
        f"zero_deg = {reading['zero_deg']!r}",
        'reads = "heavy"',
    ]
    for number, weight in enumerate(report.corrections):
        lines += ["", "[[plane]]"]
        if reading["at"] is not None:
            lines.append(f"at = {toml_value(reading['at'][number])}")
        if reading["z_mm"] is not None:
            lines.append(f"z_mm = {reading['z_mm'][number]!r}")
        lines += [f"g_mm = {weight.g_mm!r}", f"angle_deg = {weight.remove_angle_deg!r}"]
    return "\n".join(lines) + "\n"
