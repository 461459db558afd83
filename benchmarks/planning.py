"""Time to plan radial holes in eight counterweights with 24 places each, over many unbalances.

    python benchmarks/planning.py [--directions 20] [--sizes 150 400 1500 4000]
    python benchmarks/planning.py --unreachable

Each direction and size is met as a static unbalance (both planes alike), as a couple (planes opposed) and in
two planes turned against each other. Times are of the processor, so that a busy machine does not count, and
the worst is printed beside the one aimed at. The share is of the permissible value, after depth steps.

``--unreachable``: a cross-plane V8 whose counterweights are too heavy, or too light, for four drills and four
holes a web, in every zone: the processor's time to the end, and what is proposed instead.
"""

from __future__ import annotations

import argparse
import cmath
import math
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

AIMED_AT_S = {(10.0,): 0.5, (8.0, 10.0, 12.0): 3.0}
SHAPES = {"static": 1.0 + 0.0j, "couple": -1.0 + 0.0j, "two planes": 0.6 * cmath.exp(2.0j)}
WITHIN_S = 60.0
ZONES = ("counterweights", "web", "anywhere")
WEIGHTS_G = {"too heavy": (100.0, 150.0), "too light": (800.0, 900.0)}
"""Big end and piston, each of two rods a throw, for which counterweights are too heavy or too light [g]."""
JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine]
rods_per_throw = 2
[engine.layout]
bank_deg = [-45, 45]
[engine.rotating_g]
big_end = {big_end}
[engine.reciprocating_g]
piston = {piston}
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 6500
[correction]
method = "drill"
[correction.drill]
diameters_mm = [6, 8, 10, 12]
max_depth_mm = 60
max_holes = 4
zone = "{zone}"
"""


def main() -> None:
    from autobalance.planning.whole_cuts import choose
    from tests.unit.test_milp import EIGHT_WEBS_Z_MM, at_planes, holes, tolerance

    parser = argparse.ArgumentParser()
    parser.add_argument("--directions", type=int, default=20)
    parser.add_argument("--sizes", type=float, nargs="+", default=[150.0, 400.0, 1500.0, 4000.0])
    parser.add_argument("--unreachable", action="store_true")
    arguments = parser.parse_args()
    if arguments.unreachable:
        unreachable()
        return
    judge = tolerance(144.0, half_mm=170.0)
    for diameters_mm, aimed_at_s in AIMED_AT_S.items():
        offer = holes(diameters_mm, EIGHT_WEBS_Z_MM, step_mm=0.1)
        taken: list[tuple[float, str, float, float, float]] = []
        for size in arguments.sizes:
            for k in range(arguments.directions):
                angle = 2.0 * math.pi * (k + 0.3) / arguments.directions
                a = cmath.rect(size, angle)
                for shape, factor in SHAPES.items():
                    start = time.process_time()
                    plan = choose(at_planes(a, a * factor, 150.0), judge, offer)
                    seconds = time.process_time() - start
                    taken.append((seconds, shape, size, math.degrees(angle), plan.share))
        taken.sort(reverse=True)
        seconds = [each[0] for each in taken]
        late = sum(s > aimed_at_s for s in seconds)
        print(
            f"{len(diameters_mm)} drill(s), {len(taken)} unbalances: "
            f"median {seconds[len(seconds) // 2]:.2f} s, worst {seconds[0]:.2f} s, "
            f"aimed at {aimed_at_s} s, {late} slower"
        )
        for worst, shape, size, degrees, share in taken[:3]:
            print(f"  {worst:.2f} s: {shape}, {size:g} g·mm at {degrees:.0f}°, share {share:.3f}")


def unreachable() -> None:
    """Print the time to the end of jobs that cannot be met, and their first proposal."""
    import autobalance as ab
    from autobalance import integer_program

    integer_program.owns_standard_output = lambda: True  # here, so that their time counts
    crank = ab.generate("v8-crossplane", file="crank.stl", settings={"segments": 48}).data
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "crank.stl").write_bytes(crank)
        path = Path(folder) / "job.toml"
        for weights, (big_end, piston) in WEIGHTS_G.items():
            for zone in ZONES:
                path.write_text(JOB.format(big_end=big_end, piston=piston, zone=zone), encoding="utf-8")
                job = ab.read_job(path)
                start = time.process_time()
                report = ab.balance(job).report
                seconds = time.process_time() - start
                first = next((each["text"] for each in report["relaxations"]), "nothing")
                print(
                    f"{weights}, zone {zone}: {seconds:.1f} s, {WITHIN_S:g} s aimed at; "
                    f"{report['outcome']}, proposed: {first}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
