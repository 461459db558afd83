"""Time of all inertia loads of a 12-cylinder engine over 7200 crank angles; to stay under 50 ms.

Run it from the checkout: python -m benchmarks.engine_loads
"""

from __future__ import annotations

import math
import statistics
import time

from autobalance.running_gear.loads import Loads, loads, whole_turn
from autobalance.running_gear.parts import Parts
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Engine, vee

ANGLES = 7200
MAINS_MM = [100.0 * number - 300.0 for number in range(7)]


def twelve() -> Engine:
    """A 60° V12 with counterweights."""
    throws = [math.radians(angle) for angle in (0.0, 120.0, 240.0, 240.0, 120.0, 0.0)]
    banks = [math.radians(-30.0), math.radians(30.0)]
    engine = vee(throws, 100.0, banks, SliderCrank(40.0, 140.0), Parts(400.0, 500.0, 100.0), 20.0)
    return engine.with_counterweights(0.5)


def revolution() -> Loads:
    """All loads of a turn."""
    return loads(twelve(), MAINS_MM, 700.0, whole_turn(ANGLES))


def seconds(rounds: int = 20) -> list[float]:
    """Time of each of some rounds, after one to warm up."""
    revolution()
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        revolution()
        times.append(time.perf_counter() - start)
    return times


if __name__ == "__main__":
    times = seconds()
    print(f"{ANGLES} angles, 12 cylinders, all loads: median {statistics.median(times) * 1e3:.1f} ms,")
    print(f"least {min(times) * 1e3:.1f} ms, greatest {max(times) * 1e3:.1f} ms")
