"""``reading.toml`` beside a report: the reading of the balancing machine, without its numbers."""

from __future__ import annotations

import json

from autobalance.report.records.balanced import BalancedReport
from autobalance.toml_files.typed_units import FILL_IN

URR_PERCENT, UMAR_G_MM = 95.0, 0.5
"""Usual values of a hard-bearing machine in order, to begin with."""


def reading_template(report: BalancedReport) -> str:
    """Return the reading file of a report, with "FILL IN" for the machine's numbers."""
    serial = report.given.job.serial or report.serial
    inch = report.given.shop.units == "inch"
    fit = [round(each.fit_g, 2) for each in report.engine.bob_weights]
    amount, unit = ("oz_in", "oz·in") if inch else ("g_mm", "g·mm")
    lines = [
        "# Readings of the balancing machine on the corrected crank: amount and angle of each plane. Then:",
        "#   autobalance recut report.json reading.toml",
        *([] if serial is None else [f"serial = {json.dumps(serial, ensure_ascii=False)}"]),
        f"bob_weights_g = {fit}          # clamped on, one a throw",
        f"urr_percent = {URR_PERCENT:g}             # unbalance reduction ratio, and",
        f"umar_g_mm = {UMAR_G_MM:g}               # minimum achievable residual of a hard-bearing machine",
        'rotation = "ccw"             # sense in which angles count, seen from +z: "ccw" or "cw"',
        "zero_deg = 0.0               # the machine's zero mark, ccw from crankpin 1",
        'reads = "heavy"              # "heavy": where the metal is too much; "light": where to add',
    ]
    planes = report.tolerance.planes if report.tolerance.judge == "dynamic" else ()
    places = [[f'at = "{plane.name}"                     # z {plane.z_mm:.2f} mm'] for plane in planes]
    for place in places or [[]]:
        lines += [
            "",
            "[[plane]]",
            *place,
            f'{amount} = "{FILL_IN}"             # [{unit}]',
            f'angle_deg = "{FILL_IN}"        # from the zero mark',
        ]
    return "\n".join(lines) + "\n"
