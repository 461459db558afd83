"""Common parts of the kinds of lowered and built-up faces."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from typing import TypeVar

from autobalance.correction.contract import Item
from autobalance.correction.faces.cut import FaceCut, face_heights, is_kept_face
from autobalance.correction.faces.patches import FaceLimits
from autobalance.correction.faces.trace import FaceTrace
from autobalance.correction.kind import Kind
from autobalance.correction.outline import outline_shape
from autobalance.correction.relaxing import Relaxing, deeper, thinner
from autobalance.correction.trace import Trace
from autobalance.solid.csg.shape import Shape

L = TypeVar("L", bound=FaceLimits)


class FaceKind(Kind[L], ABC):
    """A kind whose cuts begin at planar faces."""

    search_levels = 3
    needs_faces = True
    offers_all = True

    def is_kept(self, cut: FaceCut, item: Item) -> bool:
        return is_kept_face(cut, item)

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
