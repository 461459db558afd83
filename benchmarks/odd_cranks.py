"""Drawn cranks that are waved, decimated, bent or cut in half, and parts that are none: right or refused.

    python benchmarks/odd_cranks.py [--cases 100] [--first 0] [--seconds 600]

What is waved, decimated or bent a little is right where counts, diameters, radii and the axis are the drawn
crank's within what was done to it. Half a crank is right where all that is recognised is part of the
whole. A part that is no crank must be refused.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.parametric.design import PRESETS, Design, preset
from autobalance.crank.parametric.generate import crank_solid
from autobalance.crank.parametric.true_anatomy import crank_anatomy
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import AutobalanceError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from tests.geometry.test_recognise_refused import NO_CRANKS
from tests.scans import decimated

WAYS = ("waved", "decimated", "waved and decimated", "bent", "half", "no crank")
SAME_MM = 0.1


def changed(way: str, mesh: Mesh, rng: np.random.Generator) -> tuple[Mesh, float]:
    """Return what becomes of a mesh, and by how much its surface moved."""
    moved = 0.0
    mesh = Mesh(np.array(mesh.vertices), np.array(mesh.triangles))  # not read-only
    if "waved" in way:
        moved = float(10.0 ** rng.uniform(-3.0, -1.0))
        mesh = Mesh(mesh.vertices + rng.normal(0.0, moved, mesh.vertices.shape), mesh.triangles)
    if "decimated" in way:
        mesh = decimated(mesh, max(200, int(len(mesh.triangles) * rng.uniform(0.3, 0.9))))
    if way == "bent":
        moved = float(10.0 ** rng.uniform(-3.0, 0.0))
        z = mesh.vertices[:, 2]
        along = (z - z.min()) / np.ptp(z)
        shift = np.stack([4.0 * moved * along * (1.0 - along), 0.0 * z, 0.0 * z], axis=1)
        mesh = Mesh(mesh.vertices + shift, mesh.triangles)
    return mesh, moved


def half(solid: Solid, rng: np.random.Generator) -> Solid:
    """Return what is left of a crank on one side of a plane across it."""
    low, high = solid.bounds
    z = float(rng.uniform(low[2] + 0.25 * (high[2] - low[2]), high[2] - 0.25 * (high[2] - low[2])))
    far = np.full(3, 1e4)
    return solid & Solid.box(np.array([-1e4, -1e4, z]), far)


def faults(found: Anatomy, true: Anatomy, within_mm: float, whole: bool) -> list[str]:
    """Return in what an anatomy is not that of the drawn crank, or what half of one has besides."""
    if whole:
        counts = [[len(part) for part in (a.main_journals, a.throws, a.webs)] for a in (found, true)]
        if counts[0] != counts[1]:
            return [f"journals, throws, webs are {counts[0]}, not {counts[1]}"]
    wrong = []
    radii = [throw.crank_radius_mm for throw in true.throws]
    pins = [throw.crankpin.diameter_mm for throw in true.throws]
    mains = [journal.diameter_mm for journal in true.main_journals]
    parts = [("crank radius", [t.crank_radius_mm for t in found.throws], radii)]
    parts.append(("crankpin", [t.crankpin.diameter_mm for t in found.throws], pins))
    parts.append(("main journal", [j.diameter_mm for j in found.main_journals], mains))
    for name, values, wanted in parts:
        wrong += [
            f"{name} {value:.4g}, of {wanted[0]:.4g}"
            for value in values
            if min(abs(value - each) for each in wanted) > within_mm
        ]
    axis = float(abs(found.rotor_to_file[2, 2]))
    if axis < np.cos(2e-3 + within_mm / 50.0):
        wrong.append(f"the axis leans by {np.degrees(np.arccos(min(axis, 1.0))):.2g}°")
    return wrong


def drawn(rng: np.random.Generator) -> Design:
    """Return a preset, some of its sizes changed."""
    design = preset(str(rng.choice([name for name in PRESETS if name != "v12-60"])))
    fillet = design.fillet_mm * float(rng.choice([0.0, 0.5, 1.0]))
    return replace(design, fillet_mm=fillet, stroke_mm=design.stroke_mm * float(rng.uniform(0.95, 1.0)))


def verdict(number: int) -> tuple[str, str]:
    """Return what was tried, and what came of it."""
    rng = np.random.default_rng(number)
    way = WAYS[number % len(WAYS)]
    overrides = Overrides(crankpin_in_file=None)
    if way == "no crank":
        name = sorted(NO_CRANKS)[number // len(WAYS) % len(NO_CRANKS)]
        try:
            recognise(NO_CRANKS[name], overrides)
        except AutobalanceError:
            return f"{way}, {name}", "refused"
        return f"{way}, {name}", "WRONG: recognised"
    try:
        design = drawn(rng)
        solid = crank_solid(design, int(rng.choice([24, 37, 64, 96])))
        true = crank_anatomy(design)
        moved = 0.0
        if way == "half":
            solid = half(solid, rng)
        else:
            mesh, moved = changed(way, solid.mesh, rng)
            solid = Solid.from_mesh(mesh_of_soup(mesh.corners.astype(np.float32)))
        found = recognise(solid, overrides)
    except AutobalanceError as error:
        return f"{way}, {str(error)[:60]}", "refused"
    wrong = faults(found, true, SAME_MM + 3.0 * moved, way != "half")
    what = f"{way}, {design.name}, moved by {moved:.2g} mm"
    return what, "right" if not wrong else "WRONG: " + "; ".join(wrong[:3])


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=600.0)
    arguments = parser.parse_args()
    began, ends = time.perf_counter(), Counter[tuple[str, str]]()
    for number in range(arguments.first, arguments.first + arguments.cases):
        if time.perf_counter() - began > arguments.seconds:
            break
        what, end = verdict(number)
        ends[WAYS[number % len(WAYS)], end.split(":")[0]] += 1
        if end.startswith("WRONG"):
            print(f"{number}  {what}: {end}", flush=True)
    for (way, end), count in sorted(ends.items()):
        print(f"{way}: {count} {end}")
    wrong = sum(count for (_, end), count in ends.items() if end == "WRONG")
    print(f"{ends.total()} tried, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
