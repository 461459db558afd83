"""Journals of a pressed-up crank, whose throws are the gaps between bores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import dropwhile, takewhile

import numpy as np

from autobalance.crank.recognition.bored_webs import bored_arm, single_web
from autobalance.crank.recognition.bores import bore_runs
from autobalance.crank.recognition.cylinder_runs import SAME_CENTRE, CylinderRun, bare_cylinder
from autobalance.crank.recognition.journal_rules import journal_choices
from autobalance.crank.recognition.layout import JournalLayout, crank_axis, mean_centre
from autobalance.crank.recognition.section_stack import CrossSection, SectionStack
from autobalance.errors import RecognitionError
from autobalance.types import Array

BORE_DISTANCE_RATIO = 0.5
"""Ratio by which a bore of a half crank is nearer to the end with the web than to the other end."""


def pressed_up_layout(
    long: SectionStack, runs: Sequence[CylinderRun], given_axis: Array | None, rounding_mm: float
) -> JournalLayout:
    """Return journals and throws of a crank whose crankpins are not in the file, from the pins' bores.

    Raises
    ------
    RecognitionError
        If there is no axis, or no gap between webs has a bore at its sides.
    """
    web = _lone_web(long, runs, given_axis, rounding_mm)
    if web is not None:
        return web
    on_axis = crank_axis(long, runs, given_axis)
    axis = mean_centre(on_axis)
    gaps = _gaps(long, axis)
    if not gaps:
        raise RecognitionError(
            "no gap between webs and no web's face with a bore for the crankpin found; cylinders: "
            f"{len(on_axis)} on the axis, {len(runs) - len(on_axis)} beside it. "
            "Set crankpins, or crankpin_in_file = true if they are in the file"
        )
    pins = [_bore_pin(long, gap, axis, rounding_mm) for gap in gaps]
    layout = JournalLayout.chosen(axis, journal_choices(long, on_axis, pins, axis), pins)
    if gaps[0][1] > gaps[0][0]:
        return layout
    bores = bore_runs(long, rounding_mm)
    layout = replace(layout, pins=(_own_bore(bores, pins[0], gaps[0][0]),), lone_bores=True)
    arm = bored_arm(long, runs, bores)
    if arm is None or arm.settled is False:
        return layout
    other = arm.shaft if given_axis is None else None
    setting = "crankshaft.crankpin_in_file = true"
    return replace(layout, pins=(arm.shaft,), other_axis=other, axis_setting=setting)


def _own_bore(bores: Sequence[CylinderRun], pin: CylinderRun, end_mm: float) -> CylinderRun:
    """Return the bore that a crankpin is pressed into, of half a crank: the metal beside it is the web's.

    Of several in line, as the two sides of a counterbore are, it is the one next to the web's free face.
    """
    own = [bore for bore in bores if _near((bore.centre, bore.radius), (pin.centre, pin.radius))]
    if not own:
        raise RecognitionError(
            f"the crankpin's bore, {2.0 * pin.radius:.4g} mm wide, has no measurable depth. Set crankpins"
        )
    return min(own, key=lambda bore: min(abs(bore.z_low - end_mm), abs(bore.z_high - end_mm)))


def _lone_web(
    long: SectionStack, runs: Sequence[CylinderRun], given_axis: Array | None, rounding_mm: float
) -> JournalLayout | None:
    """Return the layout of one web of a built-up crank, whose bores are the shaft's and the crankpin's."""
    if not all(section.pieces for section in long.sections):
        return None
    web = single_web(long, runs, bore_runs(long, rounding_mm), is_web=given_axis is not None)
    if web is None:
        return None
    if given_axis is not None:
        away = [float(np.linalg.norm(bore.centre - given_axis)) for bore in (web.shaft, web.pin)]
        web = web if away[0] <= away[1] else web.exchanged
    other = web.pin if web.settled is None and given_axis is None else None
    return JournalLayout(
        web.shaft.centre, (web.shaft,), (web.pin,), bored=True, lone_bores=True, other_axis=other
    )


def _gaps(long: SectionStack, axis: Array) -> list[tuple[float, float]]:
    """Return the z ranges without metal; without any, the end of the part if there are bores."""
    z = long.vertices[:, 2]
    empty = [section.z_mm for section in long.sections if not section.pieces]
    gaps: list[tuple[float, float]] = []
    for height in empty:
        if not gaps or height > gaps[-1][1]:
            gaps.append((float(z[z < height].max()), float(z[z > height].min())))
    if gaps:
        return gaps
    ends = [(float(end), float(end)) for end in (z.min(), z.max())]
    depths = [_bore_depth(long, end, side, axis) for end, side in zip(ends, (1, -1), strict=True)]
    order = np.argsort(depths)
    first, second = (depths[place] for place in order)
    return [ends[order[0]]] if first < BORE_DISTANCE_RATIO * second else []


def _bore_depth(long: SectionStack, end: tuple[float, float], side: int, axis: Array) -> float:
    """Return the distance of a round hole beside the axis from an end of the part; infinite without one."""
    sections = _webward(long, end, side, axis)
    return abs(sections[0].z_mm - end[0]) if sections else np.inf


def _bore_pin(long: SectionStack, gap: tuple[float, float], axis: Array, rounding_mm: float) -> CylinderRun:
    sides = [_bores(_webward(long, gap, side, axis), axis) for side in (-1, 1)]
    with_bores = [bores for bores in sides if bores]
    if not with_bores or (gap[1] > gap[0] and len(with_bores) < 2):
        raise RecognitionError(
            f"a side of the gap between webs, {gap[0]:.4g} to {gap[1]:.4g} mm from the middle of the part, "
            "has no bore for the crankpin. Set crankpins"
        )
    shared = [
        bore
        for bore in with_bores[0]
        if all(any(_near(bore, other) for other in bores) for bores in with_bores)
    ]
    alone = [bore for bore in shared if not any(_twins(bore, other, axis) for other in shared)]
    shared = sorted(alone or shared, key=lambda bore: -bore[1])  # holes beside the pin come in pairs
    if not shared or (len(shared) > 1 and shared[1][1] > 0.95 * shared[0][1]):
        raise RecognitionError(
            f"{len(shared)} pairs of crankpin bores in line found, expected one. Set crankpins"
        )
    centre, radius = shared[0]
    z = long.vertices[:, 2]
    reach = 0.5 * (float(z.max()) - float(z.min()))
    exact = bare_cylinder(long, centre, radius, (gap[0] - reach, gap[1] + reach), 0.0, rounding_mm)
    if exact is not None and float(np.linalg.norm(exact.centre - centre)) < SAME_CENTRE * radius:
        centre, radius = exact.centre, exact.radius
    return CylinderRun(centre, radius, gap[0], gap[1])


def _twins(a: tuple[Array, float], b: tuple[Array, float], axis: Array) -> bool:
    """Return whether two different bores have one size and one distance from the axis."""
    away = [float(np.linalg.norm(bore[0] - axis)) for bore in (a, b)]
    alike = abs(a[1] - b[1]) < 0.05 * a[1] and abs(away[0] - away[1]) < SAME_CENTRE * away[0]
    return alike and not _near(a, b)


def _near(a: tuple[Array, float], b: tuple[Array, float]) -> bool:
    return float(np.linalg.norm(a[0] - b[0])) < SAME_CENTRE * min(a[1], b[1]) and abs(
        a[1] - b[1]
    ) < 0.2 * min(a[1], b[1])


def _webward(long: SectionStack, gap: tuple[float, float], side: int, axis: Array) -> list[CrossSection]:
    """Return the sections of the web beyond a gap that have a round hole beside the axis.

    The first few may be missing: those of a shoulder or a collar, and of a face that leans a little.
    """
    edge = gap[0] if side < 0 else gap[1]
    outward = sorted(
        (section for section in long.sections if side * (section.z_mm - edge) > 0.0),
        key=lambda section: side * section.z_mm,
    )
    solid = takewhile(lambda section: bool(section.pieces), outward)
    begun = dropwhile(lambda section: not _bores([section], axis), solid)
    return list(takewhile(lambda section: bool(_bores([section], axis)), begun))


def _bores(sections: Sequence[CrossSection], axis: Array) -> list[tuple[Array, float]]:
    """Return centre and radius of each round hole beside the axis, once."""
    bores: list[tuple[Array, float]] = []
    for section in sections:
        for piece in section.pieces:
            for bore in piece.bores:
                here = (bore.centre, bore.radius)
                beside = float(np.linalg.norm(bore.centre - axis)) > 0.1 * bore.radius
                if beside and not any(_near(here, other) for other in bores):
                    bores.append(here)
    return bores
