"""Patches of faces to be worked, and the metal under them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, Annotated, Literal
from weakref import WeakKeyDictionary

import numpy as np

from autobalance.correction.contract import Limits
from autobalance.correction.faces.layer import Layer
from autobalance.correction.relaxing import STEP
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.declare import NOT_NEGATIVE, POSITIVE
from autobalance.errors import CorrectionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import wedge
from autobalance.solid.mesh.adjacency import rim_of
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.correction.kind import Workpiece


# Patches of faces to be worked: those that a job names, or those on the side to be changed.


FacePoint = tuple[float, float, float]
HeavyAt = Sequence[tuple[float, Array]]
"""Heavy vector (2,) at places along the axis."""

ROUNDING_SHARE = 1e-6
"""Lengths below this share of the part's diagonal are rounding, not shape (float32 keeps 6e-8 of it)."""


@dataclass(frozen=True)
class FaceLimits(Limits):
    """Limits of kinds whose cuts begin at faces; each kind explains its keys."""

    faces: Literal["auto"] | tuple[str | FacePoint, ...] = "auto"
    sector_deg: tuple[float, float] | None = None
    max_depth_mm: Annotated[float | None, POSITIVE] = None
    same_depth: bool = False
    min_wall_mm: Annotated[float | None, NOT_NEGATIVE] = None
    depth_step_mm: Annotated[float, STEP] = 0.0
    min_step_mm: Annotated[float, NOT_NEGATIVE] = 0.05


@dataclass(frozen=True, eq=False)
class Patch:
    """A face and the part of space, if not all, to which a cut of it keeps (rotor frame).

    ``wedge`` is ``within`` without facets, ``sector_deg`` its two angles about the crank axis, in [0, 360).
    """

    face: Face
    within: Solid | None = None
    wedge: Shape | None = None
    sector_deg: tuple[float, float] | None = None


def chosen_patches(limits: FaceLimits, mesh: Mesh, anatomy: Anatomy, faces: Sequence[Face]) -> list[Patch]:
    """Return the faces that a job names, by id or by a point on them.

    Raises
    ------
    CorrectionError
        If an id is unknown, a point lies on no planar face, or a face is named twice.
    """
    assert limits.faces != "auto"
    planes = [face for face in faces if face.kind == "plane"]
    picked = [
        _face_by_id(key, planes) if isinstance(key, str) else _face_at(key, mesh, anatomy, planes)
        for key in limits.faces
    ]
    for place, face in enumerate(picked):
        if face.id in [other.id for other in picked[:place]]:
            raise CorrectionError(f"correction faces name face {face.id} twice")
    if limits.sector_deg is None:
        return [Patch(face) for face in picked]
    reach = farthest_mm(mesh, anatomy)
    return [_patch(face, limits.sector_deg, reach) for face in picked]


def listed_patch(limits: FaceLimits, name: str, sector_deg: Sequence[float] | None, work: Workpiece) -> Patch:
    """Return the patch of a listed cut: a face by its id, and the part of it between two angles.

    Parameters
    ----------
    limits : FaceLimits
        Faces and sector that the cut may not leave.
    name : str
        Id of the face.
    sector_deg : (float, float) or None
        The part; None: the whole face.
    work : Workpiece

    Raises
    ------
    CorrectionError
        If the face is not on this crank or none of the job's, or the part leaves the job's sector.
    """
    face = _face_by_id(name, [each for each in work.faces if each.kind == "plane"])
    if limits.faces != "auto":
        may = chosen_patches(replace(limits, sector_deg=None), work.solid.mesh, work.anatomy, work.faces)
        if name not in [each.face.id for each in may]:
            raise CorrectionError(f"face {name} is none of faces: {', '.join(each.face.id for each in may)}")
    if limits.sector_deg is not None:
        low, high = limits.sector_deg
        span = (high - low) % 360.0 or 360.0
        start, end = sector_deg or (0.0, 360.0)
        part, begins = (end - start) % 360.0 or 360.0, (start - low + SAME_DEG) % 360.0
        if span < 360.0 and begins + part > span + 2.0 * SAME_DEG:
            raise CorrectionError(f"its part of the face leaves sector_deg = [{low:g}, {high:g}]")
    if sector_deg is None:
        return Patch(face)
    return _patch(face, (sector_deg[0], sector_deg[1]), farthest_mm(work.solid.mesh, work.anatomy))


SAME_DEG = 1e-6
"""Angle up to which two ends of sectors are one: rounding."""


def share_a_part(one: Patch, other: Patch) -> bool:
    """Return whether two patches have a part of one face in common."""
    if one.face.id != other.face.id:
        return False
    if one.sector_deg is None or other.sector_deg is None:
        return True
    low, high = one.sector_deg
    start, end = other.sector_deg
    spans = (high - low) % 360.0 or 360.0, (end - start) % 360.0 or 360.0
    return (start - low) % 360.0 < spans[0] - SAME_DEG or (low - start) % 360.0 < spans[1] - SAME_DEG


def _face_by_id(name: str, planes: Sequence[Face]) -> Face:
    for face in planes:
        if face.id == name:
            return face
    known = ", ".join(face.id for face in planes[:12]) + (", ..." if len(planes) > 12 else "")
    raise CorrectionError(f"correction face {name!r} is not on this crank; its faces are {known}")


def _face_at(point: FacePoint, mesh: Mesh, anatomy: Anatomy, planes: Sequence[Face]) -> Face:
    frame = anatomy.file_to_rotor
    place = frame[:3, :3] @ np.asarray(point) + frame[:3, 3]
    slack = max(1e-2, ROUNDING_SHARE * mesh.diagonal_mm)
    nearest = math.inf
    for face in planes:
        off_plane = abs(float(face.normal @ (place - face.centroid_mm)))
        if off_plane > slack + face.spread_mm:
            nearest = min(nearest, off_plane)
            continue
        to_face = face_frame(face.normal)
        x, y, _ = to_face[:3, :3] @ place
        outline = face_region(mesh, anatomy, face, to_face).grown(slack)
        if not (outline & Region.rectangle([x - 1e-6, y - 1e-6], [x + 1e-6, y + 1e-6])).is_empty:
            return face
    text = ", ".join(f"{value:g}" for value in point)
    hint = f"; the nearest plane is {nearest:.3g} mm away" if math.isfinite(nearest) else ""
    raise CorrectionError(f"correction face point [{text}] mm lies on no planar face{hint}")


def auto_patches(
    mesh: Mesh,
    anatomy: Anatomy,
    faces: Sequence[Face],
    heavy_at: Sequence[tuple[float, Array]],
    limits: FaceLimits,
    search_level: int,
) -> list[Patch]:
    """Return patches of suitable web faces, each kept to the heavy side, beyond the crank axis.

    Parameters
    ----------
    mesh, anatomy, faces
        The crank; faces in the rotor frame.
    heavy_at : sequence of (float, (2,) float)
        Heavy direction at two places along the axis; between them it is interpolated.
    limits : FaceLimits
        ``sector_deg`` takes the place of the heavy side.
    search_level : int
        0: the face of each web whose metal is farthest out, among those worth at least ``WORTH_SHARE`` of the
        web's best. 1: every face of some worth. 2: the same, each in two halves with separate depths, left
        and right of the heavy direction.

    Returns
    -------
    list of Patch
    """
    reach = farthest_mm(mesh, anatomy)
    offers: list[tuple[Face, float, float, list[Patch]]] = []
    for face in faces:
        if face.kind != "plane" or face.web is None or abs(face.normal[2]) < MIN_AXIAL_COMPONENT:
            continue
        heavy = heavy_direction(heavy_at, float(face.centroid_mm[2]))
        if heavy is None:
            continue
        heavy = _snapped(heavy, anatomy, face)
        worth, area, spans = half_plane_worth(mesh, anatomy, face, heavy)
        patches = [_patch(face, limits.sector_deg, reach)]
        angle = math.degrees(math.atan2(heavy[1], heavy[0]))
        if limits.sector_deg is None and spans:
            patches = [_patch(face, (angle - 90.0, angle + 90.0), reach)]
        if search_level >= 2 and limits.sector_deg is None:
            halves = (angle - 90.0, angle), (angle, angle + 90.0)
            patches = [_patch(face, half, reach) for half in halves]
        if worth > 0.0 and area > 0.0:
            offers.append((face, worth, worth / area, patches))
    if not offers:
        return []
    best = max(worth for _, worth, _, _ in offers)
    offers = [each for each in offers if each[1] >= SOME_WORTH * best]
    if search_level == 0:
        offers = _farthest_out_of_each_web(offers)
    return [patch for *_, patches in offers for patch in patches]


WORTH_SHARE = 0.3
SOME_WORTH = 0.05
MIN_AXIAL_COMPONENT = 0.7
"""A web face looks along the axis when its normal has at least this component along it."""
SNAP_DEG = 10.0
"""A heavy direction this close to a crankpin's direction, or its opposite, is taken as just that."""
STRAY_SHARE = 0.02
"""A face with less than this share of its area on the light side is cut whole."""


def _farthest_out_of_each_web(
    offers: Sequence[tuple[Face, float, float, list[Patch]]],
) -> list[tuple[Face, float, float, list[Patch]]]:
    chosen = []
    for web in sorted({each[0].web for each in offers if each[0].web is not None}):
        of_web = [each for each in offers if each[0].web == web]
        most = max(each[1] for each in of_web)
        chosen.append(
            max(
                (each for each in of_web if each[1] >= WORTH_SHARE * most),
                key=lambda each: round(each[2], 9),  # of equals the first
            )
        )
    return chosen


def heavy_vector(heavy_at: HeavyAt, z_mm: float) -> Array:
    """Return the heavy vector (2,) at a place along the axis, between the two that are known."""
    (z0, u0), (z1, u1) = heavy_at
    share = min(max((z_mm - z0) / (z1 - z0), 0.0), 1.0) if z1 != z0 else 0.0
    return np.asarray((1.0 - share) * u0 + share * u1)


def heavy_direction(heavy_at: Sequence[tuple[float, Array]], z_mm: float) -> Array | None:
    """Return the unit vector (2,) of the heavy side at a place along the axis; None without one."""
    vector = heavy_vector(heavy_at, z_mm)
    length = math.hypot(*vector)
    scale = max(math.hypot(*u) for _, u in heavy_at)
    return vector / length if length > 1e-6 * scale else None


def _snapped(heavy: Array, anatomy: Anatomy, face: Face) -> Array:
    throw = min(
        anatomy.throws,
        key=lambda throw: round(abs(float(throw.crankpin.centre_mm[2] - face.centroid_mm[2])), 6),
    )
    along = float(heavy @ throw.direction)
    if abs(along) >= math.cos(math.radians(SNAP_DEG)):
        return math.copysign(1.0, along) * throw.direction
    return heavy


def half_plane_worth(mesh: Mesh, anatomy: Anatomy, face: Face, direction: Array) -> tuple[float, float, bool]:
    """Return first moment and area, as seen along z, of the part of a face on the side of ``direction`` (2,).

    Triangles count whole, by their centroid; the third value is whether the face reaches over to the other
    side by more than a stray.
    """
    frame = anatomy.file_to_rotor
    areas = 0.5 * abs(float(face.normal[2])) * mesh.doubled_areas.take(face.triangles)
    out = mesh.vertices @ (direction @ frame[:2, :3]) + direction @ frame[:2, 3]
    lever = out.take(mesh.triangles.take(face.triangles, axis=0)) @ np.full(3, 1.0 / 3.0)
    near = ROUNDING_SHARE * mesh.diagonal_mm
    side = lever > near  # on the line itself: on neither
    other = float(areas[lever < -near].sum())
    return (
        float(areas[side] @ lever[side]),
        float(areas[side].sum()),
        other > STRAY_SHARE * float(areas.sum()),
    )


def _patch(face: Face, angles_deg: tuple[float, float] | None, reach_mm: float) -> Patch:
    """Return a face kept to the wedge between two angles; None: all of it."""
    if angles_deg is None:
        return Patch(face)
    span = (angles_deg[1] - angles_deg[0]) % 360.0
    exact = wedge(math.radians(angles_deg[0]), math.radians(span), reach_mm) if span else None
    start, end = map(wrapped_deg, angles_deg)
    return Patch(face, sector(angles_deg, reach_mm), exact, (start, end))


def sector(angles_deg: tuple[float, float], reach_mm: float) -> Solid:
    """Return the wedge between two angles about the crank axis, counter-clockwise from the first [deg]."""
    start, end = angles_deg
    span = (end - start) % 360.0 or 360.0
    angles = np.radians(start + np.linspace(0.0, span, max(2, math.ceil(span / 45.0) + 1)))
    arc = 2.0 * reach_mm * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    outline = arc[:-1] if span == 360.0 else np.concatenate([np.zeros((1, 2)), arc])
    return Solid.prism(Region.of([outline]), -2.0 * reach_mm, 2.0 * reach_mm)


def strip_along(angle_deg: float, reach_mm: float, aside_mm: float) -> Solid:
    """Return the room within ``aside_mm`` of the half-plane at an angle about the crank axis."""
    angle = math.radians(angle_deg)
    along = 2.0 * reach_mm * np.array([math.cos(angle), math.sin(angle)])
    across = aside_mm * np.array([-math.sin(angle), math.cos(angle)])
    corners = np.array([-across, along - across, along + across, across])
    return Solid.prism(Region.of([corners]), -2.0 * reach_mm, 2.0 * reach_mm)


def farthest_mm(mesh: Mesh, anatomy: Anatomy) -> float:
    """Return a distance from the rotor's origin that no point of the crank exceeds."""
    frame = anatomy.file_to_rotor
    centre = mesh.bounds.mean(axis=0)
    return float(np.linalg.norm(frame[:3, :3] @ centre + frame[:3, 3])) + mesh.diagonal_mm


# --- the face's own frame -----------------------------------------------------------------------------------


def face_frame(normal: Array) -> Array:
    """Return a rotation (4, 4) from the rotor frame that turns ``normal`` to +z."""
    n = np.asarray(normal, dtype=np.float64) / np.linalg.norm(normal)
    helper = np.eye(3)[int(np.argmin(np.round(np.abs(n), 9)))]
    x = helper - (helper @ n) * n
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(n, x), n])
    return frame


def face_region(mesh: Mesh, anatomy: Anatomy, face: Face, to_face: Array) -> Region:
    """Return a face's outline as a region in its own frame, from the edges that only one triangle has."""
    rim = rim_of(mesh, face.triangles)
    frame = to_face @ anatomy.file_to_rotor
    following: dict[int, list[int]] = {}
    for a, b in rim.tolist():
        following.setdefault(a, []).append(b)
    outlines = []
    while following:
        start, ends = next(iter(following.items()))
        loop, here = [start], start
        while (ends := following.get(here, [])) != []:
            nxt = ends.pop()
            if not ends:
                del following[here]
            if nxt == start:
                break
            loop.append(nxt)
            here = nxt
        placed = mesh.vertices[loop] @ frame[:3, :3].T + frame[:3, 3]
        outlines.append(placed[:, :2])
    return Region.of(outlines)


# Metal under a planar face, kept: its parts and sectors are cut from the same sections.


# Needed by cranks of 260 000 triangles, where each part of a face cut the same sections anew.


CLEARANCE = 5.0
"""Grains between metal on a face and the tool. The tool keeps clear of the fillet, and its outline needs no
more corners than that (a few µm on a crank of 150 mm; the ring of metal left weighs milligrams)."""
FACES_KEPT = 16
"""Faces of a mesh that are remembered: about as many as are offered together."""


@dataclass(frozen=True, eq=False)
class UnderFace:
    """The metal under a face, in the face's frame.

    Attributes
    ----------
    slab : Layer
        The triangles down to the end of the search.
    outline : Region
        The face itself.
    standing : Region
        Area closed to the tool: what is on the face, with room around, and what that encloses.
    room : Region
        Area open to the tool: everywhere else.
    """

    slab: Layer
    outline: Region
    standing: Region
    room: Region
    _sections: dict[float, Region] = field(default_factory=dict)

    @classmethod
    def of(
        cls, mesh: Mesh, anatomy: Anatomy, face: Face, to_face: Array, down_to_mm: float, grain_mm: float
    ) -> UnderFace:
        """Return the metal from just above a face down to a height in its frame."""
        height = float(face.normal @ face.centroid_mm)
        frame = to_face @ anatomy.file_to_rotor
        slab = Layer.of(mesh, frame, down_to_mm, height + 2.0 * grain_mm, grain_mm)
        outline = face_region(mesh, anatomy, face, to_face)
        standing = slab.section(height + grain_mm).grown(CLEARANCE * grain_mm)
        standing = standing.simplified(0.5 * CLEARANCE * grain_mm)
        size = farthest_mm(mesh, anatomy)
        everywhere = Region.rectangle([-size, -size], [size, size])
        rooms = (everywhere - standing).pieces()
        if len(rooms) > 1:  # an oil hole in a journal, say, which no tool at the face gets to
            rooms = [room for room in rooms if not (room & outline).is_empty]
            standing = everywhere - Region.beside_each_other(rooms)
        return cls(slab, outline, standing, Region.beside_each_other(rooms))

    def section(self, height_mm: float) -> Region:
        """Return the solid's cross-section at a height within the slab."""
        if height_mm not in self._sections:
            self._sections[height_mm] = self.slab.section(height_mm)
        return self._sections[height_mm]


_Key = tuple[Face, bytes, float, float]
_SEEN: WeakKeyDictionary[Mesh, dict[_Key, UnderFace]] = WeakKeyDictionary()


def under_face(
    mesh: Mesh, anatomy: Anatomy, face: Face, to_face: Array, down_to_mm: float, grain_mm: float
) -> UnderFace:
    """Return the metal under a face; the kept one where the same depth was searched before."""
    seen = _SEEN.setdefault(mesh, {})
    key = (face, (to_face @ anatomy.file_to_rotor).tobytes(), down_to_mm, grain_mm)
    known = seen.get(key)
    if known is None:
        known = UnderFace.of(mesh, anatomy, face, to_face, down_to_mm, grain_mm)
        for oldest in list(seen)[: max(0, len(seen) - FACES_KEPT + 1)]:
            seen.pop(oldest, None)  # another thread may have done it
        seen[key] = known
    return known
