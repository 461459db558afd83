"""Guard of speed and memory: `inspect` and `balance` as multiples of the floor, beside the last ones.

    python benchmarks/against_floor.py [--repeat 3] [--only NAME ...] [--no-balance] [--growth] [--keep]

The *floor* reads the bytes, welds, constructs the solid once, makes one cut, measures and writes, with the
same libraries (``benchmarks/floor.py``). The cranks are the bundled one with its own job, and generated ones
with shoulders to lower; AUTOBALANCE_CRANKS=FOLDER adds its STL files, in mm. Each is drawn by a process of
its own, so that the one that measures stays small: a child's peak of memory begins with its parent's.

The commands run in turn, in one thread, without the cache of what was read before, and the least processor
time (user and system) of ``--repeat`` runs counts. So other work on the machine meets all alike: compare the
ratios, not the seconds.

``benchmarks/against_floor.json`` has the ratios of the last landed change. A ratio that is more than a tenth
above its last one is marked, and the exit code is 1: the commit of such a change says why. ``--keep`` writes
the new ratios. ``--growth`` measures one crank at 0.1, 0.3, 1 and 3 million triangles instead: its seconds
for each million do not rise if the cost grows as the number of triangles.
"""

from __future__ import annotations

import argparse
import compileall
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from main_job import BUNDLED, ENVIRONMENT, measured  # noqa: E402

ENVIRONMENT.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", AUTOBALANCE_CACHE_MB="0")
ENVIRONMENT.pop("PYTHONDONTWRITEBYTECODE", None)
LANDED = ROOT / "benchmarks" / "against_floor.json"
DRAW = """
import sys
from pathlib import Path
from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import crank_shape
from autobalance.solid.csg.shape import tessellated
from main_job import write_stl
write_stl(Path("crank.stl"), tessellated(crank_shape(preset(sys.argv[1])), int(sys.argv[2])).mesh.corners)
"""
BUNDLED_NAME = "bundled, 16 k"
CRANKS = {
    BUNDLED_NAME: ("", 0),
    "single, 12 k": ("single", 128),
    "inline-4, 71 k": ("inline-4", 160),
    "inline-4, 102 k": ("inline-4", 200),
    "V12, 293 k": ("v12-60", 320),
    "V12, 1.0 M": ("v12-60", 672),
    "V12, 1.2 M": ("v12-60", 740),
}
GROWTH = {
    f"inline-4, {size}": ("inline-4", segments)
    for size, segments in (("0.1 M", 200), ("0.3 M", 410), ("1 M", 795), ("3 M", 1430))
}
MORE = 1.1
ENDED = (0, 4)
"""Exit codes of a command that did its work."""


@dataclass(frozen=True)
class Figures:
    """Processor seconds and peak memory [MB] of the floor and the commands, by their names."""

    triangles: int
    seconds: dict[str, float]
    megabytes: dict[str, float]

    def ratios(self) -> dict[str, float]:
        """Return times and peaks of the commands as multiples of the floor's."""
        names = [name for name in self.seconds if name != "floor"]
        times = {name: round(self.seconds[name] / self.seconds["floor"], 2) for name in names}
        peaks = {f"{name} MB": round(self.megabytes[name] / self.megabytes["floor"], 2) for name in names}
        return times | peaks


def cranks(chosen: dict[str, tuple[str, int]], folder: Path) -> Iterable[tuple[str, int]]:
    """Write each crank and its job into a folder in turn; yield its name and number of triangles."""
    from real_cranks import JOB

    target = folder / "crank.stl"
    for name, (design, segments) in chosen.items():
        (folder / "job.toml").write_text(JOB.format(pins="true", crankpin=""))
        if design:
            subprocess.run(
                [sys.executable, "-c", DRAW, design, str(segments)],
                check=True,
                cwd=folder,
                env=ENVIRONMENT | {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'benchmarks'}"},
            )
        else:
            shutil.copyfile(BUNDLED / "crank.stl", target)
            shutil.copyfile(BUNDLED / "factor-0.28.toml", folder / "job.toml")
        yield name, _triangles(target)
    own = os.environ.get("AUTOBALANCE_CRANKS")
    for path in sorted(Path(own).glob("*.stl")) if own else ():
        (folder / "job.toml").write_text(JOB.format(pins="true", crankpin=""))
        shutil.copyfile(path, target)
        yield path.stem, _triangles(target)


def _triangles(stl: Path) -> int:
    return (stl.stat().st_size - 84) // 50


def figures(folder: Path, triangles: int, repeat: int, balance: bool, words: list[str]) -> Figures:
    """Measure the floor and the commands on crank.stl in a folder, in turn; `inspect` takes more words."""
    program = [sys.executable, str(ROOT / "cli.py")]
    commands = {
        "floor": [sys.executable, str(ROOT / "benchmarks" / "floor.py"), "crank.stl"],
        "inspect": [*program, "inspect", "crank.stl", "--unit", "mm", "--json", "inspect.json", *words],
    }
    if balance:
        commands["balance"] = [*program, "balance", "job.toml", "-o", "out"]
    runs: dict[str, list[tuple[float, float, int]]] = {name: [] for name in commands}
    for _ in range(repeat):
        for name, command in commands.items():
            runs[name].append(measured(command, folder))
            if runs[name][-1][2] not in ENDED:
                raise SystemExit(f"{' '.join(command)} ended with exit code {runs[name][-1][2]}")
    return Figures(
        triangles,
        {name: min(run[0] for run in each) for name, each in runs.items()},
        {name: max(run[1] for run in each) for name, each in runs.items()},
    )


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME")
    parser.add_argument("--no-balance", action="store_true")
    parser.add_argument("--growth", action="store_true")
    parser.add_argument("--keep", action="store_true")
    arguments = parser.parse_args()
    compileall.compile_dir(ROOT / "autobalance", quiet=1)  # as any installed package is
    landed = json.loads(LANDED.read_text()) if LANDED.exists() else {}
    chosen = GROWTH if arguments.growth else CRANKS
    chosen = {name: each for name, each in chosen.items() if not arguments.only or name in arguments.only}
    slower = 0
    print("crank | triangles | command | seconds | ÷ floor | landed | peak MB | ÷ floor | s per million")
    with tempfile.TemporaryDirectory() as folder:
        for name, triangles in cranks(chosen, Path(folder)):
            words = ["--no-crankpin"] if name == BUNDLED_NAME else []
            found = figures(Path(folder), triangles, arguments.repeat, not arguments.no_balance, words)
            ratios, before = found.ratios(), landed.get(name, {})
            for command, seconds in found.seconds.items():
                share, last = ratios.get(command, 1.0), before.get(command)
                worse = last is not None and share > MORE * last
                slower += worse
                print(
                    f"{name} | {triangles} | {command} | {seconds:.2f} | {share:.2f} | {last or ''} | "
                    f"{found.megabytes[command]:.0f} | {ratios.get(f'{command} MB', 1.0):.2f} | "
                    f"{seconds / triangles * 1e6:.2f}{' MORE THAN A TENTH SLOWER' if worse else ''}",
                    flush=True,
                )
            landed[name] = before | ratios
            if arguments.keep:
                LANDED.write_text(json.dumps(landed, indent=1, ensure_ascii=False) + "\n")
    return 1 if slower else 0


if __name__ == "__main__":
    raise SystemExit(main())
