"""Time of the oil films of one main of a four-stroke twelve at 50 speeds with 5 factors (to stay under 5 s).

Run it from the checkout: python -m benchmarks.films
"""

from __future__ import annotations

import time

import numpy as np

from autobalance.engines.bearings.orbit import Orbits, film_orbits
from autobalance.engines.cycle.factors import FactorMainLoads
from benchmarks.cycle import firing_twelve

FACTORS = (0.0, 0.28, 0.5, 0.64, 1.0)
SPEEDS_RAD_S = np.linspace(100.0, 900.0, 50)
DEGREE = 2
"""Rows of the engine's grid to a row of the film's."""
MAIN = 1
"""The second main, which two throws load."""


def forces() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return angles (n,), forces of the crank on its main (n, k, 2) and the speed of each (k,)."""
    firing = firing_twelve()
    mains, grid = FactorMainLoads.of(firing), firing.grid
    loads = [
        mains.parts.mains_n(speed, mains.crank_n(factor))[MAIN, : grid.even_rad.size : DEGREE]
        for speed in SPEEDS_RAD_S
        for factor in FACTORS
    ]
    speeds = np.repeat(SPEEDS_RAD_S, len(FACTORS))
    force = np.stack(loads).T
    return grid.even_rad[::DEGREE], np.stack([force.real, force.imag], axis=-1), speeds


def films() -> Orbits:
    """Return the orbits of the journal."""
    angle, force, speed = forces()
    return film_orbits(angle, force, speed, 0.008, 0.050, 0.022, 25e-6)


def main() -> None:
    """Measure once, by the clock and by the processor."""
    clock, processor = time.perf_counter(), time.process_time()
    found = films()
    print(f"orbits                  {found.ratio.shape[1]:8d} of {len(found.angle_rad)} angles")
    print(f"by the clock            {time.perf_counter() - clock:8.2f} s")
    print(f"by the processor        {time.process_time() - processor:8.2f} s")
    print(f"greatest eccentricity   {found.ratio.max():8.4f}")
    print(f"turns to settle         {found.turns_to_settle.min():4d} to {found.turns_to_settle.max()}")


if __name__ == "__main__":
    main()
