"""Check of cylinders against a drawn crank's surface, and readings that the rules leave open."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy, Cylinder, Doubt, MainJournal, Pin
from autobalance.crank.recognition.cylinder_runs import SAME_RADIUS, CylinderRun
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.rough_fits import WeightedPoints, fit_tilted_circle
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.crank.recognition.through_shaft import SAME_THICKNESS
from autobalance.errors import RecognitionError
from autobalance.solid.mesh.measure import Stretches
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Main journals and an axis that the rules of recognition leave open.


CENTRE_DIGITS, SIZE_DIGITS = 5, 4
"""Decimals of a line to paste: an axis 0.01 µm off costs less than a thousandth of any permissible value."""


def journal_doubts(
    journals: Sequence[MainJournal],
    others: Sequence[CylinderRun | None],
    cylinders: Sequence[Cylinder],
    to_rotor: Array,
    to_file: Array,
) -> tuple[Doubt, ...]:
    """Return a doubt for each main journal for which another cylinder may be meant.

    The line that takes the other one takes it at the other end, too, if the same choice is left open there.

    Parameters
    ----------
    journals : sequence of MainJournal
        In the rotor frame.
    others : sequence of CylinderRun or None
        The other cylinder for each journal, in the turned axes; empty without doubts.
    cylinders : sequence of Cylinder
        All of the crank.
    to_rotor, to_file : (4, 4) float
        From the turned axes to the rotor frame, and from that to the file's.
    """
    pairs = [
        (journal, None if run is None else _listed(run, cylinders, to_rotor))
        for journal, run in zip(journals, others or [None] * len(journals), strict=True)
    ]
    doubts = []
    for journal, other in pairs:
        if other is not None:
            meant = [
                there if there is not None and _alike((journal, other), (each, there)) else each
                for each, there in pairs
            ]
            doubts.append(Doubt("main_journal", journal.number, journal, other, _setting(meant, to_file)))
    return tuple(doubts)


def _alike(pair: tuple[Pin, Pin], other: tuple[Pin, Pin]) -> bool:
    """Return whether two choices are between cylinders of the same sizes, as at two equal ends of a crank."""
    return all(
        abs(a.diameter_mm - b.diameter_mm) < SAME_THICKNESS * a.diameter_mm
        for a, b in zip(pair, other, strict=True)
    )


def axis_doubts(found: Anatomy, layout: JournalLayout, to_rotor: Array) -> tuple[Doubt, ...]:
    """Return the doubt about the axis, if a crankpin's cylinder or bore may be the shaft's instead.

    ``to_rotor`` (4, 4) leads from the layout's axes to the rotor frame.
    """
    run = layout.other_axis
    if run is None:
        return ()
    centre = to_rotor[:3, :3] @ np.array([*run.centre, run.z_mid]) + to_rotor[:3, 3]
    place = (found.rotor_to_file @ np.array([*centre, 1.0]))[:3]
    point = ", ".join(_digits(float(value), CENTRE_DIGITS) for value in place)
    setting = layout.axis_setting or f"crankshaft.axis_point_mm = [{point}]"
    other = Pin(centre, 2.0 * run.radius, run.width)
    return (Doubt("axis", 1, found.main_journals[0], other, setting),)


def _listed(run: CylinderRun, cylinders: Sequence[Cylinder], to_rotor: Array) -> Pin:
    """Return the cylinder of the crank that a run is; it was fitted again since."""
    centre = to_rotor[:3, :3] @ np.array([*run.centre, run.z_mid]) + to_rotor[:3, 3]
    own = Pin(centre, 2.0 * run.radius, run.width)
    there = [
        each
        for each in cylinders
        if each.kind == "outside"
        and abs(each.diameter_mm - own.diameter_mm) < SAME_RADIUS * own.diameter_mm
        and each.z_range_mm[0] < centre[2] < each.z_range_mm[1]
    ]
    return min(there, key=lambda each: abs(float(each.centre_mm[2] - centre[2])), default=own)


def _setting(journals: Sequence[Pin], to_file: Array) -> str:
    """Return the line of a job that states main journals, in the file's own axes."""
    entries = []
    for pin in journals:
        centre = to_file[:3, :3] @ pin.centre_mm + to_file[:3, 3]
        place = ", ".join(_digits(float(value), CENTRE_DIGITS) for value in centre)
        sizes = (_digits(value, SIZE_DIGITS) for value in (pin.diameter_mm, pin.width_mm))
        diameter, width = sizes
        entries.append(f"{{ centre_mm = [{place}], diameter_mm = {diameter}, width_mm = {width} }}")
    return f"crankshaft.main_journals = [{', '.join(entries)}]"


def _digits(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("", "-0") else text


# Check of a drawn crank's cylinders against its surface: all round, and up to the cylinders' ends.
#
# Cylinders from sections or rings of vertices are compared with all triangles there, by area: one that noise
# or decimation mimics covers little of a cylinder, or its own surface is elsewhere.


MIN_COVER = 0.6
"""Smallest share of a cylinder's surface that exists: of a journal with a port all through it, 0.87."""
ONE_SIDED = 0.75
"""Largest one-sidedness of the missing surface, where a half would be 1: a gap of 90° is 0.71, one of 40°
(a port) 0.35; drillings and keyways are less than 0.1."""
OUTWARD, UPRIGHT = 0.8, 0.25
"""Triangles of a cylinder along z face away from its axis by more than the first, along z by less than the
second."""
BAND = 0.05
"""Largest distance of their corners from it, as a share of its radius."""
EXTENSION_RATIO = 0.15
"""A cylinder is sought for this share of its radius beyond its ends: fillets have left it there ..."""
MAX_COVER_BEYOND = 0.5
"""... and no more than this share of the surface there is its own,"""
MAX_ONE_SIDED_GAP = 0.5
"""unless more than this of it is missing on one side (as for ``ONE_SIDED``): metal is next to it there."""
MAX_OFFSET_RATIO = 1e-3
"""A cylinder lies where its surface does except for this share of its radius."""
WAVED_VERTEX_RATIO = 1e-4
"""Vertices that are off by more than this share of the radius are waved. The pin of a V6 whose vertices had
moved by 0.06 mm was 0.35 mm too small by its sections, and right to 0.01 mm by all its surface."""
MAX_LEAN_RATIO = 4e-3
"""A bent crank's cylinder leans by up to this share of its radius from its middle to an end."""
FACET_DEPTH_RATIO = 1.5
"""... or for so many times the depth of facets inside it."""
ON_IT = 5e-3
"""A cylinder's continuation beyond its end is off it by less than this share of the radius."""


@dataclass(frozen=True, eq=False)
class _Skin:
    """Triangles near a cylinder: their rows, corners (k, 3, 3), area vectors (k, 3) and areas (k,) [mm]."""

    rows: Indices
    corners: Array
    vectors: Array
    areas: Array

    def between(self, low: float, high: float) -> Array:
        """Return the share (k,) of each triangle between two heights."""
        a, b, c = np.sort(self.corners[:, :, 2], axis=1).T
        shares: Array = _below(a, b, c, high) - _below(a, b, c, low)
        return shares


def _below(a: Array, b: Array, c: Array, z: float) -> Array:
    """Return the share of each triangle, corners at a ≤ b ≤ c, below a height."""
    tall = np.maximum(c - a, 1e-12)
    lower = np.clip(z - a, 0.0, None) ** 2 / (tall * np.maximum(b - a, 1e-12))
    upper = 1.0 - np.clip(c - z, 0.0, None) ** 2 / (tall * np.maximum(c - b, 1e-12))
    share: Array = np.where(z <= a, 0.0, np.where(z >= c, 1.0, np.where(z < b, lower, upper)))
    return share


def on_surface(
    mesh: Mesh,
    long: SectionStack,
    cylinders: Sequence[tuple[str, CylinderRun]],
    rounding_mm: float,
    shafts: Sequence[CylinderRun] = (),
) -> tuple[CylinderRun, ...]:
    """Return cylinders, each fitted to its own surface where that lies beside it: that of a bent crank leans.

    ``cylinders`` are named; ``long`` is the mesh's own stack. Within ``shafts`` a cylinder may continue
    beyond its end.

    Raises
    ------
    RecognitionError If a cylinder's surface is missing, is incomplete or continues, with the place.
    """
    heights = Stretches.of(long.vertices[:, 2], mesh.triangles)
    mended = []
    for name, run in cylinders:
        skin = _skin(mesh, long, heights, run, rounding_mm)
        fault, better = _looked_at(skin, run, rounding_mm, shafts=shafts)
        if better is not run and not fault:
            fault, better = _looked_at(skin, better, rounding_mm, again=True, shafts=shafts)
        if fault:
            size = f"{2.0 * run.radius:.4g} mm in diameter and {run.width:.4g} mm long"
            raise RecognitionError(f"{name}, {size}: {fault}. Set main_journals and crankpins")
        mended.append(better)
    return tuple(mended)


def _skin(mesh: Mesh, long: SectionStack, heights: Stretches, run: CylinderRun, rounding_mm: float) -> _Skin:
    """Return the triangles that face away from a cylinder's axis, near its radius, to just past its ends."""
    reach, band = EXTENSION_RATIO * run.radius, BAND * run.radius + rounding_mm
    rows = heights.within(run.z_low - reach, run.z_high + reach)
    corners = long.vertices.take(mesh.triangles.take(rows, axis=0), axis=0)
    x, y = (corners[..., k] - run.centre[k] for k in range(2))
    away = x * x + y * y
    near = (away > max(run.radius - band, 0.0) ** 2) & (away < (run.radius + band) ** 2)
    kept = np.flatnonzero(near.all(axis=1))
    rows, corners = rows.take(kept), corners.take(kept, axis=0)
    vectors = 0.5 * mesh.area_vectors.take(rows, axis=0) @ long.turn[:3, :3].T
    areas = 0.5 * mesh.doubled_areas.take(rows)
    arm = corners[..., :2].mean(axis=1) - run.centre
    outward = (vectors[:, :2] * arm).sum(axis=1) > OUTWARD * areas * np.hypot(*arm.T)
    mine = np.flatnonzero(outward & (np.abs(vectors[:, 2]) < UPRIGHT * areas))
    return _Skin(rows.take(mine), corners.take(mine, axis=0), vectors.take(mine, axis=0), areas.take(mine))


def _looked_at(
    skin: _Skin,
    run: CylinderRun,
    rounding_mm: float,
    again: bool = False,
    shafts: Sequence[CylinderRun] = (),
) -> tuple[str, CylinderRun]:
    """Return a cylinder's fault, empty without one, and the cylinder of its surface.

    That is the same if the surface lies there; if not, it is not checked ``again`` more than once.
    """
    here = skin.between(run.z_low, run.z_high)
    share = float(skin.areas @ here) / (2.0 * math.pi * run.radius * max(run.width, 1e-9))
    if share < MIN_COVER:
        return f"only {100.0 * share:.0f} % of its surface exists, below {100.0 * MIN_COVER:.0f} %", run
    missing = float(np.linalg.norm(here @ skin.vectors[:, :2])) / (2.0 * run.radius * run.width)
    if missing > ONE_SIDED:
        most = f"above {100.0 * ONE_SIDED:.0f} %"
        return f"{100.0 * missing:.0f} % of one half of its surface is missing, {most}", run
    off, better = _fitted(skin, here, run)
    is_off = off > MAX_OFFSET_RATIO * run.radius + rounding_mm
    is_rough = rounding_mm > WAVED_VERTEX_RATIO * run.radius and off > MAX_OFFSET_RATIO * run.radius
    if not again and off < BAND * run.radius and (is_off or is_rough):
        return "", better
    if is_off:
        return (
            f"its surface is {off:.2g} mm off a cylinder, above {MAX_OFFSET_RATIO * run.radius:.2g} mm",
            run,
        )
    reach = EXTENSION_RATIO * run.radius
    for low, high in ((run.z_low - reach, run.z_low), (run.z_high, run.z_high + reach)):
        if any(shaft.z_low < high and low < shaft.z_high for shaft in shafts):
            continue
        beyond = skin.between(low, high) * (_on(skin, run, rounding_mm) > 0.0)
        more = float(skin.areas @ beyond) / (2.0 * math.pi * run.radius)
        one_sided = float(np.linalg.norm(beyond @ skin.vectors[:, :2])) / (2.0 * run.radius * reach)
        if (
            more > MAX_COVER_BEYOND * reach and one_sided <= MAX_ONE_SIDED_GAP
        ):  # more: metal was added at a side
            return f"its surface continues for {reach:.2g} mm beyond its end", run
    return "", run


def _fitted(skin: _Skin, here: Array, run: CylinderRun) -> tuple[float, CylinderRun]:
    """Return the offset of a cylinder's surface, largest of centre, radius and lean, and the cylinder there.

    Corners within facets are inside by the facets' depth, which is not a fault of the radius: by half the
    square of the angle between a facet's direction and the radius.
    """
    weights = np.repeat(skin.areas * here, 3)
    fit = fit_tilted_circle(WeightedPoints(skin.corners.reshape(-1, 3), weights), run.centre, run.radius)
    arms = skin.corners[..., :2] - run.centre
    along = (arms * skin.vectors[:, None, :2]).sum(axis=2)
    across = arms[..., 0] * skin.vectors[:, None, 1] - arms[..., 1] * skin.vectors[:, None, 0]
    inside = 0.5 * run.radius * float(weights @ np.arctan2(across, along).ravel() ** 2) / float(weights.sum())
    smaller = max(abs(fit.values[2] - run.radius) - FACET_DEPTH_RATIO * inside, 0.0)
    slopes = fit.values[3:5]
    centre = fit.values[:2] + (run.z_mid - fit.middle_mm) * slopes
    apart = [
        *(centre - run.centre),
        smaller,
        *np.clip(0.5 * run.width * np.abs(slopes) - MAX_LEAN_RATIO * run.radius, 0.0, None),
    ]
    return float(np.abs(apart).max()), replace(run, centre=centre, radius=float(fit.values[2]))


def _on(skin: _Skin, run: CylinderRun, rounding_mm: float) -> Array:
    """Return the area of each triangle (k,) [mm²], 0 for those that leave the cylinder."""
    away = np.hypot(skin.corners[..., 0] - run.centre[0], skin.corners[..., 1] - run.centre[1])
    on: Array = (np.abs(away - run.radius) < ON_IT * run.radius + rounding_mm).all(axis=1)
    return skin.areas * on
