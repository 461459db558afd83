"""Constraints of a design: bounds of its profiles, clearances to its neighbours, ranges of amounts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.declare import UNWRITTEN, NotNegative, Triple
from autobalance.errors import JobError
from autobalance.profile_search.free_metal import FreeMetal
from autobalance.profile_search.input import DesignJob, SpaceEnvelope
from autobalance.profile_search.neighbours import (
    DesignClearance,
    Neighbour,
    OtherShaft,
    Piston,
    Rod,
    circle_mm,
    least_clearance,
)
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

ROUGH_ANGLES = 72
ROUGH_MM = 0.1
"""Extra clearance of a design that is judged only at every fifth degree."""
MAX_NORMAL_COMPONENT = -0.7
NO_LIMIT_MM = 1e6


@dataclass(frozen=True)
class Violation:
    """A constraint that is broken, with the amount and place."""

    constraint: str
    by: NotNegative
    unit: str
    at_mm: Triple | None
    at_deg: float | None


@dataclass(frozen=True)
class DesignConstraint:
    """A constraint on a design: ``margin`` is negative by the amount of its violation, in ``unit``."""

    name: str
    value: float
    limit: float
    unit: str
    margin: float
    scale: Annotated[float, UNWRITTEN] = 1.0
    at_mm: Annotated[tuple[float, float, float] | None, UNWRITTEN] = None
    at_deg: Annotated[float | None, UNWRITTEN] = None

    @property
    def violation(self) -> Violation | None:
        """Amount by which it is broken; None if it is met."""
        if self.margin >= 0.0:
            return None
        return Violation(self.name, -self.margin, self.unit, self.at_mm, self.at_deg)


@dataclass(frozen=True, eq=False)
class Amounts:
    """A design as numbers: control radii (n,) of each part and its thickness (None: unchanged)."""

    radii_mm: tuple[Array, ...]
    thickness_mm: tuple[float | None, ...]


def violation(constraints: Sequence[DesignConstraint]) -> float:
    """Return the sum of all violations, each as a multiple of its constraint's scale."""
    return float(sum(max(-each.margin / each.scale, 0.0) for each in constraints))


def of_profile(free: FreeMetal, k: int, amounts: Amounts, envelope: SpaceEnvelope) -> list[DesignConstraint]:
    """Return the constraints of part ``k``: those of the envelope and its own."""
    return [
        *_of_envelope(free, k, amounts, envelope),
        *_of_outline(free, k, amounts),
        *_of_holes(free, k, amounts),
    ]


def _placed(free: FreeMetal, k: int, amounts: Amounts, point: Array) -> tuple[float, float, float]:
    """Return a point of a profile in the rotor frame, midway through its first web."""
    web = next(web for web in free.webs if web.part == k)
    low, high = web.reach_mm(amounts.thickness_mm[k])
    x, y = web.matrix @ point
    return float(x), float(y), 0.5 * (low + high)


def _of_envelope(
    free: FreeMetal, k: int, amounts: Amounts, envelope: SpaceEnvelope
) -> list[DesignConstraint]:
    constraints, name = [], free.parts[k].name
    outline = free.profiles[k].outline_mm(amounts.radii_mm[k])
    far = np.linalg.norm(outline, axis=1)
    worst = int(far.argmax())
    if envelope.radius_mm is not None:
        most, at = float(far[worst]), _placed(free, k, amounts, outline[worst])
        limit = envelope.radius_mm
        constraints.append(DesignConstraint(f"{name} radius", most, limit, "mm", limit - most, 1.0, at))
    if envelope.z_mm is not None:
        z_low, z_high = envelope.z_mm
        for each in (web for web in free.webs if web.part == k):
            bottom, top = each.reach_mm(amounts.thickness_mm[k])
            room, z = min((bottom - z_low, bottom), (z_high - top, top))
            x, y = (float(value) for value in each.matrix @ outline[worst])
            place = f"{name} z, web {each.number}"
            constraints.append(DesignConstraint(place, room, 0.0, "mm", room, 1.0, (x, y, z)))
    return constraints


def _of_outline(free: FreeMetal, k: int, amounts: Amounts) -> list[DesignConstraint]:
    """Return the constraints on a profile's curvature and wall, of its smallest section if it has draft."""
    part, body = free.parts[k], free.bodies[k]
    thickness = amounts.thickness_mm[k] or free.thickness_mm(k)
    radii = body.radii_at(amounts.radii_mm[k], thickness)
    outline = body.profile.outline_mm(radii)
    constraints = []
    if part.min_curvature_radius_mm > 0.0:
        bend = body.profile.curvature_radii_mm(radii)[1:-1]
        tightest = int(bend.argmin())
        value, least = min(float(bend[tightest]), NO_LIMIT_MM), part.min_curvature_radius_mm
        at = _placed(free, k, amounts, outline[tightest + 1])
        constraints.append(
            DesignConstraint(f"{part.name} curvature", value, least, "mm", value - least, 1.0, at)
        )
    if part.min_wall_mm > 0.0:
        wall, place = _least_wall(outline)
        at = _placed(free, k, amounts, outline[place])
        margin = wall - part.min_wall_mm
        constraints.append(
            DesignConstraint(f"{part.name} wall", wall, part.min_wall_mm, "mm", margin, 1.0, at)
        )
    return constraints


def _of_holes(free: FreeMetal, k: int, amounts: Amounts) -> list[DesignConstraint]:
    """Return the constraints on the walls between a part's lightening holes and its smallest outline."""
    part, body = free.parts[k], free.bodies[k]
    if not body.holes:
        return []
    thickness = amounts.thickness_mm[k] or free.thickness_mm(k)
    outline = body.profile.outline_mm(body.radii_at(amounts.radii_mm[k], thickness))
    constraints = []
    for number, hole in enumerate(body.holes, 1):
        centre = np.asarray(hole.centre_mm)
        offset = outline - centre
        far = np.linalg.norm(offset, axis=1)
        place = int(far.argmin())
        inside = np.linalg.norm(centre) < np.linalg.norm(outline[place])
        wall = (float(far[place]) if inside else -float(far[place])) - 0.5 * hole.diameter_mm
        at = _placed(free, k, amounts, outline[place])
        name, least = f"{part.name} wall of hole {number}", part.min_wall_mm
        constraints.append(DesignConstraint(name, wall, least, "mm", wall - least, 1.0, at))
    return constraints


def clearances_of(
    free: FreeMetal, amounts: Amounts, neighbours: Sequence[Neighbour], near_mm: float, *, exact: bool
) -> list[DesignClearance]:
    """Return the least clearance of all free metal to each neighbour.

    If not ``exact``: at few angles, and without neighbours further along the axis than ``near_mm``.
    """
    clearances = []
    for neighbour in neighbours:
        each = []
        for web in free.webs:
            outline = free.profiles[web.part].outline_mm(amounts.radii_mm[web.part])
            points = (outline if exact else outline[::4]) @ web.matrix.T
            reach = web.reach_mm(amounts.thickness_mm[web.part])
            gap = max(neighbour.z_mm[0] - reach[1], reach[0] - neighbour.z_mm[1])
            if exact:
                each.append(least_clearance(neighbour, points, reach))
            elif gap <= near_mm + ROUGH_MM:
                each.append(least_clearance(neighbour, points, reach, refine=False, angles=ROUGH_ANGLES))
        if each:
            clearances.append(min(each, key=lambda clearance: clearance.least_mm))
    return clearances


def of_clearance(each: DesignClearance, wanted_mm: float) -> DesignConstraint:
    margin, at_deg = each.least_mm - wanted_mm, wrapped_deg(math.degrees(each.at_rad))
    name = f"clearance to {each.neighbour}"
    return DesignConstraint(name, each.least_mm, wanted_mm, "mm", margin, 1.0, each.at_mm, at_deg)


def of_range(name: str, value: float, limits: tuple[float, float]) -> list[DesignConstraint]:
    """Return both limits of a range as constraints."""
    low, high = limits
    scale = 0.01 * max(abs(low), abs(high))
    unit = "g" if name == "mass_g" else "kg·mm²"
    return [
        DesignConstraint(f"{name} least", value, low, unit, value - low, scale),
        DesignConstraint(f"{name} greatest", value, high, unit, high - value, scale),
    ]


def _least_wall(outline: Array) -> tuple[float, int]:
    """Return the least distance between points of an outline that face away from each other, and its place.

    The outline runs counter-clockwise, with the metal on its left.
    """
    points = outline[::2]
    along = np.empty_like(points)
    along[0], along[-1] = points[1] - points[0], points[-1] - points[-2]
    along[1:-1] = (points[2:] - points[:-2]) / 2.0
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    # few pairs face away from each other: only these are looked at further, in the order of their places
    one, other = np.nonzero(normal @ normal.T < MAX_NORMAL_COMPONENT)
    x, y = (points[other, axis] - points[one, axis] for axis in (0, 1))
    through = (x * normal[one, 0] + y * normal[one, 1] < 0.0) & (
        x * normal[other, 0] + y * normal[other, 1] > 0.0
    )
    if not through.any():
        return NO_LIMIT_MM, 0
    distance = np.sqrt(x[through] ** 2 + y[through] ** 2)
    nearest = int(distance.argmin())
    return min(float(distance[nearest]), NO_LIMIT_MM), 2 * int(one[through][nearest])


def neighbours_of(design: DesignJob, crank: Crank) -> list[Neighbour]:
    """Return the neighbours that free metal must keep clear of."""
    envelope, throws = design.envelope, crank.anatomy.throws
    length = design.start.engine.rod_length_mm
    if (envelope.pistons or envelope.rods) and length is None:
        raise JobError("engine.rod_length_mm is missing; pistons and rods of [envelope] need it")
    for number in (*(room.throw for room in envelope.pistons), *(room.throw for room in envelope.rods)):
        if number > len(throws):
            raise JobError(f"[envelope] names throw {number}; the crank has {len(throws)}")
        if length is not None and length <= throws[number - 1].crank_radius_mm:
            raise JobError(f"engine.rod_length_mm is {length:g}; must be more than the crank radius")
    neighbours: list[Neighbour] = []
    for piston in envelope.pistons:
        throw = throws[piston.throw - 1]
        assert length is not None
        neighbours.append(
            Piston(
                f"piston {piston.throw}",
                piston.z_mm,
                throw.angle_rad,
                throw.crank_radius_mm,
                length,
                piston.skirt_below_pin_mm,
                piston.half_width_mm,
            )
        )
    for rod in envelope.rods:
        throw = throws[rod.throw - 1]
        assert length is not None
        neighbours.append(
            Rod(
                f"rod {rod.throw}",
                rod.z_mm,
                throw.angle_rad,
                throw.crank_radius_mm,
                length,
                rod.big_end_radius_mm,
                rod.shank_half_width_mm,
            )
        )
    for number, shaft in enumerate(envelope.shafts, 1):
        outline = circle_mm(shaft.radius_mm) if shaft.radius_mm is not None else np.array(shaft.outline_mm)
        neighbours.append(
            OtherShaft(
                f"shaft {number}",
                shaft.z_mm,
                np.array(shaft.centre_mm),
                outline,
                shaft.ratio,
                shaft.phase_rad,
                shaft.radius_mm,
            )
        )
    return neighbours
