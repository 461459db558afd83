"""Planning time for eight counterweights with 24 hole places each, over many unbalances.

    python benchmarks/planning.py [--unbalances 24]

Unbalances of both planes are random; their size is in turn what some holes take, what few take,
and what nearly all do. Each line: drills, unbalances, median, worst, and the worst residual as a
share of the permissible value after rounding to steps of 0.1 mm.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from autobalance.choose import choose
from tests.unit.test_choose import EIGHT_WEBS_Z_MM, at_planes, holes, tolerance

SIZES_G_MM = (1500.0, 400.0, 4000.0)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--unbalances", type=int, default=24)
    count = parser.parse_args().unbalances
    print(f"{'drills mm':>12} {'count':>6} {'median s':>9} {'worst s':>8} {'worst share':>12}")
    for drills in ([10.0], [8.0, 10.0, 12.0]):
        offer = holes(drills, EIGHT_WEBS_Z_MM, step_mm=0.1)
        rng = np.random.default_rng(7)
        taken, shares = [], []
        for turn in range(count):
            size = SIZES_G_MM[turn % len(SIZES_G_MM)]
            a, b = (complex(*vector) for vector in rng.normal(size=(2, 2)) * size)
            start = time.perf_counter()
            plan = choose(at_planes(a, b, 150.0), tolerance(144.0, half_mm=170.0), offer)
            taken.append(time.perf_counter() - start)
            shares.append(plan.share)
        name = " ".join(f"{drill:g}" for drill in drills)
        print(f"{name:>12} {count:>6} {np.median(taken):>9.2f} {max(taken):>8.2f} {max(shares):>12.3f}")


if __name__ == "__main__":
    main()
