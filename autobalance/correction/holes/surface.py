"""Places of holes on the solid's own triangles: entry, zones of a web, wall left beside."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Literal
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.holes.walls import (
    EQUAL_MM,
    HoleLimits,
    clear_depth_mm,
    cross2,
    greatest_depth_mm,
    wall_left_mm,
)
from autobalance.crank.anatomy import Anatomy, Pin, Web
from autobalance.solid.mesh.mesh import Mesh, components
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Intersections of a hole's line with the solid's own triangles, and its entry among them.
#
# The entry's continuation are the triangles around the mouth that hang together and face the drill within
# `CONTINUATION_RAD`: all others are surfaces that a hole keeps its wall from.


CONTINUATION_RAD = math.radians(40.0)
"""A surface that turns further away from the drill than this is another surface (a 45° chamfer is)."""
BLOCK = 256
"""Triangles of a block: neighbours in the mesh's order, so that one box rules out all that a line misses."""
SAMPLES = 2000
"""Number of triangles, about, that a hole is compared with first: these exclude most places."""
BESIDE_MM = 1e-3
"""A line meets no triangle that stays further away from it than this; ample for rounding."""


@dataclass(frozen=True, eq=False)
class Axis:
    """Entry and direction of a hole, rotor frame.

    Local coordinates are (x, y, τ): τ is the depth along ``inward`` (unit) from ``entry_mm``.
    """

    entry_mm: Array
    inward: Array

    @cached_property
    def placement(self) -> Array:
        """Rigid motion (4, 4) from local coordinates to the rotor frame."""
        u = self.inward
        a, b, c = u.tolist()  # np.cross of two vectors takes as long as all the rest
        x = np.array(((0.0, -c, b), (c, 0.0, -a), (-b, a, 0.0))[int(np.argmin(np.round(np.abs(u), 9)))])
        x /= math.hypot(*x)
        d, e, f = x.tolist()
        place = np.eye(4)
        place[:3, 0], place[:3, 1] = x, (b * f - c * e, c * d - a * f, a * e - b * d)
        place[:3, 2], place[:3, 3] = u, self.entry_mm
        return place

    def local(self, points_mm: Array) -> Array:
        """Return points (..., 3) of the rotor frame in local coordinates."""
        place = self.placement
        flat = points_mm.reshape(-1, 3) - place[:3, 3]  # one product; numpy would do one a triangle
        out: Array = (flat @ place[:3, :3]).reshape(points_mm.shape)
        return out


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of the crank's boundary in the rotor frame.

    ``corners`` (m, 3, 3) and ``centre`` (m, 3), ``reach`` (m,) the distance of the farthest corner from it;
    ``vertex`` (m, 3) numbers the corners, equal where they are one point.
    """

    corners: Array
    vertex: Indices
    centre: Array
    reach: Array

    @classmethod
    def of(cls, mesh: Mesh, file_to_rotor: Array) -> Surface:
        """Return the whole boundary of a mesh that is given in file coordinates."""
        corners = mesh.moved(file_to_rotor).corners
        a, b, c = (corners[:, k] for k in range(3))
        centre = (a + b + c) / 3.0
        arms = ((corner - centre).T for corner in (a, b, c))
        reach = np.sqrt(np.maximum.reduce([x * x + y * y + z * z for x, y, z in arms]))
        return cls(corners, mesh.triangles, centre, reach)

    @classmethod
    def shared(cls, mesh: Mesh, file_to_rotor: Array) -> Surface:
        """Return the same boundary again as long as anybody, such as a cut's place, holds it."""
        frames = _SURFACES.setdefault(mesh, WeakValueDictionary())
        surface = frames.get(file_to_rotor.tobytes())
        if surface is None:
            frames[file_to_rotor.tobytes()] = surface = cls.of(mesh, file_to_rotor)
        return surface

    @cached_property
    def _blocks(self) -> tuple[Array, Array]:
        """Centres (b, 3) of balls that hold each block of triangles, and their radii (b,)."""
        begins = np.arange(0, len(self.reach), BLOCK)
        low = np.minimum.reduceat(self.centre - self.reach[:, None], begins, axis=0)
        high = np.maximum.reduceat(self.centre + self.reach[:, None], begins, axis=0)
        return 0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1)

    def _in_blocks(self, chosen: NDArray[np.bool_]) -> Indices:
        """Return the rows of the triangles in the chosen ones (b,) of the blocks."""
        first = np.flatnonzero(chosen)[:, None] * BLOCK
        rows = (first + np.arange(BLOCK)).reshape(-1)
        return rows[rows < len(self.reach)]

    def within(self, z_low_mm: float, z_high_mm: float) -> Surface:
        """Return the triangles that reach into a slab."""
        a, b, c = self.corners[:, :, 2].T
        above = np.maximum(np.maximum(a, b), c) >= z_low_mm
        return self.take(np.flatnonzero(above & (np.minimum(np.minimum(a, b), c) <= z_high_mm)))

    def beside_plane(self, out: Array, across: Array) -> Indices:
        """Return the rows of triangles that may meet the half plane from the origin along ``out`` (3,).

        ``across`` (3,) is its normal; both are unit vectors.
        """
        if not len(self.reach):
            return np.zeros(0, dtype=np.int64)

        def may(centre: Array, reach: Array) -> NDArray[np.bool_]:
            meets: NDArray[np.bool_] = (np.abs(centre @ across) <= reach) & (centre @ out >= -reach)
            return meets

        centre, reach = self._blocks
        rows = self._in_blocks(may(centre, reach * (1.0 + EQUAL_MM) + EQUAL_MM))
        return rows[may(self.centre[rows], self.reach[rows])]

    def around(self, axis: Axis, radius_mm: float) -> Surface:
        """Return the triangles that may come within ``radius_mm`` of the line along an axis."""
        return self.take(self.beside(axis, radius_mm))

    def beside(self, axis: Axis, radius_mm: float) -> Indices:
        """Return the rows of the triangles that may come within ``radius_mm`` of the line along an axis."""
        if not len(self.reach):
            return np.zeros(0, dtype=np.int64)
        a, b, c = axis.inward.tolist()

        def may(centre: Array, reach: Array) -> NDArray[np.bool_]:
            x, y, z = (centre - axis.entry_mm).T
            off2 = (x * x + y * y + z * z) - (a * x + b * y + c * z) ** 2
            meets: NDArray[np.bool_] = off2 <= (radius_mm + reach) ** 2
            return meets

        centre, reach = self._blocks
        rows = self._in_blocks(may(centre, reach + BESIDE_MM))
        return rows[may(self.centre[rows], self.reach[rows])]

    @cached_property
    def _shadows(self) -> tuple[Array, Array, Array, Array]:
        """Boxes around the triangles as seen along z: smallest and largest x, smallest and largest y (m,)."""
        x, y = (list(self.corners[:, :, axis].T) for axis in (0, 1))
        return np.minimum.reduce(x), np.maximum.reduce(x), np.minimum.reduce(y), np.maximum.reduce(y)

    @cached_property
    def _block_shadows(self) -> tuple[Array, Array, Array, Array]:
        """Boxes around each block of triangles as seen along z (b,)."""
        begins, (left, right, low, high) = np.arange(0, len(self.reach), BLOCK), self._shadows
        return (
            np.minimum.reduceat(left, begins),
            np.maximum.reduceat(right, begins),
            np.minimum.reduceat(low, begins),
            np.maximum.reduceat(high, begins),
        )

    def _over(self, point_mm: Array) -> Indices:
        """Return the rows of the triangles that a line along z through a point may meet.

        Balls around long slivers would let fifty times as many through.
        """
        if not len(self.reach):
            return np.zeros(0, dtype=np.int64)
        x, y, _ = point_mm.tolist()

        def may(left: Array, right: Array, low: Array, high: Array) -> NDArray[np.bool_]:
            meets: NDArray[np.bool_] = (left <= x + BESIDE_MM) & (right >= x - BESIDE_MM)
            meets &= (low <= y + BESIDE_MM) & (high >= y - BESIDE_MM)
            return meets

        rows = self._in_blocks(may(*self._block_shadows))
        return rows[may(*(side.take(rows) for side in self._shadows))]

    def take(self, rows: Indices) -> Surface:
        return Surface(self.corners[rows], self.vertex[rows], self.centre[rows], self.reach[rows])

    def hits(self, axis: Axis) -> tuple[Array, Indices]:
        """Return the intersections of the line along an axis: τ, ascending, and the triangles' rows."""
        straight = not axis.inward[:2].any()
        beside = self._over(axis.entry_mm) if straight else self.beside(axis, BESIDE_MM)
        depth, rows = met(axis.local(self.corners[beside]))
        return depth, beside[rows]

    def obliquity_rad(self, axis: Axis, entry_row: int) -> float:
        """Return the angle between an axis and the normal of the triangle that it enters."""
        a, b, c = self.corners[entry_row]
        normal = np.cross(b - a, c - a)
        return math.acos(min(max(-float(normal @ axis.inward) / float(np.linalg.norm(normal)), -1.0), 1.0))

    def may_hold(self, axis: Axis, radius_mm: float, room: HoleLimits) -> bool:
        """Return whether a sample of the triangles leaves room for a hole of the least depth.

        Only triangles that do not face the drill count: they are not a continuation of the entry.
        """
        corners = self.corners[:: max(1, len(self.corners) // SAMPLES)]
        points = axis.local(corners[~_facing(corners, axis), 0])
        s, depth = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
        return not (clear_depth_mm(s, depth, depth, radius_mm, room) < room.least_mm - EQUAL_MM).any()

    def others(
        self, axis: Axis, entry_row: int, fillet: NDArray[np.bool_] | None = None
    ) -> tuple[Array | None, float]:
        """Return the triangles (k, 3, 3) that do not continue the entry, and the smallest τ of the entry.

        Both in local coordinates. None if the entry itself is too slanted to start a drill on, or is part of
        a ``fillet`` (m,), which does not continue a face although it leaves it smoothly.
        """
        facing = _facing(self.corners, axis)
        if fillet is not None:
            facing &= ~fillet
        if not facing[entry_row]:
            return None, 0.0
        rows = np.flatnonzero(facing)
        same = rows[_connected(self.vertex[rows], int(np.searchsorted(rows, entry_row)))]
        other = np.ones(len(self.corners), dtype=bool)
        other[same] = False
        local = axis.local(self.corners)
        return local[other], float(local[same][:, :, 2].min())


def _facing(corners: Array, axis: Axis) -> NDArray[np.bool_]:
    """Return whether triangles (m, 3, 3) face a drill along an axis within `CONTINUATION_RAD`."""
    ux, uy, uz = (corners[:, 1] - corners[:, 0]).T
    vx, vy, vz = (corners[:, 2] - corners[:, 0]).T
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(x * x + y * y + z * z)
    a, b, c = axis.inward.tolist()
    facing: NDArray[np.bool_] = -(a * x + b * y + c * z) >= math.cos(CONTINUATION_RAD) * length
    facing &= length > 0.0
    return facing


def met(local: Array) -> tuple[Array, Indices]:
    """Return the intersections of the local axis with triangles (k, 3, 3): τ, ascending, and their rows."""
    a, b, c = local[:, 0, :2], local[:, 1, :2], local[:, 2, :2]
    weights = np.stack([cross2(b, c), cross2(c, a), cross2(a, b)], axis=1)
    total = weights.sum(1)
    across = np.abs(total) > 1e-12  # seen edge-on, a triangle is met through its neighbours
    weights = weights[across] / total[across, None]
    inside = (weights >= -1e-9).all(1)  # a line through an edge meets both its triangles
    rows = np.flatnonzero(across)[inside]
    depth = (weights[inside] * local[rows][:, :, 2]).sum(1)
    order = np.argsort(depth, kind="stable")
    return depth[order], rows[order]


def edge_pairs(vertex: Indices) -> tuple[Indices, Indices]:
    """Return the pairs of triangles (rows) that share an edge."""
    edges = np.sort(vertex[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(vertex)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    twin = np.flatnonzero((edges[1:] == edges[:-1]).all(1))
    return owner[twin], owner[twin + 1]


def _connected(vertex: Indices, start: int) -> NDArray[np.bool_]:
    """Return whether triangles are connected to triangle ``start`` through shared edges (m,)."""
    label = components(np.stack(edge_pairs(vertex), axis=1), len(vertex))
    same: NDArray[np.bool_] = label == label[start]
    return same


# Zones of a web for holes, and the fillets beside it.


Zone = Literal["counterweights", "web", "anywhere"]
ON_AXIS = 1e-9
"""Length up to which a direction counts as zero, for rounding."""
ON_EDGE_RAD = 1e-9
"""Angle up to which a place is on the edge of its zone: rounding."""
MOST_FILLET_SHARE = 0.25
"""Longest fillet, as a share of the radius of its cylinder."""
FILLET_GRAIN = 1e-3
"""Corners of a fillet's facets lie off its circle by up to this share of the radius."""


def in_zone(anatomy: Anatomy, web: Web, angle_rad: float, zone: Zone) -> bool:
    """Return whether an angle lies in a web's counterweight, or on the web's half away from its crankpins.

    The counterweight is the arc that its rim spans; where the rim is not known, that half.
    """
    if zone == "anywhere":
        return True
    towards = sum((throw.direction for throw in anatomy.throws_of(web)), np.zeros(2))
    size = float(np.linalg.norm(towards))
    if zone == "counterweights" and not web.counterweight:
        return False
    if size < ON_AXIS:
        return True
    away = math.atan2(-float(towards[1]), -float(towards[0]))
    half, middle = 0.5 * math.pi, away
    if zone == "counterweights" and web.outline is not None:
        half, middle = min(half, 0.5 * web.outline.fan_angle_rad), away + web.outline.skew_rad
    return abs(math.remainder(angle_rad - middle, math.tau)) <= half + ON_EDGE_RAD


def least_radius_mm(anatomy: Anatomy, web: Web, zone: Zone) -> float:
    """Return the radius at which a counterweight begins: that of the main journals and fillets beside it."""
    if zone != "counterweights":
        return 0.0
    fillets = (fillet_of(journal, web) for journal in anatomy.main_journals)
    return max((each.radius_mm + each.least_mm for each in fillets if each is not None), default=0.0)


_SURFACES: WeakKeyDictionary[Mesh, WeakValueDictionary[bytes, Surface]] = WeakKeyDictionary()
"""Boundaries in use, by mesh and frame."""


@dataclass(frozen=True)
class Fillet:
    """Fillet between a cylinder and a web, rotor frame.

    It begins at the end ``z_mm`` of the bare cylinder, runs towards the web (``sense`` along z), and is
    nowhere higher than it is long, at any radius; ``least_mm`` and ``most_mm`` bound its length.
    """

    centre_mm: tuple[float, float]
    radius_mm: float
    z_mm: float
    sense: float
    least_mm: float
    most_mm: float

    def holds(self, corners: Array) -> NDArray[np.bool_]:
        """Return whether triangles (m, 3, 3) lie in it with all corners."""
        x_mm, y_mm = self.centre_mm
        rise: Array = np.hypot(corners[:, :, 0] - x_mm, corners[:, :, 1] - y_mm) - self.radius_mm
        along = self.sense * (corners[:, :, 2] - self.z_mm)
        slack = FILLET_GRAIN * self.radius_mm
        inside = (rise <= along + slack) & (along >= -slack) & (along <= self.most_mm + slack)
        return np.asarray(inside.all(axis=1))


def fillets_of(anatomy: Anatomy, web: Web) -> tuple[Fillet, ...]:
    """Return the fillets on both sides of a web."""
    pins: list[Pin] = [*anatomy.main_journals, *(throw.crankpin for throw in anatomy.throws)]
    fillets = (fillet_of(pin, web) for pin in pins)
    return tuple(each for each in fillets if each is not None)


def in_fillets(corners: Array, fillets: tuple[Fillet, ...]) -> NDArray[np.bool_]:
    """Return whether triangles (m, 3, 3) are part of a fillet."""
    held = np.zeros(len(corners), dtype=bool)
    for each in fillets:
        held |= each.holds(corners)
    return held


def fillet_of(pin: Pin, web: Web) -> Fillet | None:
    """Return the fillet of a cylinder at a web; None where the cylinder is not beside that web.

    A web with a counterweight thicker than its hub begins, as it was recognised, above the fillet.
    """
    radius = 0.5 * pin.diameter_mm
    low, high = pin.z_range_mm
    middle = 0.5 * (web.z_min_mm + web.z_max_mm)
    below = high < middle
    gap = web.z_min_mm - high if below else low - web.z_max_mm
    if gap > radius:
        return None
    end, sense = (high, 1.0) if below else (low, -1.0)
    most = min(MOST_FILLET_SHARE * radius, abs(middle - end))
    centre = float(pin.centre_mm[0]), float(pin.centre_mm[1])
    return Fillet(centre, radius, end, sense, min(max(gap, 0.0), most), most)


# Surfaces around the axis of a hole: the wall left beside it, and its largest depth.


LOOKED_AT_MM = 10.0
"""Distance searched beside a hole, beyond its width; farther if there is nothing."""
NEAR_ENTRY_MM = 0.05
OLD_SHARE = 0.04
"""Share of the drill's radius by which an old hole that it fits may reach farther out: wider, not round."""


@dataclass(frozen=True)
class OldHole:
    """Hole to be drilled deeper: its radius, and the distance of its tip beyond the entry.

    What lies more than ``wall_mm`` above its tip is beside the old hole alone.
    """

    radius_mm: float
    tip_mm: float
    wall_mm: float

    def is_own(self, local: Array) -> NDArray[np.bool_]:
        """Return whether triangles (k, 3, 3) around the axis are the old hole's own, or beside it alone."""
        highest = local[:, :, 2].max(axis=1) - self.tip_mm
        within = (np.hypot(local[:, :, 0], local[:, :, 1]) <= (1.0 + OLD_SHARE) * self.radius_mm).all(axis=1)
        own: NDArray[np.bool_] = (within & (highest <= self.radius_mm)) | (highest < -self.wall_mm)
        return own


@dataclass(frozen=True, eq=False)
class Around:
    """All surfaces of a crank about the axis of a hole; ``fillets`` are those of its web."""

    surface: Surface
    axis: Axis
    fillets: tuple[Fillet, ...]
    old: OldHole | None = None

    def wall_mm(self, radius_mm: float, depth_mm: float, half_point_rad: float) -> float | None:
        """Return the least distance from a hole to surfaces that it does not enter.

        None where its axis meets no surface at its entry that a drill can start on.
        """
        reach = 2.0 * radius_mm + LOOKED_AT_MM
        while True:
            others = self._others(reach)
            if others is None:
                return None
            wall = wall_left_mm(others, radius_mm, depth_mm, half_point_rad)
            if radius_mm + wall <= reach:
                return wall
            reach = radius_mm + wall

    def deepest_mm(self, radius_mm: float, room: HoleLimits) -> float | None:
        """Return the largest depth of a hole within limits, -inf without any; None as in ``wall_mm``."""
        others = self._others(max(2.0 * radius_mm + LOOKED_AT_MM, radius_mm + room.wall_mm))
        return None if others is None else greatest_depth_mm(others, radius_mm, room)

    def _others(self, reach_mm: float) -> Array | None:
        near = self.surface.around(self.axis, reach_mm)
        depth, rows = near.hits(self.axis)
        away, near_mm = np.abs(depth), NEAR_ENTRY_MM
        if self.old is not None:
            away, near_mm = np.abs(depth - self.old.tip_mm), near_mm + OLD_SHARE * self.old.radius_mm
        if not (away < near_mm).any():
            return None
        entered = int(rows[np.argmin(away)])
        if self.old is None:
            return near.others(self.axis, entered, in_fillets(near.corners, self.fillets))[0]
        others, _ = near.others(self.axis, entered)
        return None if others is None else others[~self.old.is_own(others)]


def most_mm(axis: Axis, least_radius_mm: float, radius_mm: float, half_point_rad: float) -> float:
    """Return the depth at which a radial hole leaves its zone, point included, or meets the crank axis.

    Endless for an axial hole that lies in the zone, -inf for one that does not.
    """
    out = math.hypot(*axis.entry_mm[:2]) - least_radius_mm
    if abs(axis.inward[2]) > 0.5:
        return math.inf if not least_radius_mm or out >= radius_mm else -math.inf
    return out - (radius_mm / math.tan(half_point_rad) if least_radius_mm else 0.0)
