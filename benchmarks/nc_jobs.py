"""Random NC jobs: kinds, layouts, posts, signs, zeros, cranks turned and moved; each swept a second way.

python benchmarks/nc_jobs.py [--jobs 60] [--first 0]

A crank is generated at a random place, and weights are attached that leave it heavy at the counterweights of
both ends; what the cuts of one kind correct is programmed, and the text swept by `tests/nc_sweep.py`.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import autobalance as ab  # noqa: E402
from autobalance.errors import AutobalanceError  # noqa: E402
from autobalance.machining.verb import NcResult  # noqa: E402
from tests import nc_jobs, nc_sweep  # noqa: E402

LAYOUTS = ("single", "v-twin-45", "parallel-twin-360", "inline-3", "inline-4", "v6-60")
SHARES = {"radial": 0.01, "axial": 0.01, "slug": 0.01}
TEXT_MM = 0.02
"""By how much a sweep with facets may see less than the clearance."""
GOUGED_MM = 0.02
"""Thickness of what its facets may take too much."""


def machine(kind: str, rng: np.random.Generator) -> nc_jobs.Values:
    """Draw a machine."""
    values = nc_jobs.machine(str(rng.choice(["linuxcnc", "fanuc"])), kind == "turn" and bool(rng.integers(2)))
    values["rotary"] = {"letter": str(rng.choice(list("ABC"))), "sign": int(rng.choice([1, -1]))}
    angle: float | str = float(rng.uniform(0.0, 360.0)) if rng.integers(3) else "crankpin 1"
    place = [float(rng.uniform(-30.0, 30.0)), "crankpin 1", "F"][int(rng.integers(3))]
    values["zero"] = {"angle": angle, "z_mm": place}
    if rng.integers(4):  # long enough to reach beside shafts and webs
        values["tool"] = [{**tool, "stick_out_mm": 250.0} for tool in values["tool"]]
    return values


def main() -> int:
    """Run the jobs; print a line each; 1 where one fails."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--jobs", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    arguments = parser.parse_args()
    failed = programmed = 0
    kinds = list(nc_jobs.CORRECTIONS)
    with tempfile.TemporaryDirectory() as name:
        for seed in itertools.count(arguments.first):
            if programmed == arguments.jobs:
                break
            rng = np.random.default_rng(seed)
            kind, layout = kinds[seed % len(kinds)], str(rng.choice(LAYOUTS))
            begun, folder = time.perf_counter(), Path(name) / str(seed)
            print(f"{seed:3} {kind:9} {layout:17} ", end="", flush=True)
            try:
                path = nc_jobs.random_job(folder, kind, layout, seed)
                if path is None:
                    print("nothing to cut")
                    continue
                result = ab.nc(path, machine(kind, rng))
            except AutobalanceError as error:
                print(f"refused: {error}")
                continue
            result.write(folder / "nc")
            programmed += 1
            failed += not told(kind, path, result, folder / "nc")
            print(f"    {time.perf_counter() - begun:.1f} s", flush=True)
    print(f"{programmed} programmed, {failed} failed")
    return int(failed > 0)


def told(kind: str, path: Path, result: NcResult, folder: Path) -> bool:
    """Print how a job went; tell whether both sweeps agree and LinuxCNC runs it."""
    report = json.loads(path.read_text(encoding="utf-8"))
    permitted = min(plane["permissible_g_mm"] for plane in report["tolerance"]["planes"])
    part = nc_jobs.part_of(path)
    residual, seen = nc_jobs.swept_residual(report, part, result.programs, result.report)
    gouged = nc_jobs.gouged_mm(part, seen)
    said = np.array([each["unbalance_g_mm"] for each in result.report["simulated"]["residual"]["planes"]])
    wanted = np.array([each["unbalance_g_mm"] for each in report["residual"]["planes"]])
    off = float(np.abs(residual - said).max()) / permitted
    share = float(np.abs(residual - wanted).max()) / permitted
    gap = min((each.least_gap_mm for each in seen), default=np.inf)
    post = result.run.machine.post
    runs = post != "linuxcnc" or nc_sweep.RS274 is None
    runs = runs or all(nc_sweep.accepted(folder / file) for file in result.programs)
    left_out = len(result.report["not_programmed"])
    most = SHARES.get(kind, 0.03)
    fine = (
        runs
        and off <= most
        and (share <= most or left_out > 0)
        and gap >= 5.0 - TEXT_MM
        and gouged <= GOUGED_MM
    )
    cuts = sum(len(setup["cuts"]) for setup in result.report["setups"])
    print(
        f"{post:8} {cuts} cuts, {left_out} left out; off the simulated residual {100.0 * off:.3f} %, the "
        f"report's {100.0 * share:.3f} %; gap {gap:.2f} mm, gouged {gouged:.3f} mm, "
        f"{'runs' if runs else 'REFUSED'}, {'ok' if fine else 'FAILED'}",
        end="",
    )
    return fine


if __name__ == "__main__":
    raise SystemExit(main())
