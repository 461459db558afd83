"""Balanced cranks and machine files for tests of NC programs."""

from __future__ import annotations

import copy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import autobalance as ab
from autobalance.api.nc import verified_part
from autobalance.machining.part import Part
from tests import nc_sweep

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


def balanced(folder: Path, name: str, segments: int = 48) -> Path:
    """Balance a generated crank by one kind of cut; return its report."""
    correction, factor, grade = CORRECTIONS[name]
    folder.mkdir(parents=True, exist_ok=True)
    crank = ab.generate("single", file="crank.stl", settings={"segments": segments})
    (folder / "crank.stl").write_bytes(crank.data)
    job = folder / "job.toml"
    if "OUTER" in correction:
        correction = correction.replace("OUTER", str(outer_faces(folder / "crank.stl")))
    job.write_text(JOB.format(correction=correction, factor=factor, grade=grade), encoding="utf-8")
    result = ab.balance(ab.read_job(job))
    assert result.corrections, result.reason
    result.write(folder / "out", only=("json",))
    return folder / "out" / "report.json"


@cache
def part_of(report: Path) -> Part:
    """Return what a report's programs cut, verified once."""
    return verified_part(report)


def swept_residual(
    report: Values, part: Part, programs: dict[str, str], nc: Values, rapids: bool = True
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


def changed(values: Values, *path: Any, to: Any) -> Values:
    """Return a structure with one value changed."""
    found = copy.deepcopy(values)
    inner: Any = found
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = to
    return found
