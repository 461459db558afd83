"""Turning the rim down: all metal of a web beyond a radius about the crank axis, within its thickness."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from autobalance.correction.contract import (
    Correction,
    Envelope,
    Figures,
    Item,
    Limits,
    blocks,
    sector_corners,
)
from autobalance.correction.cut import EmptyPlace, listed, metal_within
from autobalance.correction.kind import Candidates, Kind, Workpiece
from autobalance.correction.machining import Operation, rim_operation
from autobalance.correction.relaxing import STEP, Relaxing, WiderLimits, refuse_out_of_range
from autobalance.correction.rings import (
    RingTrace,
    faceted_ring,
    far_mm,
    least_radius_mm,
    slab_of,
    tool_volume_mm3,
)
from autobalance.correction.trace import Trace
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.declare import POSITIVE
from autobalance.errors import CorrectionError
from autobalance.quantities import mm, said
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Joined, Shape, equal_area
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.csg.tool import Tool, ring
from autobalance.solid.mesh.measure import Stretches
from autobalance.types import Array
from autobalance.value_classes import dataclass

SEGMENTS = 360
"""Sides of the turned circle; a polygon of its area."""
EQUAL_AREA = equal_area(SEGMENTS)
ROOM_SECTORS = 36
"""Number of blocks that stand for a ring in its envelope."""
FIRST_SHARE = 0.02
"""Share of the largest depth whose slope serves below it: a tool not yet all around the rim has no slope."""


@dataclass(frozen=True)
class TurnLimits(Limits):
    """Limits of turned rims. The defaults are ours: no standard gives them.

    Attributes
    ----------
    min_radius_mm : float or None
        Smallest rim radius left; default what leaves 2 mm outside of the crankpins and main journals.
    per_web : bool
        Each web its own radius; else one radius for all.
    depth_step_mm : float
        Step in which the machine sets the depth; 0: any depth [mm].
    """

    min_radius_mm: Annotated[float | None, POSITIVE] = None
    per_web: bool = True
    depth_step_mm: Annotated[float, STEP] = 0.0

    def __post_init__(self) -> None:
        refuse_out_of_range("turn", self)


@dataclass(frozen=True, eq=False)
class TurnCut(EmptyPlace):
    """The rims of some webs; only their radius is open (a `Cut`).

    ``metal`` is the metal beyond the least radius, in the rotor frame; ``slabs`` are the tools' extents
    along the axis. The depth counts from the farthest point of these webs, ``rim_mm`` from the axis.
    """

    webs: tuple[int, ...]
    slabs: tuple[tuple[float, float], ...]
    rim_mm: float
    far_mm: float
    metal: Solid
    density_g_mm3: float
    max_depth_mm: float
    limit: str
    depth_step_mm: float
    least_depth_mm: float = 0.0
    clearance_mm: float = 0.0
    _known: dict[float, tuple[Moments, Moments]] = field(default_factory=dict, repr=False)

    @property
    def label(self) -> str:
        return "rim of web " + ", ".join(str(number) for number in self.webs)

    @cached_property
    def envelope(self) -> Envelope:
        """The rings between the old rim and the new, where they hold metal."""
        angles: Array = np.arange(float(ROOM_SECTORS)) * (2.0 * math.pi / ROOM_SECTORS)
        rim = np.full(ROOM_SECTORS, self.rim_mm)
        flat = sector_corners(rim, rim, angles, angles + angles[1])
        shadow = self.metal.shadow()
        least = self.rim_mm - self.max_depth_mm
        wedges = sector_corners(0.5 * np.full_like(rim, least), 2.0 * rim, angles, angles + angles[1])
        holds = [not (shadow & Region.of([wedge[[0, 2, 3, 1]]])).is_empty for wedge in wedges]
        flat = flat[holds]
        inner = np.zeros((len(flat), 4, 3))
        inner[:, :2, :2] = -flat[:, :2] / np.linalg.norm(flat[:, :2], axis=2, keepdims=True)
        rings = []
        for slab in self.slabs:
            low, high = (np.concatenate([flat, np.full((len(flat), 4, 1), z)], axis=2) for z in slab)
            rings.append(blocks(low, high, inner, inner))
        return functools.reduce(Envelope.joined, rings)

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the crank's moments, measured on the metal beyond the least radius."""
        return self._measured(depth_mm)[0]

    def rate(self, depth_mm: float) -> Moments:
        """Return d effect / d depth = −ρ ∫ (1, r, r rᵀ) dA over the turned surface."""
        return self._measured(max(depth_mm, FIRST_SHARE * self.max_depth_mm))[1]

    def tool(self, depth_mm: float) -> Solid:
        """Return the rings to subtract, rotor frame."""
        radius = (self.rim_mm - depth_mm) * EQUAL_AREA
        return union([faceted_ring(radius, self.far_mm, *slab, SEGMENTS) for slab in self.slabs])

    def exact_tool(self, depth_mm: float) -> Tool:
        return Joined(tuple(ring(self.rim_mm - depth_mm, self.far_mm, *slab) for slab in self.slabs))

    def correction(self, depth_mm: float) -> Correction:
        """Return the correction; its rate is that of the depth, however shallow."""
        correction = listed(
            "turn",
            self.effect(depth_mm),
            depth_mm,
            self.density_g_mm3,
            web=self.webs[0] if len(self.webs) == 1 else None,
            axis=np.array([0.0, 0.0, 1.0]),
            tool_volume_mm3=tool_volume_mm3(self.rim_mm - depth_mm, self.far_mm, self.slabs),
            webs=list(self.webs),
            z_from_mm=min(low for low, _ in self.slabs),
            z_to_mm=max(high for _, high in self.slabs),
            outer_radius_mm=self.far_mm,
            sector_deg=None,
            rim_radius_mm=self.rim_mm,
            new_radius_mm=self.rim_mm - depth_mm,
            depth_left_mm=self.max_depth_mm - depth_mm,
        )
        return replace(correction, rate=self._measured(depth_mm)[1])

    def _measured(self, depth_mm: float) -> tuple[Moments, Moments]:
        """Return effect and rate; each depth is cut once."""
        if depth_mm not in self._known:
            metal = self.metal & self.tool(depth_mm)
            effect = metal.moments(-self.density_g_mm3)
            rate = _turned_surface(metal, (self.rim_mm - depth_mm) * EQUAL_AREA).scaled(-self.density_g_mm3)
            self._known[depth_mm] = effect, rate
        return self._known[depth_mm]


def _turned_surface(metal: Solid, corner_mm: float) -> Moments:
    """Return ∫ (1, r, r rᵀ) v dA over the inner side of removed rings, v its speed for 1 mm/s of radius."""
    if metal.is_empty:
        return Moments.zero()
    corners = metal.mesh.corners
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross, axis=1)
    normal = cross / np.maximum(size, 1e-300)[:, None]
    apothem = corner_mm * math.cos(math.pi / SEGMENTS)
    inside = np.abs((normal * corners[:, 0]).sum(1) + apothem) < 1e-6 * corner_mm
    inside &= np.abs(normal[:, 2]) < 1e-6
    tri, area = corners[inside], 0.5 * size[inside] * EQUAL_AREA * math.cos(math.pi / SEGMENTS)
    total = tri.sum(axis=1)
    second = np.einsum("k,ki,kj->ij", area, total, total)
    second += np.einsum("k,kni,knj->ij", area, tri, tri)
    return Moments(float(area.sum()), area @ total / 3.0, second / 12.0)


def cuts(solid: Solid, anatomy: Anatomy, density_g_mm3: float, limits: TurnLimits) -> list[TurnCut]:
    """Return the rims that can be turned.

    Raises
    ------
    CorrectionError
        If no web reaches beyond the least radius.
    """
    least = least_radius_mm(anatomy) if limits.min_radius_mm is None else limits.min_radius_mm
    text = (
        said("the radius of {} around the crankpins", mm(least, ".4g"))
        if limits.min_radius_mm is None
        else f"min_radius_mm = {least:g}"
    )
    far = far_mm(solid.mesh, anatomy)
    slabs = {web.number: slab_of(web, anatomy.webs) for web in anatomy.webs}
    if not slabs or least >= far:
        raise CorrectionError(f"turn: no web reaches beyond {text}")
    rings = {web: faceted_ring(least * EQUAL_AREA, far, *slab, SEGMENTS) for web, slab in slabs.items()}
    metal = metal_within(solid, anatomy, rings)
    turn_cuts = []
    for group in [(web,) for web in metal] if limits.per_web else [tuple(metal)]:
        own = union([metal[web] for web in group])
        rim = 0.0 if own.is_empty else float(np.hypot(*own.mesh.vertices[:, :2].T).max())
        if rim - least > THIN_MM:
            turn_cuts.append(
                TurnCut(
                    webs=group,
                    slabs=tuple(slabs[web] for web in group),
                    rim_mm=rim,
                    far_mm=far,
                    metal=own,
                    density_g_mm3=density_g_mm3,
                    max_depth_mm=rim - least,
                    limit=text,
                    depth_step_mm=limits.depth_step_mm,
                )
            )
    if not turn_cuts:
        raise CorrectionError(f"turn: no web reaches beyond {text}")
    return turn_cuts


THIN_MM = 1e-2
"""A rim thinner than this is rounding and facets, not metal to turn."""


class Turn(Kind[TurnLimits]):
    """Rims turned down."""

    name = "turn"
    verb = "turn"
    noun = "Turned rim"
    datum = "the rim's farthest point from the crank axis"
    limits = TurnLimits
    is_round_the_rim = True
    offers_all = True
    mixed_with = ("drill",)

    def offer(self, work: Workpiece, limits: TurnLimits, search_level: int) -> Candidates:
        return Candidates(tuple(cuts(work.solid, work.anatomy, work.density_g_mm3, limits)))

    def is_kept(self, cut: TurnCut, item: Item) -> bool:
        return list(cut.webs) == list(item["webs"])

    def completed(self, item: Item, anatomy: Anatomy, limits: TurnLimits) -> Item:
        """Return a listed rim with all of its webs: those that it lists, or its one."""
        del anatomy, limits
        webs = item.get("webs") or ([] if item.get("web") is None else [item["web"]])
        if not webs:
            raise CorrectionError("web is missing: the number of the web that is turned, or webs, a list")
        return {**item, "webs": list(webs)}

    def open_keys(self, item: Item) -> Mapping[str, Any]:
        """Return the limits of a listed rim: its webs at once, in any depth outside of the crankpins."""
        return {"per_web": len(item["webs"]) == 1, "depth_step_mm": 0.0}

    def at_listed_place(self, work: Workpiece, limits: TurnLimits, item: Item) -> Sequence[TurnCut]:
        return cuts(work.solid, work.anatomy, work.density_g_mm3, limits)

    def relaxing(self, limits: TurnLimits) -> Sequence[Relaxing]:
        if limits.min_radius_mm is None:
            return ()

        def text(to: float, by: float) -> str:
            del by
            return f"turned down further (min_radius_mm = {to:.4g})"

        return (WiderLimits("min_radius_mm", limits.min_radius_mm, -MAX_RADIUS_REDUCTION, text),)

    def label(self, item: Item) -> str:
        return "turn rim of web " + ", ".join(str(web) for web in item.get("webs", ()))

    def instruction(self, item: Item, figures: Figures) -> str:
        return f"Turn the rim to radius {figures.mm(item.get('new_radius_mm'))}"

    def machining(self, item: Item) -> Operation | str | None:
        return rim_operation(item)

    def trace(self, item: Item) -> Trace:
        return RingTrace(item)

    def drawn(self, item: Item) -> Shape:
        return ring(item["new_radius_mm"], item["outer_radius_mm"], item["z_from_mm"], item["z_to_mm"])

    def size(self, item: Item) -> str:
        radius = item.get("new_radius_mm")
        return "" if radius is None else said("to radius {}", mm(float(radius), ",.3f"))

    def wall_left_mm(self, corrections: Sequence[Correction], anatomy: Anatomy) -> float | None:
        """Return the metal left outside of the crankpins."""
        reach = [throw.crank_radius_mm + 0.5 * throw.crankpin.diameter_mm for throw in anatomy.throws]
        radius = min((float(cut.details["new_radius_mm"]) for cut in corrections), default=None)
        return None if radius is None else radius - max(reach, default=0.0)

    def face_depths_mm(self, work: Workpiece, rims: Sequence[Face]) -> Mapping[str, float]:
        """Return the largest depth of each rim, unless its web reaches farther elsewhere."""
        least = least_radius_mm(work.anatomy)
        outlines = {web.number: web.outline for web in work.anatomy.webs}
        reach = _reaches_mm(work.solid, work.anatomy)
        return {
            rim.id: reach[rim.web] - least
            for rim in rims
            if rim.web in reach
            and reach[rim.web] - least > THIN_MM
            and (outline := outlines[rim.web]) is not None
            and abs(outline.rim_radius_mm - reach[rim.web]) < THIN_MM
        }


def _reaches_mm(solid: Solid, anatomy: Anatomy) -> dict[int, float]:
    """Return the largest radius of each web's metal: at a vertex of its slab, or an edge that enters it."""
    frame, mesh = anatomy.file_to_rotor, solid.mesh
    x, y, z = np.ascontiguousarray((mesh.vertices @ frame[:3, :3].T + frame[:3, 3]).T)
    metal = np.zeros(len(z), dtype=bool)  # a vertex of no triangle is not metal
    metal[mesh.triangles.reshape(-1)] = True
    square = np.where(metal, x * x + y * y, 0.0)
    stretches = Stretches.of(z, mesh.triangles)
    reaches = {}
    for web in anatomy.webs:
        low, high = slab_of(web, anatomy.webs)
        reached = [square[(z >= low) & (z <= high)].max(initial=0.0)]
        for height in (low, high):
            corners = mesh.triangles.take(stretches.within(height, height), axis=0)
            start, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
            crossing = (z[start] < height) & (z[end] > height)  # of an edge's two triangles, one goes up it
            start, end = start[crossing], end[crossing]
            share = (height - z[start]) / (z[end] - z[start])
            across = [axis[start] + share * (axis[end] - axis[start]) for axis in (x, y)]
            reached.append((across[0] ** 2 + across[1] ** 2).max(initial=0.0))
        reaches[web.number] = math.sqrt(max(reached))
    return reaches


MAX_RADIUS_REDUCTION = 0.4
"""Largest share of the least radius that is given up."""
KIND = Turn()
