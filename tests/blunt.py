"""Cranks whose webs have edges as a coarse circle might: blunt flanks, chamfers, drafts, knife edges."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.shape import (
    Arc,
    Joined,
    Line,
    Outline,
    Point,
    Prism,
    Revolved,
    Shape,
    circle,
    polygon,
    tessellated,
)
from autobalance.solid.csg.solid import Solid

DENSITY = 7.85e-3

PIN_MM, SHAFT_MM, HALF_MM = 26.0, 15.0, 15.0


def single(*webs: Shape) -> Shape:
    """Return a shaft and a crankpin with webs at z 15 to 35 and its mirror image."""
    shafts = [Prism(circle(SHAFT_MM), low, low + 41.0) for low in (-60.0, 19.0)]
    return Joined((*shafts, Prism(circle(16.0, (PIN_MM, 0.0)), -20.0, 20.0), *webs))


def both(profile: list[Point]) -> tuple[Shape, Shape]:
    """Return two turned webs of one profile (r, z), z from 15 to 35 and mirrored."""
    mirrored = [(r, -z) for r, z in reversed(profile)]
    return Revolved(polygon(profile)), Revolved(polygon(mirrored))


def flanked(*leans_deg: float) -> Shape:
    """Return a crank whose webs' flanks go from pin to rim in planes that each lean so much to the last."""
    angle, radius = math.radians(60.0), 20.0
    points = [(PIN_MM + radius * math.cos(angle), radius * math.sin(angle))]
    heading = angle
    for lean in (0.0, *leans_deg):
        heading += math.radians(lean)
        x, y = points[-1]
        points.append((x - 20.0 * math.sin(heading), y + 20.0 * math.cos(heading)))
    rim, at = math.hypot(*points[-1]), math.atan2(points[-1][1], points[-1][0])
    back = [(x, -y) for x, y in reversed(points)]
    outline: Outline = (
        Arc((PIN_MM, 0.0), radius, -angle, angle),
        *(Line(*pair) for pair in pairwise(points)),
        Arc((0.0, 0.0), rim, at, 2.0 * math.pi - at),
        *(Line(*pair) for pair in pairwise(back)),
    )
    return single(*(Prism(outline, low, low + 20.0) for low in (-35.0, 15.0)))


BLUNT: dict[str, Shape] = {
    "flanks that lean by 1°": flanked(1.0),
    "flanks that lean by 4°": flanked(4.0),
    "flanks that lean by 12°": flanked(12.0),
    "flanks that lean by 7° twice": flanked(7.0, 7.0),
    "chamfered webs": single(*both([(0, 15), (50.5, 15), (52, 16.5), (52, 33.5), (50.5, 35), (0, 35)])),
    "drafted webs": single(*both([(0, 15), (20, 15), (50, 17), (52, 25), (50, 33), (20, 35), (0, 35)])),
    "knife edges": single(*both([(0, 15), (30, 15), (52, 25), (30, 35), (0, 35)])),
    "rims of four cones": single(*both([(0, 15), (40, 15), (50, 17), (52, 25), (50, 33), (40, 35), (0, 35)])),
}
"""Each symmetric about z = 0, with shoulders that overlap."""


@cache
def blunt(name: str, segments: int) -> Solid:
    """Return such a crank as triangles, for all tests that ask for it once."""
    return tessellated(BLUNT[name], segments)


@cache
def true_moments(name: str) -> Moments:
    """Return its moments without facets: the limit of two tessellations, each arc's parts halved."""
    coarse, fine = (tessellated(BLUNT[name], 192, times).moments(DENSITY) for times in (1, 2))
    return fine.scaled(4.0 / 3.0) - coarse.scaled(1.0 / 3.0)
