"""Random jobs that mix four kinds of correction: are walls and spacing kept, and is every result verified?

    python benchmarks/mixed_jobs.py [--jobs 50] [--first 0]

Distances are measured between the bodies that the tools take from the crank; each result is written, read and
measured again, also by slices.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))


def main() -> None:
    import autobalance as ab
    from tests.mixed_kinds import faults, mixed_job

    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    outcomes: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    mixed = too_near = 0
    for seed in range(arguments.first, arguments.first + arguments.jobs):
        with tempfile.TemporaryDirectory() as folder:
            start = time.process_time()
            result = ab.balance(ab.read_job(mixed_job(Path(folder), seed)))
            made = Counter(each.kind for each in result.corrections)
            found = faults(result)
            outcomes[result.outcome] += 1
            kinds += made
            mixed += len(made) > 1
            too_near += len(found)
            checked = 0
            if made:
                result.write(Path(folder) / "out", only=("json",))
                checked = ab.verify(Path(folder) / "out" / "report.json", independent=True).checked.checked
            seconds = time.process_time() - start
            said = f"{checked} claims hold, {len(found)} too near, {seconds:.1f} s"
            print(f"{seed:3d} {result.outcome} {dict(made)} {said}")
            if result.outcome == "above_tolerance":
                print(f"    {result.reason}")
            sys.stdout.flush()
    print(f"{dict(outcomes)}; {mixed} of several kinds; cuts {dict(kinds)}; {too_near} pairs too near")


if __name__ == "__main__":
    main()
