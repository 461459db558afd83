"""Random NC jobs: kinds, layouts, posts, signs, zeros, cranks turned and moved; each swept a second way.

python benchmarks/nc_jobs.py [--jobs 60] [--seed 1]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import autobalance as ab  # noqa: E402
from autobalance.api.nc import NcResult  # noqa: E402
from autobalance.errors import AutobalanceError  # noqa: E402
from tests import nc_jobs, nc_sweep  # noqa: E402

LAYOUTS = ("single", "v-twin-45", "inline-4")
SHARES = {"radial": 0.01, "axial": 0.01, "slug": 0.01}


def turned(path: Path, rng: np.random.Generator) -> None:
    """Turn and move a crank's file at random."""
    found = ab.read_crank(path, unit="mm", density_kg_m3=7850.0)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    vertices = found.vertices_mm @ turn.T + rng.uniform(-200.0, 200.0, 3)
    ab.crank_from_mesh(vertices, found.triangles, density_kg_m3=7850.0).write(path)


def job(folder: Path, kind: str, layout: str, rng: np.random.Generator) -> Path | None:
    """Balance a crank of a layout by one kind of cut; None where that cuts nothing."""
    correction, factor, grade = nc_jobs.CORRECTIONS[kind]
    correction = correction.replace("faces = OUTER", 'faces = "auto"')
    folder.mkdir()
    crank = folder / "crank.stl"
    drawn = ab.generate(layout, file=crank, settings={"segments": 48})
    crank.write_bytes(drawn.data)
    turned(crank, rng)
    text = nc_jobs.JOB.format(correction=correction, factor=factor, grade=grade)
    (folder / "job.toml").write_text(text, encoding="utf-8")
    result = ab.balance(ab.read_job(folder / "job.toml"))
    if not result.corrections:
        return None
    result.write(folder / "out", only=("json",))
    return folder / "out" / "report.json"


def machine(kind: str, rng: np.random.Generator) -> nc_jobs.Values:
    """Draw a machine."""
    values = nc_jobs.machine(str(rng.choice(["linuxcnc", "fanuc"])), kind == "turn" and bool(rng.integers(2)))
    values["rotary"] = {"letter": str(rng.choice(list("ABC"))), "sign": int(rng.choice([1, -1]))}
    values["zero"] = {"angle": float(rng.uniform(0.0, 360.0)), "z_mm": float(rng.uniform(-30.0, 30.0))}
    return values


def main() -> int:
    """Run the jobs; print a line each; 1 where one fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng, failed = np.random.default_rng(arguments.seed), 0
    kinds = list(nc_jobs.CORRECTIONS)
    with tempfile.TemporaryDirectory() as name:
        for number in range(arguments.jobs):
            kind, layout = kinds[number % len(kinds)], str(rng.choice(LAYOUTS))
            begun, folder = time.perf_counter(), Path(name) / str(number)
            try:
                path = job(folder, kind, layout, rng)
                if path is None:
                    print(f"{number:3} {kind:9} {layout:10} nothing to cut")
                    continue
                result = ab.nc(path, machine(kind, rng))
            except AutobalanceError as error:
                print(f"{number:3} {kind:9} {layout:10} refused: {error}")
                continue
            result.write(folder / "nc")
            failed += not told(number, kind, layout, path, result, folder / "nc")
            print(f"     {time.perf_counter() - begun:.1f} s")
    print(f"{failed} failed")
    return int(failed > 0)


def told(number: int, kind: str, layout: str, path: Path, result: NcResult, folder: Path) -> bool:
    """Print how a job went; tell whether both sweeps agree and LinuxCNC runs it."""
    report = json.loads(path.read_text(encoding="utf-8"))
    permitted = min(plane["permissible_g_mm"] for plane in report["tolerance"]["planes"])
    residual, seen = nc_jobs.swept_residual(report, nc_jobs.part_of(path), result.programs, result.report)
    said = np.array([each["unbalance_g_mm"] for each in result.report["simulated"]["residual"]["planes"]])
    off = float(np.abs(residual - said).max()) / permitted
    gap = min((each.least_gap_mm for each in seen), default=np.inf)
    post = result.run.machine.post
    runs = post != "linuxcnc" or nc_sweep.RS274 is None
    runs = runs or all(nc_sweep.accepted(folder / file) for file in result.programs)
    fine = runs and off <= SHARES.get(kind, 0.03) and gap >= 4.98
    left_out = len(result.report["not_programmed"])
    print(
        f"{number:3} {kind:9} {layout:10} {post:8} off {100.0 * off:.3f} %, gap {gap:.2f} mm, "
        f"{left_out} left out, {'runs' if runs else 'REFUSED'}, {'ok' if fine else 'FAILED'}"
    )
    return fine


if __name__ == "__main__":
    raise SystemExit(main())
