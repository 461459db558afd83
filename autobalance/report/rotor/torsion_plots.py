"""Plots of a torsional chain: mode shapes, torques over the speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from autobalance.report.plots import Curve, lines

Values = Mapping[str, Any]
SHOWN = 5


def torsion_plots(report: Values) -> dict[str, dict[str, bytes]]:
    """Return the plots of a chain by name."""
    made = {}
    stations = np.arange(1, len(report["model"]["stations"]) + 1, dtype=float)
    curves = [
        Curve(f"{mode['frequency_hz']:.1f} Hz", stations, np.array(mode["shape"]))
        for mode in report["modes"][:SHOWN]
    ]
    if curves:
        labels = ("station [-]", "angle, greatest 1 [-]")
        made["torsion-modes"] = lines("Torsional modes", labels, curves)
    if report["response"]:
        made["torsion-torque"] = _torques(report["response"])
    return made


def _torques(response: list[Values]) -> dict[str, bytes]:
    """Draw the greatest torque along the chain for the strongest orders."""
    curves = []
    for each in response:
        speeds = np.array([point["speed_rpm"] for point in each["points"]])
        torques = [
            max((t for t in point["torque_N_m"] if t is not None), default=0.0) for point in each["points"]
        ]
        curves.append(Curve(f"order {each['order']:g}", speeds, np.array(torques)))
    curves.sort(key=lambda curve: -float(curve.y.max()))
    labels = ("speed [1/min]", "greatest torque [N·m]")
    return lines("Torsional response", labels, curves[:SHOWN])
