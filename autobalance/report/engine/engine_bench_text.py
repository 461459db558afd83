"""Crank variants in one engine as lines to read."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.report.tables import table
from autobalance.types import Values


def engine_bench_text(report: Values) -> str:
    """Return the variants by speed, and their run-up."""
    rows = report["variants"]
    speeds = [point["speed_rpm"] for point in rows[0]["points"]]
    blocks = [_at(rows, place, speed) for place, speed in enumerate(speeds)]
    if rows[0]["run_up"] is not None:
        blocks.append(_run_up(rows))
    return "\n\n".join(blocks)


def _at(variants: Sequence[Values], place: int, speed_rpm: float) -> str:
    head = (f"At {speed_rpm:g} rpm", "factor", "inertia", "acceleration", "greatest main", "mean main")
    rows: list[Sequence[str]] = [(*head, "torque", "from", "to", "friction")]
    for each in variants:
        point, factor = each["points"][place], each["balance_factor"]
        rows.append(
            (
                f"  {each['name']}",
                "" if factor is None else f"{100.0 * factor:.1f} %",
                f"{each['inertia_kg_mm2']:.5g} kg·mm²",
                f"{point['acceleration_rad_s2']:.5g} rad/s²",
                f"{point['greatest_main_N']:.5g} N",
                f"{point['mean_main_N']:.5g} N",
                f"{point['torque_mean_N_m']:.4g} N·m",
                f"{point['torque_least_N_m']:.4g}",
                f"{point['torque_greatest_N_m']:.4g}",
                f"{point['friction_mean_N_m']:.4g} N·m",
            )
        )
    return table(rows)


def _run_up(variants: Sequence[Values]) -> str:
    first = variants[0]["run_up"]
    head = f"Run-up, {first['from_rpm']:g} to {first['to_rpm']:g} rpm without load"
    rows: list[Sequence[str]] = [(head, "time", "turns", "gas", "friction", "gained")]
    for each in variants:
        run = each["run_up"]
        if run["time_s"] is None:
            rows.append((f"  {each['name']}", "friction keeps it from there"))
            continue
        work = (run["gas_work_J"], run["friction_work_J"], run["kinetic_J"])
        rows.append(
            (
                f"  {each['name']}",
                f"{1e3 * run['time_s']:.2f} ms",
                f"{run['turns']:.2f}",
                *(f"{value:.5g} J" for value in work),
            )
        )
    return table(rows)
