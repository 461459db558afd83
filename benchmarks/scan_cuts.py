"""Cuts planned on simulated scans, made on the true crank: benchmarks.scan_cuts [--cases N] [--first N].

A scan with noise, and a skin within the accuracy stated, is balanced; the bodies of its tools are taken from
the true crank, meshed more finely. What that leaves about its true axis is held against the report: within
its uncertainty in at least 95 of 100. A line each, then a table by crank, σ and kind.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

import autobalance as ab
from autobalance.drawn_cranks.design import PRESETS
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.verbs.entry import CutTool
from tests.scans import Scan, Wear, scan, surface_of

CRANKS = ("single", "v-twin-45", "parallel-twin-360")
SIGMAS_MM = (0.005, 0.02, 0.05)
KINDS = ("shoulder", "drill", "mill")
EDGE_MM, FINE_MM = 1.8, 0.7
ACCURACY_MM = 0.03
DENSITY_G_MM3 = 7.85e-3
DRILLS = {"diameters_mm": [6.0, 8.0, 10.0, 12.0], "max_holes": 12}
PISTON_G, BIG_END_G, FACTOR = 250.0, 150.0, 0.6


@lru_cache(maxsize=len(CRANKS))
def true_crank(name: str) -> Solid:
    """Return a crank of a preset's dimensions in its own axes."""
    vertices, triangles, _ = surface_of(PRESETS[name], FINE_MM, Wear(), 0)
    return Solid.from_mesh(Mesh(vertices, triangles))


def left_on_the_true_crank(name: str, there: Scan, tools: Sequence[CutTool]) -> Array:
    """Return the unbalance (2,) that tools leave of the true crank with its bob-weights, true rotor frame."""
    solid = true_crank(name).moved(there.placement)
    for tool in tools:
        solid = solid - Solid.from_mesh(Mesh(tool.vertices_mm, tool.triangles))
    left = solid.moments(DENSITY_G_MM3, there.truth.file_to_rotor).first_g_mm[:2].copy()
    for throw in there.truth.throws:
        left += (BIG_END_G + FACTOR * PISTON_G) * throw.crankpin.centre_mm[:2]
    return left


def one(number: int) -> tuple[str, float, str, bool | None, str]:
    """Return crank, σ, kind, whether the truth was within the uncertainty, and a line about it."""
    name, kind = CRANKS[number % 3], KINDS[number // 3 % 3]
    sigma = SIGMAS_MM[number // 9 % 3]
    rng = np.random.default_rng([number, 91])
    skin = float(rng.normal(0.0, ACCURACY_MM / 1.96))
    there = scan(name, sigma, edge_mm=EDGE_MM, seed=number, skin_mm=skin)
    job = {
        "crankshaft": {"density_kg_m3": 1e6 * DENSITY_G_MM3, "scan_accuracy_mm": ACCURACY_MM},
        "engine": {"rotating_g": {"big_end": BIG_END_G}, "reciprocating_g": {"piston": PISTON_G}},
        "balance": {"factor": FACTOR, "grade": 250, "speed_rpm": 8000, "judge": "static"},
        "correction": {"method": kind, **({"drill": DRILLS} if kind == "drill" else {})},
    }
    try:
        crank = ab.crank_from_mesh(there.mesh.vertices, there.mesh.triangles, 1e6 * DENSITY_G_MM3)
        result = ab.balance(ab.Job.from_dict(job), crank=crank)
    except ab.AutobalanceError as error:
        return name, sigma, kind, None, f"refused: {error}"
    left = left_on_the_true_crank(name, there, result.tools())
    turn = (there.truth.file_to_rotor @ np.linalg.inv(crank.file_to_rotor))[:2, :2]
    off = float(np.linalg.norm(left - turn @ np.array(result.report["residual"]["unbalance_g_mm"])))
    pm = float(result.report["residual"]["uncertainty_g_mm"])
    return name, sigma, kind, off <= pm, f"off by {off:.1f}, stated ± {pm:.1f} g·mm"


def main() -> None:
    """Print the lines and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    table: dict[tuple[str, float, str], list[bool]] = defaultdict(list)
    refused = 0
    for number in range(asked.first, asked.first + asked.cases):
        begun = time.process_time()
        name, sigma, kind, within, line = one(number)
        refused += within is None
        if within is not None:
            table[name, sigma, kind].append(within)
        print(
            f"{number:4d}  {name} σ {sigma:g} {kind}: {line}, {time.process_time() - begun:.0f} s", flush=True
        )
    for (name, sigma, kind), found in sorted(table.items()):
        print(f"| {name} | {sigma:g} mm | {kind} | {sum(found)} of {len(found)} |")
    inside = sum(sum(found) for found in table.values())
    print(f"{inside} of {sum(map(len, table.values()))} within their uncertainty; {refused} refused")


if __name__ == "__main__":
    main()
