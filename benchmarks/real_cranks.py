"""Processor time of ``inspect`` and ``balance`` on real cranks beside the least that they can cost.

    python benchmarks/real_cranks.py [FOLDER] [--triangles 100000 300000 1000000] [--no-pages]

FOLDER, or the environment's AUTOBALANCE_CRANKS, holds crank files; without it only the bundled and drawn
cranks are measured. Each is taken as it is and with its triangles split in four as often as brings their
number nearest to those asked for; true surfaces are taken as the triangles that are laid over them. A file
in another unit than mm is brought to the size of a crank by a power of ten.

- *built*: read the bytes, weld, build the solid;
- *floor*: the same, one cut, one measurement, one write;
- *inspect* ÷ built, and *balance* (with its pages) ÷ floor and seconds over it.

The aims: `inspect` 1.5 × built; `balance` 2 × the floor at a million triangles, 1.5 × on drawn cranks, 1.5 s
over it at 100 000. Printed at the end: the worst of each size, and the crank it is of.

Processor seconds of whole processes, so that other work on the machine counts little; loading Python and
numpy is in all of them. A command that ends with an error, because there is no crank in the file, say, is
listed with its exit code and left out of the worst.
"""

from __future__ import annotations

import argparse
import compileall
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from autobalance.solid.formats.read import Source

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from main_job import BUNDLED, ENVIRONMENT, subdivided, write_stl  # noqa: E402

WITH_UNIT = {".3mf", ".glb", ".step", ".stp"}
ENDINGS = {".stl", ".obj", ".off", ".ply", *WITH_UNIT}
DRAWN = ("inline-4", "single")
"""Balanced as it is drawn, and not."""
ENDED = (0, 4)
"""Exit codes of a command that did its work."""
SMALLEST_MM = 20.0
"""Size of the smallest crank: a model engine's."""
JOB = """[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
crankpin_in_file = {pins}
[engine.rotating_g]
rod = 100.0
[engine.reciprocating_g]
piston = 150.0
{crankpin}
[balance]
factor = 0.3
grade = 100.0
speed_rpm = 3000
judge = "static"
[correction]
method = "shoulder"
"""
LEAST = """
import sys
from pathlib import Path
import manifold3d as m3
import numpy as np
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
mesh = mesh_of_soup(np.frombuffer(Path("crank.stl").read_bytes(), dtype=record, offset=84)["corners"])
body = m3.Manifold(m3.Mesh64(mesh.vertices, mesh.triangles.astype(np.uint64)))
body.status()
if sys.argv[1] == "floor":
    low, high = mesh.bounds
    edge = low + (high - low) * [0.97, 0.0, 0.0]
    raw = (body - m3.Manifold.cube(tuple(high - low)).translate(tuple(edge))).to_mesh64()
    cut = Mesh(np.asarray(raw.vert_properties)[:, :3], np.asarray(raw.tri_verts).astype(np.int64))
    mesh_moments(cut, 7.85e-3)
    out = np.zeros(len(cut.triangles), dtype=record)
    out["corners"] = cut.vertices[cut.triangles]
    Path("floor.stl").write_bytes(bytes(80) + np.uint32(len(out)).tobytes() + out.tobytes())
"""


def seconds(command: list[str], cwd: Path) -> tuple[float, int]:
    """Return processor time [s] and exit code of a process."""
    with open(os.devnull, "w") as nothing:
        process = subprocess.Popen(command, cwd=cwd, env=ENVIRONMENT, stdout=nothing, stderr=nothing)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, process.returncode


def cranks(folder: Path | None) -> Iterator[tuple[str, np.ndarray, bool]]:
    """Yield names, corners (m, 3, 3) [mm], and whether crankpins are in the file."""
    from autobalance.drawn_cranks.design import PRESETS
    from autobalance.drawn_cranks.generate import crank_solid
    from autobalance.errors import AutobalanceError

    yield "bundled", subdivided(BUNDLED / "crank.stl", 0), False
    for name in DRAWN:
        yield name, crank_solid(PRESETS[name], 64).mesh.corners, True
    for file in sorted(folder.iterdir()) if folder else []:
        if file.suffix.lower() in ENDINGS:
            try:
                yield file.name, *corners_of(file)
            except AutobalanceError as error:
                print(f"{file.name}: {error}")


def corners_of(file: Path) -> tuple[np.ndarray, bool]:
    """Return a file's corners (m, 3, 3) [mm] at the size of a crank, and whether crankpins are in it.

    Raises
    ------
    AutobalanceError
        If the file cannot be read.
    """
    from autobalance.solid.formats.read import read

    unit = None if file.suffix.lower() in WITH_UNIT else "mm"
    source = read(file, unit, "all")
    scale = 10.0 ** max(0, np.ceil(np.log10(SMALLEST_MM / source.solid.mesh.diagonal_mm)))
    return scale * source.solid.mesh.corners, _holds_pins(source)


def _holds_pins(source: Source) -> bool:
    """Tell whether a file holds crankpins, or bores for them; that it does where no crank is found."""
    from autobalance.balancing.measured_crank import measured_source, recognised
    from autobalance.crank.anatomy import Overrides
    from autobalance.errors import AutobalanceError

    try:
        return measured_source(
            source, recognised(source, Overrides(crankpin_in_file=None)), 7.85e-3
        ).holds_crankpins
    except AutobalanceError:
        return True


def measured(work: Path, soup: np.ndarray, pins: bool, pages: bool) -> dict[str, tuple[float, int]]:
    """Return the processor time and exit code of each command on one crank."""
    write_stl(work / "crank.stl", soup)
    crankpin = "" if pins else "[engine.crankpin_g]\ncrankpin = 114.65"
    (work / "job.toml").write_text(JOB.format(pins=str(pins).lower(), crankpin=crankpin))
    cli = [sys.executable, str(ROOT / "cli.py")]
    inspect = [*cli, "inspect", "crank.stl", "--unit", "mm", *([] if pins else ["--no-crankpin"])]
    balance = [*cli, "balance", "job.toml", "-o", "out", *([] if pages else ["--no-report"])]
    return {
        "built": seconds([sys.executable, "-c", LEAST, "built"], work),
        "floor": seconds([sys.executable, "-c", LEAST, "floor"], work),
        "inspect": seconds(inspect, work),
        "balance": seconds(balance, work),
    }


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="?", default=os.environ.get("AUTOBALANCE_CRANKS"))
    parser.add_argument("--triangles", type=int, nargs="*", default=[100_000, 300_000, 1_000_000])
    parser.add_argument("--no-pages", action="store_true")
    arguments = parser.parse_args()
    compileall.compile_dir(ROOT / "autobalance", quiet=1)  # as any installed package is
    worst: Worst = {}
    head = f"{'crank':>34} {'triangles':>9} {'built s':>8} {'floor s':>8} {'inspect s':>10} {'÷ built':>8}"
    print(f"{head} {'balance s':>10} {'÷ floor':>8} {'over s':>7}")
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for crank, soup, pins in cranks(Path(arguments.folder) if arguments.folder else None):
            times = {
                max(0, round(np.log(wanted / len(soup)) / np.log(4.0))) for wanted in arguments.triangles
            }
            for splits in sorted({0, *times}):
                write_stl(work / "coarse.stl", soup)
                fine = subdivided(work / "coarse.stl", splits)
                found = measured(work, fine, pins, not arguments.no_pages)
                print(line(crank, len(fine), found), flush=True)
                note_worst(worst, crank, len(fine), size_of(len(fine), arguments.triangles), found)
    for (command, size), (share, where) in sorted(worst.items()):
        print(f"worst {command}, {size}: {share:.2f} on {where} triangles")
    return 0


Found = dict[str, tuple[float, int]]
Worst = dict[tuple[str, str], tuple[float, str]]


def line(crank: str, count: int, found: Found) -> str:
    """Return a row of the table."""
    shown = f"{crank:>34} {count:>9} {found['built'][0]:>8.2f} {found['floor'][0]:>8.2f}"
    for command, least in (("inspect", "built"), ("balance", "floor")):
        took, code = found[command]
        ended = f"{took / found[least][0]:>8.2f}" if code in ENDED else f"{'exit ' + str(code):>8}"
        shown += f" {took:>10.2f} {ended}"
    return f"{shown} {found['balance'][0] - found['floor'][0]:>7.2f}"


def size_of(count: int, asked: list[int]) -> str:
    """Return the size asked for that a number of triangles is brought near to by splitting in four."""
    nearest = min(asked, key=lambda wanted: abs(np.log(count / wanted)), default=count)
    return f"some {nearest} triangles" if 0.5 <= count / nearest <= 2.0 else "other sizes"


def note_worst(worst: Worst, crank: str, count: int, size: str, found: Found) -> None:
    """Keep what is worse than before: the share of the least, and the seconds over it."""
    drawn = ", drawn" if crank in DRAWN else ""
    for command, least in (("inspect", "built"), ("balance", "floor")):
        took, code = found[command]
        if code in ENDED:
            base = found[least][0]
            for name, value in ((f"÷ {least}", took / base), (f"seconds over {least}", took - base)):
                key = f"{command} {name}", size + drawn
                worst[key] = max(worst.get(key, (-1e9, "")), (value, f"{crank}, {count}"))


if __name__ == "__main__":
    raise SystemExit(main())
