"""Metal added on planar faces: the outward twin of the shoulder, for designers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from autobalance.correction.apart import TOUCHING_MM, keep_apart
from autobalance.correction.contract import Apart, Correction, Envelope, Figures, Item, drawn_out
from autobalance.correction.faces.cut import FaceCut, FaceKind, patches_of
from autobalance.correction.faces.layer import DepthCurve, moments_scale, numbers_of, plane_moments
from autobalance.correction.faces.patches import (
    FaceLimits,
    Patch,
    face_frame,
    face_region,
    farthest_mm,
    strip_along,
)
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.relaxing import refuse_out_of_range
from autobalance.crank.anatomy import Anatomy, Face, MainJournal, Pin
from autobalance.declare import NOT_NEGATIVE, POSITIVE
from autobalance.errors import CorrectionError
from autobalance.quantities import mm, said, span
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Raising, Tool
from autobalance.types import Array
from autobalance.value_classes import dataclass

DEFAULT_MAX_MM = 10.0
"""Largest height added by default (ours)."""
DEFAULT_CLEARANCE_MM = 2.0
"""Distance kept to the next metal over the face where the job names no ``min_wall_mm`` (ours)."""
SINK_SHARE = 1e-5
"""Depth in the metal at which an added body starts, as a share of the part's size, so that both unite."""

WITHIN_TOP = 1e-6
"""Share of the largest height by which sections stay below it: the end has no section."""
BESIDE_SINKS = 10.0
"""Overlap of an added body with what is on the face, in sinks; at free edges it keeps one sink inside,
so that no two surfaces coincide."""


@dataclass(frozen=True)
class AddLimits(FaceLimits):
    """Limits of added metal; keys as for shoulders.

    Attributes
    ----------
    faces : "auto" or tuple
        Ids of faces, or points in file coordinates [mm], one on each face.
    sector_deg : (float, float) or None
        Only this part of each face: angles about the crank axis, rotor frame [deg].
    max_depth_mm : float or None
        Largest height added; default 10 mm.
    same_depth : bool
        One height for all faces.
    min_wall_mm : float or None
        Clearance to the next metal over the face; default 2 mm.
    depth_step_mm : float
        Step in which the height is set; 0: any height [mm].
    min_step_mm : float
        Smallest height that a machine is set up for: nothing under it is planned [mm].
    crankcase_radius_mm : float or None
        Inner radius of the crankcase about the crank axis; added metal keeps ``min_wall_mm`` from it.
    crankcase_gap_mm : float or None
        Length of each main journal, from the web on, that is clear of the crankcase; likewise. Not set: metal
        next to a filleted main journal ends at 24 % of the journal's width, and other metal may continue
        along it. A note names each journal with the length that has metal next to it.
    """

    crankcase_radius_mm: Annotated[float | None, POSITIVE] = None
    crankcase_gap_mm: Annotated[float | None, NOT_NEGATIVE] = None

    def __post_init__(self) -> None:
        refuse_out_of_range("add", self)
        if self.sector_deg is not None and self.sector_deg[0] == self.sector_deg[1]:
            raise CorrectionError("add.sector_deg excludes every angle; all around is [0, 360]")


@dataclass(frozen=True, eq=False)
class AddCut(FaceCut):
    """Metal added on one face; only its height is open (a `Cut`).

    In the face's frame: ``gain`` is the metal gained from ``height_mm`` up to the largest height; ``sunk`` is
    the body that is added, from a little inside the metal. They differ where a part on the face or next to it
    is wider or narrower farther up. They also differ by a sink where another sector of the face begins, so
    that the bodies in both grow together. If they only touched, a slit of no width would stay.
    """

    face: Face
    to_face: Array
    height_mm: float
    gain: Solid
    sunk: Solid
    rough_mm: float
    wedge: Shape | None
    sector_deg: tuple[float, float] | None
    density_g_mm3: float
    max_depth_mm: float
    limit: str
    depth_step_mm: float
    least_depth_mm: float = 0.0
    adds_metal: bool = True
    clearance_mm: float = 0.0
    min_step_mm: float = 0.0

    @property
    def label(self) -> str:
        return f"metal on face {self.face.id}"

    @cached_property
    def envelope(self) -> Envelope:
        """The body that grows on the face."""
        return drawn_out(self.gain.shadow(), self.height_mm, 1.0, self.to_rotor)

    @cached_property
    def _curve(self) -> DepthCurve:
        """Section moments of the gain over the added height."""

        def at(depth: float) -> Array:
            return numbers_of(plane_moments(self._section(depth), self.height_mm + depth))

        most, breaks = self.max_depth_mm, np.unique(self.gain.mesh.vertices[:, 2]) - self.height_mm
        return DepthCurve(at, 0.0, most, moments_scale(self._section(0.5 * most), self.height_mm), breaks)

    def _section(self, depth_mm: float) -> Region:
        """Return the section of the gain at a height, kept over the face's roughness and under the top."""
        low, high = self.rough_mm, self.max_depth_mm * (1.0 - WITHIN_TOP)
        return self.gain.section(self.height_mm + min(max(depth_mm, low), high))

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to add, rotor frame; it starts a little inside the metal."""
        return self.sunk.below(self.height_mm + depth_mm).moved(self.to_rotor)

    def exact_tool(self, depth_mm: float) -> Tool:
        """Return the body to add, without facets: the face itself, drawn out."""
        return Raising(self.face.surfaces, self.face.normal, depth_mm, self.wedge)

    def correction(self, depth_mm: float) -> Correction:
        region = self._section(depth_mm)
        return self.listed("add", depth_mm, region, area_mm2=region.area_mm2)


def cuts(work: Workpiece, patches: Sequence[Patch], limits: AddLimits) -> list[AddCut]:
    """Return the bodies that may grow on faces, each up to the next metal over it."""
    raised = DEFAULT_MAX_MM if limits.max_depth_mm is None else limits.max_depth_mm
    clearance = DEFAULT_CLEARANCE_MM if limits.min_wall_mm is None else limits.min_wall_mm
    mesh, anatomy = work.solid.mesh, work.anatomy
    sink = SINK_SHARE * mesh.diagonal_mm
    begun = {(patch.face.id, patch.sector_deg[0]) for patch in patches if patch.sector_deg is not None}
    add_cuts = []
    for patch in patches:
        to_face = face_frame(patch.face.normal)
        height = float(patch.face.normal @ patch.face.centroid_mm)
        face = face_region(mesh, anatomy, patch.face, to_face)
        placed = work.solid.moved(to_face @ anatomy.file_to_rotor)
        beside = BESIDE_SINKS * sink
        standing = placed.section(height + 2.0 * sink + patch.face.spread_mm)
        grown = _without_skins((face + (face.grown(beside) & standing)).grown(-sink), face)
        low, high = height - sink, height + raised + clearance
        body, free = Solid.prism(grown, low, high), Solid.prism(grown - standing, low, high)
        whole = body
        if patch.within is not None:
            within = patch.within.moved(to_face)
            body, free = whole & within, free & within
        over = free & Solid.prism(face.grown(-beside), height + 2.0 * sink + patch.face.spread_mm, high)
        blocked = placed & over
        room, limit = raised, f"max_depth_mm = {raised:g}"
        if not blocked.is_empty:
            above = float(blocked.bounds[0, 2]) - height - clearance
            if above < room:
                room, limit = above, said("the clearance of {} over the face", mm(clearance, "g"))
        for free_mm, why in _contact_heights(patch.face, grown, to_face, anatomy, limits, clearance):
            if free_mm < room:
                room, limit = free_mm, why
        if room <= 4.0 * sink + 2.0 * patch.face.spread_mm or free.is_empty:
            continue
        gain = body.above(height).below(height + room) - placed
        if gain.is_empty:
            continue
        if patch.sector_deg is not None and (patch.face.id, patch.sector_deg[1]) in begun:
            seam = strip_along(patch.sector_deg[1], farthest_mm(mesh, anatomy), sink)
            body = body + (whole & seam.moved(to_face))
        add_cuts.append(
            AddCut(
                face=patch.face,
                to_face=to_face,
                height_mm=height,
                gain=gain,
                sunk=body,
                rough_mm=2.0 * sink + patch.face.spread_mm,
                wedge=patch.wedge,
                sector_deg=patch.sector_deg,
                density_g_mm3=work.density_g_mm3,
                max_depth_mm=room,
                limit=limit,
                depth_step_mm=limits.depth_step_mm,
                min_step_mm=limits.min_step_mm,
            )
        )
    return add_cuts


def _without_skins(grown: Region, face: Region) -> Region:
    """Return the pieces of a region that lie on a face.

    What is on it with a fillet is narrower a little farther up: the overlap with it is parted from the
    face there, and would grow into a skin of hundredths of a millimetre.
    """
    return Region.beside_each_other([each for each in grown.pieces() if not (each & face).is_empty])


def _contact_heights(
    face: Face, region: Region, to_face: Array, anatomy: Anatomy, limits: AddLimits, clearance_mm: float
) -> list[tuple[float, str]]:
    """Return heights at which metal on a face meets rods or the crankcase, each with the limit's name.

    A rod is as wide as its crankpin is bare, and sweeps all of that stretch of the axis as the crank turns.
    The crankcase likewise takes a main journal between the clear ends that the job states. A main journal
    from which metal is parted by a fillet's width must stay bare over most of its width, too.
    """
    rods = [_stretch(throw.crankpin, 0.0) for throw in anatomy.throws]
    journals = [_stretch(pin, MOST_BESIDE * pin.width_mm) for pin in _parted_from(region, to_face, anatomy)]
    limits_beside = [
        (_room_along_axis_mm(face, rods), "the connecting rod's width on the crankpin"),
        (_room_along_axis_mm(face, journals), "the main journal, which is bare no more beside it"),
    ]
    gap, radius = limits.crankcase_gap_mm, limits.crankcase_radius_mm
    if gap is not None:
        walls = [_stretch(pin, gap - clearance_mm) for pin in anatomy.main_journals]
        limits_beside.append((_room_along_axis_mm(face, walls), f"crankcase_gap_mm = {gap:g}"))
    if radius is not None:
        corners = np.concatenate([np.zeros((0, 2)), *region.polygons])
        height = np.full((len(corners), 1), float(face.normal @ face.centroid_mm))
        places = np.hstack([corners, height]) @ to_face[:3, :3]
        inside = _room_inside_mm(places[:, :2], face.normal[:2], radius - clearance_mm)
        limits_beside.append((inside, f"crankcase_radius_mm = {radius:g}"))
    return limits_beside


def _parted_from(region: Region, to_face: Array, anatomy: Anatomy) -> list[MainJournal]:
    """Return the main journals that metal drawn out of a region of a face does not touch."""
    up, parted = to_face[:3, :3] @ np.array([0.0, 0.0, 1.0]), []
    for journal in anatomy.main_journals:
        centre = (to_face[:3, :3] @ journal.centre_mm)[:2]
        circle = Region.circle(0.5 * journal.diameter_mm, CIRCLE_SEGMENTS, [float(each) for each in centre])
        if abs(float(up[2])) > 1.0 - MIN_AXIAL_NORMAL and (region & circle).is_empty:
            parted.append(journal)
    return parted


def _stretch(pin: Pin, less_mm: float) -> tuple[float, float]:
    """Return the ends of a pin along the axis [mm], less a length at both."""
    z, half = float(pin.centre_mm[2]), 0.5 * pin.width_mm - less_mm
    return z - half, z + half


def _room_along_axis_mm(face: Face, stretches: Sequence[tuple[float, float]]) -> float:
    """Return the height at which metal on a face reaches one of some stretches of the axis; else infinite."""
    up = float(face.normal[2])
    if abs(up) < MIN_AXIAL_NORMAL:
        return math.inf
    z, most = float(face.centroid_mm[2]), math.inf
    for low, high in stretches:
        near, far = sorted(math.copysign(1.0, up) * (end - z) for end in (low, high))
        if low < high and far > 0.0:
            most = min(most, max(near, 0.0) / abs(up))
    return most


def _room_inside_mm(places: Array, out: Array, radius_mm: float) -> float:
    """Return the largest multiple of ``out`` (2,) by which points (k, 2) may move inside a circle."""
    free_mm2 = radius_mm**2 - (places**2).sum(axis=1)
    if radius_mm <= 0.0 or not len(places) or float(free_mm2.min()) <= 0.0:
        return 0.0
    square, along = float(out @ out), places @ out
    if square < MIN_AXIAL_NORMAL**4:  # along the axis
        return math.inf
    return float(((np.sqrt(along**2 + square * free_mm2) - along) / square).min())


CIRCLE_SEGMENTS = 96
MOST_BESIDE = 0.24
"""Share of a main journal's width along which metal is next to it at each end. With a quarter, recognition of
the corrected solid takes the journal as part of the web; a V8 with 15 mm on its filleted webs was no longer
recognised as a crank."""
MIN_AXIAL_NORMAL = 0.1
"""Smallest component along the axis of the normal of a face from which metal grows towards rods."""


def _clear_of_each_other(add_cuts: Sequence[AddCut], limits: AddLimits) -> tuple[Apart, ...]:
    """Return the pairs of pads on different faces too near each other, with the height both may have."""
    if len(add_cuts) < 2:
        return ()
    clearance = DEFAULT_CLEARANCE_MM if limits.min_wall_mm is None else limits.min_wall_mm
    ids = [cut.face.id for cut in add_cuts]
    return keep_apart(
        [cut.envelope for cut in add_cuts],
        np.array([cut.max_depth_mm for cut in add_cuts]),
        np.full(len(add_cuts), max(clearance, TOUCHING_MM)),
        np.array([ids.index(each) for each in ids]),
    )


class Add(FaceKind[AddLimits]):
    """Metal added on faces, for designers."""

    name = "add"
    verb = "build up"
    noun = "Pad"
    datum = "the face as it is, outward along its normal"
    limits = AddLimits
    adds_metal = True
    usual_depth_mm = DEFAULT_MAX_MM

    def offer(self, work: Workpiece, limits: AddLimits, search_level: int) -> Candidates:
        """Return the faces that metal may be added on: on the light side, unless the job picks them."""
        light = [(z, -vector) for z, vector in work.heavy_at]
        return self.of_patches(work, limits, patches_of(work, limits, light, search_level), math.inf)

    def of_patches(
        self, work: Workpiece, limits: AddLimits, patches: Sequence[Patch], reach_mm: float
    ) -> Candidates:
        del reach_mm  # metal grows as far as there is room
        add_cuts = cuts(work, patches, limits)
        return Candidates(
            tuple(add_cuts), same_depth=limits.same_depth, apart=_clear_of_each_other(add_cuts, limits)
        )

    def heavier(self) -> Sequence[AddLimits]:
        """Return limits up to the largest height that is tried."""
        return (AddLimits(max_depth_mm=MOST_ADDED_MM),)

    def heavier_words(self, cuts: Sequence[tuple[AddCut, float]]) -> tuple[str, Mapping[str, Any]]:
        """Return the mass and the thickness added to counterweights, in words, and the keys for them."""
        grams: dict[int | None, float] = {}
        for cut, depth in cuts:
            grams[cut.face.web] = grams.get(cut.face.web, 0.0) + cut.effect(depth).mass_g
        depths = [depth for _, depth in cuts]
        each = f"on each of {len(grams)} counterweights" if len(grams) > 1 else "on the counterweight"
        mass, height = span(list(grams.values()), "g", ".0f"), span(depths, "mm", ".1f")
        text = said("{} {}, which is {} thicker (method add)", mass, each, height)
        return text, {"max_depth_mm": math.ceil(10.0 * max(depths)) / 10.0}

    def remarks(
        self, corrections: Sequence[Correction], anatomy: Anatomy, limits: AddLimits
    ) -> tuple[str, ...]:
        """Return the main journals beside which metal is, if no gap to the crankcase is stated."""
        if limits.crankcase_gap_mm is not None:
            return ()
        beside = [(journal, _beside_mm(journal, corrections)) for journal in anatomy.main_journals]
        return tuple(
            said(
                "added metal is next to {} of main journal {}, which is {} wide; check that its bearing "
                "is clear, or set crankcase_gap_mm",
                mm(covered, ".1f"),
                journal.number,
                mm(journal.width_mm, ".1f"),
            )
            for journal, covered in beside
            if covered > NOTED_BESIDE_MM
        )

    def instruction(self, item: Item, figures: Figures) -> str:
        return f"Build up face {item.get('face')}"


NOTED_BESIDE_MM = 0.05
"""Length of a main journal beside which metal is, from which it is noted: the text has tenths."""


def _beside_mm(journal: MainJournal, corrections: Sequence[Correction]) -> float:
    """Return the length of a main journal, at both ends together, beside which added metal is."""
    low, high = _stretch(journal, 0.0)
    from_low, from_high = 0.0, 0.0
    for each in corrections:
        up = float(each.details["normal"][2])
        if abs(up) < 1.0 - MIN_AXIAL_NORMAL:
            continue
        ends = sorted(float(each.details[key]) / up for key in ("face_height_mm", "new_height_mm"))
        if min(ends[1], high) <= max(ends[0], low):
            continue
        if up > 0.0:
            from_low = max(from_low, min(ends[1], high) - low)
        else:
            from_high = max(from_high, high - max(ends[0], low))
    return min(from_low + from_high, high - low)


MOST_ADDED_MM = 40.0
"""Largest height tried where counterweights are too light."""


KIND = Add()
