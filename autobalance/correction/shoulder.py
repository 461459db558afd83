"""Offset of planar faces inward: the shoulder is ground or milled lower.

A face is a largest connected set of triangles on one plane. Lowering it by a depth removes the metal between
the old plane and the new one that is connected to the face. A journal, collar, fillet or pin on the face
keeps its footprint. Neighbours that lean are trimmed by the new plane, so the removed cross-section changes
with depth; where it would jump, the depth ends.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

from autobalance.correction.contract import Correction, Envelope, Figures, Item, SharedDepth, drawn_out
from autobalance.correction.faces.cut import BESIDE_MM, FaceCut, FaceKind, lowering, part_name, patches_of
from autobalance.correction.faces.depth_limit import DepthLimit, clear_of_pins, depth_limit
from autobalance.correction.faces.layer import MAX_NORMAL_COMPONENT, DepthCurve, FaceLayer
from autobalance.correction.faces.patches import (
    ROUNDING_SHARE,
    FaceLimits,
    Patch,
    face_frame,
    half_plane_worth,
    heavy_direction,
    under_face,
)
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.machining import Operation, face_operation, loops_area_mm2, region_outline
from autobalance.correction.overlap import overlaps
from autobalance.crank.anatomy import Anatomy, Face, Web
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.value_classes import dataclass

DEFAULT_WALL_SHARE = 0.25
"""Metal left behind a face when the job names no ``min_wall_mm``, as a share of the web's width (ours)."""


@dataclass(frozen=True)
class ShoulderLimits(FaceLimits):
    """Limits of shoulder corrections.

    Attributes
    ----------
    faces : "auto" or tuple
        Ids of faces, or points in file coordinates [mm], one on each face.
    sector_deg : (float, float) or None
        Only this part of each face: angles about the crank axis, rotor frame [deg].
    max_depth_mm : float or None
        Largest depth; default what the metal allows.
    same_depth : bool
        One depth for all faces.
    min_wall_mm : float or None
        Metal to leave, from every point of the new face along −n to the next surface [mm]; default a quarter
        of the web's width.
    depth_step_mm : float
        Step in which the machine sets the depth; 0: any depth [mm].
    min_step_mm : float
        Smallest depth that a machine is set up for: nothing under it is planned [mm].
    """


# --- the cut ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ShoulderCut(FaceCut):
    """The lowering of one face; only its depth is open. Implements ``correction.kind.Cut``."""

    face: Face
    to_face: Array
    height_mm: float
    top_mm: float
    layer: FaceLayer
    heights_mm: Array
    within: Solid | None
    wedge: Shape | None
    sector_deg: tuple[float, float] | None
    density_g_mm3: float
    max_depth_mm: float
    limit: str
    depth_step_mm: float
    clearance_mm: float
    limit_is_reach: bool
    least_depth_mm: float = 0.0
    min_step_mm: float = 0.0

    @property
    def label(self) -> str:
        return f"face {self.face.id}{part_name(self.sector_deg)}"

    @cached_property
    def _curve(self) -> DepthCurve:
        return self.layer.curve(self.max_depth_mm, self.height_mm - self.heights_mm)

    @cached_property
    def envelope(self) -> Envelope:
        """Metal connected to the face down to its largest depth, drawn out from the face."""
        self.effect(self.max_depth_mm)  # has looked at sections down to here
        return drawn_out(self.layer.taken(self.max_depth_mm), self.height_mm, -1.0, self.to_rotor)

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to subtract, rotor frame: a prism from the new face to just above the old one.

        It reaches a little beyond the metal that goes, not over all the room that there is.
        """
        self.effect(depth_mm)  # has looked at sections down to here
        low, high = self.layer.taken(depth_mm).bounds
        around = Region.rectangle((low - BESIDE_MM).tolist(), (high + BESIDE_MM).tolist())
        room = (self.layer.room & around) - self.layer.spared(depth_mm)
        body = _prism(room, self.height_mm - depth_mm, self.top_mm).moved(self.to_rotor)
        return body if self.within is None else body & self.within

    def taken(self, depth_mm: float) -> Solid:
        """Return a body around the removed metal, rotor frame: all that is connected to the face."""
        self.effect(depth_mm)  # has looked at sections down to here
        low, high = self.height_mm - depth_mm, self.height_mm
        body = Solid.prism(self.layer.taken(depth_mm), low, high).moved(self.to_rotor)
        return body if self.within is None else body & self.within

    def exact_tool(self, depth_mm: float) -> Tool:
        """Return the lowering without facets; the exact solid finds the metal on the face itself."""
        self.effect(depth_mm)  # has looked at sections down to here
        return lowering(self.layer, depth_mm, self.to_rotor, self.wedge)

    def outline_beside(self, depth_mm: float, earlier: Solid) -> tuple[dict[str, Any], float]:
        height = self.height_mm - depth_mm
        left = self.layer.kept(depth_mm) - earlier.moved(self.to_rotor.T).section(height)  # a rotation
        outline = region_outline(left, self.to_rotor)
        return outline, loops_area_mm2(outline["outline"])

    def correction(self, depth_mm: float) -> Correction:
        left = self.layer.kept(depth_mm)
        return self.listed("shoulder", depth_mm, left, new_face_area_mm2=left.area_mm2)


NEAR_HOLES = 0.05
"""Margin of the box around a room's holes, as a share of the box's size."""


def _prism(room: Region, low_mm: float, high_mm: float) -> Solid:
    """Return the prism over a room, its caps divided around the holes.

    Triangles that reach from a finely drawn hole to the far corners of the region are long slivers. A boolean
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
    """Return the cuts of faces, each with its limits measured on the solid.

    Parameters
    ----------
    solid : Solid
        The crank in file coordinates.
    anatomy : Anatomy
    patches : sequence of Patch
        The faces, and the parts of them.
    density_g_mm3 : float
    limits : ShoulderLimits
    reach_mm : float
        Largest depth of the search; ``limit_is_reach`` marks a cut whose limit is only this.

    Returns
    -------
    list of ShoulderCut
        One a patch, in the same order; patches with no metal to take are left out.
    """
    all_cuts = (_cut(patch, solid.mesh, anatomy, density_g_mm3, limits, reach_mm) for patch in patches)
    return [cut for cut in all_cuts if cut is not None]


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
    reach = _reach(limits, reach_mm)
    under = under_face(mesh, anatomy, face, to_face, height - reach.depth_mm - wall - grain, grain)
    layer = FaceLayer(
        under.section,
        height,
        under.outline,
        under.standing,
        under.room,
        None if patch.within is None else patch.within.moved(to_face),
        grain,
        0.0 if face.rms_mm is None else grain,
    )
    if not layer.holds_its_face:
        return None
    limit = clear_of_pins(layer, to_face, anatomy, depth_limit(layer, under.slab, reach, wall))
    if limit.depth_mm <= 2.0 * grain:
        return None
    return ShoulderCut(
        face=face,
        to_face=to_face,
        height_mm=height,
        top_mm=height + 3.0 * grain,
        layer=layer,
        heights_mm=under.slab.vertices[:, 2],
        within=patch.within,
        wedge=patch.wedge,
        sector_deg=patch.sector_deg,
        density_g_mm3=density_g_mm3,
        max_depth_mm=limit.depth_mm,
        limit=limit.reason,
        limit_is_reach=limit.is_reach,
        depth_step_mm=limits.depth_step_mm,
        min_step_mm=limits.min_step_mm,
        clearance_mm=wall,
    )


def _reach(limits: ShoulderLimits, reach_mm: float) -> DepthLimit:
    """Return the depth of the search: the reach, or the job's largest depth if that is less."""
    if limits.max_depth_mm is None or limits.max_depth_mm > reach_mm:
        return DepthLimit(reach_mm, "how far was looked", is_reach=True)
    return DepthLimit(limits.max_depth_mm, f"max_depth_mm = {limits.max_depth_mm:g}")


def _wall_mm(face: Face, anatomy: Anatomy, limits: ShoulderLimits) -> float:
    if limits.min_wall_mm is not None:
        return limits.min_wall_mm
    web: Web | None = next((web for web in anatomy.webs if web.number == face.web), None)
    return 0.0 if web is None else DEFAULT_WALL_SHARE * (web.z_max_mm - web.z_min_mm)


def shared_depths(cuts: Sequence[ShoulderCut], anatomy: Anatomy, limits: ShoulderLimits) -> list[SharedDepth]:
    """Return the depths that cuts on opposite faces of a web may have together, with a wall between them."""
    shared = []
    for i, one in enumerate(cuts):
        for j in range(i + 1, len(cuts)):
            other = cuts[j]
            facing = float(one.face.normal @ other.face.normal)
            if one.face.web is None or one.face.web != other.face.web or facing > MAX_NORMAL_COMPONENT:
                continue
            metal = one.height_mm + other.height_mm - _wall_mm(one.face, anatomy, limits)
            shared.append(SharedDepth(i, j, max(metal, 0.0)))
    return shared


def _beside_each_other(cuts: Sequence[ShoulderCut]) -> list[tuple[int, int]]:
    """Return the pairs of cuts on faces of one web that do not look opposite ways."""
    return [
        (i, j)
        for (i, one), (j, other) in itertools.combinations(enumerate(cuts), 2)
        if one.face.web is not None
        and one.face.web == other.face.web
        and one.face.id != other.face.id
        and float(one.face.normal @ other.face.normal) > MAX_NORMAL_COMPONENT
    ]


# --- the kind -----------------------------------------------------------------------------------------------

LOOK_AHEAD = 1.5
"""Factor on the depth that the faces' first effect requires: drafts and sectors change it."""


def _worth_g_mm_per_mm(patch: Patch, work: Workpiece) -> float:
    heavy = heavy_direction(work.heavy_at, float(patch.face.centroid_mm[2]))
    if heavy is None:
        return 0.0
    return work.density_g_mm3 * half_plane_worth(work.solid.mesh, work.anatomy, patch.face, heavy)[0]


class Shoulder(FaceKind[ShoulderLimits]):
    """Faces lowered into the metal."""

    name = "shoulder"
    verb = "face"
    noun = "Shoulder"
    datum = "the face as it is, along its normal"
    limits = ShoulderLimits
    mixed_with = ("drill",)

    def offer(self, work: Workpiece, limits: ShoulderLimits, search_level: int) -> Candidates:
        """Return the cuts that a job's limits allow; more of them with more ``search_level`` (from 0)."""
        patches = patches_of(work, limits, work.heavy_at, search_level)
        worth = sum(_worth_g_mm_per_mm(patch, work) for patch in patches)
        reach = work.look * LOOK_AHEAD * work.need_g_mm / worth if worth > 0.0 else math.inf
        return self.of_patches(work, limits, patches, min(reach, work.solid.mesh.diagonal_mm))

    def of_patches(
        self, work: Workpiece, limits: ShoulderLimits, patches: Sequence[Patch], reach_mm: float
    ) -> Candidates:
        shoulder_cuts = cuts(work.solid, work.anatomy, patches, work.density_g_mm3, limits, reach_mm)
        shared = tuple(shared_depths(shoulder_cuts, work.anatomy, limits))
        apart, both = overlaps(shoulder_cuts, _beside_each_other(shoulder_cuts))
        return Candidates(tuple(shoulder_cuts), shared, limits.same_depth, apart, overlaps=both)

    def instruction(self, item: Item, figures: Figures) -> str:
        heights = (
            f" from {figures.mm(item['face_height_mm'])} to {figures.mm(item['new_height_mm'])} "
            "from the crankpin's middle"
            if item.get("new_height_mm") is not None
            else ""
        )
        return f"Face mill {item.get('face')}{part_name(item.get('sector_deg'))}{heights}"

    def machining(self, item: Item) -> Operation | str | None:
        return face_operation(item)

    def wall_left_mm(self, corrections: Sequence[Correction], anatomy: Anatomy) -> float | None:
        """Return the least thickness left of the lowered webs; None where none is."""
        lowered = {web.number: [cut for cut in corrections if cut.web == web.number] for web in anatomy.webs}
        walls = [_thickness_left_mm(web, lowered[web.number]) for web in anatomy.webs if lowered[web.number]]
        return min(walls, default=None)

    def face_depths_mm(self, work: Workpiece, rims: Sequence[Face]) -> Mapping[str, float]:
        """Return the largest depth of each planar face by itself."""
        planes = [Patch(face) for face in work.faces if face.kind == "plane"]
        thickness = {web.number: web.z_max_mm - web.z_min_mm for web in work.anatomy.webs}
        thickest = max(thickness.values(), default=0.0)
        depths: dict[str, float] = {}
        for patch in planes:
            near = thickest if patch.face.web is None else thickness[patch.face.web]
            for reach in (NEAR_WEBS * near, work.solid.mesh.diagonal_mm):
                face_cuts = cuts(
                    work.solid, work.anatomy, [patch], work.density_g_mm3, ShoulderLimits(), reach
                )
                depths |= {cut.face.id: cut.max_depth_mm for cut in face_cuts if not cut.limit_is_reach}
                if not any(cut.limit_is_reach for cut in face_cuts):
                    break
        return depths


NEAR_WEBS = 1.25
"""Reach of a first search, in thicknesses of a web: most cuts end so near, with far less to search."""


def _thickness_left_mm(web: Web, lowered: Sequence[Correction]) -> float:
    """Return a web's thickness less the deepest cut from either side."""
    left = web.z_max_mm - web.z_min_mm
    for sign in (1.0, -1.0):
        left -= max((c.depth_mm for c in lowered if sign * c.details["normal"][2] > 0.0), default=0.0)
    return left


KIND = Shoulder()
