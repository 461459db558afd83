"""All cylinders and bores along a crank, exact where the file keeps true surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from autobalance.crank.anatomy import Cylinder, CylinderKind, CylinderRole, Overrides, Web
from autobalance.crank.recognition.bores import bore_runs
from autobalance.crank.recognition.cylinder_runs import (
    SAME_CENTRE,
    SAME_RADIUS,
    CylinderRun,
    bare_cylinder,
    find_thin_runs,
)
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.crank.recognition.through_shaft import RING_DOUBT, holds
from autobalance.solid.cad.tessellation import CylinderFace
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Cylinders with the exact axes and radii of a solid's file, where it keeps true surfaces.


NEAR_RAD = 1e-2
"""An axis estimated from the surface's directions is that of cylinders which differ by less."""
PARALLEL_RAD = 1e-7
"""Axes of cylinders that differ by less are one direction, except for rounding [rad]."""
SAME_SHARE = 1e-3
"""A cylinder is the solid's own when centre and radius are this near, as shares of the radius."""
ONE_AXIS = 1e-7
"""Distance of two axes over the length, below which their journals lie on one line except for rounding."""


def own_direction(estimate: Array, cylinders: Sequence[CylinderFace]) -> Array | None:
    """Return the direction (3,) of most cylindrical surface near an estimate; None without such a surface."""
    near = [face for face in cylinders if float(np.linalg.norm(np.cross(face.axis, estimate))) < NEAR_RAD]
    if not near:
        return None
    axes = np.array([face.axis for face in near])
    areas = np.array([face.area_mm2 for face in near])
    apart = np.linalg.norm(np.cross(axes[:, None], axes[None]), axis=2)
    best: Array = axes[int(np.argmax((apart < PARALLEL_RAD) @ areas))]
    return best if float(best @ estimate) > 0.0 else -best


def own_layout(long: SectionStack, layout: JournalLayout, cylinders: Sequence[CylinderFace]) -> JournalLayout:
    """Return a layout with the solid's own centres and radii, if it has any."""
    journals = [own_cylinder(long, run, cylinders) for run in layout.journals]
    pins = [own_cylinder(long, run, cylinders) for run in layout.pins]
    centres = np.array([run.centre for run in journals])
    own = replace(layout, journals=tuple(journals), pins=tuple(pins))
    if journals and float(np.ptp(centres, axis=0).max()) <= ONE_AXIS * long.length_mm:
        return replace(own, axis=centres[0], settled=True)
    return own


def own_cylinder(long: SectionStack, run: CylinderRun, cylinders: Sequence[CylinderFace]) -> CylinderRun:
    """Return a run with the centre and radius of the solid's cylinder there; the same run without one."""
    turn = long.turn[:3, :3]
    best, most = run, 0.0
    for face in cylinders:
        axis, slack = turn @ face.axis, SAME_SHARE * run.radius
        if float(np.hypot(*axis[:2])) > NEAR_RAD or abs(face.radius_mm - run.radius) > slack:
            continue
        point = long.placed(face.point_mm)
        at = point + (run.z_mid - point[2]) / axis[2] * axis
        if float(np.hypot(*(at[:2] - run.centre))) > slack:
            continue
        ends = sorted(point[2] + along * axis[2] for along in (face.low_mm, face.high_mm))
        shared = (min(ends[1], run.z_high) - max(ends[0], run.z_low)) * face.swept_rad
        if shared > most:
            best, most = replace(run, centre=at[:2], radius=face.radius_mm), shared
    return best


# All bare cylinders and bores along a recognised crank, with what each was taken for.


LEAST_WIDTH_MM, LEAST_WIDTH_SHARE = 2.0, 0.05
"""Cylinders are listed from this width on, or from this share of the thickest main journal's diameter."""
SAME_STRETCH = 0.5
"""A cylinder belongs to a journal or a web when it shares so much of its width or of the journal's."""
BESIDE = 0.1
"""... and its middle is off the journal's by less than this share of the radius: typed ones are off, too."""
SAME_BORE = 0.05
"""A pressed-in crankpin's bore has its radius except for this share."""


@dataclass(frozen=True, eq=False)
class _Told:
    """A cylinder with its role."""

    run: CylinderRun
    kind: CylinderKind
    role: CylinderRole
    number: int | None = None


def all_cylinders(
    long: SectionStack,
    layout: JournalLayout,
    webs: Sequence[Web],
    overrides: Overrides,
    own: Sequence[CylinderFace],
    rounding_mm: float,
    to_rotor: Array,
) -> tuple[Cylinder, ...]:
    """Return the bare cylinders and bores of a crank, by increasing z.

    Parameters
    ----------
    long : SectionStack
    layout : JournalLayout
        With the bare cylinders from which it was chosen.
    webs : sequence of Web
        In the turned axes' z.
    overrides : Overrides
        Journals and crankpins that it states are listed as they are in the file.
    own : sequence of CylinderFace
        The solid's own, where its file keeps them: they are more exact.
    rounding_mm : float
    to_rotor : (4, 4) float
        From the turned axes to the rotor frame.
    """
    thickest = max((run.radius for run in layout.journals), default=0.0)
    least_mm = min(LEAST_WIDTH_MM, LEAST_WIDTH_SHARE * 2.0 * thickest)
    outside = list(layout.chosen_from)
    if long.blur_mm == 0.0:
        outside += find_thin_runs(long, rounding_mm, least_mm, outside)
    told = [
        *_held(
            layout.journals, outside, "main_journal", overrides.main_journals is not None, not layout.bored
        ),
        *_held(layout.pins, outside, "crankpin", overrides.crankpins is not None, overrides.crankpin_in_file),
    ]
    taken = [each.run for each in told]
    for run in outside:
        if not any(_is_part(run, other) for other in taken):
            told.append(_Told(_tight(long, run, own, rounding_mm), "outside", _role(run, layout, webs)))
    told += _bores(long, layout, told, least_mm, own, rounding_mm)
    wide = [each for each in told if each.number is not None or each.run.width >= least_mm]
    wide.sort(key=lambda each: (each.run.z_mid, each.run.radius))
    return tuple(_placed(each, to_rotor) for each in wide)


def _placed(each: _Told, to_rotor: Array) -> Cylinder:
    run = each.run
    centre = to_rotor[:3, :3] @ np.array([*run.centre, run.z_mid]) + to_rotor[:3, 3]
    return Cylinder(centre, 2.0 * run.radius, run.width, each.kind, each.role, each.number)


def _held(
    taken: Sequence[CylinderRun],
    outside: Sequence[CylinderRun],
    role: Literal["main_journal", "crankpin"],
    stated: bool,
    in_file: bool | None = True,
) -> list[_Told]:
    """Return the file's cylinder of each journal or crankpin: its own, or the nearest to a stated one."""
    told = []
    for number, run in enumerate(taken, 1):
        there = [
            other
            for other in outside
            if _shares(other, run) > SAME_STRETCH
            and (_is_beside(other, run) or (stated and _meets(other, run)))
        ]
        if stated and there:
            nearest = min(there, key=lambda other: float(np.linalg.norm(other.centre - run.centre)))
            told.append(_Told(nearest, "outside", role, number))
        elif not stated and (there or in_file):
            told.append(_Told(run, "outside", role, number))
    return told


def _shares(run: CylinderRun, other: CylinderRun) -> float:
    """Return the length that two cylinders share, over the lesser one's."""
    shared = min(run.z_high, other.z_high) - max(run.z_low, other.z_low)
    return shared / max(min(run.width, other.width), 1e-9)


def _is_beside(run: CylinderRun, other: CylinderRun) -> bool:
    return float(np.linalg.norm(run.centre - other.centre)) < BESIDE * max(run.radius, other.radius)


def _meets(run: CylinderRun, other: CylinderRun) -> bool:
    """Return whether one cylinder holds the other's middle: that of a typed one that is off."""
    return float(np.linalg.norm(run.centre - other.centre)) < max(run.radius, other.radius)


def _is_part(run: CylinderRun, other: CylinderRun) -> bool:
    """Return whether two cylinders are one."""
    return (
        _shares(run, other) > SAME_STRETCH
        and float(np.linalg.norm(run.centre - other.centre)) < SAME_CENTRE * run.radius
        and abs(run.radius - other.radius) < SAME_RADIUS * run.radius
    )


def _tight(
    long: SectionStack, run: CylinderRun, own: Sequence[CylinderFace], rounding_mm: float
) -> CylinderRun:
    """Return a cylinder fitted again in the final axes, or the solid's own."""
    if long.blur_mm > 0.0:
        return run
    pad = 1e-3 * run.radius
    reach = run.z_low - pad, run.z_high + pad
    again = bare_cylinder(long, run.centre, run.radius, reach, 0.9 * run.width, rounding_mm, (), 0.0)
    return own_cylinder(long, run if again is None else again, own)


def _role(run: CylinderRun, layout: JournalLayout, webs: Sequence[Web]) -> CylinderRole:
    """Return the feature of a bare cylinder that is neither journal nor crankpin.

    A web that is round lies beside the axis, or holds a crankpin; shoulders of webs do not.
    """
    on_axis = float(np.linalg.norm(run.centre - layout.axis)) < SAME_CENTRE * run.radius
    in_web = any(
        min(run.z_high, web.z_max_mm) - max(run.z_low, web.z_min_mm) > SAME_STRETCH * run.width
        for web in webs
    )
    if in_web and (not on_axis or any(holds(run, pin, layout.axis) for pin in layout.pins)):
        return "web"
    is_ring = run.width < RING_DOUBT * 2.0 * run.radius
    if on_axis:
        return "collar" if is_ring else "shaft"
    about_pin = any(
        float(np.linalg.norm(run.centre - pin.centre)) < SAME_CENTRE * run.radius for pin in layout.pins
    )
    return "collar" if about_pin and is_ring else "none"


# --- bores --------------------------------------------------------------------------------------------------


def _bores(
    long: SectionStack,
    layout: JournalLayout,
    told: Sequence[_Told],
    least_mm: float,
    own: Sequence[CylinderFace],
    rounding_mm: float,
) -> list[_Told]:
    """Return the bores; those of journals and crankpins that no cylinder outside is have their numbers."""
    numbered = {(each.role, each.number) for each in told}
    kinds: tuple[tuple[CylinderRole, Sequence[CylinderRun]], ...] = (
        ("main_journal", layout.journals),
        ("crankpin", layout.pins),
    )
    open_ends = [
        (role, number, run)
        for role, taken in kinds
        for number, run in enumerate(taken, 1)
        if (role, number) not in numbered
    ]
    bores = []
    for bore in bore_runs(long, rounding_mm):
        fitted = own_cylinder(long, bore, own)
        near = [each for each in open_ends if _is_beside(bore, each[2]) and _alike(bore, each[2].radius)]
        if near:
            role, number, _ = min(near, key=lambda each: _apart_mm(bore, each[2]))
            bores.append(_Told(fitted, "bore", role, number))
        elif bore.width >= least_mm:
            bores.append(_Told(fitted, "bore", "none"))
    return bores


def _alike(bore: CylinderRun, radius: float) -> bool:
    return abs(bore.radius - radius) < SAME_BORE * radius


def _apart_mm(run: CylinderRun, other: CylinderRun) -> float:
    """Return the distance of two cylinders along the axis, below 0 where they overlap."""
    return max(run.z_low, other.z_low) - min(run.z_high, other.z_high)
