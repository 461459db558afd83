"""Exact descriptions of solids from lines and arcs, and the source of each surface of a cut."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property

import manifold3d as m3
import numpy as np
from numpy.typing import NDArray

from autobalance.solid.csg.region import Region, triangulated
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh, without_collapsed
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Exact descriptions of solids: outlines of lines and arcs, extruded, turned, joined and cut.
#
# A shape has no facets. ``tessellated`` turns it into triangles, all corners of whose faces lie on the true
# surface; ``autobalance.solid.cad.brep`` turns the same description into exact surfaces.


Point = tuple[float, float]

GRID_MM = 2.0**-27
"""Regions keep coordinates on this grid; heights that lie on it too add and subtract without rounding."""


SAME_MM = 1e-6
"""Points and heights closer than this are one, rounded differently."""


@dataclass(frozen=True)
class Line:
    """A straight edge from ``start`` to ``end`` [mm]; meshes have corners at ``via`` too, points on it."""

    start: Point
    end: Point
    via: tuple[Point, ...] = ()

    def points(self, segments: int, times: int = 1) -> list[Point]:
        """Return the line's points, the last one left out."""
        del segments, times
        return [self.start, *self.via]


@dataclass(frozen=True)
class Arc:
    """An arc of a circle, counter-clockwise if ``end_rad`` > ``start_rad``.

    ``share`` is the fineness of its division over that of a full circle into ``segments``, and ``least`` the
    smallest number of parts: fillets have few.
    """

    centre: Point
    radius: float
    start_rad: float
    end_rad: float
    share: float = 1.0
    least: int = 1

    def at(self, angle_rad: float) -> Point:
        """Return the point of the circle at an angle."""
        return (
            self.centre[0] + self.radius * math.cos(angle_rad),
            self.centre[1] + self.radius * math.sin(angle_rad),
        )

    @property
    def start(self) -> Point:
        return self.at(self.start_rad)

    @property
    def end(self) -> Point:
        return self.at(self.end_rad)

    def points(self, segments: int, times: int = 1) -> list[Point]:
        """Return the arc's points, the last one left out; every part is divided ``times`` over."""
        swept = self.end_rad - self.start_rad
        parts = max(self.least, math.ceil(self.share * segments * abs(swept) / (2.0 * math.pi) - 1e-9))
        parts *= times
        return [self.at(self.start_rad + swept * i / parts) for i in range(parts)]


Outline = tuple[Line | Arc, ...]
"""A closed sequence of edges, counter-clockwise."""


def polygon(corners: Sequence[Point]) -> Outline:
    """Return the outline of straight edges between corners."""
    return tuple(Line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))


def circle(radius: float, centre: Point = (0.0, 0.0)) -> Outline:
    return (Arc(centre, radius, 0.0, 2.0 * math.pi),)


def equal_area(sides: int) -> float:
    """Return the radius of a regular polygon's corners over that of the circle of its area."""
    return math.sqrt((2.0 * math.pi / sides) / math.sin(2.0 * math.pi / sides))


def outline_points(outline: Outline, segments: int, times: int = 1) -> Array:
    """Return the corners (k, 2) of a tessellated outline, on the grid."""
    points = np.array([point for edge in outline for point in edge.points(segments, times)])
    rounded: Array = np.round(points / GRID_MM) * GRID_MM
    return rounded


def outline_area_mm2(outline: Outline) -> float:
    """Return the area inside an outline, its arcs as they are: ½ ∮ (x dy − y dx)."""
    total = 0.0
    for edge in outline:
        (x0, y0), (x1, y1) = edge.start, edge.end
        total += x0 * y1 - x1 * y0
        if isinstance(edge, Arc):  # between the arc and its chord
            swept = edge.end_rad - edge.start_rad
            total += edge.radius**2 * (swept - math.sin(swept))
    return 0.5 * total


def polygon_area_mm2(polygon: Array) -> float:
    """Return the area inside a polygon (k, 2), positive if it runs counter-clockwise."""
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def rotated(outline: Outline, angle_rad: float) -> Outline:
    """Return an outline turned about the origin."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)

    def turn(point: Point) -> Point:
        return (c * point[0] - s * point[1], s * point[0] + c * point[1])

    return tuple(
        Line(turn(edge.start), turn(edge.end), tuple(map(turn, edge.via)))
        if isinstance(edge, Line)
        else Arc(
            turn(edge.centre),
            edge.radius,
            edge.start_rad + angle_rad,
            edge.end_rad + angle_rad,
            edge.share,
            edge.least,
        )
        for edge in outline
    )


def with_corners(outline: Outline, points: Iterable[Point]) -> Outline:
    """Return an outline with corners at the points that lie on its lines.

    Two bodies that touch along a line share their corners then, and join without slivers.
    """
    corners = list(points)
    return tuple(
        Line(edge.start, edge.end, tuple(_between(edge, corners))) if isinstance(edge, Line) else edge
        for edge in outline
    )


def _between(line: Line, points: Sequence[Point]) -> list[Point]:
    """Return the points strictly within a line, from its start on."""
    length = math.dist(line.start, line.end)
    inside = []
    for point in points:
        before, after = math.dist(line.start, point), math.dist(point, line.end)
        if min(before, after) > SAME_MM and before + after - length < SAME_MM:
            inside.append((before, point))
    return [point for _, point in sorted(inside)]


def on_grid(height_mm: float) -> float:
    """Return a height rounded to the grid on which sums and differences of heights are exact."""
    return round(height_mm / GRID_MM) * GRID_MM


@dataclass(frozen=True)
class Prism:
    """An outline in x and y, drawn out along z."""

    outline: Outline
    z_low: float
    z_high: float


@dataclass(frozen=True)
class Drafted:
    """A prism from ``face`` to ``top``, some of whose edges lean inward.

    ``leaning`` numbers those edges in the outline, which are lines; ``slope`` is their shift inward per
    height. The outline needs corners where the leaning planes reach the top. ``top`` may lie below ``face``.
    """

    outline: Outline
    face: float
    top: float
    leaning: tuple[int, ...]
    slope: float

    @property
    def up(self) -> float:
        """1 or −1: the sense in which it is on the face."""
        return math.copysign(1.0, self.top - self.face)

    @property
    def height(self) -> float:
        """Height over the face [mm]."""
        return abs(self.top - self.face)

    def inward(self, number: int) -> tuple[Array, Array]:
        """Return a point (2,) of a leaning edge and its unit normal (2,) into the metal."""
        edge = self.outline[number]
        start, along = np.array(edge.start), np.array(edge.end) - np.array(edge.start)
        return start, np.array([-along[1], along[0]]) / np.linalg.norm(along)

    def heights(self, points: Array) -> tuple[Array, Indices]:
        """Return each corner's height over the face, and the leaning edge that limits it, or −1."""
        limits = np.array(
            [(points - start) @ normal / self.slope for start, normal in map(self.inward, self.leaning)]
        )
        limits[np.abs(limits) < SAME_MM] = 0.0
        limits[np.abs(limits - self.height) < SAME_MM] = self.height
        low = limits.min(axis=0)
        tied = np.where(limits - low < SAME_MM, self.aways(points), np.inf)  # two edges may be in one line
        nearest = tied.argmin(axis=0)
        return np.clip(low, 0.0, self.height), np.where(low < self.height, nearest, -1)

    def aways(self, points: Array) -> Array:
        """Return the distances (k, n) of corners (n, 2) from the middles of the leaning edges."""
        edges = [self.outline[number] for number in self.leaning]
        middles = [0.5 * (np.array(edge.start) + np.array(edge.end)) for edge in edges]
        return np.array([np.linalg.norm(points - middle, axis=1) for middle in middles])


@dataclass(frozen=True)
class Revolved:
    """A profile in (r, z), r ≥ 0, turned about the line parallel to z through ``centre``."""

    profile: Outline
    centre: Point = (0.0, 0.0)


@dataclass(frozen=True)
class Bar:
    """A round bar, as a drill leaves it, between two points."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    diameter: float


@dataclass(frozen=True)
class Joined:
    """Union of the parts."""

    parts: tuple[Shape, ...]


@dataclass(frozen=True)
class Without:
    """The body without the volume of the tools."""

    body: Shape
    tools: tuple[Shape, ...]


@dataclass(frozen=True, eq=False)
class Placed:
    """A shape moved rigidly by a homogeneous matrix (4, 4)."""

    shape: Shape
    placement: Array


Shape = Prism | Drafted | Revolved | Bar | Joined | Without | Placed


def bar_placement(bar: Bar) -> tuple[Array, float]:
    """Return the matrix (4, 4) that takes a bar along z from the origin to its place, and its length."""
    start = np.array(bar.start)
    axis = np.array(bar.end) - start
    length = float(np.linalg.norm(axis))
    z = axis / length
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    placement = np.eye(4)
    placement[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    placement[:3, 3] = start
    return placement, length


def tessellated(shape: Shape, segments: int, times: int = 1) -> Solid:
    """Return a shape as triangles.

    Parameters
    ----------
    shape : Shape
    segments : int
        Parts of a full circle.
    times : int
        Divisions of each part again: the facets' error then falls as its square, exactly.

    Returns
    -------
    Solid
        Its corners lie on the true surface, save where a cut crosses a curved face slantwise: there they lie
        on the facets.
    """
    if isinstance(shape, Joined):
        return union([tessellated(part, segments, times) for part in shape.parts])
    if isinstance(shape, Without):
        tools = union([tessellated(tool, segments, times) for tool in shape.tools])
        return tessellated(shape.body, segments, times) - tools
    if isinstance(shape, Placed):
        return tessellated(shape.shape, segments, times).moved(shape.placement)
    return _tessellated_primitive(shape, segments, times)


def _tessellated_primitive(shape: Prism | Drafted | Revolved | Bar, segments: int, times: int) -> Solid:
    if isinstance(shape, Prism):
        region = Region.of([outline_points(shape.outline, segments, times)])
        return Solid.prism(region, shape.z_low, shape.z_high)
    if isinstance(shape, Drafted):
        return Solid.from_mesh(_drafted_mesh(shape, segments, times))
    if isinstance(shape, Revolved):
        placement = np.eye(4)
        placement[:2, 3] = shape.centre
        return Solid.revolved(outline_points(shape.profile, segments, times), segments * times).moved(
            placement
        )
    placement, length = bar_placement(shape)
    slices = max(1, round(length / shape.diameter))
    outline = Region.circle(shape.diameter / 2.0, segments * times)
    return Solid.prism(outline, 0.0, length, slices=slices).moved(placement)


def _drafted_mesh(shape: Drafted, segments: int, times: int) -> Mesh:
    """Return the mesh with every corner of the outline raised to a leaning plane or the top."""
    points = outline_points(shape.outline, segments, times)
    count = len(points)
    height, limited_by = shape.heights(points)
    here = np.arange(count)
    raised = np.where(height > 0.0, here + count, here)
    after, raised_after = np.roll(here, -1), np.roll(raised, -1)
    faces = [triangulated(points)[:, ::-1]]
    faces += [np.column_stack([here, after, raised_after]), np.column_stack([here, raised_after, raised])]
    for edge in (-1, *range(len(shape.leaning))):
        own = np.flatnonzero(_on_plane(shape, points, height, limited_by, edge))
        faces.append(raised[own[triangulated(points[own])]])
    z = np.concatenate([np.full(count, shape.face), shape.face + shape.up * height])
    triangles = without_collapsed(np.concatenate(faces))
    mesh = Mesh(np.column_stack([np.tile(points, (2, 1)), z]), triangles)
    return mesh if shape.up > 0.0 else mesh.flipped()


def _on_plane(
    shape: Drafted, points: Array, height: Array, limited_by: Indices, edge: int
) -> NDArray[np.bool_]:
    """Mark the raised corners (k,) on the top (−1) or on the leaning plane of an edge."""
    if edge < 0:
        return np.asarray(height == shape.height)
    start, normal = shape.inward(shape.leaning[edge])
    at_top = np.abs((points - start) @ normal - shape.slope * shape.height) < SAME_MM
    near = shape.aways(points).argmin(axis=0) == edge
    return np.asarray((limited_by == edge) | (at_top & near))


def wedges(shape: Drafted) -> list[Placed]:
    """Return the tools that cut the leaning edges from the upright prism, one for each."""
    far = 4.0 * max(abs(value) for edge in shape.outline for value in (*edge.start, *edge.end))
    top = 2.0 * shape.height
    profile = polygon([(0.0, 0.0), (-far, 0.0), (-far, top), (shape.slope * top, top)])
    tools = []
    for number in shape.leaning:
        start, normal = shape.inward(number)
        inward, rise = np.array([*normal, 0.0]), np.array([0.0, 0.0, shape.up])
        placement = np.eye(4)
        placement[:3, :3] = np.stack([inward, rise, np.cross(inward, rise)], axis=1)
        placement[:3, 3] = (*start, shape.face)
        tools.append(Placed(Prism(tuple(reversed_outline(profile)), -far, far), placement))
    return tools


def reversed_outline(outline: Outline) -> Outline:
    return tuple(
        Line(edge.end, edge.start, edge.via[::-1])
        if isinstance(edge, Line)
        else Arc(edge.centre, edge.radius, edge.end_rad, edge.start_rad, edge.share, edge.least)
        for edge in reversed(outline)
    )


# Common parts and differences of a large solid and small ones, with the source of each surface.


@dataclass(frozen=True, eq=False)
class Shared:
    """Result of a boolean of a large and a small solid; its surface is partly the one's or the other's.

    Attributes
    ----------
    solid : Solid
    small : int
        manifold3d's number for the small one's surface.
    """

    solid: Solid
    small: int

    @cached_property
    def surfaces(self) -> tuple[Mesh, NDArray[np.bool_]]:
        """The mesh, and a mark of its triangles (m,) on the surface of the small solid."""
        raw = self.solid._body.to_mesh64()
        ends = np.asarray(raw.run_index, dtype=np.int64) // 3
        lengths = ends[1:] - ends[:-1]
        of_small = np.asarray(raw.run_original_id) == self.small
        vertices = np.asarray(raw.vert_properties, dtype=np.float64).reshape(-1, raw.vert_properties.shape[1])
        mesh = Mesh(vertices[:, :3], np.asarray(raw.tri_verts, dtype=np.int64).reshape(-1, 3))
        return mesh, np.repeat(of_small[: len(lengths)], lengths)

    def simplified(self, by_mm: float) -> Shared:
        """Return the solid with edges merged that are shorter than ``by_mm``; its surface moves by less."""
        return Shared(self.solid.simplified(by_mm), self.small)


def shared_with(first: Solid, tools: Sequence[Solid]) -> list[Shared]:
    """Return the common part of ``first`` and each of some small solids."""
    if not tools:
        return []
    bodies = [tool._body.as_original() for tool in tools]
    reach = first._body ^ m3.Manifold.batch_boolean(bodies, m3.OpType.Add)
    own: dict[int, list[m3.Manifold]] = {body.original_id(): [] for body in bodies}
    for part in reach.decompose():
        raw = part.to_mesh64()
        touched = own.keys() & np.asarray(raw.run_original_id)[np.diff(raw.run_index) > 0]
        if len(touched) != 1:  # solids that touch each other share it, and each has its own share
            return [Shared(Solid(reach ^ body), body.original_id()) for body in bodies]
        own[touched.pop()].append(part)
    return [Shared(Solid(m3.Manifold.compose(parts)), small) for small, parts in own.items()]


def beyond(tool: Solid, solid: Solid) -> Shared:
    """Return the part of a small solid outside of ``solid``."""
    body = tool._body.as_original()
    return Shared(Solid(body - solid._body), body.original_id())
