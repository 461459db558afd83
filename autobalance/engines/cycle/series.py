"""A cycle by angle, one column each, unit in its name."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np

from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.types import Array
from autobalance.units import BAR_PER_MPA, RAD_S_PER_RPM


def series_columns(cycle: CycleAnalysis) -> dict[str, Array]:
    """Return the columns of a series, every ½° from crank angle 0: (1440,) for 4 strokes, (720,) for 2.

    At a jump of the pressure they have the value after it. ``speed_rpm`` is left out where the crank would
    stop.
    """
    columns = {"angle_deg": 0.5 * np.arange(cycle.grid.even_rad.size, dtype=np.float64)}
    columns |= {name: cycle.grid.even(values) for name, values in _columns(cycle)}
    if cycle.uneven_speed is not None:
        columns["speed_rpm"] = cycle.uneven_speed.speed_rad_s / RAD_S_PER_RPM
    return columns


def _columns(cycle: CycleAnalysis) -> Iterator[tuple[str, Array]]:
    state, loads, shown = cycle.firing.parts.gas_state, cycle.loads, cycle.firing.engine.shown
    wall = -1.0 if cycle.firing.engine.clockwise else 1.0
    for number in range(len(cycle.firing.cycles)):
        name = f"c{number + 1}"
        yield f"{name}_volume_cm3", state.volume_mm3[number] * 1e-3
        yield f"{name}_pressure_bar", state.pressure_mpa[number] * BAR_PER_MPA
        yield from _force(f"{name}_wrist_pin", shown(loads.wrist_pin_n[number]))
        yield f"{name}_wall_N", wall * loads.wall_n[number]
        yield from _force(f"{name}_big_end", shown(loads.crankpin_n[number]))
    for number, load in enumerate(cycle.crankpins_n, 1):
        yield from _force(f"crankpin_{number}", shown(load))
    for number, load in enumerate(loads.main_n, 1):
        yield from _force(f"main_{number}", shown(load))
    yield "gas_N_m", cycle.gas_n_m
    yield "inertia_N_m", cycle.inertia_n_m
    yield "friction_N_m", cycle.friction_n_m
    yield "total_N_m", cycle.total_n_m


def _force(name: str, load_n: Array) -> Iterator[tuple[str, Array]]:
    yield f"{name}_x_N", load_n[:, 0]
    yield f"{name}_y_N", load_n[:, 1]


def series_csv(columns: dict[str, Array]) -> bytes:
    """Return columns as a CSV file with a header."""
    text, table = io.StringIO(), np.column_stack(list(columns.values()))
    np.savetxt(text, table, fmt="%.12g", delimiter=",", header=",".join(columns), comments="")
    return text.getvalue().encode()
