"""Stress of a crank's webs before and after its cuts, as a report has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Self

from autobalance.declare import ABSENT, Absent, Count, NotNegative, Ordinal, record

if TYPE_CHECKING:
    from autobalance.machine_models.web_bending import Bending as ComputedBending


@record
class WebBending:
    """Nominal stress M c/I + Q/A of a web's weakest section between crank axis and crankpin."""

    web: Ordinal
    throw: Ordinal
    before_MPa: NotNegative
    after_MPa: NotNegative


@record
class ThrowElements:
    """A throw by finite elements: von Mises' stress that 1 % of its surface exceeds."""

    throw: Ordinal
    before_MPa: NotNegative | None
    after_MPa: NotNegative | None
    nodes: Count | None
    seconds: Annotated[NotNegative, "processor time"]
    failed: Annotated[str | None, "why there is none"]


@record
class Bending:
    """Bending of each throw between its main journals by its rods' inertia at top dead centre."""

    force_N: Annotated[Sequence[NotNegative], "m r Ω² on each crankpin at service speed"]
    webs: Annotated[Sequence[WebBending], "beside throws that have a bay of their own"]
    elements: Annotated[ThrowElements | None, "the throw whose webs lose most"]

    @classmethod
    def of(cls, bending: ComputedBending | None) -> Self | Absent:
        """Return the stress of a run that was asked for it."""
        if bending is None:
            return ABSENT
        elements = bending.elements
        return cls(
            force_N=bending.force_N,
            webs=[WebBending(**vars(each)) for each in bending.webs],
            elements=None if elements is None else ThrowElements(**vars(elements)),
        )
