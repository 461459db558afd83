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
    mixed = too_near = unverified = 0
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
            result.write(Path(folder) / "out", only=("json",))
            verdict = verified(Path(folder) / "out" / "report.json", result.exit_code)
            unverified += not verdict.startswith("verified")
            seconds = time.process_time() - start
            print(
                f"{seed:3d} {result.outcome} {dict(made)} {verdict}, {len(found)} too near, {seconds:.1f} s"
            )
            for each in found:
                print(f"    {each}")
            if result.outcome == "above_tolerance":
                print(f"    {result.reason}")
            sys.stdout.flush()
    print(f"{dict(outcomes)}; {mixed} of several kinds; cuts {dict(kinds)}")
    print(f"{too_near} pairs too near, {unverified} not verified")


def verified(report: Path, exit_code: int) -> str:
    """Return the verdict of ``verify --independent``: what holds and how well slices agree, or what fails."""
    import autobalance as ab

    try:
        found = ab.verify(report, independent=True)
    except ab.AutobalanceError as error:
        return f"NOT VERIFIED: {error}"
    if found.exit_code != exit_code:
        return f"NOT VERIFIED: exit code {found.exit_code}, but balance said {exit_code}"
    return f"verified: {found.claims} claims hold, slices agree to {found.report['agreement']:.0e}"


if __name__ == "__main__":
    main()
