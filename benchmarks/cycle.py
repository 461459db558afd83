"""Time of all loads with gas of a four-stroke twelve at 7200 crank angles (to stay under 0.1 s), and of its
main-bearing loads at 50 speeds with 5 factors.

Run it from the checkout: python -m benchmarks.cycle
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np

from autobalance.engines.cycle.chamber import Chamber
from autobalance.engines.cycle.closed_part import Charge
from autobalance.engines.cycle.cylinder import CylinderCycle, GasExchange
from autobalance.engines.cycle.factors import factor_rows
from autobalance.engines.cycle.firing import dead_centres_rad, firing_in_order
from autobalance.engines.cycle.firing_engine import FiringEngine, LoadParts, ThrowPlace
from autobalance.engines.cycle.heat_release import Wiebe
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


WORKS = {"all loads at 7200 angles": loads_of_a_cycle, "50 speeds, 5 factors": speeds_and_factors}

if __name__ == "__main__":
    for name, work in WORKS.items():
        times = seconds(work)
        print(f"{name}: median {statistics.median(times) * 1e3:.1f} ms, least {min(times) * 1e3:.1f} ms")
