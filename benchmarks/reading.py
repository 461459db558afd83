"""Read, weld, check and measure a large STL, beside numpy reading, exact weld and construction alone.

    python benchmarks/reading.py [--triangles 5000000]

Each side runs in a process of its own; the peak memory is that process's.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))


def write_ball(path: Path, triangles: int) -> None:
    from autobalance.solid.csg.solid import Solid
    from autobalance.solid.formats.write import encode

    segments = int(np.sqrt(triangles)) // 2 * 2
    angle = np.linspace(0.0, np.pi, segments // 2 + 1)
    ball = Solid.revolved(50.0 * np.stack([np.sin(angle), -np.cos(angle)], axis=1), segments)
    path.write_bytes(encode(ball.mesh, "stl", 1.0))


def ours(path: Path) -> None:
    from autobalance.solid.formats.read import read

    read(path, "mm").solid.moments(7.85e-3)


def floor(path: Path) -> None:
    from autobalance.solid.csg.solid import Solid
    from autobalance.solid.mesh.mesh import mesh_of_soup

    record = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(path.read_bytes(), dtype=record, offset=84)["corners"]
    Solid.from_mesh(mesh_of_soup(np.ascontiguousarray(corners)))


def peak_mib() -> float:
    """Return the peak memory of this process [MiB]; Linux counts its parent's into ``ru_maxrss``."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--triangles", type=int, default=5_000_000)
    parser.add_argument("--only", nargs=2, metavar=("SIDE", "FILE"))
    arguments = parser.parse_args()
    if arguments.only:
        side, file = arguments.only
        start = time.perf_counter()
        {"ours": ours, "floor": floor}[side](Path(file))
        seconds = time.perf_counter() - start
        print(f"{seconds:.3f} {peak_mib():.0f}")
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ball.stl"
        write_ball(path, arguments.triangles)
        size = path.stat().st_size / 2**20
        found: dict[str, tuple[float, float]] = {}
        for side in ("floor", "ours", "floor", "ours"):
            command = [sys.executable, __file__, "--only", side, str(path)]
            seconds, peak = map(
                float, subprocess.run(command, capture_output=True, check=True).stdout.split()
            )
            found[side] = min(found.get(side, (np.inf, 0.0)), (seconds, peak))
        print(f"file {size:.0f} MiB")
        for side, (seconds, peak) in found.items():
            print(f"{side:6s} {seconds:7.2f} s  peak {peak:6.0f} MiB = {peak / size:.1f} times the file")
        print(f"ratio  {found['ours'][0] / found['floor'][0]:.2f}")


if __name__ == "__main__":
    main()
