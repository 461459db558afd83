"""Random jobs that add metal: each must end 0, 4 or 3 with one line, and what is written must be verified.

python benchmarks/added_metal.py [JOBS] [SEED]
"""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import autobalance as ab

PRESETS = (
    "single",
    "v-twin-45",
    "parallel-twin-360",
    "inline-3",
    "v8-crossplane",
    "pressed-up-single-no-pin",
)
METHODS = (["add"], ["shoulder", "add"])


def job_of(rng: np.random.Generator, preset: str, file: Path) -> ab.Job:
    """Return a random job on a crank's file."""
    method = METHODS[int(rng.integers(len(METHODS)))]
    limits = {"max_depth_mm": float(rng.uniform(2.0, 12.0)), "min_wall_mm": float(rng.uniform(1.0, 4.0))}
    pressed = preset.endswith("no-pin")
    return ab.Job.from_dict(
        {
            "crankshaft": {
                "file": str(file),
                "unit": "mm",
                "density_kg_m3": 7850.0,
                "crankpin_in_file": not pressed,
            },
            "engine": {
                "rotating_g": {"big_end": float(rng.uniform(100.0, 500.0))},
                "reciprocating_g": {"piston": float(rng.uniform(200.0, 600.0))},
                **({"crankpin_g": {"crankpin": 150.0}} if pressed else {}),
            },
            "balance": {"factor": float(rng.uniform(0.2, 0.7)), "grade": 16.0, "speed_rpm": 6000.0},
            "correction": {"method": method, "add": limits},
        }
    )


def main(count: int = 60, seed: int = 1) -> int:
    """Run the jobs; return the number that verify does not confirm."""
    rng = np.random.default_rng(seed)
    ends: Counter[str] = Counter()
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            preset = PRESETS[int(rng.integers(len(PRESETS)))]
            file = Path(folder) / f"{number}.stl"
            settings = {"segments": int(rng.integers(16, 49))}
            file.write_bytes(ab.generate(preset, file=file, settings=settings).data)
            try:
                result = ab.balance(job_of(rng, preset, file))
            except ab.AutobalanceError as error:
                ends["refused"] += 1
                print(f"{number} {preset}: refused: {error}", flush=True)
                continue
            result.write(Path(folder) / str(number), only=("json",))
            ends[result.outcome] += 1
            try:
                ab.verify(Path(folder) / str(number) / "report.json", independent=True)
            except ab.AutobalanceError as error:
                wrong += 1
                print(f"{number} {preset} {result.outcome}: NOT CONFIRMED: {error}", flush=True)
    print(f"{count} jobs: {dict(ends)}; {wrong} not confirmed")
    return wrong


if __name__ == "__main__":
    raise SystemExit(main(*map(int, sys.argv[1:3])) > 0)
