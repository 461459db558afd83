"""Balanced cranks and machine files for tests of NC programs."""

from __future__ import annotations

import copy
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.drawn_cranks.design import PRESETS
from autobalance.machining import verb
from autobalance.machining.area_moves import MachinedCrank
from autobalance.machining.verb import NcResult, verified_part
from autobalance.rigid_rotor.unbalance import Unbalance
from tests import nc_sweep
from tests.generated import generated_crank
from tests.jobs import without_advice, write_stl

Values = dict[str, Any]
JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.rotating_g]
big_end = 300.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = {factor}
grade = {grade}
speed_rpm = 6000
[correction]
{correction}
"""
CORRECTIONS = {
    "radial": ('method = "drill"\ndrill = { diameters_mm = [10.0] }', 0.12, 6.3),
    "axial": ('method = "drill"\ndrill = { direction = "axial", diameters_mm = [10.0] }', 0.12, 6.3),
    "slug": ('method = "slug"\nslug = { diameters_mm = [12.0], lengths_mm = [8.0, 12.0] }', 0.3, 40.0),
    "mill": ('method = "mill"', 0.12, 40.0),
    "shoulder": ('method = "shoulder"\nfaces = OUTER', 0.12, 40.0),
    "turn": ('method = "turn"', 0.12, 40.0),
}
STEEL = 7.85e-3
HOLDER = [[32.0, 60.0], [63.0, 100.0]]


def tool(number: int, kind: str, **keys: Any) -> Values:
    """Return a tool of a machine file."""
    usual: Values = {"number": number, "kind": kind, "flute_mm": 40.0, "stick_out_mm": 95.0, "holder": HOLDER}
    return {**usual, "rpm": 900, "feed_mm_min": 120.0, **keys}


def machine(post: str = "linuxcnc", lathe: bool = False, **keys: Any) -> Values:
    """Return the structure of a machine file."""
    tools = [
        tool(1, "drill", diameter_mm=10.0, peck_mm=4.0),
        tool(2, "drill", diameter_mm=12.0, point_deg=180.0),
        tool(3, "end_mill", diameter_mm=10.0, step_down_mm=2.0, step_over_mm=4.0),
    ]
    if lathe:
        tools.append(tool(4, "turning", flute_mm=15.0))
    return {
        "machine": {"post": post, "max_rpm": 8000},
        "rotary": {"letter": "A"},
        "zero": {"angle": "crankpin 1", "z_mm": "crankpin 1"},
        "tool": tools,
        **keys,
    }


def outer_faces(crank: Path) -> list[str]:
    """Return the largest face of each outermost web that looks away from the crank."""
    found = ab.read_crank(crank, unit="mm", density_kg_m3=7850.0)
    webs = found.webs
    wanted: dict[int | None, float] = {webs[0].number: -1.0, webs[-1].number: 1.0}
    faces = [face for face in found.faces if wanted.get(face.web, 0.0) * face.normal[2] > 0.9]
    largest = {face.web: face for face in sorted(faces, key=lambda each: each.area_mm2)}
    return [largest[web].id for web in wanted]


def balanced(folder: Path, name: str, segments: int = 48, change: tuple[str, str] = ("", "")) -> Path:
    """Balance a generated crank by one kind of cut, words of which may be changed; return its report.

    What was balanced before is copied.
    """
    shutil.copytree(_balanced(name, segments, change), folder, dirs_exist_ok=True)
    return folder / "out" / "report.json"


_FOLDER = tempfile.TemporaryDirectory(prefix="autobalance-nc-")
"""Of what was balanced; goes with this process."""


@cache
def _balanced(name: str, segments: int, change: tuple[str, str]) -> Path:
    folder = Path(tempfile.mkdtemp(dir=_FOLDER.name))
    correction, factor, grade = CORRECTIONS[name]
    correction = correction.replace(*change)
    write_stl(folder / "crank.stl", generated_crank("single", segments=segments).soup)
    job = folder / "job.toml"
    if "OUTER" in correction:
        correction = correction.replace("OUTER", str(outer_faces(folder / "crank.stl")))
    job.write_text(JOB.format(correction=correction, factor=factor, grade=grade), encoding="utf-8")
    with without_advice():
        result = ab.balance(ab.read_job(job))
    assert result.corrections, result.reason
    result.write(folder / "out", only=("json",))
    return folder


ATTACHED_G = 1.0
SIZES = {"mill": 25.0, "shoulder": 25.0, "turn": 25.0}
"""Unbalance of a random job in crank radii; other kinds 12."""


def random_job(folder: Path, kind: str, layout: str, seed: int) -> Path | None:
    """Balance a crank somewhere, heavy at both ends, by one kind of cut; None where that cuts nothing."""
    rng = np.random.default_rng(seed)
    correction, _, grade = CORRECTIONS[kind]
    folder.mkdir(parents=True)
    crank = generated_crank(PRESETS[layout], seed=seed, segments=int(rng.choice([32, 48, 64])))
    write_stl(folder / "crank.stl", crank.mesh.corners)
    anatomy, frame = crank.truth, crank.truth.file_to_rotor
    ends = tuple(0.5 * (web.z_min_mm + web.z_max_mm) for web in (anatomy.webs[0], anatomy.webs[-1]))
    size = float(rng.uniform(0.6, 1.2)) * crank.design.crank_radius_mm * SIZES.get(kind, 12.0)
    now = Unbalance.of(crank.solid.moments(STEEL, frame)).in_planes(*ends)
    attached: list[str] = []
    for throw, z, here in zip((anatomy.throws[0], anatomy.throws[-1]), ends, now, strict=True):
        heavy, lean = np.asarray(throw.direction), float(rng.uniform(-0.4, 0.4))
        away = heavy if kind == "slug" else -heavy  # slugs weigh more than the metal that they replace
        c, s = np.cos(lean), np.sin(lean)
        x, y = size * np.array([[c, -s], [s, c]]) @ away - here
        attached.append(
            f'[[engine.attached]]\nname = "end {len(attached)}"\nmass_g = {ATTACHED_G}\nz_mm = {z}\n'
            f"unbalance_g_mm = [{x}, {y}]\n"
        )
    (folder / "job.toml").write_text(
        '[crankshaft]\nfile = "crank.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0\n'
        + "".join(attached)
        + f"[balance]\nfactor = 0.0\ngrade = {grade}\nspeed_rpm = 6000\n[correction]\n"
        + correction.replace("faces = OUTER", 'faces = "auto"'),
        encoding="utf-8",
    )
    with without_advice():
        result = ab.balance(ab.read_job(folder / "job.toml"))
    if not result.corrections:
        return None
    result.write(folder / "out", only=("json",))
    return folder / "out" / "report.json"


@cache
def part_of(report: Path) -> MachinedCrank:
    """Return what a report's programs cut, verified once."""
    return verified_part(report)


def programmed(report: Path, machine: Values) -> NcResult:
    """Return the NC programs of a report that is verified once, for them and for `part_of`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verb, "verified_part", part_of)
        return verb.nc(report, machine)


def swept_residual(
    report: Values, part: MachinedCrank, programs: dict[str, str], nc: Values, rapids: bool = True
) -> tuple[np.ndarray, list[nc_sweep.Swept]]:
    """Return the residual in both planes that another sweep of programs leaves, and all that it saw."""
    whole = nc_sweep.manifold(part.before.mesh.vertices, part.before.mesh.triangles)
    after = nc_sweep.manifold(part.after.mesh.vertices, part.after.mesh.triangles)
    now, seen = whole, []
    for setup in nc["setups"]:
        found = nc_sweep.sweep(
            now, programs[setup["file"]], setup["name"], nc, nc["machine"]["zero"]["clearance_mm"], rapids
        )
        now = found.solid
        seen.append(found)
    (_, now_first, now_second), (_, first, second) = nc_sweep.moments(now), nc_sweep.moments(after)
    first, second = now_first - first, now_second - second
    planes = report["residual"]["planes"]
    places = [plane["z_mm"] for plane in report["tolerance"]["planes"]]
    was = np.array([plane["unbalance_g_mm"] for plane in planes])
    span = places[1] - places[0]
    density = part.density_g_mm3
    in_a = density * (places[1] * first - second) / span
    return was + np.stack([in_a, density * first - in_a]), seen


def gouged_mm(part: MachinedCrank, seen: list[nc_sweep.Swept]) -> float:
    """Return how thick the metal is that a sweep took beyond the report's solid."""
    after = nc_sweep.manifold(part.after.mesh.vertices, part.after.mesh.triangles)
    return nc_sweep.thickest_mm(after - seen[-1].solid) if seen else 0.0


def changed(values: Values, *path: Any, to: Any) -> Values:
    """Return a structure with one value changed."""
    found = copy.deepcopy(values)
    inner: Any = found
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = to
    return found
