"""Offset of planar faces inward: the shoulder is ground or milled lower.

A face is a largest connected set of triangles on one plane. Lowering it by a depth removes the metal between
the old plane and the new one that hangs together with the face, except under what stands on the face (a
journal, collar, fillet or pin keeps its footprint). Neighbours that lean are trimmed by the new plane, so the
removed cross-section changes with depth; where it would jump, the depth ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from autobalance.correction.curve import DepthCurve
from autobalance.correction.kind import Array, Correction, Offer, SharedDepth, Workpiece
from autobalance.correction.layer import BACKWARD, FaceLayer, Layer, moments_of
from autobalance.correction.lowering import lowering
from autobalance.crank.anatomy import Anatomy, Face, Web
from autobalance.errors import CorrectionError
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Region, Solid
from autobalance.solid.csg.tool import Tool, wedge
from autobalance.solid.mesh.mesh import Mesh

FacePoint = tuple[float, float, float]

ROUNDING_SHARE = 1e-6
"""Lengths below this share of the part's diagonal are rounding, not shape (float32 keeps 6e-8 of it)."""
DEFAULT_WALL_SHARE = 0.25
"""Metal left behind a face when the job names no ``min_wall_mm``, as a share of the web's width (ours)."""


@dataclass(frozen=True)
class ShoulderLimits:
    """What a job asks of shoulder corrections.

    Attributes
    ----------
    faces : "auto" or tuple
        Ids of faces, or points in file coordinates [mm], one on each face.
    sector_deg : (float, float) or None
        Only this part of each face: angles about the crank axis, rotor frame [deg].
    max_depth_mm : float or None
    same_depth : bool
        One depth for all faces.
    min_wall_mm : float or None
        Metal to leave, from every point of the new face along −n to the next surface [mm]; default a quarter
        of the web's width.
    depth_step_mm : float
        Step in which the machine sets the depth; 0: any depth [mm].
    """

    faces: Literal["auto"] | tuple[str | FacePoint, ...] = "auto"
    sector_deg: tuple[float, float] | None = None
    max_depth_mm: float | None = None
    same_depth: bool = False
    min_wall_mm: float | None = None
    depth_step_mm: float = 0.0


@dataclass(frozen=True, eq=False)
class Patch:
    """A face and the part of space, if not all, to which a cut of it keeps (rotor frame).

    ``wedge`` is ``within`` without facets.
    """

    face: Face
    within: Solid | None = None
    wedge: Shape | None = None


EFFORTS = 3
"""How many ever wider sets of faces ``faces = "auto"`` can offer."""


def offer(work: Workpiece, limits: ShoulderLimits, effort: int) -> Offer:
    """Return the cuts that a job's limits allow; more of them with more ``effort`` (from 0)."""
    mesh = work.solid.mesh
    if limits.faces == "auto":
        patches = auto_patches(mesh, work.anatomy, work.faces, work.heavy_at, limits, effort)
    else:
        patches = chosen_patches(limits, mesh, work.anatomy, work.faces)
    worth = sum(_worth_g_mm_per_mm(patch, work) for patch in patches)
    reach = work.look * LOOK_AHEAD * work.need_g_mm / worth if worth > 0.0 else math.inf
    found = cuts(work.solid, work.anatomy, patches, work.density_g_mm3, limits, min(reach, mesh.diagonal_mm))
    return Offer(tuple(found), tuple(shared_depths(found, work.anatomy, limits)), limits.same_depth)


LOOK_AHEAD = 1.5
"""How much deeper to look than the faces' first worth says is needed: drafts and sectors change it."""


def _worth_g_mm_per_mm(patch: Patch, work: Workpiece) -> float:
    heavy = _heavy_direction(work.heavy_at, float(patch.face.centroid_mm[2]))
    if heavy is None:
        return 0.0
    return work.density_g_mm3 * _half_plane_worth(work.solid.mesh, work.anatomy, patch.face, heavy)[0]


# --- where -------------------------------------------------------------------------------------------------


def chosen_patches(
    limits: ShoulderLimits, mesh: Mesh, anatomy: Anatomy, faces: Sequence[Face]
) -> list[Patch]:
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
    reach = _reach_mm(mesh, anatomy)
    return [_patch(face, limits.sector_deg, reach) for face in picked]


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
    limits: ShoulderLimits,
    effort: int,
) -> list[Patch]:
    """Return the web faces that suit, each kept to the side that is too heavy, beyond the crank axis.

    Parameters
    ----------
    mesh, anatomy, faces
        The crank; faces in the rotor frame.
    heavy_at : sequence of (float, (2,) float)
        Heavy direction at two places along the axis; between them it is interpolated.
    limits : ShoulderLimits
        ``sector_deg`` takes the place of the heavy side.
    effort : int
        0: of each web the face whose metal stands farthest out, among those worth at least ``WORTHWHILE`` of
        the web's best; 1: every face of some worth; 2: the same, each in two halves with their own depths,
        left and right of the heavy direction.

    Returns
    -------
    list of Patch
    """
    reach = _reach_mm(mesh, anatomy)
    offers: list[tuple[Face, float, float, list[Patch]]] = []
    for face in faces:
        if face.kind != "plane" or face.web is None or abs(face.normal[2]) < AXIAL:
            continue
        heavy = _heavy_direction(heavy_at, float(face.centroid_mm[2]))
        if heavy is None:
            continue
        heavy = _snapped(heavy, anatomy, face)
        worth, area, spans = _half_plane_worth(mesh, anatomy, face, heavy)
        patches = [_patch(face, limits.sector_deg, reach)]
        angle = math.degrees(math.atan2(heavy[1], heavy[0]))
        if limits.sector_deg is None and spans:
            patches = [_patch(face, (angle - 90.0, angle + 90.0), reach)]
        if effort >= 2 and limits.sector_deg is None:
            halves = (angle - 90.0, angle), (angle, angle + 90.0)
            patches = [_patch(face, half, reach) for half in halves]
        if worth > 0.0 and area > 0.0:
            offers.append((face, worth, worth / area, patches))
    if not offers:
        return []
    best = max(worth for _, worth, _, _ in offers)
    offers = [offer for offer in offers if offer[1] >= SOME_WORTH * best]
    if effort == 0:
        offers = _farthest_out_of_each_web(offers)
    return [patch for *_, patches in offers for patch in patches]


WORTHWHILE = 0.3
SOME_WORTH = 0.05
AXIAL = 0.7
"""A web face looks along the axis when its normal has at least this component along it."""
SNAP_DEG = 10.0
"""A heavy direction this close to a crankpin's direction, or its opposite, is taken as just that."""
STRAY_SHARE = 0.02
"""A face with less than this share of its area on the light side is cut whole."""


def _farthest_out_of_each_web(
    offers: Sequence[tuple[Face, float, float, list[Patch]]],
) -> list[tuple[Face, float, float, list[Patch]]]:
    chosen = []
    for web in sorted({offer[0].web for offer in offers if offer[0].web is not None}):
        of_web = [offer for offer in offers if offer[0].web == web]
        most = max(offer[1] for offer in of_web)
        chosen.append(
            max((offer for offer in of_web if offer[1] >= WORTHWHILE * most), key=lambda offer: offer[2])
        )
    return chosen


def _heavy_direction(heavy_at: Sequence[tuple[float, Array]], z_mm: float) -> Array | None:
    (z0, u0), (z1, u1) = heavy_at
    share = min(max((z_mm - z0) / (z1 - z0), 0.0), 1.0) if z1 != z0 else 0.0
    vector = (1.0 - share) * u0 + share * u1
    length = math.hypot(*vector)
    scale = max(math.hypot(*u0), math.hypot(*u1))
    return vector / length if length > 1e-6 * scale else None


def _snapped(heavy: Array, anatomy: Anatomy, face: Face) -> Array:
    throw = min(
        anatomy.throws, key=lambda throw: abs(float(throw.crankpin.centre_mm[2] - face.centroid_mm[2]))
    )
    along = float(heavy @ throw.direction)
    if abs(along) >= math.cos(math.radians(SNAP_DEG)):
        return math.copysign(1.0, along) * throw.direction
    return heavy


def _half_plane_worth(
    mesh: Mesh, anatomy: Anatomy, face: Face, direction: Array
) -> tuple[float, float, bool]:
    """Return first moment and area, as seen along z, of the part of a face on the side of ``direction`` (2,).

    Triangles count whole, by their centroid; the third value tells whether the face reaches over to the other
    side by more than a stray.
    """
    frame = anatomy.file_to_rotor
    areas = 0.5 * abs(float(face.normal[2])) * mesh.doubled_areas.take(face.triangles)
    out = mesh.vertices @ (direction @ frame[:2, :3]) + direction @ frame[:2, 3]
    lever = out.take(mesh.triangles.take(face.triangles, axis=0)) @ np.full(3, 1.0 / 3.0)
    side = lever > 0.0
    other = float(areas[~side].sum())
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
    return Patch(face, sector(angles_deg, reach_mm), exact)


def sector(angles_deg: tuple[float, float], reach_mm: float) -> Solid:
    """Return the wedge between two angles about the crank axis, counter-clockwise from the first [deg]."""
    start, end = angles_deg
    span = (end - start) % 360.0 or 360.0
    angles = np.radians(start + np.linspace(0.0, span, max(2, math.ceil(span / 45.0) + 1)))
    arc = 2.0 * reach_mm * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    outline = arc[:-1] if span == 360.0 else np.concatenate([np.zeros((1, 2)), arc])
    return Solid.prism(Region.of([outline]), -2.0 * reach_mm, 2.0 * reach_mm)


def _reach_mm(mesh: Mesh, anatomy: Anatomy) -> float:
    """Return a distance from the rotor's origin that no point of the crank exceeds."""
    frame = anatomy.file_to_rotor
    centre = mesh.bounds.mean(axis=0)
    return float(np.linalg.norm(frame[:3, :3] @ centre + frame[:3, 3])) + mesh.diagonal_mm


# --- the face's own frame -----------------------------------------------------------------------------------


def face_frame(normal: Array) -> Array:
    """Return a rotation (4, 4) from the rotor frame that turns ``normal`` to +z."""
    n = np.asarray(normal, dtype=np.float64) / np.linalg.norm(normal)
    helper = np.eye(3)[int(np.argmin(np.abs(n)))]
    x = helper - (helper @ n) * n
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(n, x), n])
    return frame


def face_region(mesh: Mesh, anatomy: Anatomy, face: Face, to_face: Array) -> Region:
    """Return a face's outline as a region in its own frame, from the edges that only one triangle has."""
    triangles = mesh.triangles.take(face.triangles, axis=0)
    tail, head = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    count = len(mesh.vertices)
    edge = 2 * (np.minimum(tail, head) * count + np.maximum(tail, head)) + (tail > head)
    edge.sort()  # an edge and its twin stand side by side
    differs = np.diff(edge // 2, prepend=-1, append=-1) != 0
    alone = edge[differs[:-1] & differs[1:]]
    rim = np.stack(np.divmod(alone // 2, count), axis=1)
    rim[alone % 2 == 1] = rim[alone % 2 == 1, ::-1]
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


# --- the cut ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ShoulderCut:
    """The lowering of one face, of which only the depth is open; implements ``correction.kind.Cut``."""

    face: Face
    to_face: Array
    top_mm: float
    layer: FaceLayer
    heights_mm: Array
    within: Solid | None
    wedge: Shape | None
    density_g_mm3: float
    max_depth_mm: float
    limit: str
    limit_is_reach: bool
    depth_step_mm: float
    least_depth_mm: float = 0.0
    kind: str = "shoulder"
    adds_metal: bool = False

    @property
    def label(self) -> str:
        """Short name for messages."""
        return f"face {self.face.id}"

    @property
    def height_mm(self) -> float:
        """Height of the face along its normal, from the rotor's origin [mm]."""
        return self.layer.height_mm

    @cached_property
    def _to_rotor(self) -> Array:
        back = np.eye(4)
        back[:3, :3] = self.to_face[:3, :3].T
        return back

    @cached_property
    def _curve(self) -> DepthCurve:
        return self.layer.curve(self.max_depth_mm, self.height_mm - self.heights_mm)

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the crank's moments, rotor frame."""
        return self._change(self._curve.integral(depth_mm))

    def rate(self, depth_mm: float) -> Moments:
        """Return d effect / d depth = −ρ ∫ (1, r, r rᵀ) dA over the new face, rotor frame."""
        return self._change(self._curve.value(depth_mm))

    def _change(self, section: Array) -> Moments:
        return moments_of(section).moved(self._to_rotor).scaled(-self.density_g_mm3)

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return nothing: no other metal is put in."""
        return Moments.zero()

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to subtract, rotor frame: a prism from the new face to just above the old one."""
        self.effect(depth_mm)  # has looked at sections down to here
        room = self.layer.room - self.layer.spared(depth_mm)
        body = _prism(room, self.height_mm - depth_mm, self.top_mm).moved(self._to_rotor)
        return body if self.within is None else body & self.within

    def exact_tool(self, depth_mm: float) -> Tool:
        """Return the lowering without facets; what stands on the face is the exact solid's to tell."""
        self.effect(depth_mm)  # has looked at sections down to here
        return lowering(self.layer, depth_mm, self._to_rotor, self.wedge)

    def correction(self, depth_mm: float) -> Correction:
        """Return what the report lists."""
        change = self.effect(depth_mm)
        return Correction(
            kind=self.kind,
            face=self.face.id,
            web=self.face.web,
            position_mm=change.centre_mm,
            depth_mm=depth_mm,
            change=change,
            removed_volume_mm3=-change.mass_g / self.density_g_mm3,
            details={
                "normal": [float(value) for value in self.face.normal],
                "face_height_mm": self.height_mm,
                "new_height_mm": self.height_mm - depth_mm,
                "new_face_area_mm2": self.layer.kept(depth_mm).area_mm2,
            },
        )


NEAR_HOLES = 0.05
"""Margin of the box around a room's holes, as a share of the box's size."""


def _prism(room: Region, low_mm: float, high_mm: float) -> Solid:
    """Return the prism over a room, its caps divided around the holes.

    Triangles that reach from a finely drawn hole to the far corners of the room are long slivers; a boolean
    compares the box around each with every edge of the crank in it, which made the cut half as slow again.
    """
    holes = Region.rectangle(*room.bounds.tolist()) - room
    if holes.is_empty:
        return Solid.prism(room, low_mm, high_mm)
    low, high = holes.bounds
    margin = NEAR_HOLES * (high - low)
    near = Region.rectangle((low - margin).tolist(), (high + margin).tolist())
    return Solid.prism(room & near, low_mm, high_mm) + Solid.prism(room - near, low_mm, high_mm)


def cuts(
    solid: Solid,
    anatomy: Anatomy,
    patches: Sequence[Patch],
    density_g_mm3: float,
    limits: ShoulderLimits,
    reach_mm: float,
) -> list[ShoulderCut]:
    """Set up the cuts of faces, each with its limits measured on the solid.

    Parameters
    ----------
    solid : Solid
        The crank in file coordinates.
    anatomy : Anatomy
    patches : sequence of Patch
        The faces, and where on them.
    density_g_mm3 : float
    limits : ShoulderLimits
    reach_mm : float
        How deep to look at most; a cut whose limit is only this says so in ``limit_is_reach``.

    Returns
    -------
    list of ShoulderCut
        One a patch, in the same order; patches with no metal to take are left out.
    """
    found = (_cut(patch, solid.mesh, anatomy, density_g_mm3, limits, reach_mm) for patch in patches)
    return [cut for cut in found if cut is not None]


CLEARANCE = 5.0
"""Grains between what stands on a face and the tool: it keeps clear of the fillet, and its outline needs no
more corners than that (a few µm on a crank of 150 mm; the ring of metal left weighs milligrams)."""


def _cut(
    patch: Patch,
    mesh: Mesh,
    anatomy: Anatomy,
    density_g_mm3: float,
    limits: ShoulderLimits,
    reach_mm: float,
) -> ShoulderCut | None:
    face = patch.face
    height, to_face = float(face.normal @ face.centroid_mm), face_frame(face.normal)
    grain = max(ROUNDING_SHARE * mesh.diagonal_mm, 4.0 * face.spread_mm)
    wall = _wall_mm(face, anatomy, limits)
    looked = reach_mm if limits.max_depth_mm is None else min(reach_mm, limits.max_depth_mm)
    low, high = height - looked - wall - grain, height + 2.0 * grain
    slab = Layer.of(mesh, to_face @ anatomy.file_to_rotor, low, high, grain)
    standing = slab.section(height + grain).grown(CLEARANCE * grain).simplified(0.5 * CLEARANCE * grain)
    size = _reach_mm(mesh, anatomy)
    layer = FaceLayer(
        slab.section,
        height,
        face_region(mesh, anatomy, face, to_face),
        Region.rectangle([-size, -size], [size, size]) - standing,
        None if patch.within is None else patch.within.moved(to_face),
        grain,
    )
    if layer.kept(grain).is_empty:
        return None
    depth, limit, is_reach = _depth_limit(layer, slab, looked, wall, limits)
    if depth <= 2.0 * grain:
        return None
    return ShoulderCut(
        face=face,
        to_face=to_face,
        top_mm=height + 3.0 * grain,
        layer=layer,
        heights_mm=slab.vertices[:, 2],
        within=patch.within,
        wedge=patch.wedge,
        density_g_mm3=density_g_mm3,
        max_depth_mm=depth,
        limit=limit,
        limit_is_reach=is_reach,
        depth_step_mm=limits.depth_step_mm,
    )


def _depth_limit(
    layer: FaceLayer, slab: Layer, looked_mm: float, wall_mm: float, limits: ShoulderLimits
) -> tuple[float, str, bool]:
    """Return the greatest depth, what ends it, and whether that is only how far was looked."""
    depth, limit, is_reach = looked_mm, "how far was looked", True
    if limits.max_depth_mm is not None and limits.max_depth_mm <= looked_mm:
        limit, is_reach = f"max_depth_mm = {limits.max_depth_mm:g}", False
    step = layer.step_depth_mm(slab, depth)
    if step is not None:
        depth, limit, is_reach = (
            step - layer.grain_mm,
            "the height of the shoulder over the next plane",
            False,
        )
    merge = layer.merge_depth_mm(slab, depth)
    if merge is not None:
        depth, limit, is_reach = merge - layer.grain_mm, "another raised part beside the face", False
    back = layer.back_height_mm(slab, layer.height_mm - depth - wall_mm, depth)
    if back is not None and layer.height_mm - back - wall_mm < depth:
        depth = layer.height_mm - back - wall_mm
        limit, is_reach = f"the wall of {wall_mm:.3g} mm behind it", False
    return depth, limit, is_reach


def _wall_mm(face: Face, anatomy: Anatomy, limits: ShoulderLimits) -> float:
    if limits.min_wall_mm is not None:
        return limits.min_wall_mm
    web: Web | None = next((web for web in anatomy.webs if web.number == face.web), None)
    return 0.0 if web is None else DEFAULT_WALL_SHARE * (web.z_max_mm - web.z_min_mm)


def shared_depths(cuts: Sequence[ShoulderCut], anatomy: Anatomy, limits: ShoulderLimits) -> list[SharedDepth]:
    """Return what two cuts on opposite faces of one web may take together, wall left between them."""
    shared = []
    for i, one in enumerate(cuts):
        for j in range(i + 1, len(cuts)):
            other = cuts[j]
            facing = float(one.face.normal @ other.face.normal)
            if one.face.web is None or one.face.web != other.face.web or facing > BACKWARD:
                continue
            metal = one.height_mm + other.height_mm - _wall_mm(one.face, anatomy, limits)
            shared.append(SharedDepth(i, j, max(metal, 0.0)))
    return shared
