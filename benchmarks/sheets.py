"""Sheets of random jobs: no text over text, no page under a third full but the last.

    python benchmarks/sheets.py [--jobs 100] [--first 0]

Each crank is generated (V8, inline-4 and single among the presets) and balanced, its sheet written on A4 or
Letter, in metric or
inch; poppler reads the pages back.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]


def main() -> None:
    from random_jobs import called, random_job

    from tests.pages import faults, page_texts

    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    good = drawn = 0
    for seed in range(arguments.first, arguments.first + arguments.jobs):
        with tempfile.TemporaryDirectory() as folder:
            job, out = random_job(Path(folder), seed, []), Path(folder) / "out"
            paper, units = ("A4", "Letter")[seed % 2], ("metric", "inch")[seed // 2 % 2]
            code, said = called(
                "balance", str(job), "-o", str(out), "--only", "pdf", "--paper", paper, "--units", units
            )
            if code not in (0, 4):
                print(f"{seed:3d} refused: {said.strip()[:120]}", flush=True)
                continue
            drawn += 1
            wrong = faults(out / "sheet.pdf")
            good += not wrong
            count = len(page_texts(out / "sheet.pdf"))
            print(f"{seed:3d} {count:2d} pages, {paper}, {units}: {'; '.join(wrong) or 'good'}", flush=True)
    print(f"{good} of {drawn} sheets are good")


if __name__ == "__main__":
    main()
