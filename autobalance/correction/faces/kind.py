"""Common parts of the kinds of lowered and built-up faces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, ClassVar, TypeVar

from autobalance.correction.contract import Item
from autobalance.correction.faces.cut import FaceCut, face_heights, is_kept_face
from autobalance.correction.faces.patches import FaceLimits, Patch, listed_patch, share_a_part
from autobalance.correction.faces.trace import FaceTrace
from autobalance.correction.kind import Candidates, Kind, ListedCutError, Workpiece
from autobalance.correction.outline import outline_shape
from autobalance.correction.relaxing import Relaxing, deeper, thinner
from autobalance.correction.trace import Trace
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError
from autobalance.solid.csg.shape import Shape

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
