"""A crank with parts of its webs removed: the held metal, and the room for free metal (rotor frame)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Throw, Web
from autobalance.errors import JobError
from autobalance.profile_search.input import DesignJob, FreePart
from autobalance.profile_search.outlines import (
    FreeBody,
    Profile,
    fitted_radii_mm,
    past,
    placed_along,
    prism,
    refuse_crossing,
    round_mm,
    sector_mm,
)
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

T = TypeVar("T")

RAYS = 181
FAR_RATIO = 2.0
LEAST_HOLD_MM = 0.5
SNAP_MM = 1e-3
OFF_HOLD_MM = 0.01
"""Room between a spline and the hold radius: where the two touch, the CAD kernel fails."""
SECTIONS = 5
"""Heights of a web at which the held disc is measured."""


@dataclass(frozen=True, eq=False)
class FreeWeb:
    """A web's free metal.

    Attributes
    ----------
    number, part : int
        Numbers of the web, and of the part (from 0) whose profile it has.
    turn_rad : float
        Angle of its crankpin in the rotor frame: profiles count from there.
    z_mm : (float, float)
        Range of its original metal.
    grows_up : bool
        Whether a greater thickness reaches to greater z, away from the crankpin.
    """

    number: int
    part: int
    turn_rad: float
    z_mm: tuple[float, float]
    grows_up: bool

    @cached_property
    def matrix(self) -> Array:
        """Rotation (2, 2) from the profile's axes to the rotor frame."""
        c, s = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return np.array([[c, -s], [s, c]])

    def reach_mm(self, thickness_mm: float | None) -> tuple[float, float]:
        """Return the range of the metal at a thickness; None: its original range."""
        low, high = self.z_mm
        if thickness_mm is None:
            return low, high
        return (low, low + thickness_mm) if self.grows_up else (high - thickness_mm, high)

    def heights_mm(self, depths_mm: Array) -> Array:
        """Return the z coordinates at distances from the face towards the crankpin."""
        heights: Array = self.z_mm[0] + depths_mm if self.grows_up else self.z_mm[1] - depths_mm
        return heights


@dataclass(frozen=True, eq=False)
class FreeMetal:
    """Metal of a crank that may change.

    Attributes
    ----------
    parts : sequence of FreePart
    bodies : sequence of FreeBody
        One for each part.
    start_mm : sequence of (n,) float
        Control radii that follow the webs as they are.
    fit_error_mm : float
        Largest distance between the webs and these.
    webs : sequence of FreeWeb
    solid, held, region : Solid
        The original crank, its held metal, and the region of free metal; rotor frame.
    held_moments : Moments
        Of the held metal, less the oil drillings through free metal.
    drillings : Solid
        Oil drillings kept open through free metal.
    bounds_mm : sequence of (n, 2) float
        Of the control radii.
    """

    parts: Sequence[FreePart]
    bodies: Sequence[FreeBody]
    start_mm: Sequence[Array]
    fit_error_mm: float
    webs: Sequence[FreeWeb]
    solid: Solid
    held: Solid
    region: Solid
    far_mm: float
    held_moments: Moments
    drillings: Solid
    bounds_mm: Sequence[Array]

    @property
    def profiles(self) -> list[Profile]:
        return [body.profile for body in self.bodies]

    def thickness_mm(self, part: int) -> float:
        """Return the original thickness of a part's webs."""
        low, high = next(web.z_mm for web in self.webs if web.part == part)
        return high - low


def free_metal(design: DesignJob, crank: Crank) -> FreeMetal:
    """Return the metal of a crank that its design job leaves free.

    Raises
    ------
    JobError
        If a web does not exist, its control points cross, or held metal is outside the envelope.
    """
    solid = crank.source.solid.moved(crank.anatomy.file_to_rotor)
    bodies, starts, webs, bounds, errors = [], [], [], [], []
    region = Solid.nothing()
    far = FAR_RATIO * float(np.abs(solid.bounds[:, :2]).max())
    for index, part in enumerate(design.parts):
        webs_here = [_free_web(part, index, number, crank, solid) for number in part.webs]
        body, start, error = _body(part, webs_here[0], solid)
        bodies.append(body)
        starts.append(start)
        errors.append(error)
        webs += webs_here
        bounds.append(_bounds(part, body, webs_here[0], start, design.envelope.radius_mm))
        for web in webs_here:
            region = region + prism(sector_mm(body.profile, far), web.matrix, past(web.z_mm))
    held = solid - region
    _refuse_held(held, design)
    drillings = _drillings(design, solid & region)
    moments = held.moments(crank.density_g_mm3) - drillings.moments(crank.density_g_mm3)
    return FreeMetal(
        design.parts, bodies, starts, max(errors), webs, solid, held, region, far, moments, drillings, bounds
    )


def regathered(free: FreeMetal, part: int, angles_rad: Array) -> FreeMetal:
    """Return free metal with a part's control points (n,) at other angles.

    Between widely spaced points the spline lies within them, so they may lie beyond the envelope, which the
    outline keeps.
    """
    body = free.bodies[part]
    if np.array_equal(angles_rad, body.profile.angles_rad):
        return free
    web = next(web for web in free.webs if web.part == part)
    angles = np.linspace(*free.parts[part].sector_rad, RAYS)
    profile = Profile(angles_rad, body.profile.hold_radius_mm)
    outline = _radii_mm(free.solid.section(0.5 * sum(web.z_mm)), angles + web.turn_rad)[1]
    start, error = fitted_radii_mm(profile, angles, np.maximum(outline, profile.hold_radius_mm))
    start = np.maximum(start, profile.hold_radius_mm) + 0.5 * body.slope * (web.z_mm[1] - web.z_mm[0])
    bounds = free.bounds_mm[part].copy()
    thickest = (free.parts[part].thickness_mm or (0.0, web.z_mm[1] - web.z_mm[0]))[1]
    bounds[:, 0] = np.maximum(bounds[:, 0], profile.least_radii_mm + body.slope * thickest + OFF_HOLD_MM)
    bounds[:, 1] *= 3.0 / (1.0 + 2.0 * math.cos(float(np.diff(angles_rad).max())))
    return replace(
        free,
        bodies=_with(free.bodies, part, replace(body, profile=profile)),
        start_mm=_with(free.start_mm, part, start),
        bounds_mm=_with(free.bounds_mm, part, bounds),
        fit_error_mm=max(free.fit_error_mm, error),
    )


def _with(values: Sequence[T], place: int, value: T) -> list[T]:
    return [value if k == place else each for k, each in enumerate(values)]


def _drillings(design: DesignJob, free: Solid) -> Solid:
    """Return the oil drillings within the original free metal."""
    total = Solid.nothing()
    for drilling in design.drillings:
        start, end = np.array(drilling.from_mm), np.array(drilling.to_mm)
        along = end - start
        length = float(np.linalg.norm(along))
        round_ = Region.of([round_mm(drilling.diameter_mm)])
        total = total + Solid.prism(round_, 0.0, length).moved(placed_along(start, along / length))
    return total & free


def _free_web(part: FreePart, index: int, number: int, crank: Crank, solid: Solid) -> FreeWeb:
    webs = crank.anatomy.webs
    if number > len(webs):
        raise JobError(f"{part.name}.webs names {number}; the crank has webs 1 to {len(webs)}")
    web = webs[number - 1]
    throw = throw_of(web, crank.anatomy.throws)
    heights = np.unique(solid.mesh.vertices[:, 2])
    low, high = part.z_mm or (web.z_min_mm, web.z_max_mm)
    z = _snapped(low, heights), _snapped(high, heights)
    above = 0.5 * (web.z_min_mm + web.z_max_mm) > float(throw.crankpin.centre_mm[2])
    return FreeWeb(number, index, throw.angle_rad, z, above)


def _snapped(z_mm: float, heights: Array) -> float:
    """Return a height, moved to a corner of the solid if close to one, so that no film of metal is left."""
    nearest = float(heights[np.abs(heights - z_mm).argmin()])
    return nearest if abs(nearest - z_mm) < SNAP_MM else z_mm


def throw_of(web: Web, throws: Sequence[Throw]) -> Throw:
    """Return the throw whose crankpin is nearest to a web."""
    middle = 0.5 * (web.z_min_mm + web.z_max_mm)
    return min(throws, key=lambda throw: abs(float(throw.crankpin.centre_mm[2]) - middle))


def _body(part: FreePart, web: FreeWeb, solid: Solid) -> tuple[FreeBody, Array, float]:
    """Return a part's body, the control radii of its start, and their largest error against the web."""
    low, high = part.sector_rad
    angles = np.linspace(low, high, RAYS)
    heights = np.linspace(*web.z_mm, SECTIONS + 2)[1:-1]
    sections = [_radii_mm(solid.section(z), angles + web.turn_rad) for z in heights]
    hold = part.hold_radius_mm or min(float(first.min()) for first, _ in sections)
    if hold < LEAST_HOLD_MM:
        raise JobError(f"{part.name}: web {web.number} has no metal about the axis there; set hold_radius_mm")
    profile, start, error = _profile(part, hold, angles, np.maximum(sections[SECTIONS // 2][1], hold))
    body = FreeBody(profile, math.tan(part.draft_rad), part.corner_radius_mm, part.holes)
    body.refuse_holes_outside(part.name)
    if part.start_points_mm is None:
        start = start + 0.5 * body.slope * (web.z_mm[1] - web.z_mm[0])  # fitted midway
    return body, _held_points(part, start), error


def _profile(part: FreePart, hold_mm: float, angles: Array, radii: Array) -> tuple[Profile, Array, float]:
    """Return a profile that follows radii at given angles, its control radii, and the largest error."""
    low, high = part.sector_rad
    if part.start_points_mm is None:
        profile = Profile.even((low, high), part.points, hold_mm)
        start, error = fitted_radii_mm(profile, angles, radii)
        return profile, np.maximum(start, hold_mm), error
    points = np.array(part.start_points_mm)
    refuse_crossing(points, part.name)
    if len(points) < 4:
        raise JobError(f"{part.name}.start_points_mm has {len(points)} points; expected at least 4")
    around = low + np.unwrap(np.arctan2(points[:, 1], points[:, 0]) - low)
    around = around - math.tau * round((around[0] - low) / math.tau)
    if (np.diff(around) <= 0.0).any() or around[0] < low - 1e-6 or around[-1] > high + 1e-6:
        raise JobError(
            f"{part.name}.start_points_mm cross or leave the sector: they must go counter-clockwise within it"
        )
    around[0], around[-1] = low, high
    return Profile(around, hold_mm), np.linalg.norm(points, axis=1), 0.0


def _held_points(part: FreePart, radii: Array) -> Array:
    for number, radius in part.held_points:
        if not 1 <= number <= len(radii):
            raise JobError(f"{part.name}.held_points names point {number}; there are {len(radii)}")
        radii[number - 1] = radius
    return radii


def _bounds(part: FreePart, body: FreeBody, web: FreeWeb, start: Array, envelope_mm: float | None) -> Array:
    """Return the bounds (n, 2) of the control radii; a held point has one value."""
    profile, thickest = body.profile, (part.thickness_mm or (0.0, web.z_mm[1] - web.z_mm[0]))[1]
    least = profile.least_radius_mm + body.slope * thickest
    low, high = part.radius_mm or (profile.hold_radius_mm, envelope_mm or float(start.max()))
    if not max(low, least) < high:
        raise JobError(
            f"{part.name}: control points have no room between {max(low, least):g} and {high:g} mm"
        )
    bounds = np.tile([max(low, least), high], (profile.count, 1))
    for number, radius in part.held_points:
        bounds[number - 1] = radius
    return bounds


def _radii_mm(section: Region, angles: Array) -> tuple[Array, Array]:
    """Return the first and last crossing of rays from the axis with a section's outline; 0: none."""
    starts = np.concatenate([np.zeros((0, 2)), *section.polygons])
    ends = np.concatenate([np.zeros((0, 2)), *(np.roll(polygon, -1, axis=0) for polygon in section.polygons)])
    first, last = np.zeros(len(angles)), np.zeros(len(angles))
    for place, angle in enumerate(angles):
        c, s = math.cos(angle), math.sin(angle)
        u0, v0 = starts @ [c, s], starts @ [-s, c]
        u1, v1 = ends @ [c, s], ends @ [-s, c]
        crosses = (v0 < 0.0) != (v1 < 0.0)
        at = u0[crosses] - v0[crosses] * (u1[crosses] - u0[crosses]) / (v1[crosses] - v0[crosses])
        ahead = np.sort(at[at > 0.0])
        if len(ahead):
            first[place], last[place] = ahead[0], ahead[-1]
    return first, last


def _refuse_held(held: Solid, design: DesignJob) -> None:
    """Refuse a start whose held metal is outside the envelope."""
    envelope, vertices = design.envelope, held.mesh.vertices
    if envelope.radius_mm is not None:
        radii = np.hypot(vertices[:, 0], vertices[:, 1])
        _refuse_beyond("envelope.radius_mm", radii, envelope.radius_mm, vertices)
    if envelope.z_mm is not None:
        _refuse_beyond("envelope.z_mm", vertices[:, 2], envelope.z_mm[1], vertices)
        _refuse_beyond("envelope.z_mm", -vertices[:, 2], -envelope.z_mm[0], vertices)


ROUNDING_MM = 1e-3


def _refuse_beyond(key: str, values: Array, limit: float, vertices: Array) -> None:
    worst = int(values.argmax())
    if values[worst] > limit + ROUNDING_MM:
        at = ", ".join(f"{value:.3f}" for value in vertices[worst])
        raise JobError(
            f"{key}: held metal is {values[worst] - limit:.3f} mm beyond {abs(limit):g} mm, at ({at}) "
            "mm; widen the envelope, or free this metal too"
        )
