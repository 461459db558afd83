"""Metal of the webs after the cuts, and corrections as measured tool by tool."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction.contract import Correction
from autobalance.correction.cut import Made, as_taken
from autobalance.correction.faces.patches import face_frame
from autobalance.correction.holes.surface import Fillet, fillet_of
from autobalance.correction.machining import listed_outline, loops_area_mm2, side_of
from autobalance.crank.anatomy import Anatomy, Pin, Web
from autobalance.declare import NotNegative, Ordinal
from autobalance.quantities import mm, said
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import Stretches, mesh_moments
from autobalance.solid.mesh.mesh import Mesh, least_and_greatest
from autobalance.solid.slicing.slices import cross_sections
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass
from autobalance.wording import listed_numbers

if TYPE_CHECKING:
    from autobalance.solid.cad.taken import EachTaken


# Thickness of the webs after cuts: metal behind crankpins, walls of holes, fillets beside them.


COLUMNS = 48
"""Columns of metal across the greater side of the sampled area, in each direction."""
OFF_GRID = 0.37
"""Place of a column in its cell, and of the section in a web: beside the edges that round numbers have."""
CIRCLES = 33
WITHIN_PINS = 0.9
"""Share of a pin's radius within which columns are: edges of the web are chamfered."""
BORED_SHARE = 0.5
"""Columns with less metal than this share of the web's thickness go through bores and drillings."""
THINNED_SHARE = 0.9
"""Share of its metal before the cuts below which a web is reported."""
NEAR_DIAMETERS = 0.25
"""Wall, or distance to a fillet, in diameters of the hole, below which it is reported."""
MOST_PAIRS = 2_000_000
ZERO_AREA = 1e-300
"""Area that stands for 0 where a point lies on a side, positive or negative."""


@dataclass(frozen=True)
class WebMetal:
    """Minimum metal along the axis between a web's crankpin and main journal, before and after the cuts."""

    web: Ordinal
    thinnest_before_mm: NotNegative
    thinnest_mm: NotNegative


def web_metal(before: Solid, after: Solid | None, anatomy: Anatomy) -> tuple[WebMetal, ...]:
    """Return the least metal of each web that carries a crankpin, on columns along the axis.

    Metal counts within the web's own thickness, in front of a hole and behind it together; columns through
    bores and oil drillings that were there are left out.
    """
    was = _Metal.of(before, anatomy)
    now = was if after is None else _Metal.of(after, anatomy)
    rows = []
    for web in anatomy.webs:
        columns = _columns(anatomy, web)
        if not len(columns):
            continue
        ends = web.z_min_mm, web.z_max_mm
        there = was.lengths_mm(columns, ends)
        solid = there >= BORED_SHARE * (ends[1] - ends[0])
        if solid.any():
            left = there if now is was else now.lengths_mm(columns, ends)
            rows.append(WebMetal(web.number, float(there[solid].min()), max(float(left[solid].min()), 0.0)))
    return tuple(rows)


def least_share(metal: Sequence[WebMetal]) -> float | None:
    """Return the least share of its metal that a web keeps; None if no web carries a crankpin."""
    return min((each.thinnest_mm / each.thinnest_before_mm for each in metal), default=None)


def weak_places(
    metal: Sequence[WebMetal], corrections: Sequence[Correction], anatomy: Anatomy, first: int = 1
) -> tuple[str, ...]:
    """Return the places that cuts weaken, a line each: webs, walls thin for their hole, holes near a fillet.

    Cuts with the same finding share a line.
    """
    lines: list[str] = [
        said(
            "web {}: {} of metal left between crankpin and main journal, {} before",
            each.web,
            mm(each.thinnest_mm, ".1f"),
            mm(each.thinnest_before_mm, ".1f"),
        )
        for each in metal
        if each.thinnest_mm < THINNED_SHARE * each.thinnest_before_mm
    ]
    weak: dict[str, list[int]] = {}
    for number, cut in enumerate(corrections, first):
        diameter = cut.details.get("diameter_mm")
        if diameter is None or cut.axis is None:
            continue
        name, distance = _nearest_fillet(cut, 0.5 * float(diameter), anatomy)
        wall = cut.details.get("wall_left_mm")
        near, thin = NEAR_DIAMETERS * diameter, wall is not None and float(wall) < NEAR_DIAMETERS * diameter
        if distance < near:
            says = said(
                "{} from the fillet of {}, {}", mm(distance, ".1f"), name, f"{distance / diameter:.2f}"
            )
        elif thin and wall is not None:
            says = said("a wall of {} beside it, {}", mm(wall, ".1f"), f"{wall / diameter:.2f}")
        else:
            continue
        found = said("{} of its diameter of {}", says, mm(diameter, "g"))
        weak.setdefault(found, []).append(number)
    for finding, numbers in weak.items():
        name = "cut" if len(numbers) == 1 else "each of cuts"
        lines.append(said("{} {}: {}", name, listed_numbers(numbers), finding))
    return tuple(lines)


def _nearest_fillet(cut: Correction, radius_mm: float, anatomy: Anatomy) -> tuple[str, float]:
    """Return the pin of the fillet nearest to a hole, and the distance [mm]; infinite without a fillet."""
    webs = [web for web in anatomy.webs if web.number == cut.web]
    named = [(f"main journal {each.number}", each) for each in anatomy.main_journals]
    pins: list[tuple[str, Pin]] = [*named, *((f"crankpin {t.number}", t.crankpin) for t in anatomy.throws)]
    every = [
        (name, _distance_mm(cut, radius_mm, fillet))
        for web in webs
        for name, pin in pins
        if (fillet := fillet_of(pin, web)) is not None
    ]
    return min(every, key=lambda each: each[1], default=("", math.inf))


def _distance_mm(cut: Correction, radius_mm: float, fillet: Fillet) -> float:
    """Return the distance from a hole's cylinder to the circles between which a fillet lies."""
    assert cut.axis is not None
    turn = np.linspace(0.0, math.tau, 721)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    points = []
    for length in (0.0, fillet.least_mm):
        flat = fillet.centre_mm[:2] + (fillet.radius_mm + length) * ring
        points.append(np.column_stack([flat, np.full(len(flat), fillet.z_mm + fillet.sense * length)]))
    off = np.concatenate(points) - cut.position_mm
    along = off @ cut.axis
    across = np.linalg.norm(off - along[:, None] * cut.axis, axis=1)
    beyond = np.maximum(np.maximum(-along, along - cut.depth_mm), 0.0)
    return float(np.hypot(np.maximum(across - radius_mm, 0.0), beyond).min())


def _columns(anatomy: Anatomy, web: Web) -> Array:
    """Return a grid of columns (n, 2) between a web's two pins; none without a crankpin or a second pin."""
    pins: list[Pin] = [throw.crankpin for throw in anatomy.throws_of(web)]
    pins += [journal for journal in anatomy.main_journals if fillet_of(journal, web) is not None]
    if len(pins) < 2 or not anatomy.throws_of(web):
        return np.zeros((0, 2))
    centres = np.array([pin.centre_mm[:2] for pin in pins[:2]])
    radii = np.array([WITHIN_PINS * 0.5 * pin.diameter_mm for pin in pins[:2]])
    low, high = (centres - radii[:, None]).min(axis=0), (centres + radii[:, None]).max(axis=0)
    step = float((high - low).max()) / COLUMNS
    x, y = (np.arange(low[k] + OFF_GRID * step, high[k], step) for k in range(2))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = np.zeros(len(grid), dtype=bool)
    for share in np.linspace(0.0, 1.0, CIRCLES):
        centre, radius = (1.0 - share) * centres[0] + share * centres[1], radii @ [1.0 - share, share]
        inside |= np.hypot(*(grid - centre).T) <= radius
    kept: Array = grid[inside]
    return kept


@dataclass(frozen=True, eq=False)
class _Metal:
    """A solid's mesh in the rotor frame, and the heights between which each triangle lies."""

    mesh: Mesh
    stretches: Stretches

    @classmethod
    def of(cls, solid: Solid, anatomy: Anatomy) -> _Metal:
        mesh = solid.mesh.moved(anatomy.file_to_rotor)
        return cls(mesh, Stretches.of(mesh.vertices[:, 2], mesh.triangles))

    def lengths_mm(self, columns: Array, ends_mm: tuple[float, float]) -> Array:
        """Return the length of metal in each column (n,) between two heights z₁ and z₂.

        A section between them shows the columns that are in the metal there. Above it up to z₂, and below it
        down to z₁, a column that leaves the metal subtracts the length beyond, and one that enters adds it.
        The sum is (z₂ − z₁) inside + Σ ± (z − z₂) above + Σ ± (z − z₁) below.
        """
        low, high = ends_mm
        amid = low + OFF_GRID * (high - low)
        between = self.mesh.triangles.take(self.stretches.within(low, high), axis=0)
        (outlines,) = cross_sections(self.mesh.vertices, between, np.array([amid]))
        lengths: Array = (high - low) * Region.of(outlines).contains(columns).astype(np.float64)
        axes = np.ascontiguousarray(self.mesh.vertices.T)
        for corners, points in _pairs(axes, between, columns):
            x, y = (axes[k].take(corners) - columns[:, k].take(points) for k in range(2))
            beside = [_left_of(x, y, k) for k in range(3)]
            a, b, c = (each > 0.0 for each in beside)
            hit = np.flatnonzero((a == b) & (b == c))
            beside = [each.take(hit) for each in beside]
            weights = np.abs(beside) / np.abs(beside).sum(axis=0)
            heights = axes[2].take(corners.take(hit, axis=1))
            z = np.clip((heights * weights).sum(axis=0), low, high)
            np.add.at(lengths, points.take(hit), np.sign(beside[0]) * (z - np.where(z > amid, high, low)))
        return lengths


def _left_of(x: Array, y: Array, corner: int) -> Array:
    """Return twice the areas (n,) of the origin with the side across from a corner of triangles (3, n) each.

    Positive: left of it. The two triangles at a side get the same number with opposite signs, to the last
    digit, and never 0: no column through their side meets both of them, or none.
    """
    one, two = (corner + 1) % 3, (corner + 2) % 3
    left: Array = x[one] * y[two] - y[one] * x[two]
    on_it = np.flatnonzero(left == 0.0)
    x_one, y_one, x_two, y_two = (of.take(on_it) for of in (x[one], y[one], x[two], y[two]))
    upward = (y_one < y_two) | ((y_one == y_two) & (x_one < x_two))
    left[on_it] = np.where(upward, ZERO_AREA, -ZERO_AREA)
    return left


def _pairs(axes: Array, triangles: Indices, columns: Array) -> Iterator[tuple[Indices, Indices]]:
    """Yield corners (3, k) of triangles, and the numbers (k,) of columns in their boxes, in batches.

    Columns (n, 2) are best places of a grid: those of one x are looked up together.
    """
    (x, of_x), (y, of_y) = (np.unique(columns[:, k], return_inverse=True) for k in range(2))
    (left, right), (lower, upper) = (
        _between(values, *least_and_greatest(axes[k], triangles)) for k, values in enumerate((x, y))
    )
    corners = np.ascontiguousarray(triangles.T)
    chosen = np.flatnonzero((right > left) & (upper > lower))
    left, right, lower, upper = (each.take(chosen) for each in (left, right, lower, upper))
    before = np.zeros((len(x), len(y) + 1), dtype=np.int64)  # columns of less x, or of that x and less y
    np.add.at(before, (of_x, of_y + 1), 1)
    ordered = np.lexsort((of_y, of_x))
    before = np.cumsum(before.reshape(-1)).reshape(before.shape)
    most = np.cumsum((right - left) * (upper - lower))
    begin = 0
    while begin < len(chosen):
        done = int(most[begin - 1]) if begin else 0
        end = max(int(np.searchsorted(most, done + MOST_PAIRS, side="right")), begin + 1)
        few = slice(begin, end)
        row, strip = _members(left[few], right[few] - left[few])
        row += begin
        start = before[strip, lower.take(row)]
        which, points = _members(start, before[strip, upper.take(row)] - start)
        yield corners.take(chosen.take(row.take(which)), axis=1), ordered.take(points)
        begin = end


def _between(places: Array, low: Array, high: Array) -> tuple[Indices, Indices]:
    """Return the indices, among rising places, at which intervals (m,) begin and end, ends included."""
    return np.searchsorted(places, low), np.searchsorted(places, high, side="right")


def _members(first: Indices, count: Indices) -> tuple[Indices, Indices]:
    """Return the interval's number and the value of each of so many whole numbers from each first one on."""
    number = np.repeat(np.arange(len(count)), count)
    return number, np.arange(len(number)) + (first - np.cumsum(count) + count).take(number)


# Corrections as they were measured tool by tool: on true surfaces, or on the metal of a scan.


def one_by_one(
    rotor: Rotor, cut_depths: Made, removed: Sequence[EachTaken], added: Sequence[EachTaken]
) -> tuple[Correction | None, ...]:
    """Return the corrections of cuts as measured, one a cut; None if no metal went or came.

    ``removed`` and ``added`` are the metal that the tools took and added, each in the order of the cuts.
    """
    takes, adds = iter(removed), iter(added)
    measured: list[Correction | None] = []
    for cut, depth in cut_depths:
        if cut.exact_tool(depth) is None:
            measured.append(None)
            continue
        took = next(adds if cut.adds_metal else takes)
        measured.append(_measured(rotor, cut.correction(depth), cut.pressed_in(depth), took, cut.adds_metal))
    return tuple(measured)


def _measured(rotor: Rotor, planned: Correction, pressed_in: Any, took: EachTaken, adds: bool) -> Correction:
    frame, sign = rotor.anatomy.file_to_rotor, 1.0 if adds else -1.0
    density = sign * rotor.density_g_mm3
    change = took.volume.moved(frame).scaled(density) + pressed_in
    rate = None
    details: dict[str, Any] = {}
    area = 0.0
    if took.floor is not None and took.floor.mass_g > 0.0 and planned.axis is not None:
        rate, area = took.floor.moved(frame).scaled(density), took.floor.mass_g
        details = _outline(took, sign * planned.axis, frame)
        details |= {"area_mm2": area} if "area_mm2" in planned.details else {}
        details |= {"entry_lift_mm": took.lift_mm} if took.lift_mm > 0.0 else {}
    correction = as_taken(planned, change, rate, area, -sign * took.volume.mass_g, **details)
    if "outline" in details:
        volume = (abs(correction.depth_mm) + took.lift_mm) * loops_area_mm2(details["outline"])
        correction = replace(correction, tool_volume_mm3=volume)
    return correction if took.hole is None else _in_old_hole(correction, frame @ took.hole)


def taken_of_scan(
    rotor: Rotor, left: Solid, cut_depths: Made, corrections: Sequence[Correction]
) -> tuple[Correction, ...]:
    """Return corrections as measured on the metal that each tool takes of a rough surface, one after another.

    ``left`` is the metal that all of them take, in the file's axes: each boolean with the whole scan takes as
    long as cutting it. Its beginning is planned on the fitted plane; its amount depends on the surface's
    waves and rounded edges.
    """
    removing = [cut.tool(depth) for cut, depth in cut_depths if not cut.adds_metal]
    taken = metal_of_each(left.moved(rotor.anatomy.file_to_rotor), removing)
    measured = []
    for (cut, depth), planned in zip(cut_depths, corrections, strict=True):
        mesh = None if cut.adds_metal else next(taken)
        if mesh is None or not len(mesh.triangles):
            measured.append(planned)
            continue
        metal = mesh_moments(mesh, rotor.density_g_mm3)
        area, volume = planned.details.get("new_face_area_mm2", 0.0), metal.mass_g / rotor.density_g_mm3
        measured.append(as_taken(planned, cut.pressed_in(depth) - metal, None, area, volume))
    return tuple(measured)


def metal_of_each(metal: Solid, tools: Sequence[Solid]) -> Iterator[Mesh]:
    """Yield each tool's part of the metal that all of them take, one after another, all in one frame."""
    low, high = np.array([tool.bounds for tool in tools]).swapaxes(0, 1)
    apart = (low[:, None] > high[None]) | (low[None] > high[:, None])
    if apart.any(axis=2).sum() < len(tools) * (len(tools) - 1):
        for tool in tools:
            taken, metal = metal.split(tool)
            yield taken.mesh
        return
    mesh = metal.mesh  # the boxes hold a piece each: no boolean is needed to tell them from each other
    first = mesh.vertices.take(mesh.triangles[:, 0], axis=0)
    outside = [
        np.maximum(least - first, first - most).max(axis=1) for least, most in zip(low, high, strict=True)
    ]
    nearest = np.argmin(outside, axis=0)
    for number in range(len(tools)):
        yield mesh.part(nearest == number)


def _outline(took: EachTaken, normal: Array, frame: Array) -> dict[str, Any]:
    """Return the outline of the new face in the rotor frame, or in separate axes where it is askew."""
    from autobalance.solid.cad.taken import flat_loops

    to_face = face_frame(normal)
    to_rotor = np.eye(4)
    to_rotor[:3, :3] = to_face[:3, :3].T
    plane = frame if side_of(normal) is not None else to_face @ frame
    return listed_outline(flat_loops(took.loops, plane), to_rotor)


def _in_old_hole(correction: Correction, placement: Array) -> Correction:
    """Return the correction of a drill that ran along an existing hole."""
    inward, entry = placement[:3, 2], placement[:3, 3]
    details = dict(correction.details) | {"inward": [float(v) for v in inward]}
    if details.get("entry_mm") is not None:
        sunk = float(details["deepened_from_mm"])
        details["entry_mm"] = [float(v) for v in entry - sunk * inward]
    return replace(correction, position_mm=entry, axis=inward, details=details)
