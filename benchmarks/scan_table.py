"""Scans of all layouts and of real cranks: what is found, and what cuts leave: benchmarks.scan_table.

    python -m benchmarks.scan_table [--cranks NAME ...] [--sigmas 0.02 ...] [--kinds drill ...] [--corpus DIR]

A row for each crank and σ, as the documentation has it: the greatest errors of axis, diameters, crank radii
and webs' faces against the truth, the greatest of all in standard errors, processor seconds, then for each
kind of correction by how much the residual on the true crank is off, as a share of what is stated. An
attached unbalance makes every crank want a cut. Of a real crank the drawn mesh is the truth.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

import autobalance as ab
from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import PRESETS
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from benchmarks.scans import errors
from tests.scanned_meshes import scan_of_mesh
from tests.scans import Scan, Wear, scan, surface_of

DENSITY_G_MM3 = 7.85e-3
PISTON_G, BIG_END_G, FACTOR = 100.0, 60.0, 0.5
ATTACHED_MM = np.array([-0.15, 0.1])
"""Unbalance of what is attached, times the crank's mass: twice what G 40 permits."""
KEYS: dict[str, dict[str, object]] = {
    "drill": {"diameters_mm": [5.0, 6.0, 8.0, 10.0], "max_holes": 6},
    "shoulder": {},
    "mill": {},
}
FINER = dict.fromkeys(PRESETS, 0.8) | {"v8-flatplane": 0.85}
"""Edges of the true crank, as a share of its scan's; at 0.8 the mesher folds one of these."""
REAL: dict[str, tuple[str, str | None, float, float]] = {
    "vhacd": ("vhacd-crank.off", "mm", 100.0, 2.0),
    "kurbelwelle": ("gmsh-kurbelwelle.stl", "mm", 4.0, 1.6),
    "4a": ("gmsh-sample-crankshaft-4a.stp", None, 1.0, 2.4),
    "modelica": ("modelica-crank.stl", "m", 0.1, 2.2),
    "diefiler": ("diefiler-crankshaft.stl", "mm", 4.0, 1.6),
}
"""File, unit, factor that brings it to the size of an engine's, edges of its scan [mm]."""


def edge_mm(name: str) -> float:
    """Return the edges at which a layout is scanned: some 50 000 to 100 000 triangles."""
    return 2.2 if len(PRESETS[name].bays) <= 2 else 3.0


@lru_cache(maxsize=1)
def drawn(name: str, folder: Path) -> tuple[Mesh, Anatomy]:
    """Return a real crank as drawn, and what is recognised in it."""
    file, unit, factor, _ = REAL[name]
    mesh = read(folder / file, unit, None).solid.mesh
    mesh = Mesh(factor * mesh.vertices, mesh.triangles)
    return mesh, recognise(Solid.from_mesh(mesh), Overrides(crankpin_in_file=None))


def scanned(name: str, sigma: float, folder: Path | None) -> Scan:
    """Return a scan."""
    if name in PRESETS:
        return scan(name, sigma, edge_mm=edge_mm(name), seed=0)
    assert folder is not None
    mesh, truth = drawn(name, folder)
    return scan_of_mesh(mesh, truth, sigma, edge_mm=REAL[name][3], seed=1)


def true_crank(name: str, placement: Array, folder: Path | None) -> Solid:
    """Return the true crank where its scan lies, more finely meshed."""
    if name in PRESETS:
        vertices, triangles, _ = surface_of(PRESETS[name], FINER[name] * edge_mm(name), Wear(), 0)
        return Solid.from_mesh(Mesh(vertices, triangles)).moved(placement)
    assert folder is not None
    return Solid.from_mesh(drawn(name, folder)[0]).moved(placement)


def found_in(crank: ab.Crank, there: Scan) -> str:
    """Return the columns of what was found."""
    found, true = crank.measured.anatomy, there.truth
    pairs = errors(found, there)
    if pairs is None:
        return "miscounted | | | |"
    origin = true.file_to_rotor @ found.rotor_to_file[:, 3]
    lean = np.cross(found.rotor_to_file[:3, 2], true.rotor_to_file[:3, 2])
    sizes = [abs(error) for error, _ in pairs]
    pins = 3 * (len(true.main_journals) + len(true.throws))
    throws = pins + len(true.throws)
    sure = max(abs(error) / max(pm, 1e-3) for error, pm in pairs)
    return (
        f"{np.hypot(*origin[:2]):.4f} mm, {math.degrees(float(np.linalg.norm(lean))):.4f}° |"
        f" {max(sizes[:pins:3]):.3f} | {max(sizes[pins:throws]):.3f} | {max(sizes[throws:]):.3f} |"
        f" {sure:.1f} |"
    )


def left(crank: ab.Crank, there: Scan, true: Solid, kind: str) -> str:
    """Return how far the residual is off on the true crank, as a share of what is stated."""
    attached = np.round(ATTACHED_MM * crank.mass_g, 1)
    job = {
        "crankshaft": {"density_kg_m3": 1e6 * DENSITY_G_MM3, "scan_accuracy_mm": 0.03},
        "engine": {
            "rotating_g": {"big_end": BIG_END_G},
            "reciprocating_g": {"piston": PISTON_G},
            "attached": [{"name": "wheel", "z_mm": 0.0, "mass_g": 0.0, "unbalance_g_mm": attached.tolist()}],
        },
        "balance": {"factor": FACTOR, "grade": 40, "speed_rpm": 6000, "judge": "static"},
        "correction": {"method": kind, **({kind: KEYS[kind]} if KEYS[kind] else {})},
    }
    try:
        result = ab.balance(ab.Job.from_dict(job), crank=crank)
    except ab.AutobalanceError as error:
        return f"refused: {str(error)[:60]}"
    solid = true
    for tool in result.tools():
        solid = solid - Solid.from_mesh(Mesh(tool.vertices_mm, tool.triangles))
    turn = (there.truth.file_to_rotor @ np.linalg.inv(crank.file_to_rotor))[:2, :2]
    rest = solid.moments(DENSITY_G_MM3, there.truth.file_to_rotor).first_g_mm[:2] + turn @ attached
    for throw in there.truth.throws:
        rest = rest + (BIG_END_G + FACTOR * PISTON_G) * throw.crankpin.centre_mm[:2]
    residual = result.report["residual"]
    off = float(np.linalg.norm(rest - turn @ np.array(residual["unbalance_g_mm"])))
    cuts = len(result.report["corrections"])
    return f"{off / residual['uncertainty_g_mm']:.2f} ({cuts} cuts)"


def rows(
    names: list[str], sigmas: list[float], kinds: list[str], folder: Path | None, in_turn: bool
) -> Iterator[str]:
    """Yield the rows of the table; with ``in_turn`` one kind at each σ."""
    for name in names:
        for number, sigma in enumerate(sigmas):
            there = scanned(name, sigma, folder)
            begun = time.process_time()
            head = f"| {name} | {len(there.mesh.triangles)} | {sigma:g} mm |"
            try:
                crank = ab.crank_from_mesh(
                    there.mesh.vertices,
                    there.mesh.triangles,
                    1e6 * DENSITY_G_MM3,
                    crankpin_in_file=None,
                    body="all",  # of a crank without its pin there are two
                    fill_holes_mm=0.0 if name in PRESETS else 10.0,  # where layers of 4a do not close
                )
            except ab.AutobalanceError as error:
                yield f"{head} refused: {error}, {time.process_time() - begun:.0f} s"
                continue
            took = time.process_time() - begun
            line = f"{head} {found_in(crank, there)} {took:.0f} s |"
            tried = [kinds[number % len(kinds)]] if in_turn and kinds else kinds
            for kind in tried:
                line += f" {kind} {left(crank, there, true_crank(name, there.placement, folder), kind)} |"
            yield line


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cranks", nargs="*", default=list(PRESETS))
    parser.add_argument("--sigmas", nargs="*", type=float, default=[0.005, 0.02, 0.05])
    parser.add_argument("--kinds", nargs="*", default=list(KEYS))
    parser.add_argument("--in-turn", action="store_true", help="one kind at each sigma, not all")
    parser.add_argument("--corpus", type=Path, help="a folder of crank files: its cranks are scanned too")
    asked = parser.parse_args()
    names = [name for name in asked.cranks if name in PRESETS]
    names += [name for name in REAL if asked.corpus and (name in asked.cranks or not asked.cranks)]
    for row in rows(names, asked.sigmas, asked.kinds, asked.corpus, asked.in_turn):
        print(row, flush=True)


if __name__ == "__main__":
    main()
