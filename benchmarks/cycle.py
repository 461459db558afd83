"""Time of all loads with gas of a four-stroke twelve at 7200 crank angles (to stay under 0.1 s), of its
main-bearing loads at 50 speeds with 5 factors, and of `cycle` on a preset without and with weight, drive,
friction of pistons, heat and windage.

Run it from the checkout: python -m benchmarks.cycle
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

import autobalance as ab
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.engines.cycle.closed_part import Chamber, Charge, Wiebe
from autobalance.engines.cycle.cylinder import CylinderCycle, GasExchange
from autobalance.engines.cycle.factors import factor_rows
from autobalance.engines.cycle.firing import dead_centres_rad, firing_in_order
from autobalance.engines.cycle.firing_engine import FiringEngine, LoadParts, ThrowPlace
from autobalance.running_gear.loads import Loads
from benchmarks.engine_loads import MAINS_MM, twelve

ORDER = [1, 2, 5, 6, 9, 10, 11, 12, 7, 8, 3, 4]
ANGLES = 7200


def firing_twelve() -> FiringEngine:
    """Return a 60° V12 that fires every 60°."""
    engine = twelve()
    first = engine.cylinders[::2]
    throws = tuple(
        ThrowPlace(each.throw_angle_rad, each.z_mm + 10.0, (2 * number, 2 * number + 1))
        for number, each in enumerate(first)
    )
    cycle = CylinderCycle.modelled(
        Chamber(engine.cylinders[0].slider_crank, 80.0, 11.0),
        GasExchange(4, 0.1, 0.11, 0.1, None, math.radians(140.0)),
        Charge(0.1, 330.0, 1.35),
        Wiebe(math.radians(-15.0), math.radians(50.0), 5.0, 3.0, 9e5),
        None,
    )
    firing = firing_in_order(dead_centres_rad(engine.cylinders), ORDER, 4.0 * math.pi)
    return FiringEngine(engine, throws, tuple(MAINS_MM), (50.0,) * 7, (cycle,) * 12, tuple(firing))


def loads_of_a_cycle() -> Loads:
    """Return all loads over two turns, gas and all, from nothing but the engine's numbers."""
    angle = 4.0 * math.pi * np.arange(ANGLES) / ANGLES
    return LoadParts.of(firing_twelve(), angle).at_speed(700.0)


def speeds_and_factors() -> float:
    """Return the greatest main load of 50 speeds and 5 factors."""
    firing = firing_twelve()
    factors = (0.0, 0.28, 0.5, 0.64, 1.0)
    speeds = np.linspace(100.0, 900.0, 50)
    return max(row.greatest_main_n for speed in speeds for row in factor_rows(firing, factors, speed))


def seconds(work: Callable[[], object], rounds: int = 20) -> list[float]:
    """Return the processor time of each of some rounds, after one to warm up."""
    work()
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return times


MORE = {
    "gravity": {"direction_deg": 180.0},
    "drive": [{"kind": "chain", "z_mm": -150.0, "pitch_radius_mm": 40.0, "direction_deg": 30.0, "teeth": 16}],
    "piston": {"skirt_mu": 0.05, "ring_mu": 0.05, "ring_tension_N": 30.0},
    "heat": {"conductance_W_K": 20.0},
    "windage": {},
}


@lru_cache(maxsize=1)
def four() -> ab.Crank:
    """Return the preset inline-4 as a crank."""
    mesh = crank_solid(PRESETS["inline-4"], 32).mesh
    return ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850.0)


def whole_cycle(**keys: Any) -> object:
    """Return the result of a cycle of an inline-4 at 3000 rpm with further keys of ``[cycle]``."""
    job = {
        "engine": {
            "rod_length_mm": 140.0,
            "rotating_g": {"big_end": 300.0},
            "reciprocating_g": {"piston": 400.0},
        },
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 3000},
        "correction": {"method": "drill"},
        "cycle": {
            "bore_mm": 80.0,
            "compression_ratio": 10.0,
            "heat_J": 700.0,
            "flywheel_kg_mm2": 60000.0,
            "firing_order": [1, 3, 4, 2],
            "friction": {"main_mu": 0.01},
            **keys,
        },
    }
    return ab.cycle(job, crank=four())


WORKS: dict[str, Callable[[], object]] = {
    "all loads at 7200 angles": loads_of_a_cycle,
    "50 speeds, 5 factors": speeds_and_factors,
    "cycle, inline-4": whole_cycle,
    "the same with weight, drive, friction of pistons, heat, windage": lambda: whole_cycle(**MORE),
}

if __name__ == "__main__":
    for name, work in WORKS.items():
        times = seconds(work)
        print(f"{name}: median {statistics.median(times) * 1e3:.1f} ms, least {min(times) * 1e3:.1f} ms")
