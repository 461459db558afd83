"""Choice of the main journal on each stretch of the crank axis that crankpins part.

If several cylinders are on one stretch, the rules apply in this order. A cylinder as thick as the certain
journals is chosen first, then one next to the web that is not a thrust collar, then one as thick as journals
chosen in this way. A keyway, a spline or teeth mark a shaft. If the choice stays open, it is a doubt: one
cylinder is chosen, another may be meant.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.datums import shaft_marks
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.types import Array
from autobalance.value_classes import dataclass

SAME_THICKNESS = 0.02
"""Main journals of one crank differ by less than this share of their diameter, as a rule."""
RING, RING_DOUBT = 0.15, 0.3
"""A cylinder narrower than the first share of its diameter is a ring: a thrust collar, a gear's or a seal's.
One up to the second share may be. A public crank has shoulders of 54 mm by 12 mm at its webs, and its seats
of 34.93 mm by 18.8 mm behind them. Another one has main journals of 69.85 mm by 19.05 mm."""
ROUGH_RING = 0.9
"""Rounded edges of a scan leave so much of a ring's width (a journal of 19.05 mm: 17.44 mm)."""
LIKELY_RING = 0.225
"""Ratio of the ring's width to the width of the seat behind it below which the seat is chosen."""
SEAT = 0.4
"""Smallest width of a bearing's seat as a share of its diameter."""


@dataclass(frozen=True, eq=False)
class JournalChoice:
    """A main journal, and the cylinder that may be meant instead of it; None without a doubt."""

    run: CylinderRun
    other: CylinderRun | None = None


@dataclass(frozen=True, eq=False)
class _Stretch:
    """The cylinders on one stretch of the axis, by z, and whether a crankpin is below and above it."""

    runs: tuple[CylinderRun, ...]
    below: bool
    above: bool

    def outward(self, runs: Sequence[CylinderRun]) -> list[list[CylinderRun]]:
        """Return cylinders in their order from the web: at an end once, between crankpins from both sides."""
        orders = [list(runs)] if self.below else []
        return [*orders, list(runs)[::-1]] if self.above else orders


def journal_choices(
    long: SectionStack, on_axis: Sequence[CylinderRun], pins: Sequence[CylinderRun], axis: Array
) -> list[JournalChoice]:
    """Return the main journal of each stretch of the axis, by z; a stretch of discs alone has no journal.

    Parameters
    ----------
    long : SectionStack
    on_axis, pins : sequence of CylinderRun
        Cylinders on the axis, and crankpins.
    axis : (2,) float
        Of the crank, in the turned axes.
    """
    stretches = _stretches(on_axis, pins, axis)
    if not stretches:
        return [JournalChoice(max(on_axis, key=lambda run: run.width))]
    size = ROUGH_RING if long.blur_mm else 1.0
    likely = [_likely(long, stretch.runs, size) for stretch in stretches]
    certain = [runs[0].radius for runs in likely if len(runs) == 1]
    choices = [_chosen(*each, certain, size) for each in zip(stretches, likely, strict=True)]
    certain += [choice.run.radius for choice in choices if choice.other is None]
    return [
        choice if choice.other is None else _chosen(stretch, runs, certain, size)
        for choice, stretch, runs in zip(choices, stretches, likely, strict=True)
    ]


def _stretches(on_axis: Sequence[CylinderRun], pins: Sequence[CylinderRun], axis: Array) -> list[_Stretch]:
    """Return the stretches between crankpins, without the discs that hold one."""
    borders = sorted(pins, key=lambda run: run.z_mid)
    ends: list[CylinderRun | None] = [None, *borders, None]
    stretches = []
    for below, above in pairwise(ends):
        beside = [pin for pin in (below, above) if pin is not None]
        here = tuple(
            run
            for run in sorted(on_axis, key=lambda run: run.z_mid)
            if (below is None or run.z_mid >= below.z_mid)
            and (above is None or run.z_mid < above.z_mid)
            and not any(holds(run, pin, axis) for pin in beside)
        )
        if here:
            stretches.append(_Stretch(here, below is not None, above is not None))
    return stretches


def holds(disc: CylinderRun, pin: CylinderRun, centre: Array) -> bool:
    """Return whether a disc about ``centre`` (2,) is wide enough to hold a crankpin: it is a web."""
    offset = float(np.linalg.norm(pin.centre - centre))
    return disc.radius > offset + 0.98 * pin.radius


def _likely(long: SectionStack, runs: Sequence[CylinderRun], size: float) -> list[CylinderRun]:
    """Return the cylinders that are neither rings nor, if others are left, shafts; all if none is left."""
    wide = [run for run in runs if _is_wide(run.width, run, RING * size)]
    if len(wide) > 1 and long.blur_mm == 0.0:
        wide = [run for run in wide if not _is_shaft(long, run)] or wide
    return wide or [max(runs, key=lambda run: run.width)]


def _is_wide(width_mm: float, run: CylinderRun, share: float) -> bool:
    return width_mm >= share * 2.0 * run.radius


def _chosen(
    stretch: _Stretch, likely: Sequence[CylinderRun], certain: Sequence[float], size: float
) -> JournalChoice:
    """Return the choice among cylinders that are neither thin rings nor shafts."""
    alike = [run for run in likely if any(abs(run.radius - r) < SAME_THICKNESS * r for r in certain)]
    orders = stretch.outward(alike or likely)
    picks = [JournalChoice(order[0]) if alike else _beside_web(order, size) for order in orders]
    one, *more = picks
    if not more or more[0].run is one.run:
        other = next((pick.other for pick in picks if pick.other is not None), None)
        return JournalChoice(one.run, other)
    wide, narrow = sorted((one.run, more[0].run), key=lambda run: -run.width)
    return JournalChoice(wide, narrow)


def _beside_web(order: Sequence[CylinderRun], size: float) -> JournalChoice:
    """Return the cylinder next to the web, or the seat behind it where it may be a thrust collar."""
    ring, *rest = order
    if not rest or _is_wide(ring.width, ring, RING_DOUBT * size):
        return JournalChoice(ring)
    seat = rest[0]
    if seat.radius >= ring.radius or not _is_wide(seat.width, seat, SEAT):
        return JournalChoice(ring)
    if _is_wide(ring.width, ring, LIKELY_RING * size):
        return JournalChoice(ring, seat)
    return JournalChoice(seat, ring)


# --- keyways and splines ------------------------------------------------------------------------------------


def _is_shaft(long: SectionStack, run: CylinderRun) -> bool:
    """Return whether keyways, a spline or teeth leave less of a cylinder than a bearing's seat."""
    plain = [(run.z_low, run.z_high)]
    for low, high in shaft_marks(long, run):
        parts = ((a, min(b, low)) for a, b in plain), ((max(a, high), b) for a, b in plain)
        plain = [(a, b) for part in parts for a, b in part if a < b]
    plain_mm = max((b - a for a, b in plain), default=0.0)
    return plain_mm < run.width and not _is_wide(plain_mm, run, SEAT)
