"""Common parts of the kinds drill and slug."""

from __future__ import annotations

from abc import ABC
from typing import TypeVar

from autobalance.correction.contract import Item, Limits
from autobalance.correction.holes.cut import HoleCut, is_kept_hole
from autobalance.correction.holes.hole import hole_shape
from autobalance.correction.kind import Kind
from autobalance.correction.machining import Operation, hole_operation
from autobalance.solid.csg.shape import Shape

L = TypeVar("L", bound=Limits)


class HoleKind(Kind[L], ABC):
    """A kind whose cuts are holes."""

    has_axis = True

    def is_kept(self, cut: HoleCut, item: Item) -> bool:
        return is_kept_hole(cut, item)

    def machining(self, item: Item) -> Operation | str | None:
        return hole_operation(item)

    def drawn(self, item: Item) -> Shape:
        return hole_shape(item)
