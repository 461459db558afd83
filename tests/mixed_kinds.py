"""Random jobs that mix kinds of correction on generated cranks, and how near their cuts come."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

import autobalance as ab
from autobalance.correction import Limits
from autobalance.drawn_cranks.design import PRESETS
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from tests.generated import generated_crank
from tests.jobs import write_stl

LAYOUTS = ("single", "pressed-up-single", "v-twin-45", "parallel-twin-360", "inline-3", "v6-60")
METHODS = ("mill", "drill", "slug", "shoulder")
STEEL = 7.85e-3
ROD_G = 100.0
FACETS_MM = 0.02
"""By how much chords, and files of single precision, may let two bodies come nearer than planned."""


def mixed_job(folder: Path, seed: int) -> Path:
    """Write a crank anywhere in space and a job for it: walls, spacing, sizes and unbalance at random."""
    rng = np.random.default_rng(seed)
    design = PRESETS[LAYOUTS[seed % len(LAYOUTS)]]
    crank = generated_crank(design, seed=seed, segments=int(rng.choice([32, 48, 64])))
    folder.mkdir(parents=True, exist_ok=True)
    write_stl(folder / "crank.stl", crank.mesh.corners)
    anatomy = crank.truth
    heavy = [-throw.direction for throw in (anatomy.throws[0], anatomy.throws[-1])]
    size = float(rng.uniform(0.5, 2.0)) * design.crank_radius_mm * 12.0
    ends = (
        0.5 * (anatomy.webs[0].z_min_mm + anatomy.webs[0].z_max_mm),
        0.5 * (anatomy.webs[-1].z_min_mm + anatomy.webs[-1].z_max_mm),
    )
    wanted = [size * turned(vector, float(rng.uniform(-0.6, 0.6))) for vector in heavy]
    rods = [Moments.point(ROD_G, throw.crankpin.centre_mm) for throw in anatomy.throws]
    bare = crank.solid.moments(STEEL, anatomy.file_to_rotor)
    now = Unbalance.of(sum(rods, bare)).in_planes(*ends)
    attached = "".join(
        f'[[engine.attached]]\nname = "{name}"\nmass_g = 1.0\nz_mm = {z}\n'
        f"unbalance_g_mm = [{(want - here)[0]}, {(want - here)[1]}]\n"
        for name, z, want, here in zip("ab", ends, wanted, now, strict=True)
    )
    wall, spacing = rng.uniform(1.5, 4.0, 4).round(1), float(rng.uniform(1.0, 5.0))
    pressed_up = "crankpin_in_file = false\n" if not design.crankpin_in_file else ""
    path = folder / "job.toml"
    path.write_text(
        f'[crankshaft]\nfile = "crank.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0\n{pressed_up}'
        f"[engine.rotating_g]\nrod = {ROD_G}\n[engine.reciprocating_g]\npiston = {ROD_G}\n{attached}"
        "[balance]\nfactor = 0.0\ngrade = 16.0\nspeed_rpm = 6000.0\n"
        f"[correction]\nmethod = {list(METHODS)}\nmin_wall_mm = {wall[0]}\n"
        f"[correction.mill]\ncutter_mm = {float(rng.choice([6.0, 8.0, 10.0]))}\nmin_wall_mm = {wall[1]}\n"
        f"[correction.drill]\ndiameters_mm = [{float(rng.uniform(6.0, 10.0)):.1f}]\nmin_wall_mm = {wall[2]}\n"
        f"min_spacing_mm = {spacing:.2f}\nmax_holes = 1\nmax_depth_mm = {float(rng.uniform(6.0, 16.0)):.1f}\n"
        f"[correction.slug]\ndiameters_mm = [8.0, 10.0]\nlengths_mm = [5.0, 8.0]\n"
        f"min_wall_mm = {min(wall[3], 2.5)}\n",
        encoding="utf-8",
    )
    return path


def turned(vector: Any, angle: float) -> Any:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]]) @ vector


def faults(result: ab.BalanceResult) -> list[str]:
    """Return the pairs of cuts whose metal, on the tools' bodies, is nearer than walls and spacing allow."""
    balanced = result.record.balanced
    assert balanced is not None
    limits = dict(zip(result.job.method_names, result.job.methods, strict=True))
    made = balanced.result.corrections
    metal = [tool & result.before.measured.source.solid for tool in balanced.result.tools]
    found = []
    for (i, one), (j, two) in combinations(enumerate(made), 2):
        least = apart_mm(limits, one.kind, two.kind)
        gap = metal[i].gap_mm(metal[j], least + 1.0)
        if gap < least - FACETS_MM:
            found.append(f"{one.kind} {i} and {two.kind} {j}: {gap:.3f} of {least:.3f} mm")
    return found


def apart_mm(limits: dict[str, Limits], one: str, two: str) -> float:
    """Return the metal that must stay between two cuts; lowered faces of one crank may meet."""
    asked: list[Any] = [limits[one], limits[two]]
    if one == two:
        if one == "shoulder":
            return 0.0
        return float(asked[0].min_spacing_mm if one == "drill" else asked[0].min_wall_mm)
    return float(max(each.min_wall_mm for each in asked))
