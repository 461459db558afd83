"""Recognition of a connecting rod in a solid: its two eyes are the bores, parallel and round, at its ends."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from autobalance.crank.recognition.candidates import axis_candidates
from autobalance.crank.recognition.cylinder_runs import (
    ROUNDING,
    SAME_CENTRE,
    SAME_RADIUS,
    CylinderRun,
    bare_cylinder,
)
from autobalance.crank.recognition.cylinders import own_cylinder, own_direction
from autobalance.crank.recognition.section_stack import SectionStack, lengthwise
from autobalance.declare import Positive, Triple
from autobalance.errors import RecognitionError
from autobalance.solid.cad.tessellation import CylinderFace
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.value_classes import dataclass

TRIED_DIRECTIONS = 3
"""Directions tried: most of a rod's surface is along its eyes or square to them."""
LEAST_SHARE = 0.2
"""A bore smaller than this share of the largest is an oil hole or one for lightness, not an eye."""
END_SHARE = 3.0
"""Metal beyond an eye's centre, away from the other eye, reaches at most this many of its bore's radii: its
wall, a cap with bolts, a balance pad."""
SIDE_SHARE = 3.5
"""Metal beside the line of the eyes reaches at most this many radii of the larger bore: bolts of a cap."""
THICK_SHARE = 1.0
"""A rod is thinner along its eyes than they are apart."""
SAME_DIAMETER = 1e-3
"""Bores that differ by less count as equal; the big end is then the one nearer to the centre of mass."""


@dataclass(frozen=True, eq=False)
class RodEye:
    """One of the two bores; its centre, midway along it, in the rod's axes and in the file's."""

    centre_mm: Triple
    file_centre_mm: Triple
    diameter_mm: Positive
    width_mm: Positive


@dataclass(frozen=True, eq=False)
class RodEyes:
    """The eyes of a rod.

    Attributes
    ----------
    big, small : RodEye
    file_to_rod : (4, 4) float
        From the file's coordinates [mm] to the rod's: origin in the big end's centre, z along the eyes, x
        towards the small end. The largest component of z in the file is positive, as for a crank axis.
    """

    big: RodEye
    small: RodEye
    file_to_rod: Array

    @property
    def length_mm(self) -> float:
        """Distance of the eyes' axes [mm]."""
        return float(self.small.centre_mm[0])

    @property
    def offset_mm(self) -> float:
        """Height of the small end's middle over the big end's along the eyes [mm]."""
        return float(self.small.centre_mm[2])


def find_eyes(mesh: Mesh, centre_mm: Array, cylinders: Sequence[CylinderFace] = ()) -> RodEyes:
    """Return the eyes of a connecting rod.

    Parameters
    ----------
    mesh : Mesh
        Closed, in the file's coordinates [mm].
    centre_mm : (3,) float
        Centre of mass.
    cylinders : sequence of CylinderFace
        The solid's own, where its file keeps them: the eyes are theirs, not fitted.

    Raises
    ------
    RecognitionError
        If the solid is not a connecting rod; the message describes its bores.
    """
    rounding = ROUNDING * float(np.abs(mesh.bounds).max())
    rows, weight = mesh.sample
    reasons: list[tuple[int, str]] = []
    axes = axis_candidates(weight[:, None] * mesh.area_vectors.take(rows, axis=0))
    for axis in itertools.islice(axes, TRIED_DIRECTIONS):
        own = own_direction(axis, cylinders)
        long = lengthwise(mesh, _upright(axis if own is None else own), rounding)
        bores = _bores(long, rounding)
        bores_found = [
            own_cylinder(long, bore, [each for each in cylinders if each.hollow]) for bore in bores
        ]
        reason = _why_no_rod(long, bores_found)
        if reason is None:
            return _eyes(long, _ends(bores_found), long.placed(centre_mm))
        reasons.append((min(len(bores_found), 2), reason))
    most = max(reasons, key=lambda item: item[0], default=(0, "none was found"))[1]
    raise RecognitionError(f"no connecting rod: expected two parallel round bores at its ends; {most}")


def _upright(axis: Array) -> Array:
    """Return the direction whose largest component is positive, as a crank's axis has it."""
    size = np.abs(axis)
    return axis if axis[int(np.flatnonzero(size >= size.max() - 1e-6)[0])] > 0.0 else -axis


@dataclass(frozen=True, eq=False)
class _Hole:
    """A round hole in the sections from number ``first`` to ``last``."""

    centre: Array
    radius: float
    first: int
    last: int


def _bores(long: SectionStack, rounding_mm: float) -> list[CylinderRun]:
    """Return the round bores along the axis, the widest of each line, that are large enough for eyes."""
    holes: list[_Hole] = []
    for place, section in enumerate(long.sections):
        for circle in (bore for piece in section.pieces for bore in piece.bores):
            for number, hole in enumerate(holes):
                if hole.last == place - 1 and _is_same(hole, circle.centre, circle.radius):
                    holes[number] = _Hole(hole.centre, hole.radius, hole.first, place)
                    break
            else:
                holes.append(_Hole(circle.centre, circle.radius, place, place))
    runs = [run for run in (_run(long, hole, rounding_mm) for hole in holes) if run is not None]
    lines: list[CylinderRun] = []
    for run in sorted(runs, key=lambda each: -each.width):
        if all(float(np.linalg.norm(run.centre - other.centre)) > 0.5 * other.radius for other in lines):
            lines.append(_with_rest(run, runs))
    greatest = max((run.radius for run in lines), default=0.0)
    return [run for run in lines if run.radius >= LEAST_SHARE * greatest]


def _is_same(hole: _Hole, centre: Array, radius: float) -> bool:
    return (
        abs(radius - hole.radius) < SAME_RADIUS * hole.radius
        and float(np.linalg.norm(centre - hole.centre)) < SAME_CENTRE * hole.radius
    )


def _run(long: SectionStack, hole: _Hole, rounding_mm: float) -> CylinderRun | None:
    heights = [section.z_mm for section in long.sections]
    low = heights[hole.first - 1] if hole.first > 0 else -np.inf
    high = heights[hole.last + 1] if hole.last + 1 < len(heights) else np.inf
    span = heights[hole.last] - heights[hole.first]
    return bare_cylinder(long, hole.centre, hole.radius, (low, high), span, rounding_mm)


def _with_rest(run: CylinderRun, runs: Sequence[CylinderRun]) -> CylinderRun:
    """Return a bore with its parts beyond an oil groove."""
    parts = [
        other
        for other in runs
        if abs(other.radius - run.radius) < SAME_RADIUS * run.radius
        and float(np.linalg.norm(other.centre - run.centre)) < SAME_RADIUS * run.radius
    ]
    low, high = min(part.z_low for part in parts), max(part.z_high for part in parts)
    return CylinderRun(run.centre, run.radius, low, high)


def _ends(bores: Sequence[CylinderRun]) -> tuple[CylinderRun, CylinderRun]:
    return max(itertools.combinations(bores, 2), key=lambda pair: _apart(*pair))


def _apart(one: CylinderRun, other: CylinderRun) -> float:
    return float(np.linalg.norm(one.centre - other.centre))


def _why_no_rod(long: SectionStack, bores: Sequence[CylinderRun]) -> str | None:
    """Return the reason that bores along an axis are not the eyes of a rod; None where they are."""
    if len(bores) < 2:
        return f"found {len(bores)}"
    one, other = _ends(bores)
    apart = _apart(one, other)
    if apart <= one.radius + other.radius:
        return f"the two that were found, {apart:.4g} mm apart, overlap"
    if long.length_mm > THICK_SHARE * apart:
        return f"the solid is {long.length_mm:.4g} mm long along the bores, which are {apart:.4g} mm apart"
    along = (other.centre - one.centre) / apart
    places = (long.vertices[:, :2] - one.centre) @ along
    beyond = ((-float(places.min()), one), (float(places.max()) - apart, other))
    for reach, bore in beyond:
        if reach > END_SHARE * bore.radius:
            return (
                f"metal reaches {reach:.4g} mm beyond the centre of a bore of {2.0 * bore.radius:.4g} mm;"
                f" expected at most {END_SHARE * bore.radius:.4g}"
            )
    side = float(np.abs((long.vertices[:, :2] - one.centre) @ np.array([-along[1], along[0]])).max())
    most = SIDE_SHARE * max(one.radius, other.radius)
    return None if side <= most else f"metal reaches {side:.4g} mm to the side; expected at most {most:.4g}"


def _eyes(long: SectionStack, ends: tuple[CylinderRun, CylinderRun], centre: Array) -> RodEyes:
    """Return the eyes and the frame between them."""
    one, other = ends
    if abs(one.radius - other.radius) <= SAME_DIAMETER * one.radius:
        near = [float(np.linalg.norm(end.centre - centre[:2])) for end in ends]
        big, small = ends if near[0] <= near[1] else ends[::-1]
    else:
        big, small = ends if one.radius > other.radius else ends[::-1]
    along = (small.centre - big.centre) / _apart(big, small)
    local = np.eye(4)
    local[0, :2] = along
    local[1, :2] = [-along[1], along[0]]
    local[:3, 3] = -local[:3, :3] @ np.array([*big.centre, big.z_mid])
    back = long.turn[:3, :3].T

    def eye(end: CylinderRun) -> RodEye:
        at = np.array([*end.centre, end.z_mid])
        here, in_file = local[:3, :3] @ at + local[:3, 3], back @ (at - long.turn[:3, 3])
        return RodEye(here, in_file, 2.0 * end.radius, end.width)

    return RodEyes(eye(big), eye(small), local @ long.turn)
