"""Processor time of whole processes and peak memory of ``balance`` beside the floor and the naive way.

    python benchmarks/main_job.py [--splits 0 1 2 3] [--repeat 3] [--skip-naive]

- *ours*: ``autobalance balance JOB`` as a user runs it, report pages left out;
- *floor*: read the bytes, weld, one construction of the solid, one boolean, one measurement, one write,
  once, with the same libraries (``benchmarks/floor.py``);
- *naive*: trimesh load, mass properties and ``trimesh.boolean.difference`` inside a root finder until within
  1 % of the permissible value (``benchmarks/naive.py``).

The crank is the bundled straight one, each of its 16 348 triangles split in four 0, 1, 2 or 3 times.
"""

from __future__ import annotations

import argparse
import compileall
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
BUNDLED = ROOT / "fixtures" / "crf250r" / "straight"
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}


def write_stl(path: Path, corners: np.ndarray) -> None:
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    data = np.zeros(len(corners), dtype=record)
    data["corners"] = corners
    path.write_bytes(b"benchmark".ljust(80) + np.uint32(len(corners)).tobytes() + data.tobytes())


def subdivided(source: Path, times: int) -> np.ndarray:
    """Return the corners (m, 3, 3) of a binary STL, each triangle split in four ``times`` times."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(source.read_bytes(), dtype=record, offset=84)["corners"].astype(np.float64)
    for _ in range(times):
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    return corners


def measured(command: list[str], cwd: Path) -> tuple[float, float, int]:
    """Return processor time [s] with children's, peak memory [MB] and exit code of a process."""
    with open(os.devnull, "w") as nothing:
        process = subprocess.Popen(command, cwd=cwd, env=ENVIRONMENT, stdout=nothing, stderr=nothing)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0, process.returncode


def job_text(crank: str) -> str:
    """Return the bundled job with its crank replaced."""
    lines = (BUNDLED / "factor-0.28.toml").read_text().splitlines()
    return "\n".join(f'file = "{crank}"' if line.startswith("file") else line for line in lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--splits", type=int, nargs="+", default=[0, 1, 2, 3])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--skip-naive", action="store_true")
    parser.add_argument("--balance-options", nargs="*", default=[], metavar="WORD")
    arguments = parser.parse_args()
    compileall.compile_dir(ROOT / "autobalance", quiet=1)  # as any installed package is
    print(f"{'triangles':>10} {'way':>6} {'seconds':>8} {'÷ floor':>8} {'peak MB':>8}")
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        for splits in arguments.splits:
            corners = subdivided(BUNDLED / "crank.stl", splits)
            write_stl(work / "crank.stl", corners)
            (work / "job.toml").write_text(job_text("crank.stl"))
            python = sys.executable
            ways = {
                "floor": [python, str(HERE / "floor.py"), "crank.stl"],
                "ours": [python, str(ROOT / "cli.py"), "balance", "job.toml", "-o", "out", "--no-report"],
                "naive": [python, str(HERE / "naive.py"), "crank.stl"],
            }
            ways["ours"] += arguments.balance_options
            if arguments.skip_naive:
                del ways["naive"]
            floor = 0.0
            taken: dict[str, list[tuple[float, float, int]]] = {name: [] for name in ways}
            for again in range(arguments.repeat):  # in turn, so that a machine's good and bad times meet all
                for name, command in ways.items():
                    if again == 0 or name != "naive":
                        taken[name].append(measured(command, work))
            for name, runs in taken.items():
                if any(run[2] for run in runs):
                    print(f"{len(corners):>10} {name:>6} failed with exit code {runs[-1][2]}")
                    return 1
                seconds = min(run[0] for run in runs)
                floor = seconds if name == "floor" else floor
                memory = max(run[1] for run in runs)
                print(f"{len(corners):>10} {name:>6} {seconds:>8.2f} {seconds / floor:>8.2f} {memory:>8.0f}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
