"""Common parts of lowered and built-up faces: choice, frame, tools, listing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from typing import Any, ClassVar, TypeVar

import numpy as np

from autobalance.correction.contract import Correction, Item
from autobalance.correction.cut import EmptyPlace, listed
from autobalance.correction.faces.layer import DepthCurve, FaceLayer, moments_of
from autobalance.correction.faces.patches import (
    FaceLimits,
    Patch,
    auto_patches,
    chosen_patches,
    listed_patch,
    share_a_part,
)
from autobalance.correction.faces.trace import FaceTrace
from autobalance.correction.kind import Candidates, Kind, ListedCutError, Workpiece
from autobalance.correction.machining import loops_area_mm2, outline_shape, region_outline
from autobalance.correction.relaxing import Relaxing, deeper, thinner
from autobalance.correction.trace import Trace
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.errors import CorrectionError
from autobalance.quantities import mm, said
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Prism, Shape, Without, polygon, reversed_outline
from autobalance.solid.csg.tool import Lowering
from autobalance.types import Array
from autobalance.wording import degrees

# Common parts of lowered faces and metal on faces: choice of faces, their frame, their listing.


class FaceCut(EmptyPlace):
    """Cut into a planar face, or metal on one: the same with two signs."""

    face: Face
    to_face: Array
    sector_deg: tuple[float, float] | None
    density_g_mm3: float
    height_mm: float
    """Height of the face along its normal, from the rotor's origin."""

    @cached_property
    def _curve(self) -> DepthCurve:
        """Moments of the section at the new face, over the depth."""
        raise NotImplementedError

    @property
    def _sign(self) -> float:
        return 1.0 if self.adds_metal else -1.0

    @cached_property
    def to_rotor(self) -> Array:
        """The face's frame in the rotor's."""
        back = np.eye(4)
        back[:3, :3] = self.to_face[:3, :3].T
        return back

    def effect(self, depth_mm: float) -> Moments:
        return self._change(self._curve.integral(depth_mm))

    def rate(self, depth_mm: float) -> Moments:
        """Return d effect / d depth = ±ρ ∫ (1, r, r rᵀ) dA over the new face, rotor frame."""
        return self._change(self._curve.value(depth_mm))

    def _change(self, section: Array) -> Moments:
        return moments_of(section).moved(self.to_rotor).scaled(self._sign * self.density_g_mm3)

    def listed(self, kind: str, depth_mm: float, region: Region, **own: Any) -> Correction:
        """Return the finished correction; ``region`` is the face as it is now, in its own axes."""
        outline = region_outline(region, self.to_rotor)
        return listed(
            kind,
            self.effect(depth_mm),
            -self._sign * depth_mm,
            self.density_g_mm3,
            web=self.face.web,
            axis=self._sign * self.face.normal,
            tool_volume_mm3=abs(depth_mm) * loops_area_mm2(outline["outline"]),
            face=self.face.id,
            normal=[float(value) for value in self.face.normal],
            face_height_mm=self.height_mm,
            new_height_mm=self.height_mm + self._sign * depth_mm,
            **own,
            **outline,
            sector_deg=None if self.sector_deg is None else list(self.sector_deg),
        )


def patches_of(
    work: Workpiece, limits: FaceLimits, heavy_at: Sequence[tuple[float, Array]], search_level: int
) -> list[Patch]:
    """Return the patches of faces that a job picks, or of those on the heavy side."""
    mesh = work.solid.mesh
    if limits.faces == "auto":
        return auto_patches(mesh, work.anatomy, work.faces, heavy_at, limits, search_level)
    return chosen_patches(limits, mesh, work.anatomy, work.faces)


WHOLE_SIDE_DEG = 179.0
"""Angle from which on a sector is the whole heavy side, 180° except for rounding."""


def part_name(sector_deg: Sequence[float] | None) -> str:
    """Return the name of the part of a face that a cut keeps to; empty for a whole face or heavy side."""
    if sector_deg is None or not 0.0 < (sector_deg[1] - sector_deg[0]) % 360.0 < WHOLE_SIDE_DEG:
        return ""
    return f", its part from {degrees(sector_deg[0])} to {degrees(sector_deg[1])}"


def face_heights(item: Item) -> str:
    """Return the height of a corrected face before and after, where the report has them."""
    if item.get("new_height_mm") is None:
        return ""
    return said("{} → {}", mm(item["face_height_mm"], ",.3f"), mm(item["new_height_mm"], ",.3f"))


SAME_SECTOR_DEG = 0.5
"""Angle up to which sectors are the same: reports round theirs."""


def is_kept_face(cut: FaceCut, item: Item) -> bool:
    """Return whether a face, or its sector, is that of an earlier report."""
    listed = item.get("sector_deg")
    if cut.face.id != item.get("face") or (cut.sector_deg is None) != (listed is None):
        return False
    pairs = zip(cut.sector_deg or (), listed or (), strict=True)
    return all(abs((a - float(b) + 180.0) % 360.0 - 180.0) < SAME_SECTOR_DEG for a, b in pairs)


# A shoulder's tool without facets: a box over the new face, around the metal that is to go.


BESIDE_MM = 0.5
"""Margin of the box around the metal that it takes, and its distance from spared metal, if possible."""
SLIVER_MM = 0.01
"""Metal that is nowhere twice as thick is not metal, but the difference of two outlines."""
LAYER_SHARES = (1.0, 0.5, 0.2, 0.1, 0.04)
"""Shares of that distance tried between removed and spared metal."""


def lowering(layer: FaceLayer, depth_mm: float, to_rotor: Array, within: Shape | None) -> Lowering:
    """Return the tool that lowers a face; the exact solid finds the metal on the face itself.

    Raises
    ------
    CorrectionError
        If other metal is so near that the tool has no room between.
    """
    metal = layer.taken(depth_mm)
    low, high = metal.bounds
    low, high = (low - BESIDE_MM).tolist(), (high + BESIDE_MM).tolist()
    bottom, seed = layer.height_mm - depth_mm, layer.outline.inner_point()
    spared = layer.spared(depth_mm) & Region.rectangle(low, high)
    return Lowering(
        placement=to_rotor,
        outline=polygon([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]),
        face_mm=layer.height_mm,
        low_mm=bottom,
        seed=(float(seed[0]), float(seed[1])),
        spared=clear_of(spared, metal, (bottom - 1.0, layer.height_mm + 1.0)),
        within=within,
    )


def clear_of(spared: Region, metal: Region, heights_mm: tuple[float, float]) -> tuple[Shape, ...]:
    """Return prisms around metal to spare, with walls through air, well clear of the metal's surface.

    Slivers are left out: those lie between the facets of what is on the face and the tool's outline.
    """
    spared = spared.grown(-SLIVER_MM).grown(SLIVER_MM)
    if spared.is_empty:
        return ()
    for share in LAYER_SHARES:
        grown = spared.grown(share * BESIDE_MM).simplified(0.25 * share * BESIDE_MM)
        if (grown & metal).is_empty:
            return tuple(_prism(piece, heights_mm) for piece in grown.pieces())
    raise CorrectionError(
        f"other metal is nearer to the face than {LAYER_SHARES[-1] * BESIDE_MM:g} mm;"
        " no tool fits between them"
    )


def _prism(piece: Region, heights_mm: tuple[float, float]) -> Shape:
    """Return a connected region, with its holes, drawn out between two heights."""
    outlines = sorted(piece.polygons, key=lambda one: -Region.of([one]).area_mm2)
    drawn = [polygon([(float(x), float(y)) for x, y in outline]) for outline in outlines]
    outer = Prism(drawn[0], *heights_mm)
    holes = [Prism(tuple(reversed_outline(hole)), *heights_mm) for hole in drawn[1:]]
    return Without(outer, tuple(holes)) if holes else outer


# Common parts of the kinds of lowered and built-up faces.


L = TypeVar("L", bound=FaceLimits)


class FaceKind(Kind[L], ABC):
    """A kind whose cuts begin at planar faces."""

    search_levels = 3
    needs_faces = True
    offers_all = True
    described_by = ("face",)
    usual_depth_mm: ClassVar[float | None] = None
    """Largest depth if the job states no depth; None: limited by the metal."""

    def is_kept(self, cut: FaceCut, item: Item) -> bool:
        return is_kept_face(cut, item)

    def completed(self, item: Item, anatomy: Anatomy, limits: L) -> Item:
        """Return a listed face, which is named by its id; ids are those of ``inspect``."""
        del anatomy, limits
        if not isinstance(item.get("face"), str):
            raise CorrectionError("face is missing: the id of a face, as inspect lists them")
        return item

    def open_keys(self, item: Item) -> Mapping[str, Any]:
        """Return the limits of a listed face: itself, its sector, and no wall."""
        sector, usual = item.get("sector_deg"), self.usual_depth_mm
        return {
            "faces": (item["face"],),
            "sector_deg": None if sector is None else (float(sector[0]), float(sector[1])),
            "max_depth_mm": None if usual is None else max(abs(float(item["depth_mm"])), usual),
            "same_depth": False,
            "min_wall_mm": 0.0,
            "depth_step_mm": 0.0,
            "min_step_mm": 0.0,
        }

    def as_listed(self, work: Workpiece, limits: Sequence[L], items: Sequence[Item]) -> Candidates:
        """Return the listed faces with the rules among them."""
        patches = []
        for each, item in zip(limits, items, strict=True):
            try:
                patches.append(listed_patch(each, item["face"], item.get("sector_deg"), work))
            except CorrectionError as error:
                raise ListedCutError(item, str(error)) from None
        for (one, first), (other, second) in combinations(zip(items, patches, strict=True), 2):
            if share_a_part(first, second):
                raise ListedCutError(other, f"its part of face {second.face.id} is cut {one['number']}'s too")
        depths = [abs(float(item["depth_mm"])) for item in items]
        most = [each.max_depth_mm for each in limits if each.max_depth_mm is not None]
        together = replace(limits[0], max_depth_mm=max(most, default=None))
        found = self.of_patches(work, together, patches, max(depths))
        there = [(cut.face.id, cut.sector_deg) for cut in found.cuts if isinstance(cut, FaceCut)]
        for item, patch in zip(items, patches, strict=True):
            if (patch.face.id, patch.sector_deg) not in there:
                raise ListedCutError(item, "no metal can be changed there")
        return found

    def too_many(self, items: Sequence[Item], limits: L, stated: Collection[str]) -> str | None:
        """Return the warning that depths differ if a job wants one for all."""
        depths = {round(abs(float(item["depth_mm"])), 6) for item in items}
        if "same_depth" in stated and limits.same_depth and len(depths) > 1:
            return f"{len(depths)} different depths are listed; {self.name}.same_depth asks for one"
        return None

    @abstractmethod
    def of_patches(self, work: Workpiece, limits: L, patches: Sequence[Patch], reach_mm: float) -> Candidates:
        """Return the cuts of patches, one each where metal can be changed, looked for down to a depth."""

    def relaxing(self, limits: L) -> Sequence[Relaxing]:
        """Return ways to more depth or height, and to a thinner wall behind the face or clearance over it."""
        return *deeper(limits.max_depth_mm), *thinner(limits.min_wall_mm)

    def trace(self, item: Item) -> Trace:
        return FaceTrace(item, adds=self.adds_metal)

    def drawn(self, item: Item) -> Shape:
        """Return the body between the face before and after, within its new outline."""
        return outline_shape(item)

    def size(self, item: Item) -> str:
        return face_heights(item)
