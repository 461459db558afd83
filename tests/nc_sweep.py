"""NC programs swept a second way: an own reader of the text, hulls of the whole tool, manifold3d by itself.

Nothing here knows the program's interpreter, simulator or planner.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import manifold3d as m3
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SIDES = 72
EQUAL = math.sqrt((2.0 * math.pi / SIDES) / math.sin(2.0 * math.pi / SIDES))
RS274 = shutil.which("rs274")
STEP = re.compile(r"([XYZABCRQFTGMSH])(-?\d+(?:\.\d+)?)")


@dataclass
class Swept:
    """What is left of a crank after a program, and how near rapids came to it."""

    solid: m3.Manifold
    least_gap_mm: float = math.inf
    hits: list[str] = field(default_factory=list)


def manifold(vertices: Array, triangles: NDArray[np.int64]) -> m3.Manifold:
    """Return a body of manifold3d."""
    corners = np.require(np.array(vertices, dtype=np.float64), requirements=["C", "W"])
    return m3.Manifold(m3.Mesh64(corners, np.array(triangles, dtype=np.uint64)))


def moments(body: m3.Manifold) -> tuple[float, Array, Array]:
    """Return volume, ∫ (x, y) dV and ∫ z (x, y) dV, by tetrahedra from the origin."""
    raw = body.to_mesh64()
    a, b, c = np.asarray(raw.vert_properties)[:, :3][np.asarray(raw.tri_verts).astype(int)].transpose(1, 0, 2)
    volume = (a * np.cross(b, c)).sum(1) / 6.0
    total = a + b + c
    first = (volume[:, None] * total).sum(0) / 4.0
    second = sum(np.einsum("k,ki,kj->ij", volume, p, p) for p in (a, b, c, total)) / 20.0
    return float(volume.sum()), first[:2], np.asarray(second)[:2, 2]


def thickest_mm(body: m3.Manifold) -> float:
    """Return how thick the thickest piece of a body is, as a plate of its volume and surface."""
    pieces = [each for each in body.decompose() if each.volume() > 1e-6]
    return max((2.0 * each.volume() / each.surface_area() for each in pieces), default=0.0)


def cylinder(radius: float, low: float, high: float, scale: float) -> m3.Manifold:
    """Return a round bar along z."""
    return m3.Manifold.cylinder(high - low, radius * scale, radius * scale, SIDES).translate((0.0, 0.0, low))


def cutter(tool: Mapping[str, Any]) -> m3.Manifold:
    """Return the flutes of a tool, its tip at the origin, of the volume that a round one has."""
    radius, flute = 0.5 * tool["diameter_mm"], tool["flute_mm"]
    if tool["kind"] != "drill" or tool["point_deg"] == 180.0:
        return cylinder(radius, 0.0, flute, EQUAL)
    point = radius / math.tan(math.radians(0.5 * tool["point_deg"]))
    cone = m3.Manifold.cylinder(point, 1e-6, radius * EQUAL, SIDES)
    return cone + cylinder(radius, point, point + flute, EQUAL)


def body(tool: Mapping[str, Any]) -> list[m3.Manifold]:
    """Return the convex parts of tool and holder, the tip first."""
    found = [
        m3.Manifold.batch_hull([cutter(tool)]),
        cylinder(0.5 * tool["diameter_mm"], 1.0, tool["stick_out_mm"], 1.0),
    ]
    at = tool["stick_out_mm"]
    for diameter, length in tool["holder"]:
        found.append(cylinder(0.5 * diameter, at, at + length, 1.0))
        at += length
    return found


def pose(name: str, zero: Mapping[str, Any], sign: int, turned: float) -> Array:
    """Return the matrix (3, 4) from a set-up's coordinates to the rotor frame, as the contract says them."""
    theta = math.radians(zero["angle_deg"] + (sign * turned if name == "R" else 0.0))
    c, s = math.cos(theta), math.sin(theta)
    rows = {
        "R": [[0.0, s, c, 0.0], [0.0, -c, s, 0.0], [1.0, 0.0, 0.0, zero["z_mm"]]],
        "T": [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, zero["z_mm"]]],
        "B": [[c, s, 0.0, 0.0], [s, -c, 0.0, 0.0], [0.0, 0.0, -1.0, zero["z_mm"]]],
    }
    return np.array(rows[name])


def read(text: str, letter: str) -> Iterator[tuple[str, int, Array, Array, bool]]:
    """Yield moves of a program: rapid or feed, tool, both ends (x, y, z, a), whether in a hole."""
    at = np.array([np.nan, np.nan, np.nan, 0.0])
    tool, motion = 0, 0
    for line in text.splitlines():
        code = re.sub(r"\([^)]*\)", "", line).strip()
        if not code or code[0] in "%O":
            continue
        words: dict[str, float] = {}
        for key, value in STEP.findall(code):
            number = float(value)
            if key == "T":
                tool = int(number)
            elif key == "M" and number == 6.0:
                at[:3] = np.nan
            elif key == "G" and number in (0.0, 1.0, 81.0, 83.0):
                motion = int(number)
            elif key == "G" and number == 80.0:
                motion = 0
            elif key in "XYZRQ" or key == letter:
                words["A" if key == letter else key] = number
        if not words:
            continue
        end = at.copy()
        for place, key in enumerate("XYZA"):
            if key in words and not (motion in (81, 83) and key == "Z"):
                end[place] = words[key]
        yield ("rapid" if motion != 1 else "feed"), tool, at.copy(), end.copy(), False
        at = end
        if motion in (81, 83):
            top, bottom, high = words["R"], words["Z"], at[2]
            mouth, deep = at.copy(), at.copy()
            mouth[2], deep[2] = top, bottom
            yield "rapid", tool, at.copy(), mouth.copy(), False
            yield "feed", tool, mouth.copy(), deep.copy(), False
            yield "rapid", tool, deep.copy(), mouth.copy(), True
            at[2] = high
            yield "rapid", tool, mouth.copy(), at.copy(), False


def sweep(
    start: m3.Manifold,
    text: str,
    name: str,
    report: Mapping[str, Any],
    clearance_mm: float,
    rapids: bool = True,
) -> Swept:
    """Sweep a program through a crank (rotor frame)."""
    machine = report["machine"]
    rotary = machine["rotary"] or {"letter": "A", "sign": 1}
    zero = next(each["zero"] for each in report["setups"] if each["name"] == name)
    tools = {tool["number"]: tool for tool in machine["tool"]}
    found = Swept(start)
    feeds: list[m3.Manifold] = []
    level: dict[tuple[int, float, float], list[m3.CrossSection]] = {}

    def flush() -> None:
        """Take off what was fed through; moves at one height are joined in their plane, which is quick."""
        for (number, z, angle), areas in level.items():
            layer = m3.CrossSection.batch_boolean(areas, m3.OpType.Add).extrude(tools[number]["flute_mm"])
            feeds.append(layer.translate((0.0, 0.0, z)).transform(pose(name, zero, rotary["sign"], angle)))
        if feeds:
            found.solid = found.solid - m3.Manifold.batch_boolean(feeds, m3.OpType.Add)
        feeds.clear()
        level.clear()

    for kind, number, begin, end, in_hole in read(text, rotary["letter"]):
        tool = tools[number]
        if name == "L":
            if kind == "feed":
                feeds.append(turned(tool, begin, end, zero["z_mm"]))
            continue
        if begin[3] != end[3]:
            if kind == "feed":
                z, radius = begin[0] + zero["z_mm"], 0.5 * tool["diameter_mm"]
                feeds.append(ring(begin[2], begin[2] + tool["flute_mm"], z - radius, z + radius))
            continue
        place = pose(name, zero, rotary["sign"], end[3])
        if kind == "feed" and begin[2] == end[2] and tool["kind"] == "end_mill":
            disc = m3.CrossSection.circle(0.5 * tool["diameter_mm"] * EQUAL, SIDES)
            moved = [disc.translate(tuple(each[:2])) for each in (begin, end)]
            level.setdefault((number, end[2], end[3]), []).append(m3.CrossSection.batch_hull(moved))
            continue
        if kind == "feed":
            shape = cutter(tool)
            ends = [shape.translate(tuple(each[:3])) for each in (begin, end)]
            feeds.append(m3.Manifold.batch_hull(ends).transform(place))
            continue
        flush()
        if not rapids or np.isnan(begin).any() or np.isnan(end).any() or in_hole:
            continue
        for part in body(tool):
            ends = [part.translate(tuple(each[:3])) for each in (begin, end)]
            gap = m3.Manifold.batch_hull(ends).transform(place).min_gap(found.solid, 2.0 * clearance_mm)
            found.least_gap_mm = min(found.least_gap_mm, gap)
    flush()
    return found


def ring(inner: float, outer: float, low: float, high: float) -> m3.Manifold:
    """Return a ring about the crank axis."""
    sides = 720
    scale = math.sqrt((2.0 * math.pi / sides) / math.sin(2.0 * math.pi / sides))
    outline = np.array([[inner * scale, low], [outer, low], [outer, high], [inner * scale, high]])
    return m3.Manifold.revolve(m3.CrossSection([outline]), sides)


def turned(tool: Mapping[str, Any], begin: Array, end: Array, z: float) -> m3.Manifold:
    """Return what a turning tool takes on its way: all beyond its nose, as far as it cuts."""
    radius = 0.5 * min(begin[0], end[0])
    nose = tool["nose_radius_mm"]
    low, high = sorted((begin[2] + z, end[2] + z))
    return ring(radius, radius + tool["flute_mm"], low - nose, high + nose)


def accepted(path: Path) -> bool:
    """Tell whether LinuxCNC's own interpreter runs a program to its end without a complaint."""
    assert RS274 is not None
    command = [RS274, "-g", "-t", str(path.parent / "tools.tbl"), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, cwd=path.parent)
    lines = [
        line for line in done.stdout.splitlines() if "ON_RESET" not in line and line.strip() != "executing"
    ]
    return done.returncode == 0 and "PROGRAM_END" in lines[-1] and "rror" not in done.stderr + done.stdout
