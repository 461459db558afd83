"""Common parts of the kinds drill and slug."""

from __future__ import annotations

import math
from abc import ABC
from typing import Any, TypeVar

from autobalance.correction.contract import Item, Limits
from autobalance.correction.holes.cut import HoleCut, is_kept_hole
from autobalance.correction.holes.hole import hole_shape
from autobalance.correction.holes.positions import completed_hole
from autobalance.correction.kind import Kind
from autobalance.correction.machining import Operation, hole_operation
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError
from autobalance.solid.csg.shape import Shape

L = TypeVar("L", bound=Limits)


class HoleKind(Kind[L], ABC):
    """A kind whose cuts are holes."""

    has_axis = True

    def is_kept(self, cut: HoleCut, item: Item) -> bool:
        return is_kept_hole(cut, item)

    def is_listed(self, cut: HoleCut, item: Item) -> bool:
        """Return whether a hole is the listed one; where its entry is not listed, it is the surface's."""
        if item["entry_radius_mm"] is None:
            return is_kept_hole(cut, {**item, "position_mm": cut.hole.axis.entry_mm.tolist()})
        if is_kept_hole(cut, item):
            return True
        entry = float(math.hypot(*cut.hole.axis.entry_mm[:2]))
        at_surface = {**item, "position_mm": cut.hole.axis.entry_mm.tolist()}
        if item["direction"] == "radial" and is_kept_hole(cut, at_surface):
            listed = float(item["entry_radius_mm"])
            raise CorrectionError(
                f"entry_radius_mm is {listed:g}; the crank's surface is at a radius of {entry:.4g} mm there"
            )
        return False

    def completed(self, item: Item, anatomy: Anatomy, limits: Any) -> Item:
        return completed_hole(item, anatomy, limits.direction)

    def machining(self, item: Item) -> Operation | str | None:
        return hole_operation(item)

    def drawn(self, item: Item) -> Shape:
        return hole_shape(item)
