"""Simulated scans of cranks whose truth is known: waved, dented, out of round, with holes, anywhere.

Nothing here uses the recogniser, nor the program's own solids: a crank is a signed distance, made from a
design's dimensions, and its surface is meshed as scanners' software does it (dual contouring on a grid that
lies anywhere, vertices pulled onto the surface). Noise then moves every vertex along the true normal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import manifold3d
import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.drawn_cranks.design import PRESETS, Design
from autobalance.drawn_cranks.generate import axial_plan, shoulder_height_mm
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices
from tests.generated import random_placement

Field = Callable[[Array], Array]
"""Takes points (n, 3), gives their signed distances from a surface (n,), negative inside [mm]."""

HIDDEN_MM = 3.0
"""How far a journal or crankpin reaches into its web."""


def _max(a: Array, b: Array) -> Array:
    most: Array = np.maximum(a, b)
    return most


# --- signed distances ----------------------------------------------------------------------------------
def rounded_and(a: Array, b: Array, radius: float) -> Array:
    """Intersect, with the convex edge rounded."""
    if radius == 0.0:
        return np.maximum(a, b)
    outer = np.hypot(np.maximum(a + radius, 0.0), np.maximum(b + radius, 0.0))
    return np.minimum(-radius, np.maximum(a, b)) + outer


def filleted_or(a: Array, b: Array, radius: float) -> Array:
    """Unite, with the concave corner filleted."""
    return -rounded_and(-a, -b, radius)


def slab(z: Array, low: float, high: float) -> Array:
    return np.abs(z - 0.5 * (low + high)) - 0.5 * (high - low)


def hull_of_discs(x: Array, y: Array, r0: float, r1: float, apart: float) -> Array:
    """Distance from the hull of a disc about the origin and one at (apart, 0)."""
    across = np.abs(y)
    lean = (r0 - r1) / apart
    upright = math.sqrt(1.0 - lean * lean)
    along = -lean * across + upright * x
    side = upright * across + lean * x - r0
    ends = np.where(along < 0.0, np.hypot(x, across) - r0, np.hypot(x - apart, across) - r1)
    return np.where((along >= 0.0) & (along <= upright * apart), side, ends)


def sector(x: Array, y: Array, radius: float, half_angle: float) -> Array:
    """Distance (a bound) from a sector about −x, of less than a half turn or a half turn."""
    edge = np.abs(y) * math.cos(half_angle) + x * math.sin(half_angle)
    return np.maximum(np.hypot(x, y) - radius, edge)


def bar(points: Array, start: Sequence[float], end: Sequence[float], radius: float) -> Array:
    """Distance from a cylinder from one point to another, and a little past both."""
    first = np.asarray(start)
    way = np.asarray(end) - first
    length = float(np.linalg.norm(way))
    along = (points - first) @ way / length
    away = np.sqrt(np.maximum(((points - first) ** 2).sum(axis=1) - along**2, 0.0)) - radius
    return _max(away, slab(along, -2.0, length + 2.0))


# --- a crank from its dimensions -----------------------------------------------------------------------
@dataclass(frozen=True)
class Wear:
    """What a real crank has that its drawing has not.

    ``dents`` are (x, y, z, radius) of balls pressed in, ``collars`` (x, z_min, z_max, radius) of discs
    on webs.
    """

    out_of_round_mm: float = 0.0
    taper_mm: float = 0.0
    edge_mm: float = 0.5
    dents: tuple[tuple[float, float, float, float], ...] = ()
    label_mm: float = 0.0
    bow_mm: float = 0.0
    collars: tuple[tuple[float, float, float, float], ...] = ()


@dataclass(frozen=True)
class Part:
    """A piece of a crank between two heights, its distance in its own x and y."""

    low: float
    high: float
    field: Field


def _shaft(
    centre: tuple[float, float], radius: float, low: float, high: float, wear: Wear, ends: tuple[float, float]
) -> Part:
    """A journal or crankpin; ``ends`` say how far it reaches into what is below and above."""
    middle, width = 0.5 * (low + high), high - low

    def field(points: Array) -> Array:
        x, y, z = points[:, 0] - centre[0], points[:, 1] - centre[1], points[:, 2]
        along = np.clip((z - middle) / width, -0.5, 0.5)
        oval = 0.5 * wear.out_of_round_mm * np.cos(2.0 * np.arctan2(y, x) + 0.7 + middle)
        away = np.hypot(x, y) - radius - oval - wear.taper_mm * along
        return rounded_and(away, slab(z, low - ends[0], high + ends[1]), wear.edge_mm)

    return Part(low - ends[0], high + ends[1], field)


def _turned(x: Array, y: Array, angle: float) -> tuple[Array, Array]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x + s * y, -s * x + c * y


def _webs(crank: Design, wear: Wear) -> list[Part]:
    parts = []
    web, throw, weight = crank.web, crank.crank_radius_mm, crank.counterweight

    for span in axial_plan(crank).webs:

        def arm(points: Array, span: object = span) -> Array:
            x, y = _turned(points[:, 0], points[:, 1], span.angle_rad)  # type: ignore[attr-defined]
            z, low, high = points[:, 2], span.low, span.high  # type: ignore[attr-defined]
            second = span.second_angle_rad  # type: ignore[attr-defined]
            if second is not None:
                between = second - span.angle_rad  # type: ignore[attr-defined]
                radius = web.pin_end_radius_mm or crank.crankpin.diameter_mm / 2.0 + crank.fillet_mm
                to = throw * np.array([math.cos(between) - 1.0, math.sin(between)])
                u, v = _turned(x - throw, y, math.atan2(to[1], to[0]))
                outline = hull_of_discs(u, v, radius, radius, float(np.hypot(*to)))
                return rounded_and(outline, slab(z, low, high), wear.edge_mm)
            if web.outline == "pear":
                hub, end = float(web.hub_radius_mm or 0), float(web.pin_end_radius_mm or 0)
                outline = hull_of_discs(x, y, hub, end, throw)
            else:
                outline = np.hypot(x, y) - float(web.disc_radius_mm or 0)
            found = rounded_and(outline, slab(z, low, high), wear.edge_mm)
            if weight is None or not span.counterweight:  # type: ignore[attr-defined]
                return found
            fan = sector(x, y, weight.radius_mm, math.radians(weight.fan_angle_deg) / 2.0)
            found = np.minimum(found, rounded_and(fan, slab(z, low, high), wear.edge_mm))
            height = shoulder_height_mm(crank)
            if height > 0.0:
                inner = weight.inner_radius_mm or crank.main_journal.diameter_mm / 2.0 + crank.fillet_mm + 1.0
                ring = np.maximum(fan, inner - np.hypot(x, y))
                side = span.journal_side  # type: ignore[attr-defined]
                reach = slab(z, low - height * (side < 0), high + height * (side > 0))
                found = np.minimum(found, rounded_and(ring, reach, wear.edge_mm))
            return found

        tall = shoulder_height_mm(crank)
        parts.append(Part(span.low - tall, span.high + tall, arm))
    return parts


def _shafts(crank: Design, wear: Wear) -> list[Part]:
    plan, parts = axial_plan(crank), []
    main, pin = crank.main_journal.diameter_mm / 2.0, crank.crankpin.diameter_mm / 2.0
    for span in plan.journals:
        below = HIDDEN_MM if any(web.high == span.low for web in plan.webs) else 0.0
        above = HIDDEN_MM if any(web.low == span.high for web in plan.webs) else 0.0
        parts.append(_shaft((0.0, 0.0), main, span.low, span.high, wear, (below, above)))
    for span in plan.pins if crank.crankpin_in_file else ():
        above = HIDDEN_MM if any(web.low == span.high for web in plan.webs) else 0.0
        x, y = (
            crank.crank_radius_mm * math.cos(span.angle_rad),
            crank.crank_radius_mm * math.sin(span.angle_rad),
        )
        parts.append(_shaft((x, y), pin, span.low, span.high, wear, (HIDDEN_MM, above)))
    return parts


def _ends(crank: Design, wear: Wear) -> list[Part]:
    """Nose and flange."""
    parts = []
    if (nose := crank.nose) is not None:
        tip, base, long = (
            (nose.end_diameter_mm or nose.diameter_mm) / 2.0,
            nose.diameter_mm / 2.0,
            nose.length_mm,
        )
        slope = (base - tip) / long
        upright = 1.0 / math.hypot(1.0, slope)

        def cone(points: Array) -> Array:
            z = points[:, 2]
            away = (np.hypot(points[:, 0], points[:, 1]) - base - slope * np.minimum(z, 0.0)) * upright
            return rounded_and(away, slab(z, -long, HIDDEN_MM), wear.edge_mm)

        parts.append(Part(-long, HIDDEN_MM, cone))
    if (flange := crank.flange) is not None:
        low = axial_plan(crank).journals[-1].high
        high, wide = low + flange.thickness_mm, flange.diameter_mm / 2.0

        def disc(points: Array) -> Array:
            away = np.hypot(points[:, 0], points[:, 1]) - wide
            return rounded_and(away, slab(points[:, 2], low, high), wear.edge_mm)

        parts.append(Part(low, high, disc))
    return parts


def _taken(crank: Design) -> list[Part]:
    """Bores, oil holes, keyway, bolt holes: what is cut out."""
    plan, parts = axial_plan(crank), []
    ends = (-(crank.nose.length_mm if crank.nose else 0.0), plan.journals[-1].high if plan.journals else 0.0)

    def round_hole(centre: tuple[float, float], radius: float, low: float, high: float) -> Part:
        def hole(points: Array) -> Array:
            away = np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1]) - radius
            return np.maximum(away, slab(points[:, 2], low, high))

        return Part(low, high, hole)

    bore = crank.crankpin.bore_mm if crank.crankpin_in_file else crank.crankpin.diameter_mm
    for pin in plan.pins if bore > 0.0 else ():
        low = min(web.low for web in plan.webs if web.high == pin.low)
        high = max((web.high for web in plan.webs if web.low == pin.high), default=pin.high + 1.0)
        centre = crank.crank_radius_mm * np.array([math.cos(pin.angle_rad), math.sin(pin.angle_rad)])
        past = (
            0.0 if crank.crank_radius_mm - bore / 2.0 <= crank.main_journal.diameter_mm / 2.0 + 3.0 else 1.0
        )
        parts.append(round_hole((float(centre[0]), float(centre[1])), bore / 2.0, low - past, high + past))
    for pin in plan.pins if crank.oil_hole_mm > 0.0 else ():
        journal = plan.journals[0] if pin.low < plan.journals[-1].low else plan.journals[-1]
        journal = max((j for j in plan.journals if j.high <= pin.low), key=lambda j: j.high, default=journal)
        start = (
            -crank.main_journal.diameter_mm / 2.0 * math.cos(pin.angle_rad),
            -crank.main_journal.diameter_mm / 2.0 * math.sin(pin.angle_rad),
            0.5 * (journal.low + journal.high),
        )
        far = crank.crank_radius_mm + crank.crankpin.diameter_mm / 2.0
        end = (far * math.cos(pin.angle_rad), far * math.sin(pin.angle_rad), 0.5 * (pin.low + pin.high))

        def drilling(points: Array, start: Sequence[float] = start, end: Sequence[float] = end) -> Array:
            return bar(points, start, end, crank.oil_hole_mm / 2.0)

        if (
            journal.high < pin.low + 100.0
            and sum(1 for web in plan.webs if journal.high <= web.low < pin.low) == 1
        ):
            parts.append(Part(start[2] - 5.0, end[2] + 5.0, drilling))
    if crank.nose is not None and (key := crank.nose.keyway) is not None:
        floor = (crank.nose.end_diameter_mm or crank.nose.diameter_mm) / 2.0 - key.depth_mm

        def slot(points: Array) -> Array:
            side = np.maximum(np.abs(points[:, 0]) - key.width_mm / 2.0, floor - points[:, 1])
            return np.maximum(side, points[:, 2] - ends[0] - key.length_mm)

        parts.append(Part(ends[0] - 5.0, ends[0] + key.length_mm, slot))
    if (flange := crank.flange) is not None:
        for number in range(flange.bolts):
            angle = 2.0 * math.pi * number / flange.bolts
            x, y = (0.5 * flange.bolt_circle_mm * part for part in (math.cos(angle), math.sin(angle)))
            parts.append(
                round_hole(
                    (x, y), flange.bolt_diameter_mm / 2.0, ends[1] - 1, ends[1] + flange.thickness_mm + 1
                )
            )
    return parts


def _nearest(parts: Sequence[Part], points: Array) -> Array:
    """Least of the parts' distances from points in the order of z; parts far along z are not asked."""
    least = np.full(len(points), FAR_MM)
    for part in parts:
        begin, end = np.searchsorted(points[:, 2], [part.low - FAR_MM, part.high + FAR_MM])
        if end > begin:
            np.minimum(least[begin:end], part.field(points[begin:end]), out=least[begin:end])
    return least


FAR_MM = 12.0


def crank_field(crank: Design, wear: Wear) -> Field:
    """Return the signed distance of a crank in its own axes (z the axis); a bound away from the surface."""
    webs, shafts = _webs(crank, wear), [*_shafts(crank, wear), *_ends(crank, wear)]
    hidden = (0.0, 0.0)
    webs += [_shaft((x, 0.0), radius, low, high, wear, hidden) for x, low, high, radius in wear.collars]
    taken = _taken(crank)

    def field(points: Array) -> Array:
        if wear.bow_mm:
            low, high = points[:, 2].min(), points[:, 2].max()
            along = (points[:, 2] - 0.5 * (low + high)) / max(0.5 * (high - low), 1.0)
            points = points - np.stack([wear.bow_mm * along**2, 0.0 * along, 0.0 * along], axis=1)
        order = np.argsort(points[:, 2])
        rising = points.take(order, axis=0)
        body = filleted_or(_nearest(webs, rising), _nearest(shafts, rising), crank.fillet_mm)
        body = np.maximum(body, -_nearest(taken, rising))
        for x, y, z, radius in wear.dents:
            body = np.maximum(body, radius - np.linalg.norm(rising - np.array([x, y, z]), axis=1))
        found = np.zeros(len(points))
        found[order] = body
        return found

    return field


def crank_box(crank: Design) -> Array:
    """Return corners (2, 3) that hold a crank in its own axes."""
    plan, reach = axial_plan(crank), crank.crank_radius_mm + crank.crankpin.diameter_mm
    reach = max(
        reach,
        float(crank.web.disc_radius_mm or 0),
        *((crank.counterweight.radius_mm,) if crank.counterweight else ()),
        *((crank.flange.diameter_mm / 2.0,) if crank.flange else ()),
    )
    low = -(crank.nose.length_mm if crank.nose else 0.0)
    high = max(span.high for span in (*plan.journals, *plan.webs, *plan.pins))
    high += (crank.flange.thickness_mm if crank.flange else 0.0) + shoulder_height_mm(crank)
    return np.array([[-reach, -reach, low], [reach, reach, high]])


# --- meshing -------------------------------------------------------------------------------------------
CORNERS = np.array(list(product((0, 1), repeat=3)))
RING = [(0, 0), (0, 1), (1, 1), (1, 0)]
EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1]


def meshed(field: Field, box: Array, edge_mm: float, turn: Array, seed: int = 0) -> tuple[Array, Indices]:
    """Return vertices (n, 3) and triangles (m, 3) of a field's surface, edges of about ``edge_mm``.

    The grid is turned by ``turn`` (3, 3) against the field's axes.
    """
    middle, step = 0.5 * (box[0] + box[1]), 0.95 * edge_mm
    half = 0.5 * float(np.linalg.norm(box[1] - box[0])) + 2.0 * step

    def there(points: Array) -> Array:
        placed: Array = points @ turn.T + middle
        return placed

    shift = np.random.default_rng(seed).uniform(0.0, step, 3) - half
    vertices, triangles = _contoured(
        lambda grid: field(there(grid * step + shift)), box, there, step, shift, half
    )
    points = there(vertices * step + shift)
    points = on_surface(field, points, step)
    for _ in range(2):
        points = _relaxed(field, points, triangles, step)
    points = on_surface(field, points, step)
    return points, triangles


def _contoured(
    value: Field, box: Array, there: Field, step: float, shift: Array, half: float
) -> tuple[Array, Indices]:
    size = 8 if step < 1.3 else 4
    axis = np.arange(0, int(2.0 * half / step) + size, size)
    cells = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    middles = there((cells + 0.5 * size) * step + shift)
    near = np.all((middles > box[0] - 8 * step) & (middles < box[1] + 8 * step), axis=1)
    cells = cells[near]
    while True:
        distance = value(cells.astype(np.float64) + 0.5 * size)
        cells = cells[np.abs(distance) < min(0.9 * size * step * 1.1 + 0.2, FAR_MM)]
        if size == 1:
            break
        size //= 2
        cells = (cells[:, None] + size * CORNERS[None]).reshape(-1, 3)
    span = int(cells.max()) + 3
    key_of = np.array([span * span, span, 1])
    cells = cells[np.argsort(cells @ key_of)]
    corner_keys = (cells @ key_of)[:, None] + (CORNERS @ key_of)[None]
    distinct, inverse = np.unique(corner_keys, return_inverse=True)
    grid = np.stack([distinct // (span * span), distinct // span % span, distinct % span], axis=1)
    number = inverse.reshape(corner_keys.shape)
    at = _unambiguous(value(grid.astype(np.float64)), number)[number]
    mixed = (at < 0.0).any(axis=1) & (at >= 0.0).any(axis=1)
    cells, at = cells[mixed], at[mixed]
    total, count = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for a, b in EDGES:
        cross = (at[:, a] < 0.0) != (at[:, b] < 0.0)
        t = at[cross, a] / (at[cross, a] - at[cross, b])
        total[cross] += CORNERS[a] + t[:, None] * (CORNERS[b] - CORNERS[a])
        count[cross] += 1.0
    vertices = cells + total / count[:, None]
    keys = cells @ key_of
    quads = []
    for direction in range(3):
        end = int(np.flatnonzero((np.eye(3, dtype=int)[direction] == CORNERS).all(axis=1))[0])
        u, v = key_of[(direction + 1) % 3], key_of[(direction + 2) % 3]
        cross = np.flatnonzero((at[:, 0] < 0.0) != (at[:, end] < 0.0))
        ring = keys[cross][:, None] - np.array([0, u, u + v, v])[None]
        quad = np.searchsorted(keys, ring)
        outward = at[cross, 0] < 0.0
        quads.append(np.where(outward[:, None], quad, quad[:, ::-1]))
    quad = np.concatenate(quads)
    a, b, c, d = quad.T
    short = np.linalg.norm(vertices[a] - vertices[c], axis=1) < np.linalg.norm(
        vertices[b] - vertices[d], axis=1
    )
    one = np.where(short[:, None], np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    two = np.where(short[:, None], np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return vertices, np.concatenate([one, two])


FACES = [
    [int(np.flatnonzero((np.insert(corner, axis, side) == CORNERS).all(axis=1))[0]) for corner in RING]
    for axis in range(3)
    for side in (0, 1)
]


def _unambiguous(values: Array, number: Indices) -> Array:
    """Push grid points outside where two corners of a cell, or of its face, touch across: edges of four."""
    for _ in range(30):
        inside = values[number] < 0.0
        bad = [
            np.stack([number[rows, face[k]], number[rows, face[k + 2]]], axis=1)
            for face in FACES
            for k in (0, 1)
            if len(
                rows := np.flatnonzero(
                    inside[:, face[k]]
                    & inside[:, face[k + 2]]
                    & ~inside[:, face[1 - k]]
                    & ~inside[:, face[3 - k]]
                )
            )
        ]
        count = inside.sum(axis=1)
        for low in range(4):
            across = inside[:, low] == inside[:, 7 - low]
            rows = np.flatnonzero(across & np.isin(count, (2, 6)) & (inside[:, low] == (count == 2)))
            if len(rows):
                bad.append(number[rows][:, [low, 7 - low]])
        if not bad:
            break
        pairs = np.concatenate(bad)
        which = pairs[np.arange(len(pairs)), np.argmax(values[pairs], axis=1)]
        values[which] = 1e-6
    return values


def gradient(field: Field, points: Array, here: Array | None = None) -> Array:
    """Return the unit normals (n, 3), outward."""
    d = 1e-5
    here = field(points) if here is None else here
    slope: Array = np.stack([field(points + d * e) - here for e in np.eye(3)], axis=1)
    slope /= np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-12)
    return slope


def on_surface(field: Field, points: Array, step: float) -> Array:
    """Pull points onto the surface, along its normal."""
    for _ in range(2):
        here = field(points)
        off: Array = np.clip(here, -0.5 * step, 0.5 * step)
        points = points - off[:, None] * gradient(field, points, here)
    return points


def _relaxed(field: Field, points: Array, triangles: Indices, step: float) -> Array:
    """Move each vertex towards the middle of its neighbours, within the surface."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    many = np.maximum(np.bincount(pairs[:, 0], minlength=len(points)), 1)
    mean = np.stack([np.bincount(pairs[:, 0], c[pairs[:, 1]], len(points)) for c in points.T], axis=1)
    here = field(points)
    normal = gradient(field, points, here)
    way = mean / many[:, None] - points
    off = np.clip(here, -0.5 * step, 0.5 * step) + 0.6 * (way * normal).sum(axis=1)
    moved: Array = points + 0.6 * way - off[:, None] * normal
    return moved


# --- noise and damage ----------------------------------------------------------------------------------
WAVES = 96
WHITE_SHARE = 0.3
"""Share of the noise's variance that neighbours do not share."""


def waves(points: Array, rng: np.random.Generator, lengths_mm: tuple[float, float] = (1.0, 40.0)) -> Array:
    """Return a random field of standard deviation 1 at points (n, 3): plane waves of many lengths."""
    way = rng.normal(size=(WAVES, 3))
    way *= (
        2.0
        * math.pi
        / np.exp(rng.uniform(math.log(lengths_mm[0]), math.log(lengths_mm[1]), WAVES))
        / np.linalg.norm(way, axis=1)
    )[:, None]
    phase = rng.uniform(0.0, 2.0 * math.pi, WAVES)
    total = np.zeros(len(points))
    for k, p in zip(way, phase, strict=True):
        total += np.cos(points @ k + p)
    return total * math.sqrt(2.0 / WAVES)


def noise(
    points: Array, sigma_mm: float, rng: np.random.Generator, lengths_mm: tuple[float, float] = (1.0, 40.0)
) -> Array:
    """Return how far noise moves each point along its normal: waves of 1 to 40 mm, and white."""
    white = rng.normal(size=len(points))
    both = math.sqrt(1.0 - WHITE_SHARE) * waves(points, rng, lengths_mm) + math.sqrt(WHITE_SHARE) * white
    return sigma_mm * both


@dataclass(frozen=True, eq=False)
class Scan:
    """A scanned crank in the file's axes [mm]: what the scanner gives, the surface there, the truth."""

    mesh: Mesh
    true: Mesh
    truth: Anatomy
    placement: Array

    @property
    def soup(self) -> np.typing.NDArray[np.float32]:
        """Triangles (m, 3, 3) as an STL file keeps them."""
        return self.mesh.corners.astype(np.float32)


@lru_cache(maxsize=12)
def surface_of(crank: Design, edge_mm: float, wear: Wear, seed: int) -> tuple[Array, Indices, Array]:
    """Return vertices, triangles and outward normals of a crank's surface, in its own axes."""
    turn = random_placement(np.random.default_rng(seed))[:3, :3]
    field = crank_field(crank, wear)
    vertices, triangles = meshed(field, crank_box(crank), edge_mm, turn, seed)
    return vertices, triangles, gradient(field, vertices)


def scan(
    design: str | Design,
    sigma_mm: float,
    *,
    edge_mm: float = 1.2,
    seed: int = 0,
    wear: Wear | None = None,
    skin_mm: float = 0.0,
    scale: float = 1.0,
    placed: bool = True,
    lengths_mm: tuple[float, float] = (1.0, 40.0),
) -> Scan:
    """Return a scan of a crank; ``skin_mm`` and ``scale`` are the scanner's systematic errors."""
    crank = PRESETS[design] if isinstance(design, str) else design
    rng = np.random.default_rng([seed, 77])
    vertices, triangles, normals = surface_of(crank, edge_mm, wear or Wear(), seed % 3)
    placement = random_placement(rng, 200.0) if placed else np.eye(4)
    move = (
        noise(vertices, sigma_mm, rng, lengths_mm) + skin_mm
        if sigma_mm or skin_mm
        else np.zeros(len(vertices))
    )
    noisy = (vertices + move[:, None] * normals) * scale
    true = Mesh(vertices, triangles).moved(placement)
    return Scan(Mesh(noisy, triangles).moved(placement), true, crank_anatomy(crank, placement), placement)


def decimated(mesh: Mesh, count: int) -> Mesh:
    """Return a mesh of about ``count`` triangles of uneven size, or fewer."""
    body = manifold3d.Manifold(manifold3d.Mesh64(mesh.vertices, mesh.triangles.astype(np.uint64)))
    low, high = 1e-3, 3.0
    best = body
    for _ in range(9):
        middle = math.sqrt(low * high)
        best = body.simplify(middle)
        low, high = (middle, high) if best.num_tri() > count else (low, middle)
    found = best.to_mesh64()
    return Mesh(np.asarray(found.vert_properties)[:, :3].copy(), np.asarray(found.tri_verts).astype(np.int64))


def punched(mesh: Mesh, holes: Sequence[tuple[Array, float]]) -> Mesh:
    """Take out all triangles within a radius of a point: the scanner did not see them."""
    middles = mesh.corners.mean(axis=1)
    gone = np.zeros(len(middles), dtype=bool)
    for centre, radius in holes:
        gone |= np.linalg.norm(middles - centre, axis=1) < radius
    return mesh.part(~gone)


def patched(mesh: Mesh) -> Mesh:
    """Close every hole by a fan about the middle of its rim, as scanners' software does."""
    triangles = mesh.triangles
    ahead = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    number = len(mesh.vertices)
    free = ahead[~np.isin(ahead @ [number, 1], ahead @ [1, number])]
    follows = dict(zip(free[:, 1].tolist(), free[:, 0].tolist(), strict=True))
    vertices, fans = [*mesh.vertices], []
    while follows:
        ring = [next(iter(follows))]
        while (after := follows.pop(ring[-1])) != ring[0]:
            ring.append(after)
        vertices.append(mesh.vertices[ring].mean(axis=0))
        fans += [(a, b, len(vertices) - 1) for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
    return Mesh(
        np.array(vertices), np.concatenate([triangles, np.array(fans, dtype=np.int64).reshape(-1, 3)])
    )


def with_mesh(found: Scan, mesh: Mesh) -> Scan:
    return replace(found, mesh=mesh)


# --- parts that are no crank ---------------------------------------------------------------------------
def camshaft_field(points: Array) -> Array:
    """A shaft with journals and eight cams."""
    x, y, z = points.T
    away = np.hypot(x, y)
    found: Array = np.maximum(away - 11.0, slab(z, 0.0, 240.0))
    for number in range(3):
        found = np.minimum(
            found, rounded_and(away - 15.0, slab(z, 105.0 * number, 105.0 * number + 22.0), 0.5)
        )
    for number in range(8):
        u, v = _turned(x, y, 0.8 * number)
        low = 28.0 + 20.0 * number + 22.0 * (number >= 4)
        found = np.minimum(
            found, rounded_and(hull_of_discs(u, v, 16.0, 5.0, 15.0), slab(z, low, low + 13.0), 0.5)
        )
    return found


def propeller_shaft_field(points: Array) -> Array:
    """A stepped shaft with a flange beside its axis' middle and a fork."""
    x, y, z = points.T
    away = np.hypot(x, y)
    found = np.maximum(away - 14.0, slab(z, 0.0, 160.0))
    found = np.minimum(found, rounded_and(away - 40.0, slab(z, 0.0, 12.0), 1.0))
    for side in (-1.0, 1.0):
        ear = np.maximum(np.abs(y - side * 22.0) - 6.0, np.maximum(np.abs(x) - 16.0, slab(z, 150.0, 200.0)))
        found = np.minimum(found, ear)
    found = np.minimum(
        found, np.maximum(np.maximum(np.abs(x) - 16.0, np.abs(y) - 28.0), slab(z, 148.0, 160.0))
    )
    return _max(found, 9.0 - np.hypot(x, z - 182.0))


def bracket_field(points: Array) -> Array:
    """An angle with three holes."""
    x, y, z = points.T
    foot = np.maximum(np.abs(x) - 40.0, np.maximum(np.abs(y) - 25.0, slab(z, 0.0, 10.0)))
    wall = np.maximum(np.abs(x + 35.0) - 5.0, np.maximum(np.abs(y) - 25.0, slab(z, 0.0, 60.0)))
    found = filleted_or(foot, wall, 4.0)
    for at in ((10.0, 12.0), (10.0, -12.0)):
        found = np.maximum(found, 5.0 - np.hypot(x - at[0], y - at[1]))
    return _max(found, 8.0 - np.hypot(y, z - 40.0))


WRONG_PARTS: dict[str, tuple[Field, Array]] = {
    "camshaft": (camshaft_field, np.array([[-25.0, -25.0, -2.0], [25.0, 25.0, 242.0]])),
    "propeller shaft": (propeller_shaft_field, np.array([[-42.0, -42.0, -2.0], [42.0, 42.0, 202.0]])),
    "bracket": (bracket_field, np.array([[-42.0, -27.0, -2.0], [42.0, 27.0, 62.0]])),
}


def wrong_part(name: str, sigma_mm: float, *, edge_mm: float = 1.5, seed: int = 0) -> Mesh:
    """Return a scan of a part that is no crank."""
    field, box = WRONG_PARTS[name]
    rng = np.random.default_rng([seed, 78])
    placement = random_placement(rng, 200.0)
    vertices, triangles = meshed(field, box, edge_mm, placement[:3, :3], seed)
    moved = vertices + noise(vertices, sigma_mm, rng)[:, None] * gradient(field, vertices)
    return Mesh(moved, triangles).moved(placement)
