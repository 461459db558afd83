"""Recognition of odd cranks of every kind, against the truth of their construction: a table by kind.

    python benchmarks/odd_cranks.py [--cases 500] [--first 0] [--kind KIND ...] [--seconds 600]

Place, diameter and width of every main journal and crankpin, crank radius and angle of every throw, and both
faces of every web are compared (``tests/odd_cranks.py``). A crank is *right*; *doubted*, if a doubt names
what is true instead; *refused*; or *WRONG* in silence, which is listed with the seed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.odd_cranks import KINDS, odd_crank, outcome

ENDINGS = ("right", "doubted", "refused", "WRONG")


def table(ends: Counter[tuple[str, str]]) -> str:
    """Return a Markdown table of outcomes by kind, totals last."""
    rows = ["| kind | cranks | right | doubted | refused | wrong |", "|---|---:|---:|---:|---:|---:|"]
    kinds = [kind for kind in KINDS if any((kind, ending) in ends for ending in ENDINGS)]
    for kind in kinds:
        counts = [ends[kind, ending] for ending in ENDINGS]
        rows.append(f"| {kind} | {sum(counts)} | {' | '.join(map(str, counts))} |")
    sums = [sum(ends[kind, ending] for kind in kinds) for ending in ENDINGS]
    return "\n".join([*rows, f"| **all** | {sum(sums)} | {' | '.join(map(str, sums))} |"])


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kind", nargs="*", choices=KINDS, default=KINDS)
    parser.add_argument("--seconds", type=float, default=600.0)
    arguments = parser.parse_args()
    began, ends = time.process_time(), Counter[tuple[str, str]]()
    doubts = 0
    for seed in range(arguments.first, arguments.first + arguments.cases):
        odd = odd_crank(seed)
        if odd.kind not in arguments.kind:
            continue
        if time.process_time() - began > arguments.seconds:
            print(f"stopped before seed {seed}: {arguments.seconds:g} s of processor time are over")
            break
        ending, what = outcome(odd)
        ends[odd.kind, ending] += 1
        doubts += ending == "right" and bool(what)
        if ending != "right":
            step = "STEP" if odd.step else f"{odd.segments} segments, {odd.unit}"
            print(f"{seed}  {odd.kind}, {odd.what}, {step}: {ending}: {what}", flush=True)
    print(f"\n{table(ends)}\n\n{doubts} of those right have a doubt; {time.process_time() - began:.0f} s")
    return 1 if any(ending == "WRONG" for _, ending in ends) else 0


if __name__ == "__main__":
    raise SystemExit(main())
