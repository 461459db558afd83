"""Drawn cranks that are waved, decimated, bent or cut in half, and parts that are none: right or refused.

    python benchmarks/damaged_cranks.py [--cases 100] [--first 0] [--seconds 600] [--unchecked]

What is waved, decimated or bent a little is right where counts, diameters, radii, webs' faces and the axis
at both ends are the drawn crank's within what was done to it (so is the unbalance, wrong by mass times the
axis' offset); of a bent one only where a warning says so. Half a crank is right where all that is
recognised is part of the whole; cut along its axis it must be refused, as must a part that is no crank.

``--unchecked`` leaves out what refuses a crank that is not explained, and prints of what is recognised then
the greatest length along the axis between two neighbours that is neither of a cylinder nor of a web (in
greatest radii), and the least and the greatest share of its own volume that a cylinder's stretch of the axis
holds: what length and mass alone would tell right from wrong by.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import autobalance.crank.recognition.recognise as recognition
from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.alignment import misalignment_warning
from autobalance.drawn_cranks.design import PRESETS, Design, preset
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import AutobalanceError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from tests.generated import random_placement
from tests.geometry.test_recognise_refused import NO_CRANKS
from tests.scans import decimated

WAYS = (
    "waved",
    "decimated",
    "waved and decimated",
    "bent",
    "bent and waved",
    "half",
    "half lengthwise",
    "no crank",
)
SAME_MM, FACE_MM = 0.1, 0.3
"""Faces may be off by a fillet more: decimation makes chamfers of fillets."""


def disc(radius: float, low: float, high: float, x: float = 0.0, y: float = 0.0) -> Solid:
    return Solid.prism(Region.circle(radius, 48, (x, y)), low, high)


def across(radius: float, x: float, y: float, z: float) -> Solid:
    """Return a round bar along y through a point, as long as anything."""
    turn = np.eye(4)
    turn[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    turn[:3, 3] = (x, y, z)
    return disc(radius, -200.0, 200.0).moved(turn)


def propeller_shaft(rng: np.random.Generator) -> Solid:
    """Return a tube with a yoke of two bored ears at each end."""
    long, radius = float(rng.uniform(200.0, 500.0)), float(rng.uniform(20.0, 40.0))
    ear = 0.4 * radius
    parts = [disc(radius, 0.0, long), disc(1.3 * radius, 0.0, 12.0), disc(1.3 * radius, long - 12.0, long)]
    for low in (-1.6 * radius, long - 1.0):
        high = low + 1.6 * radius + 1.0
        parts += [
            Solid.box(np.array([side - 0.5 * ear, -ear, low]), np.array([side + 0.5 * ear, ear, high]))
            for side in (-radius, radius)
        ]
    body = union(parts) - disc(0.8 * radius, 20.0, long - 20.0)
    turn = np.eye(4)
    turn[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    for z in (-0.9 * radius, long + 0.9 * radius):
        body = body - across(0.5 * ear, 0.0, 0.0, z).moved(turn)
    return body


def bracket(rng: np.random.Generator) -> Solid:
    """Return an angle with three holes."""
    width, tall = float(rng.uniform(40.0, 90.0)), float(rng.uniform(40.0, 120.0))
    body = Solid.box(np.zeros(3), np.array([width, tall, 8.0]))
    body = body + Solid.box(np.zeros(3), np.array([width, 8.0, 50.0]))
    size = float(rng.uniform(4.0, 9.0))
    for x, y in rng.uniform([0.25 * width, 15.0], [0.75 * width, tall - 10.0], (2, 2)):
        body = body - disc(size, -1.0, 9.0, float(x), float(y))
    return body - across(size, 0.5 * width, 0.0, 30.0)


def cams(rng: np.random.Generator) -> Solid:
    """Return a camshaft of random lobes, bearings between some of them."""
    radius, count = float(rng.uniform(10.0, 18.0)), int(rng.integers(4, 13))
    parts = [disc(radius, 0.0, 30.0 * count + 20.0)]
    for number in range(count):
        low, angle = 20.0 + 30.0 * number, float(rng.uniform(0.0, 2.0 * np.pi))
        lift, nose = float(rng.uniform(5.0, 12.0)), float(rng.uniform(5.0, 9.0))
        away = 1.4 * radius + lift - nose
        for share in np.linspace(0.0, 1.0, 6):  # from the base circle to the nose
            size, x = 1.4 * radius + share * (nose - 1.4 * radius), share * away
            parts.append(disc(size, low, low + 14.0, x * np.cos(angle), x * np.sin(angle)))
        if rng.random() < 0.5:
            parts.append(disc(2.0 * radius, low + 16.0, low + 28.0))
    return union(parts)


def stepped_shaft(rng: np.random.Generator) -> Solid:
    """Return a gearbox' shaft: steps, a keyway, a flange with holes."""
    z, parts = 0.0, []
    for _ in range(int(rng.integers(3, 8))):
        wide = float(rng.uniform(10.0, 60.0))
        parts.append(disc(float(rng.uniform(8.0, 40.0)), z - 0.5, z + wide))
        z += wide
    body = union([*parts, disc(50.0, z - 0.5, z + 10.0)])
    for angle in np.arange(4) * 0.5 * np.pi:
        body = body - disc(4.0, z - 1.0, z + 11.0, 45.0 * np.cos(angle), 45.0 * np.sin(angle))
    return body - Solid.box(np.array([5.0, -3.0, -1.0]), np.array([50.0, 3.0, 15.0]))


def plate_with_pins(rng: np.random.Generator) -> Solid:
    """Return a plate with pins on both sides, in no line."""
    body = Solid.box(np.array([-60.0, -60.0, 0.0]), np.array([60.0, 60.0, 12.0]))
    for x, y in rng.uniform(-50.0, 50.0, (int(rng.integers(3, 7)), 2)):
        long, side = float(rng.uniform(5.0, 40.0)), rng.random() < 0.5
        body = body + disc(
            float(rng.uniform(3.0, 9.0)), -long if side else 11.0, 1.0 if side else 12.0 + long, x, y
        )
    return body


RANDOM_PARTS = (propeller_shaft, bracket, cams, stepped_shaft, plate_with_pins)


def changed(way: str, mesh: Mesh, rng: np.random.Generator) -> tuple[Mesh, float]:
    """Return what becomes of a mesh, and by how much its surface moved."""
    moved = 0.0
    mesh = Mesh(np.array(mesh.vertices), np.array(mesh.triangles))  # not read-only
    if "waved" in way:
        moved = float(10.0 ** rng.uniform(-3.0, -1.0))
        mesh = Mesh(mesh.vertices + rng.normal(0.0, moved, mesh.vertices.shape), mesh.triangles)
    if "decimated" in way:
        mesh = decimated(mesh, max(200, int(len(mesh.triangles) * rng.uniform(0.3, 0.9))))
    if "bent" in way:
        moved = max(moved, float(10.0 ** rng.uniform(-3.0, 0.0)))
        z = mesh.vertices[:, 2]
        along = (z - z.min()) / np.ptp(z)
        shift = np.stack([4.0 * moved * along * (1.0 - along), 0.0 * z, 0.0 * z], axis=1)
        mesh = Mesh(mesh.vertices + shift, mesh.triangles)
    return mesh, moved


def half(solid: Solid, rng: np.random.Generator, lengthwise: bool) -> Solid:
    """Return what is left of a crank on one side of a plane across it, or along its axis."""
    low, high = solid.bounds
    if lengthwise:
        angle = float(rng.uniform(0.0, 2.0 * np.pi))
        turn = np.eye(4)
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        return solid & Solid.box(np.array([0.0, -1e4, -1e4]), np.full(3, 1e4)).moved(turn)
    z = float(rng.uniform(low[2] + 0.25 * (high[2] - low[2]), high[2] - 0.25 * (high[2] - low[2])))
    far = np.full(3, 1e4)
    return solid & Solid.box(np.array([-1e4, -1e4, z]), far)


def faults(found: Anatomy, true: Anatomy, within_mm: float, face_mm: float, whole: bool) -> list[str]:
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
    to_file = found.rotor_to_file
    faces = [z for web in found.webs for z in (web.z_min_mm, web.z_max_mm)]
    drawn_at = true.rotor_to_file[2, 3]
    wanted = [drawn_at + z for web in true.webs for z in (web.z_min_mm, web.z_max_mm)]
    for number, z in enumerate(faces):
        at = to_file[2, 3] + z * to_file[2, 2]
        if whole and abs(at - wanted[number]) > face_mm:
            wrong.append(f"a face of web {number // 2 + 1} is at {at:.4g} mm, not {wanted[number]:.4g}")
    if to_file[2, 2] < 0.99:
        return [*wrong, f"the axis leans by {np.degrees(np.arccos(np.clip(to_file[2, 2], -1, 1))):.2g}°"]
    for z in (min(faces), max(faces)):
        off = float(np.hypot(*(to_file[:2, 3] + z * to_file[:2, 2])))
        if off > within_mm:
            wrong.append(f"the axis is {off:.2g} mm off")
    return wrong


def agreement(solid: Solid, found: Anatomy) -> str:
    """Return how far length and mass of a crank agree with what was recognised of it, in words."""
    placed = solid.moved(found.file_to_rotor)
    cylinders = [*found.main_journals, *(throw.crankpin for throw in found.throws)]
    cylinders = [each for each in cylinders if each.width_mm > 0.0]
    stretches = sorted(each.z_range_mm for each in cylinders)
    stretches = sorted([*stretches, *((web.z_min_mm, web.z_max_mm) for web in found.webs)])
    gap, end = 0.0, stretches[0][1]
    for low, high in stretches[1:]:
        gap, end = max(gap, low - end), max(end, high)
    shares = []
    for each in cylinders:
        low, high = each.z_range_mm
        own = 0.25 * np.pi * each.diameter_mm**2 * each.width_mm
        shares.append(placed.above(low).below(high).volume_mm3 / own)
    radius = 0.5 * max(each.diameter_mm for each in cylinders)
    return f"gap {gap / radius:.3f}, volumes {min(shares):.3f} to {max(shares):.3f}"


@contextmanager
def unchecked() -> Iterator[None]:
    """Let through what does not explain the crank."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            recognition, "on_surface", lambda _mesh, _long, named, _rounding: [run for _, run in named]
        )
        for name in ("refuse_incomplete", "refuse_unexplained"):
            patch.setattr(recognition, name, lambda *_: None)
        yield


def drawn(rng: np.random.Generator) -> Design:
    """Return a preset, some of its sizes changed."""
    design = preset(str(rng.choice([name for name in PRESETS if name != "v12-60"])))
    fillet = design.fillet_mm * float(rng.choice([0.0, 0.5, 1.0]))
    return replace(design, fillet_mm=fillet, stroke_mm=design.stroke_mm * float(rng.uniform(0.95, 1.0)))


def verdict(number: int, measured: bool = False) -> tuple[str, str]:
    """Return what was tried, and what came of it; ``measured``: with how far length and mass agree."""
    rng = np.random.default_rng(number)
    way = WAYS[number % len(WAYS)]
    overrides = Overrides(crankpin_in_file=None)
    if way == "no crank":
        part = number // len(WAYS)
        if part % 2:
            name = RANDOM_PARTS[part // 2 % len(RANDOM_PARTS)].__name__
            solid = RANDOM_PARTS[part // 2 % len(RANDOM_PARTS)](rng)
        else:
            name = sorted(NO_CRANKS)[part // 2 % len(NO_CRANKS)]
            solid = NO_CRANKS[name]
        try:
            recognition.recognise(Solid.from_mesh(solid.mesh.moved(random_placement(rng))), overrides)
        except AutobalanceError:
            return f"{way}, {name}", "refused"
        return f"{way}, {name}", "WRONG: recognised"
    try:
        design = drawn(rng)
        solid = crank_solid(design, int(rng.choice([24, 37, 64, 96])))
        true = crank_anatomy(design)
        moved = 0.0
        if "half" in way:
            solid = half(solid, rng, "lengthwise" in way)
        else:
            mesh, moved = changed(way, solid.mesh, rng)
            solid = Solid.from_mesh(mesh_of_soup(mesh.corners.astype(np.float32)))
        found = recognition.recognise(solid, overrides)
    except AutobalanceError as error:
        return f"{way}, {str(error)[:60]}", "refused"
    if way == "half lengthwise":
        return f"{way}, {design.name}", "WRONG: recognised"
    two = len(true.main_journals) == 2  # a bow moves both alike: they are in line, beside the drawn axis
    named = "bent" not in way or two or misalignment_warning(found) is not None
    within = SAME_MM + 3.0 * moved * named
    wrong = faults(found, true, within, within + FACE_MM + design.fillet_mm, way != "half")
    what = f"{way}, {design.name}, moved by {moved:.2g} mm"
    what += f", {agreement(solid, found)}" if measured else ""
    return what, "right" if not wrong else "WRONG: " + "; ".join(wrong[:3])


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--unchecked", action="store_true")
    arguments = parser.parse_args()
    began, ends = time.perf_counter(), Counter[tuple[str, str]]()
    for number in range(arguments.first, arguments.first + arguments.cases):
        if time.perf_counter() - began > arguments.seconds:
            break
        with unchecked() if arguments.unchecked else nullcontext():
            what, end = verdict(number, arguments.unchecked)
        ends[WAYS[number % len(WAYS)], end.split(":")[0]] += 1
        if end.startswith("WRONG") or (arguments.unchecked and end == "right"):
            print(f"{number}  {what}: {end}", flush=True)
    for (way, end), count in sorted(ends.items()):
        print(f"{way}: {count} {end}")
    wrong = sum(count for (_, end), count in ends.items() if end == "WRONG")
    print(f"{ends.total()} tried, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
