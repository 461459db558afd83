"""How much faster a batch is with two workers than with one, and what limits a thousand.

    python benchmarks/batch_workers.py [--rows 1000] [--simulate]

The rows are small jobs: a crank of some 700 triangles, balanced at as many factors. Besides the wall time the
processor time is told of this process (reading cranks, sending, writing results and the journal) and of the
workers, each per row: on a machine that does other work these are the figures that hold. ``--simulate`` plays
a cluster with them: rows of a duration, a client that serves one row at a time.
"""

from __future__ import annotations

import argparse
import heapq
import os
import resource
import shutil
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from autobalance.solid.formats.write import encode  # noqa: E402
from autobalance.studies.batch.verb import batch  # noqa: E402
from tests.cranks import Shape, make_crank  # noqa: E402

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.rotating_g]
rod = 300.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = 0.5
grade = 16
speed_rpm = 6000
judge = "static"
[correction]
method = "turn"
"""
WORKERS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000)


def spent() -> tuple[float, float, float]:
    """Return wall time, processor time of this process, and of its children that ended [s]."""
    own, others = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter(), own.ru_utime + own.ru_stime, others.ru_utime + others.ru_stime


def measured(rows: int, workers: int, folder: Path) -> tuple[float, float, float]:
    """Return wall time, processor time of the client and of the workers of a batch [s]."""
    before = spent()
    report = batch(folder / "list.csv", folder / "out", workers=workers, fresh=True).report
    assert report["rows"] == rows
    assert report["failed"] == report["lost"] == 0
    wall, client, others = (after - since for after, since in zip(spent(), before, strict=True))
    return wall, client, others


def simulated(workers: int, row_s: float, client_s: float, rows: int) -> float:
    """Return the time of a batch whose client serves rows one after the other [s].

    A worker asks for its next row when one ends; the client takes ``client_s`` for each, both for the end of
    the one and the sending of the other.
    """
    ends = [0.0] * workers
    heapq.heapify(ends)
    client = 0.0
    for _ in range(rows):
        free = heapq.heappop(ends)
        client = max(client, free) + client_s
        heapq.heappush(ends, client + row_s)
    return max(ends)


def main() -> None:
    """Measure, simulate, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=1000)
    parser.add_argument("--simulate", action="store_true", help="only play the cluster")
    parser.add_argument("--client-ms", type=float, default=8.0, help="of the client, a row, as measured")
    parser.add_argument("--row-s", type=float, nargs="*", default=[0.1, 1.0, 10.0])
    given = parser.parse_args()
    if not given.simulate:
        folder = Path(tempfile.mkdtemp())
        solid, _ = make_crank([0.0], Shape(segments=24))
        (folder / "crank.stl").write_bytes(encode(solid.mesh, "stl", 1.0))
        (folder / "job.toml").write_text(JOB, "utf-8")
        rows = "".join(f"r{k},job.toml,{0.4 + 0.2 * k / given.rows:.6f}\n" for k in range(given.rows))
        (folder / "list.csv").write_text("name,job,balance.factor\n" + rows, "utf-8")
        walls = []
        for workers in (1, 2):
            wall, client, others = measured(given.rows, workers, folder)
            walls.append(wall)
            print(
                f"{workers} workers: {wall:.1f} s; a row takes {1e3 * client / given.rows:.2f} ms of the "
                f"client and {1e3 * others / given.rows:.2f} ms of a worker; load "
                f"{os.getloadavg()[0]:.1f} on {os.cpu_count()} cores",
                flush=True,
            )
        print(f"two workers are {walls[0] / walls[1]:.2f} times as fast as one")
        shutil.rmtree(folder)
    for row_s in given.row_s:
        client_s = 1e-3 * given.client_ms
        alone = simulated(1, row_s, client_s, 4000)
        told = ", ".join(
            f"{count}: {alone / simulated(count, row_s, 1e-3 * given.client_ms, 4000):.0f}"
            for count in WORKERS
        )
        print(f"rows of {row_s:g} s, {given.client_ms:g} ms of the client each, times as fast with {told}")


if __name__ == "__main__":
    main()
