"""Deviation of a crank from its drawing, of `inspect --against`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Self

from autobalance.declare import NotNegative, Pair, Positive, Triple, record

if TYPE_CHECKING:
    from autobalance.crank.against import AgainstDrawing


@record
class Against:
    """Distances from the drawing's surface, outside positive, by area; differences are from it."""

    file: str
    mean_mm: float
    rms_mm: NotNegative
    p95_mm: Annotated[NotNegative, "95 % of the surface lies within"]
    worst_mm: float
    worst_at_mm: Triple
    mass_g: Annotated[Positive, "the drawing's"]
    unbalance_g_mm: Annotated[Pair, "the drawing's, in this crank's rotor frame"]
    mass_difference_g: float
    unbalance_difference_g_mm: Pair

    @classmethod
    def of(cls, against: AgainstDrawing) -> Self:
        return cls(
            file=against.file,
            mean_mm=against.mean_mm,
            rms_mm=against.rms_mm,
            p95_mm=against.p95_mm,
            worst_mm=against.worst_mm,
            worst_at_mm=against.worst_at_mm,
            mass_g=against.mass_g,
            unbalance_g_mm=against.unbalance_g_mm,
            mass_difference_g=against.mass_difference_g,
            unbalance_difference_g_mm=against.unbalance_difference_g_mm,
        )
