"""Solids with checked booleans; the kernel's status is read here alone."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import manifold3d as m3
import numpy as np

from autobalance.errors import SolidError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region, triangulated
from autobalance.solid.mesh.measure import mesh_moments, part_volumes
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

# Solids with booleans, all checked: this module alone reads the kernel's status.
#
# manifold3d does not raise: an open mesh becomes an empty solid with a status, an inverted one a solid of
# negative volume, and both travel on through booleans. Everything here looks at the status first.


SAME_VOLUME = 1e-6
"""Share by which the volume of a body rebuilt from its triangles may differ: manifold3d takes long slivers
out of them, and where these are many, a part of the body with them."""

BESIDE_SHARE = 1e-3
"""Room left around a connected body that is taken out of others, in shares of its size."""
FILM = 1e-6
"""Volume over area and diagonal up to which manifold3d has to tell whether a mesh bounds anything: it merges
what is nearer than 1e-12 of the diagonal. Cranks have 0.01 to 0.03."""

STATUS_TEXTS = {
    "InvalidConstruction": "a part of it has no thickness or no area (InvalidConstruction); check its sizes",
}
"""Meanings of manifold3d's status of a body."""


def _run(triangles: int, number: int) -> dict[str, Any]:
    """Return the arguments of manifold3d's mesh that give all of its triangles one number."""
    return {
        "run_index": np.array([0, 3 * triangles], dtype=np.uint64),
        "run_original_id": np.array([number], dtype=np.uint32),
    }


class Solid:
    """Closed, outward, non-overlapping body, which may be empty (``is_empty``)."""

    __slots__ = ("_built", "_id", "_mesh", "_volume_mm3")

    def __init__(self, body: m3.Manifold) -> None:
        """Take a manifold3d body; use the named constructors instead."""
        if body.status() != m3.Error.NoError:
            status = _status_name(body)
            raise SolidError(f"the solid is not valid: {STATUS_TEXTS.get(status, status)}")
        self._built: m3.Manifold | None = body
        self._id: int | None = None
        self._mesh: Mesh | None = None
        self._volume_mm3: float | None = None

    @property
    def _body(self) -> m3.Manifold:
        """The manifold3d body, built on first use where only the mesh was given."""
        if self._built is None:
            self._built = Solid._numbered(self.mesh, self._id)._body
        return self._built

    @classmethod
    def from_mesh(cls, mesh: Mesh) -> Solid:
        """Build a solid from a closed, outward mesh.

        Raises
        ------
        SolidError
            If the mesh is open or not manifold, is inside out, or bounds nothing.
        """
        return cls._numbered(mesh, None)

    @classmethod
    def of_closed(cls, mesh: Mesh) -> Solid | None:
        """Return the solid of a mesh whose edges each join two triangles, None where building has to tell.

        Its edges prove that it is closed, and its moments that it is outward and no film. So manifold3d
        builds its body only when it is first cut, for a million triangles a third of what reading takes.
        """
        if mesh.twins is None:
            return None
        volume = mesh_moments(mesh, 1.0).mass_g
        if not volume > FILM * 0.5 * float(mesh.doubled_areas.sum()) * mesh.diagonal_mm:
            return None
        return cls.from_plain((mesh, volume))

    @classmethod
    def _numbered(cls, mesh: Mesh, number: int | None) -> Solid:
        """Do the same with the kernel's number for the body; None: the next one."""
        if len(mesh.triangles) == 0:
            raise SolidError("the mesh bounds no volume: it has no triangles")
        if len(mesh.triangles) % 2:  # three sides each, two to an edge; manifold3d 3.5 may crash on these
            odd = f"NotManifold, with {len(mesh.triangles)} triangles, an odd number"
            raise SolidError(f"the mesh does not bound a solid: {odd}")
        vertices = np.require(mesh.vertices, np.float64, ["C", "W"])
        triangles = np.require(mesh.triangles, np.int64, ["C", "W"]).view(np.uint64)
        runs = {} if number is None else _run(len(triangles), number)
        body = m3.Manifold(m3.Mesh64(vertices, triangles, **runs))
        if body.status() != m3.Error.NoError:
            raise SolidError(f"the mesh does not bound a solid: {_status_name(body)}")
        solid = cls(body)
        if solid.is_empty or solid.volume_mm3 == 0.0:
            raise SolidError("the mesh bounds no volume")
        if solid.volume_mm3 < 0.0:
            raise SolidError(f"the mesh is inside out: its volume is {solid.volume_mm3:.6g} mm³")
        solid._mesh = mesh
        return solid

    @classmethod
    def _whole(cls, mesh: Mesh, volume_mm3: float) -> Solid | None:
        """Return the solid of a mesh of known volume, None where manifold3d takes some with the slivers.

        Of a film that a boolean left between near surfaces nothing may remain, or less: a negative volume.
        """
        try:
            solid = cls.from_mesh(mesh)
        except SolidError:
            return None
        return solid if abs(solid.volume_mm3 - volume_mm3) <= SAME_VOLUME * volume_mm3 else None

    @classmethod
    def of_parts(cls, mesh: Mesh) -> Solid:
        """Return the solid bounded by whole parts of another solid's mesh, which are known to be closed.

        It takes no time before it is cut: building one of a million triangles takes longer than cutting it.
        """
        solid = cls.__new__(cls)
        solid._built, solid._id, solid._mesh = None, None, mesh
        solid._volume_mm3 = mesh_moments(mesh, 1.0).mass_g
        return solid

    @classmethod
    def nothing(cls) -> Solid:
        return cls(m3.Manifold())

    @classmethod
    def box(cls, low_mm: Array, high_mm: Array) -> Solid:
        """Return the box between two corners (3,) [mm]."""
        low, high = np.asarray(low_mm, dtype=np.float64), np.asarray(high_mm, dtype=np.float64)
        return cls(m3.Manifold.cube(tuple(high - low)).translate(tuple(low)))

    @classmethod
    def prism(cls, region: Region, z_low_mm: float, z_high_mm: float, *, slices: int = 1) -> Solid:
        """Return a plane region extruded from ``z_low_mm`` to ``z_high_mm``, its walls in ``slices`` rings.

        A long slender body that lies slantwise wants slices: booleans compare the boxes around its triangles,
        and those of facets from end to end enclose half the crank.
        """
        if region.is_empty:
            return cls.nothing()
        body = m3.Manifold.extrude(region.section, z_high_mm - z_low_mm, slices - 1)
        return cls(body.translate((0.0, 0.0, z_low_mm)))

    @classmethod
    def lofted(cls, low: Array, high: Array, z_low_mm: float, z_high_mm: float) -> Solid:
        """Return the body between two outlines (k, 2), counter-clockwise, corner k above corner k."""
        count = len(low)
        vertices = np.concatenate(
            [
                np.column_stack([low, np.full(count, z_low_mm)]),
                np.column_stack([high, np.full(count, z_high_mm)]),
            ]
        )
        here = np.arange(count)
        following = np.roll(here, -1)
        walls = np.concatenate(
            [
                np.column_stack([here, following, following + count]),
                np.column_stack([here, following + count, here + count]),
            ]
        )
        lids = np.concatenate([triangulated(low)[:, ::-1], triangulated(high) + count])
        return cls.from_mesh(Mesh(vertices, np.concatenate([walls, lids])))

    @classmethod
    def revolved(cls, profile_rz_mm: Array, segments: int) -> Solid:
        """Return the body that a closed (r, z) outline (k, 2), r ≥ 0, sweeps about the z axis."""
        outline = m3.CrossSection([np.asarray(profile_rz_mm, dtype=np.float64)], m3.FillRule.NonZero)
        return cls(m3.Manifold.revolve(outline, segments))

    def __reduce__(self) -> tuple[Callable[..., Solid], tuple[Any, ...]]:
        """Pickle the mesh: manifold3d's bodies stay in their process."""
        if self.is_empty:
            return Solid.nothing, ()
        return Solid.from_mesh, (self.mesh,)

    def to_plain(self) -> tuple[Mesh, float]:
        """Return the mesh and the volume [mm³], from which the same solid is made again."""
        return self.mesh, self.volume_mm3

    @classmethod
    def from_plain(cls, plain: tuple[Mesh, float]) -> Solid:
        """Return the solid of ``to_plain``; manifold3d builds its body when it is first cut.

        Its number is taken now: booleans list triangles by the numbers of their bodies, and the last digits
        of what is measured would depend on whether the crank or a tool was built first.
        """
        solid = cls.__new__(cls)
        solid._built, solid._id = None, int(m3.Manifold.reserve_ids(1))
        solid._mesh, solid._volume_mm3 = plain
        return solid

    @property
    def is_built(self) -> bool:
        """Whether manifold3d has built its body."""
        return self._built is not None

    @property
    def is_empty(self) -> bool:
        return self._built is not None and bool(self._built.is_empty())

    @property
    def volume_mm3(self) -> float:
        if self._volume_mm3 is None:
            self._volume_mm3 = float(self._body.volume())
        return self._volume_mm3

    @property
    def triangle_count(self) -> int:
        return len(self.mesh.triangles) if self._built is None else int(self._built.num_tri())

    @property
    def is_pinched(self) -> bool:
        """Whether parts of the mesh touch at vertices or edges: manifold3d gives each its own there."""
        used = np.zeros(len(self.mesh.vertices), dtype=bool)
        used[self.mesh.triangles] = True
        return int(self._body.num_vert()) != int(used.sum())

    @property
    def bounds(self) -> Array:
        """Smallest and largest coordinates (2, 3) [mm]."""
        if self._built is None:
            return self.mesh.bounds
        return np.asarray(self._built.bounding_box(), dtype=np.float64).reshape(2, 3)

    @property
    def mesh(self) -> Mesh:
        """The boundary as triangles, in double precision."""
        if self._mesh is None:
            assert self._built is not None  # one of the two was given
            raw = self._built.to_mesh64()
            self._mesh = Mesh(
                np.asarray(raw.vert_properties, dtype=np.float64)[:, :3],
                np.asarray(raw.tri_verts).view(np.int64),
            )
        return self._mesh

    def moments(self, density_g_mm3: float, frame: Array | None = None) -> Moments:
        """Return the mass moments, in ``frame`` (4, 4) if given; zero for the empty solid."""
        return Moments.zero() if self.is_empty else mesh_moments(self.mesh, density_g_mm3, frame)

    def __add__(self, other: Solid) -> Solid:
        return Solid(self._body + other._body)

    def __sub__(self, other: Solid) -> Solid:
        return Solid(self._body - other._body)

    def __and__(self, other: Solid) -> Solid:
        return Solid(self._body ^ other._body)

    def split(self, other: Solid) -> tuple[Solid, Solid]:
        """Return the parts inside and outside of the other solid, in one boolean."""
        inside, outside = self._body.split(other._body)
        return Solid(inside), Solid(outside)

    def gap_mm(self, other: Solid, most_mm: float) -> float:
        """Return the least distance to another solid, at most ``most_mm``; 0 where they touch or overlap."""
        return float(self._body.min_gap(other._body, most_mm))

    def moved(self, placement: Array) -> Solid:
        """Return the solid with the rigid motion ``placement`` (4, 4) applied."""
        return Solid(self._body.transform(np.ascontiguousarray(placement[:3, :], dtype=np.float64)))

    def above(self, z_mm: float) -> Solid:
        """Return the part with z ≥ ``z_mm``."""
        return self._trimmed((0.0, 0.0, 1.0), z_mm)

    def below(self, z_mm: float) -> Solid:
        """Return the part with z ≤ ``z_mm``."""
        return self._trimmed((0.0, 0.0, -1.0), -z_mm)

    def _trimmed(self, normal: tuple[float, float, float], offset_mm: float) -> Solid:
        # manifold3d makes a body of not-a-number where there is nothing to trim: its bounds are infinite
        return self if self.is_empty else Solid(self._body.trim_by_plane(normal, offset_mm))

    def section(self, z_mm: float) -> Region:
        return Region(self._body.slice(z_mm))

    def shadow(self) -> Region:
        """Return the projection along z."""
        return Region(self._body.project())

    def simplified(self, by_mm: float) -> Solid:
        """Return the solid with edges merged that are shorter than ``by_mm``; its surface moves by less."""
        return Solid(self._body.simplify(by_mm))

    def without_needles(self, by_mm: float) -> Solid:
        """Return the solid `simplified` as one: short edges between facets of its source solids go too."""
        return Solid(self._body.as_original().simplify(by_mm))

    def pieces(self) -> list[Solid]:
        """Return the connected bodies, each by itself."""
        return [Solid(body) for body in self._body.decompose()]

    def thicker_pieces(self, thickness_mm: float) -> list[Solid]:
        """Return the connected bodies of more volume than their own area times a thickness [mm].

        A boolean between near surfaces leaves thousands of flakes. They are recognised by sums over their
        facets and never become bodies.
        """
        mesh = self.mesh
        of_vertex, count = mesh.parts_at_vertices
        of_facet = of_vertex[mesh.triangles[:, 0]]
        volume = part_volumes(mesh, of_facet, count)
        area = np.bincount(of_facet, 0.5 * mesh.doubled_areas, count)
        nothing = 4.0 * np.finfo(float).eps * float(np.abs(mesh.vertices).max()) ** 3
        chosen = volume > np.maximum(thickness_mm * area, nothing)  # of collapsed facets both are rounding
        if not chosen.any():
            return []
        thicker = Mesh(mesh.vertices, mesh.triangles[chosen[of_facet]])
        again = self._whole(thicker, float(volume[chosen].sum()))
        if again is not None:
            return again.pieces()
        each = [
            self._taken_out(mesh.part(of_facet == number), float(volume[number]))
            for number in np.flatnonzero(chosen)
        ]
        found = [piece for piece in each if piece is not None]
        if len(found) == len(each):
            return found
        return [piece for piece in self.pieces() if piece.volume_mm3 > thickness_mm * piece.area_mm2]

    def _taken_out(self, part: Mesh, volume_mm3: float) -> Solid | None:
        """Return a connected body of this one, by its mesh and volume, None where it cannot be had alone.

        If it cannot be built again, it is sought among the few bodies around it. Of thousands of flakes each
        would take as long as all of the solid, together two minutes of a tessellated V6.
        """
        alone = self._whole(part, volume_mm3)
        if alone is not None:
            return alone
        low, high = part.bounds
        around = Solid.box(low - BESIDE_SHARE * (high - low), high + BESIDE_SHARE * (high - low))
        same = SAME_VOLUME * volume_mm3
        found = [each for each in (self & around).pieces() if abs(each.volume_mm3 - volume_mm3) <= same]
        return found[0] if len(found) == 1 else None

    def built_anew(self) -> Solid | None:
        """Return the solid built from its triangles, free of earlier films; None where metal goes."""
        return None if self.is_empty else self._whole(self.mesh, self.volume_mm3)

    @property
    def area_mm2(self) -> float:
        return float(self._body.surface_area())


def union(solids: Sequence[Solid]) -> Solid:
    """Return the union of the solids; overlaps count once."""
    if len(solids) == 1:
        return solids[0]
    return Solid(m3.Manifold.batch_boolean([solid._body for solid in solids], m3.OpType.Add))


def _status_name(body: m3.Manifold) -> str:
    return str(body.status()).rpartition(".")[2]


# Number of threads that booleans use.


SEGMENTS = 128
"""A sphere of so many segments is large enough for the kernel to ask how many threads it may have."""


def booleans_in_one_thread() -> None:
    """Limit booleans to this thread, in a process that is one of many; call before the first of them.

    The kernel has no setting for it: it asks the system once, at its first large solid, how many cores the
    process may use. So it asks while this process may use one. Where a process cannot be kept to a core
    (outside Linux) nothing changes.
    """
    import manifold3d as m3

    with suppress(AttributeError, OSError):
        cores = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {min(cores)})
        try:
            m3.Manifold.sphere(1.0, SEGMENTS).volume()
        finally:
            os.sched_setaffinity(0, cores)
