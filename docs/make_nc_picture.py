"""Draw the simulated moves of two set-ups, for the page on NC programs.

python docs/make_nc_picture.py
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import autobalance as ab  # noqa: E402
from autobalance.machining.input import inverse, placement  # noqa: E402
from autobalance.machining.verb import NcResult  # noqa: E402

PICTURE = ROOT / "docs" / "pictures" / "nc.png"
INK, SOFT, FEED, RAPID = "#17191c", "#c9c9c4", "#b5400f", "#1c5d8f"
JOB = {
    "crankshaft": {"file": "crank.stl", "unit": "mm", "density_kg_m3": 7850.0},
    "engine": {"rotating_g": {"big_end": 300.0}, "reciprocating_g": {"piston": 300.0}},
    "balance": {"factor": 0.12, "grade": 40.0, "speed_rpm": 6000.0},
}
HOLDER = [[32.0, 60.0]]
USUAL = {"flute_mm": 40.0, "stick_out_mm": 95.0, "holder": HOLDER, "rpm": 900, "feed_mm_min": 120.0}
MACHINE = {
    "machine": {"post": "linuxcnc", "max_rpm": 8000},
    "rotary": {},
    "zero": {"angle": "crankpin 1", "z_mm": "crankpin 1"},
    "tool": [
        {"number": 1, "kind": "drill", "diameter_mm": 10.0, "peck_mm": 4.0, **USUAL},
        {"number": 3, "kind": "end_mill", "diameter_mm": 10.0, "step_over_mm": 4.0, **USUAL},
    ],
}


def programs(folder: Path, correction: dict[str, Any]) -> NcResult:
    """Balance a crank by one kind of cut and program it."""
    crank = ab.generate("single", file=folder / "crank.stl", segments=96)
    crank.write(folder)
    job = ab.Job.from_dict(
        {
            **JOB,
            "crankshaft": {**JOB["crankshaft"], "file": str(folder / "crank.stl")},
            "correction": correction,
        }
    )
    ab.balance(job).write(folder / "out", only=("json",))
    return ab.nc(folder / "out" / "report.json", MACHINE)


def drawn(axes: Any, result: NcResult, name: str, planes: tuple[str, str]) -> None:
    """Draw the moves of a set-up over the crank's outline."""
    run = result.run
    program = next(each for each in run.programs if each.name == name)
    across, up = ("xyz".index(letter) for letter in planes)
    first = next(move for move in program.moves if not move.rapid)
    pose = placement(program.name, run.zero, 1, first.end.turned_deg)
    placed = run.part.before.moved(inverse(pose))
    order = [across, up, 3 - across - up]
    turn = np.eye(4)
    turn[:3, :3] = np.eye(3)[order]
    if np.linalg.det(turn[:3, :3]) < 0.0:
        turn[2] *= -1.0
    for outline in placed.moved(turn).shadow().polygons:
        axes.fill(*outline.T, facecolor="#e4e6e8", edgecolor=SOFT, linewidth=0.8)
    for move in program.moves:
        ends = [[getattr(place, letter) for letter in planes] for place in (move.start, move.end)]
        if any(value is None for end in ends for value in end) or move.start == move.end:
            continue
        colour, dash = (RAPID, (0, (4, 3))) if move.rapid else (FEED, "solid")
        axes.plot(*np.array(ends).T, color=colour, linestyle=dash, linewidth=0.9 if move.rapid else 1.1)
    axes.set_aspect("equal")
    axes.set_xlabel(f"machine {planes[0].upper()} [mm]")
    axes.set_ylabel(f"machine {planes[1].upper()} [mm]")
    axes.set_title(f"set-up {name}: {program.file}", fontsize=9, color=INK)
    axes.tick_params(labelsize=7)


def main() -> None:
    """Write the picture."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.6), constrained_layout=True)
    with tempfile.TemporaryDirectory() as name:
        one, other = Path(name) / "drill", Path(name) / "mill"
        one.mkdir()
        other.mkdir()
        drill = {"method": "drill", "drill": {"diameters_mm": [10.0]}}
        drawn(left, programs(one, drill), "R", ("x", "z"))
        drawn(right, programs(other, {"method": "mill"}), "T", ("x", "y"))
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
