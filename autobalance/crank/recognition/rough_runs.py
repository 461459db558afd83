"""Bare cylinders of a scanned crank: sections at even steps, circles through rough outlines, runs of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.section_stack import (
    CrossSection,
    SectionStack,
    pieces_of,
    rotated,
    turn_to_z,
)
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.slicing.slices import cross_sections
from autobalance.types import Array

STEP_MM = 0.6
STATIONS = (120, 600)
"""Sections are this far apart, but not fewer or more of them."""
MAX_OUTLINE_DISTANCE = (4.0, 0.02)
"""A rough outline may be off its circle by so many times the local roughness, and this much more [mm]:
waves longer than a neighbourhood, journals out of round."""
SAME_CENTRE, SAME_RADIUS = 0.03, 0.015
"""Circles follow each other along one shaft when centre and radius differ by less, as shares of the last."""
FACE_BLUR_STEPS = 3.0
"""A face lies within so many steps of the sections that show it."""
GAP_SHARE = 0.5
"""Drillings and grooves part a cylinder for this share of its radius."""
LEAST_WIDTH = 0.15
"""Bare cylinders shorter than this share of their radius are chamfers, collars and fillets."""
MOST_TAPER = 0.015
"""A cylinder's radius changes by less than this along its length: cones for pulleys begin at 1 : 40."""
MIN_SECTION_SHARE = 0.6
"""Smallest share of a cylinder's sections that show its circle."""


def rough_slack_mm(local_mm: float) -> float:
    """Return the largest distance of an outline from its circle, for a roughness [mm]."""
    return MAX_OUTLINE_DISTANCE[0] * local_mm + MAX_OUTLINE_DISTANCE[1]


def rough_stack(mesh: Mesh, direction: Array, slack_mm: float) -> SectionStack:
    """Return a scanned mesh with ``direction`` (3,) turned to z, cut at even steps; it has no levels yet."""
    turn = turn_to_z(direction, mesh.bounds.mean(axis=0))
    vertices = rotated(mesh.vertices, turn)
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    count = int(np.clip((high - low) / STEP_MM, *STATIONS))
    heights = low + (high - low) * (np.arange(count) + 0.5) / count
    outlines = cross_sections(vertices, mesh.triangles, heights)
    sections = tuple(
        CrossSection(float(z), pieces_of(outline, 0.0, slack_mm))
        for z, outline in zip(heights, outlines, strict=True)
    )
    step = (high - low) / count
    return SectionStack(turn, vertices, np.zeros(0), np.zeros(0), sections, blur_mm=FACE_BLUR_STEPS * step)


@dataclass(frozen=True, eq=False)
class _Ring:
    """A circle that is a whole piece of a section."""

    place: int
    z_mm: float
    centre: Array
    radius: float


def rough_runs(long: SectionStack) -> list[CylinderRun]:
    """Return the bare cylinders along a rough shaft, by increasing z."""
    chains: list[list[_Ring]] = []
    step = long.blur_mm / FACE_BLUR_STEPS
    for place, section in enumerate(long.sections):
        for piece in section.pieces:
            if piece.circle is None:
                continue
            ring = _Ring(place, section.z_mm, piece.circle.centre, piece.circle.radius)
            for chain in reversed(chains):
                if _follows(ring, chain[-1], step):
                    chain.append(ring)
                    break
            else:
                chains.append([ring])
    runs = [run for chain in chains for run in _cylinders(chain, long)]
    return sorted(_distinct(runs), key=lambda run: run.z_mid)


def _follows(ring: _Ring, last: _Ring, step: float) -> bool:
    return (
        0.0 < ring.z_mm - last.z_mm <= max(GAP_SHARE * last.radius, 2.1 * step)
        and abs(ring.radius - last.radius) < SAME_RADIUS * last.radius + 0.05
        and float(np.linalg.norm(ring.centre - last.centre)) < SAME_CENTRE * last.radius
    )


def _cylinders(chain: Sequence[_Ring], long: SectionStack) -> list[CylinderRun]:
    """Return the stretches of a chain over which its circle stays the same."""
    runs: list[CylinderRun] = []
    rest = list(chain)
    slack = long.sections[chain[0].place].pieces[0].rough_mm
    step = long.blur_mm / FACE_BLUR_STEPS
    while len(rest) >= 3:
        radii = np.sort([ring.radius for ring in rest])
        held = np.searchsorted(radii, radii + slack, side="right") - np.arange(len(radii))
        best = len(held) - 1 - int(np.argmax(held[::-1]))
        radius = float(np.median(radii[best : best + held[best]]))
        same = [ring for ring in rest if abs(ring.radius - radius) <= slack]
        stretch = _longest(same, radius, step)
        if len(stretch) < 3:
            break
        run = _run(stretch, step)
        if run is not None:
            runs.append(run)
        rest = [ring for ring in rest if all(ring is not other for other in stretch)]
    return runs


def _longest(same: Sequence[_Ring], radius: float, step: float) -> list[_Ring]:
    stretches: list[list[_Ring]] = [[]]
    for ring in same:
        if stretches[-1] and ring.z_mm - stretches[-1][-1].z_mm > max(GAP_SHARE * radius, 2.1 * step):
            stretches.append([])
        stretches[-1].append(ring)
    return max(stretches, key=len)


def _run(stretch: Sequence[_Ring], step: float) -> CylinderRun | None:
    z = np.array([ring.z_mm for ring in stretch])
    radii = np.array([ring.radius for ring in stretch])
    radius, width = float(np.median(radii)), float(np.ptp(z)) + step
    if width < max(LEAST_WIDTH * radius, 3.0 * step) or len(stretch) * step < MIN_SECTION_SHARE * width:
        return None
    slope = float(np.polyfit(z - z.mean(), radii, 1)[0])
    if abs(slope) > MOST_TAPER and abs(slope) * width > 0.1:
        return None
    centre = np.median([ring.centre for ring in stretch], axis=0)
    return CylinderRun(centre, radius, float(z[0]) - 0.5 * step, float(z[-1]) + 0.5 * step)


def _distinct(runs: Sequence[CylinderRun]) -> list[CylinderRun]:
    """Return cylinders without those that are part of a longer one."""
    kept: list[CylinderRun] = []
    for run in sorted(runs, key=lambda run: -run.width):
        if not any(
            min(run.z_high, other.z_high) - max(run.z_low, other.z_low) > 0.5 * run.width
            and float(np.linalg.norm(run.centre - other.centre)) < SAME_CENTRE * run.radius
            for other in kept
        ):
            kept.append(run)
    return kept
