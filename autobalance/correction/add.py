"""Metal added on planar faces: the outward twin of the shoulder, for designers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from autobalance.correction.face_cut import FaceCut, face_heights, patches_of
from autobalance.correction.face_trace import FaceTrace
from autobalance.correction.kind import (
    Apart,
    Array,
    Correction,
    Figures,
    Item,
    Kind,
    Offer,
    Workpiece,
)
from autobalance.correction.patches import (
    FaceLimits,
    Patch,
    face_frame,
    face_region,
)
from autobalance.correction.refusals import refuse_below_zero
from autobalance.correction.relaxing import Relaxing, deeper, thinner
from autobalance.correction.room import TOUCHING_MM, Room, drawn_out, keep_apart
from autobalance.correction.trace import Trace
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.errors import CorrectionError
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Region, Solid
from autobalance.solid.csg.tool import Raising, Tool

DEFAULT_MAX_MM = 10.0
"""Greatest height added where the job names none (ours)."""
DEFAULT_CLEARANCE_MM = 2.0
"""Distance kept to the next metal over the face where the job names no ``min_wall_mm`` (ours)."""
SINK_SHARE = 1e-5
"""How deep an added body starts inside the metal, as a share of the part's size, so that it grows on."""

BESIDE_SINKS = 10.0
"""How far an added body reaches into what stands on the face, in sinks; at free edges it keeps one sink
inside, so that no two surfaces coincide."""


@dataclass(frozen=True)
class AddLimits(FaceLimits):
    """What a job asks of added metal; keys as for shoulders.

    Attributes
    ----------
    faces : "auto" or tuple
        Ids of faces, or points in file coordinates [mm], one on each face.
    sector_deg : (float, float) or None
        Only this part of each face: angles about the crank axis, rotor frame [deg].
    max_depth_mm : float or None
        Greatest height added; default 10 mm.
    same_depth : bool
        One height for all faces.
    min_wall_mm : float or None
        Clearance to the next metal over the face; default 2 mm.
    depth_step_mm : float
        Step in which the height is set; 0: any height [mm].
    """

    def __post_init__(self) -> None:
        """Refuse limits that are no lengths."""
        refuse_below_zero("add", self, "max_depth_mm", "min_wall_mm", "depth_step_mm")
        if self.sector_deg is not None and self.sector_deg[0] == self.sector_deg[1]:
            raise CorrectionError("add.sector_deg excludes every angle; all around is [0, 360]")


@dataclass(frozen=True, eq=False)
class AddCut(FaceCut):
    """Metal added on one face, of which only the height is open (a `Cut`).

    ``base`` is the part of the face that it stands on, as a body from ``height_mm`` up to the greatest
    height, in the face's frame.
    """

    face: Face
    to_face: Array
    height_mm: float
    base: Solid
    sunk: Solid
    wedge: Shape | None
    sector_deg: tuple[float, float] | None
    density_g_mm3: float
    max_depth_mm: float
    limit: str
    depth_step_mm: float
    least_depth_mm: float = 0.0
    adds_metal: bool = True
    clearance_mm: float = 0.0

    @property
    def label(self) -> str:
        """Short name for messages."""
        return f"metal on face {self.face.id}"

    @cached_property
    def room(self) -> Room:
        """The body that grows on the face."""
        return drawn_out(self._outline, self.height_mm, 1.0, self.to_rotor)

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the crank's moments: a prism."""
        area, first, second = self._area
        z0, z1 = self.height_mm, self.height_mm + depth_mm
        rise, rise2, rise3 = (((z1**n) - (z0**n)) / n for n in (1, 2, 3))
        return self._prism(area, first, second, (rise, rise2, rise3))

    def rate(self, depth_mm: float) -> Moments:
        """Return d effect / d depth: the section at the new height."""
        area, first, second = self._area
        z = self.height_mm + depth_mm
        return self._prism(area, first, second, (1.0, z, z * z))

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to add, rotor frame; it starts a little inside the metal."""
        return self.sunk.below(self.height_mm + depth_mm).moved(self.to_rotor)

    def exact_tool(self, depth_mm: float) -> Tool:
        """Return the body to add, without facets: the face itself, drawn out."""
        return Raising(self.face.surfaces, self.face.normal, depth_mm, self.wedge)

    def correction(self, depth_mm: float) -> Correction:
        """Return what the designer needs to know."""
        heights = self.height_mm, self.height_mm + depth_mm
        return self.listed("add", self.effect(depth_mm), -depth_mm, heights, area_mm2=self._area[0])

    @property
    def _area(self) -> tuple[float, Array, Array]:
        return self._outline.area_moments()

    @property
    def _outline(self) -> Region:
        return self.base.section(self.height_mm + 0.5 * self.max_depth_mm)

    def _prism(self, area: float, first: Array, second: Array, powers: tuple[float, float, float]) -> Moments:
        one, z, zz = powers
        second3 = np.zeros((3, 3))
        second3[:2, :2] = second * one
        second3[:2, 2] = second3[2, :2] = first * z
        second3[2, 2] = area * zz
        moments = Moments(area * one, np.array([*(first * one), area * z]), second3)
        return moments.moved(self.to_rotor).scaled(self.density_g_mm3)


def cuts(work: Workpiece, patches: Sequence[Patch], limits: AddLimits) -> list[AddCut]:
    """Set up the bodies that may grow on faces, each up to the next metal over it."""
    asked = DEFAULT_MAX_MM if limits.max_depth_mm is None else limits.max_depth_mm
    clearance = DEFAULT_CLEARANCE_MM if limits.min_wall_mm is None else limits.min_wall_mm
    mesh, anatomy = work.solid.mesh, work.anatomy
    sink = SINK_SHARE * mesh.diagonal_mm
    found = []
    for patch in patches:
        to_face = face_frame(patch.face.normal)
        height = float(patch.face.normal @ patch.face.centroid_mm)
        face = face_region(mesh, anatomy, patch.face, to_face)
        placed = work.solid.moved(to_face @ anatomy.file_to_rotor)
        beside = BESIDE_SINKS * sink
        standing = placed.section(height + 2.0 * sink + patch.face.spread_mm)
        grown = (face + (face.grown(beside) & standing)).grown(-sink)
        low, high = height - sink, height + asked + clearance
        body, free = Solid.prism(grown, low, high), Solid.prism(grown - standing, low, high)
        if patch.within is not None:
            within = patch.within.moved(to_face)
            body, free = body & within, free & within
        over = free & Solid.prism(face.grown(-beside), height + 2.0 * sink + patch.face.spread_mm, high)
        blocked = placed & over
        room, limit = asked, f"max_depth_mm = {asked:g}"
        if not blocked.is_empty:
            above = float(blocked.bounds[0, 2]) - height - clearance
            if above < room:
                room, limit = above, f"the clearance of {clearance:g} mm over the face"
        beside_rods = _room_beside_rods_mm(patch.face, anatomy)
        if beside_rods < room:
            room, limit = beside_rods, "the connecting rod's width on the crankpin"
        if room <= 2.0 * sink or free.is_empty:
            continue
        found.append(
            AddCut(
                face=patch.face,
                to_face=to_face,
                height_mm=height,
                base=free.above(height).below(height + room),
                sunk=body,
                wedge=patch.wedge,
                sector_deg=patch.sector_deg,
                density_g_mm3=work.density_g_mm3,
                max_depth_mm=room,
                limit=limit,
                depth_step_mm=limits.depth_step_mm,
            )
        )
    return found


def _room_beside_rods_mm(face: Face, anatomy: Anatomy) -> float:
    """Return how high metal may stand on a face before it is in a connecting rod's way.

    A rod is as wide as its crankpin is bare, and sweeps all of that stretch of the axis as the crank turns.
    """
    up = float(face.normal[2])
    if abs(up) < ALONG:
        return math.inf
    z, most = float(face.centroid_mm[2]), math.inf
    for throw in anatomy.throws:
        pin = throw.crankpin
        ends = (pin.centre_mm[2] - 0.5 * pin.width_mm, pin.centre_mm[2] + 0.5 * pin.width_mm)
        near, far = sorted(math.copysign(1.0, up) * (end - z) for end in ends)
        if far > 0.0:
            most = min(most, max(float(near), 0.0) / abs(up))
    return most


ALONG = 0.1
"""Component along the axis that the normal of a face has, at least, from which metal grows towards rods."""


def _clear_of_each_other(found: Sequence[AddCut], limits: AddLimits) -> tuple[Apart, ...]:
    """Return the pads on different faces that come too near each other, with the height both may have."""
    if len(found) < 2:
        return ()
    clearance = DEFAULT_CLEARANCE_MM if limits.min_wall_mm is None else limits.min_wall_mm
    ids = [cut.face.id for cut in found]
    return keep_apart(
        [cut.room for cut in found],
        np.array([cut.max_depth_mm for cut in found]),
        np.full(len(found), max(clearance, TOUCHING_MM)),
        np.array([ids.index(each) for each in ids]),
    )


class Add(Kind[AddLimits]):
    """Metal added on faces, for designers."""

    name = "add"
    verb = "build up"
    noun = "Added metal"
    datum = "the face as it is, outward along its normal"
    limits = AddLimits
    efforts = 3
    needs_faces = True
    adds_metal = True

    def offer(self, work: Workpiece, limits: AddLimits, effort: int) -> Offer:
        """Return the faces that metal may be added on: on the light side, unless the job picks them."""
        light = [(z, -vector) for z, vector in work.heavy_at]
        found = cuts(work, patches_of(work, limits, light, effort), limits)
        return Offer(tuple(found), same_depth=limits.same_depth, apart=_clear_of_each_other(found, limits))

    def relaxing(self, limits: AddLimits) -> Sequence[Relaxing]:
        """Return more height, and less clearance over the face."""
        return *deeper(limits.max_depth_mm), *thinner(limits.min_wall_mm)

    def instruction(self, item: Item, figures: Figures) -> str:
        """Return on which face to add metal."""
        return f"Add metal on face {item.get('face')}"

    def trace(self, item: Item) -> Trace:
        """Return the metal on its face."""
        return FaceTrace(item, adds=True)

    def size(self, item: Item) -> str:
        """Return the face's height, old and new."""
        return face_heights(item)


KIND = Add()
