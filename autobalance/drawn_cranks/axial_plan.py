"""Places of a crankshaft's parts along its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.drawn_cranks.design import Design
from autobalance.solid.csg.shape import on_grid

PAST_MM = 1.0
"""Reach of tools past the metal."""


@dataclass(frozen=True)
class Span:
    """A stretch along the axis; ``angle_rad`` is the angle of its crankpin, if it belongs to one."""

    low: float
    high: float
    angle_rad: float = 0.0
    counterweight: bool = False
    journal_side: int = 0
    second_angle_rad: float | None = None


@dataclass(frozen=True)
class AxialPlan:
    """Places of all parts along the axis: spans from face to face, fillets included."""

    journals: tuple[Span, ...]
    pins: tuple[Span, ...]
    webs: tuple[Span, ...]


def axial_plan(crank: Design) -> AxialPlan:
    """Return the places of journals, crankpins and webs, the first main journal beginning at z = 0."""
    journals: list[Span] = []
    pins: list[Span] = []
    webs: list[Span] = []
    here = 0.0

    def span(width: float) -> tuple[float, float]:
        nonlocal here
        low, here = here, on_grid(here + width)
        return low, here

    end = crank.end_journal_width_mm or crank.main_journal.width_mm
    thickness = crank.web.thickness_mm
    journals.append(Span(*span(end)))
    for number, bay in enumerate(crank.bays, start=1):
        angles = [math.radians(angle) for angle in bay.crankpins_deg]
        first, last = (flag and crank.counterweight is not None for flag in bay.counterweights)
        webs.append(Span(*span(thickness), angles[0], first, -1))
        for i, angle in enumerate(angles):
            pins.append(Span(*span(crank.crankpin.width_mm), angle))
            if i + 1 < len(angles):
                webs.append(Span(*span(crank.web.between_pins_mm), angle, second_angle_rad=angles[i + 1]))
        final = number == len(crank.bays)
        if final and crank.journals == "first":
            break
        webs.append(Span(*span(thickness), angles[-1], last, 1))
        journals.append(Span(*span(end if final else crank.main_journal.width_mm)))
    return AxialPlan(tuple(journals), tuple(pins), tuple(webs))


def has_free_end(crank: Design, plan: AxialPlan, pin: Span) -> bool:
    """Return whether a crankpin has a web below it only: the last one of an overhung crank."""
    return crank.journals == "first" and pin is plan.pins[-1]


def at_angle(radius: float, angle_rad: float) -> tuple[float, float]:
    return (radius * math.cos(angle_rad), radius * math.sin(angle_rad))


def shoulder_height_mm(crank: Design) -> float:
    """Return the height of counterweights beyond their webs."""
    size = crank.counterweight
    if size is None or size.thickness_mm is None:
        return 0.0
    return on_grid(size.thickness_mm - crank.web.thickness_mm)
