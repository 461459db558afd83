"""Random jobs of all kinds and mixes: each ends verified, within or above tolerance, or refused in a line.

    python benchmarks/random_jobs.py [--jobs 300] [--first 0] [--corpus FOLDER]

Cranks are generated; with ``--corpus`` every third is of a crank file of that folder: half of these as the
file is, half brought to a crank's size and turned, with weights that suit. An end is good where the exit code
is 0 or 4 and ``verify --independent`` agrees, or where it is 3 with one line on standard error.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
import tempfile
import time
import traceback
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

KINDS = ("shoulder", "turn", "drill", "slug", "add", "mill")
MESHES = (".stl", ".obj", ".off", ".3mf", ".stp")
UNITLESS = (".stl", ".obj", ".off")
CAR_CRANK_G = 10_000.0
PREFER = ("simple", "least_metal", "fewest_holes", "least_inertia_change")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--corpus", type=Path, help="a folder of crank files, tried beside generated ones")
    arguments = parser.parse_args()
    files = (
        []
        if arguments.corpus is None
        else sorted(file for file in arguments.corpus.iterdir() if file.suffix in MESHES)
    )
    ends: Counter[str] = Counter()
    for seed in range(arguments.first, arguments.first + arguments.jobs):
        with tempfile.TemporaryDirectory() as folder:
            start = time.process_time()
            end, said = run(random_job(Path(folder), seed, files))
        ends[end] += 1
        print(f"{seed:3d} {end:10s} {time.process_time() - start:5.1f} s  {said}", flush=True)
    print(dict(ends))


def run(job: Path) -> tuple[str, str]:
    """Balance a job and verify what was written; return how it ended, in a word, and what was said."""
    out = job.parent / "out"
    method = next(line for line in job.read_text(encoding="utf-8").splitlines() if line.startswith("method"))
    code, said = called("balance", str(job), "-o", str(out), "--only", "json")
    lines = said.strip().splitlines()
    if code == 3:
        good = len(lines) == 1 and lines[0].startswith("autobalance: error: ") and not out.exists()
        return ("refused" if good else "BAD LINE"), f"{method}: {said.strip()[:200]}"
    if code not in (0, 4):
        return "BAD END", f"{method}: exit code {code}: {said.strip()[-400:]}"
    again, doubts = called("verify", str(out / "report.json"), "--independent")
    if again != code:
        return "UNVERIFIED", f"{method}: {code} but verify {again}: {doubts.strip()[:400]}"
    return ("within" if code == 0 else "above"), method


def called(*words: str) -> tuple[int, str]:
    """Return the exit code of a command and its standard error."""
    from autobalance.command.main import main as command

    error = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(error):
        try:
            code = command(list(words))
        except SystemExit as end:
            code = int(end.code or 0)
        except BaseException:  # noqa: BLE001 - what must not happen is what is looked for
            return -1, traceback.format_exc()
    return code, "\n".join(line for line in error.getvalue().splitlines() if "warning" not in line)


@dataclass(frozen=True)
class Drawn:
    """A crank of a job: its file, what is said of it, the share of a car's weights that hangs on it."""

    file: Path
    said: tuple[str, ...]
    is_pressed_up: bool
    scale: float
    judges: tuple[str, ...] = ("dynamic", "dynamic", "static")


def random_job(folder: Path, seed: int, files: list[Path]) -> Path:
    """Write a crank, unless it is one of some files, and a job: methods, limits and weights at random."""
    rng = np.random.default_rng(seed)
    if not files or seed % 3:
        crank = _generated(folder, seed, rng)
    elif seed % 2:
        crank = _turned(folder, files[(seed // 6) % len(files)], rng)
    else:
        crank = _as_it_is(files[(seed // 6) % len(files)], rng)
    return _job(folder, crank, rng)


def _generated(folder: Path, seed: int, rng: np.random.Generator) -> Drawn:
    from autobalance.drawn_cranks.design import PRESETS
    from tests.generated import generated_crank
    from tests.jobs import write_stl

    name = sorted(PRESETS)[int(rng.integers(len(PRESETS)))]
    crank = generated_crank(name, seed=seed, segments=int(rng.choice([16, 24, 37])))
    write_stl(folder / "crank.stl", crank.mesh.corners)
    return Drawn(folder / "crank.stl", ('unit = "mm"',), not crank.design.crankpin_in_file, 1.0)


def _as_it_is(file: Path, rng: np.random.Generator) -> Drawn:
    said = ('unit = "mm"',) if file.suffix in UNITLESS else ()
    return Drawn(file, said, False, float(rng.choice([0.01, 0.1, 1.0])))


def _turned(folder: Path, file: Path, rng: np.random.Generator) -> Drawn:
    """Return a file's crank at the size of a small engine's, turned any way."""
    from real_cranks import corners_of
    from scipy.spatial.transform import Rotation

    from autobalance.solid.mesh.measure import soup_moments
    from tests.jobs import write_stl

    corners, has_pins = corners_of(file)
    turn = Rotation.random(random_state=int(rng.integers(2**31)))
    write_stl(folder / "crank.stl", turn.apply(corners.reshape(-1, 3)).reshape(corners.shape))
    scale = soup_moments(corners, 7.85e-3).mass_g / CAR_CRANK_G
    return Drawn(folder / "crank.stl", ('unit = "mm"',), not has_pins, scale, ("static",))


def _job(folder: Path, crank: Drawn, rng: np.random.Generator) -> Path:
    scale = crank.scale
    methods = [str(each) for each in rng.permutation(KINDS)[: int(rng.integers(1, 4))]]
    lines = [
        "[crankshaft]",
        f'file = "{crank.file}"',
        *crank.said,
        "density_kg_m3 = 7850.0",
        *(["crankpin_in_file = false"] if crank.is_pressed_up else []),
        "[engine.rotating_g]",
        f"rod = {scale * rng.uniform(50.0, 400.0):.3f}",
        "[engine.reciprocating_g]",
        f"piston = {scale * rng.uniform(100.0, 600.0):.3f}",
        *(["[engine.crankpin_g]", f"crankpin = {scale * 150.0:.3f}"] if crank.is_pressed_up else []),
        "[balance]",
        f"factor = {rng.uniform(0.0, 1.0):.2f}",
        f"grade = {float(rng.choice([2.5, 6.3, 16.0, 40.0]))}",
        f"speed_rpm = {float(rng.choice([3000.0, 6000.0, 12000.0]))}",
        f'judge = "{rng.choice(crank.judges)}"',
        "[correction]",
        f"method = {methods}",
        f'prefer = "{rng.choice(PREFER)}"',
    ]
    lines += limits(rng, methods)
    path = folder / "job.toml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def limits(rng: np.random.Generator, methods: list[str]) -> list[str]:
    """Return tables of some methods' limits."""
    lines: list[str] = []
    start = float(rng.uniform(0.0, 360.0))
    sector = f"sectors_deg = [[{start:.0f}, {start + float(rng.uniform(20.0, 330.0)):.0f}]]"
    if "drill" in methods:
        sizes = sorted({float(each) for each in rng.uniform(4.0, 14.0, 3).round(1)})
        lines += [
            "[correction.drill]",
            f'direction = "{rng.choice(["radial", "axial"])}"',
            f'zone = "{rng.choice(["counterweights", "anywhere"])}"',
            *([f"diameters_mm = {sizes}"] if rng.random() < 0.5 else []),
            *([sector] if rng.random() < 0.3 else []),
        ]
    if "slug" in methods:
        lines += ["[correction.slug]", "diameters_mm = [10.0, 16.0]", "lengths_mm = [6.0, 10.0, 14.0]"]
    if "mill" in methods:
        lines += ["[correction.mill]", f"cutter_mm = {float(rng.choice([6.0, 10.0]))}"]
    return lines


if __name__ == "__main__":
    main()
