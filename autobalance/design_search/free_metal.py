"""A crank with parts of its webs taken out: what is held, and where free metal may go (rotor frame)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalance.balancing.measured_crank import Crank
from autobalance.crank.anatomy import Throw, Web
from autobalance.design_search.profile import Profile, fitted_radii_mm, refuse_crossing
from autobalance.errors import JobError
from autobalance.job.design import DesignJob, FreePart
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Region, Solid

Array = NDArray[np.float64]

RAYS = 181
FAR = 2.0
LEAST_HOLD_MM = 0.5
SNAP_MM = 1e-3
PAST_MM = 1e-5
"""How far a cut goes past the heights of the free metal: what is thinner is no metal."""
SKIN_MM = 1e-4
"""Old metal that is left around a new outline, so that no two surfaces nearly coincide."""


@dataclass(frozen=True, eq=False)
class FreeWeb:
    """A web's free metal.

    Attributes
    ----------
    number, part : int
        Of the web, and of the part (from 0) whose profile it has.
    turn_rad : float
        Angle of its crankpin in the rotor frame: profiles count from there.
    z_mm : (float, float)
        Where its metal was.
    grows_up : bool
        Whether a greater thickness reaches to greater z, away from the crankpin.
    """

    number: int
    part: int
    turn_rad: float
    z_mm: tuple[float, float]
    grows_up: bool

    @property
    def matrix(self) -> Array:
        """Rotation (2, 2) from the profile's axes to the rotor frame."""
        c, s = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return np.array([[c, -s], [s, c]])

    def reach_mm(self, thickness_mm: float | None) -> tuple[float, float]:
        """Return where the metal is at a thickness; None: where it was."""
        low, high = self.z_mm
        if thickness_mm is None:
            return low, high
        return (low, low + thickness_mm) if self.grows_up else (high - thickness_mm, high)


@dataclass(frozen=True, eq=False)
class FreeMetal:
    """What may change of a crank.

    Attributes
    ----------
    parts : sequence of FreePart
    profiles : sequence of Profile
        One a part.
    start_mm : sequence of (n,) float
        Control radii that follow the webs as they are.
    fit_error_mm : float
        How far they are off at most.
    webs : sequence of FreeWeb
    solid, held, region : Solid
        The crank as it came, what of it is held, and where metal is free; rotor frame.
    held_moments : Moments
    bounds_mm : sequence of (n, 2) float
        Of the control radii.
    """

    parts: Sequence[FreePart]
    profiles: Sequence[Profile]
    start_mm: Sequence[Array]
    fit_error_mm: float
    webs: Sequence[FreeWeb]
    solid: Solid
    held: Solid
    region: Solid
    far_mm: float
    held_moments: Moments
    bounds_mm: Sequence[Array]


def free_metal(design: DesignJob, crank: Crank) -> FreeMetal:
    """Return what a design job leaves free of its crank.

    Raises
    ------
    JobError
        If a web is not there, its control points cross, or held metal stands outside the envelope.
    """
    solid = crank.source.solid.moved(crank.anatomy.file_to_rotor)
    profiles, starts, webs, bounds, errors = [], [], [], [], []
    region = Solid.nothing()
    far = FAR * float(np.abs(solid.bounds[:, :2]).max())
    for index, part in enumerate(design.parts):
        found = [_free_web(part, index, number, crank, solid) for number in part.webs]
        profile, start, error = _profile(part, found[0], solid)
        profiles.append(profile)
        starts.append(start)
        errors.append(error)
        webs += found
        bounds.append(_bounds(part, profile, start, design.envelope.radius_mm))
        for web in found:
            region = region + _prism(_sector(profile, far), web, _past(web.z_mm))
    held = solid - region
    _refuse_held(held, design)
    moments = held.moments(crank.density_g_mm3)
    return FreeMetal(
        design.parts, profiles, starts, max(errors), webs, solid, held, region, far, moments, bounds
    )


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
    """Return a height as the solid's corners have it, where they nearly do: no film of metal is left."""
    nearest = float(heights[np.abs(heights - z_mm).argmin()])
    return nearest if abs(nearest - z_mm) < SNAP_MM else z_mm


def throw_of(web: Web, throws: Sequence[Throw]) -> Throw:
    """Return the throw whose crankpin is nearest to a web."""
    middle = 0.5 * (web.z_min_mm + web.z_max_mm)
    return min(throws, key=lambda throw: abs(float(throw.crankpin.centre_mm[2]) - middle))


def _profile(part: FreePart, web: FreeWeb, solid: Solid) -> tuple[Profile, Array, float]:
    """Return a part's profile, the control radii of its start, and how far these are off the web."""
    low, high = part.sector_rad
    angles = np.linspace(low, high, RAYS)
    section = solid.section(0.5 * (web.z_mm[0] + web.z_mm[1]))
    first, last = _radii_mm(section, angles + web.turn_rad)
    hold = part.hold_radius_mm or float(first.min())
    if hold < LEAST_HOLD_MM:
        raise JobError(
            f"{part.name}: web {web.number} has no metal about the axis there; needed hold_radius_mm"
        )
    if part.start_points_mm is None:
        profile = Profile.even((low, high), part.points, hold)
        start, error = fitted_radii_mm(profile, angles, np.maximum(last, hold))
        return profile, _held_points(part, np.maximum(start, hold)), error
    points = np.array(part.start_points_mm)
    refuse_crossing(points, part.name)
    if len(points) < 4:
        raise JobError(f"{part.name}.start_points_mm has {len(points)} points; needed at least 4")
    around = low + np.unwrap(np.arctan2(points[:, 1], points[:, 0]) - low)
    around = around - math.tau * round((around[0] - low) / math.tau)
    if (np.diff(around) <= 0.0).any() or around[0] < low - 1e-6 or around[-1] > high + 1e-6:
        raise JobError(
            f"{part.name}.start_points_mm cross or leave the sector: they must go counter-clockwise within it"
        )
    around[0], around[-1] = low, high
    return Profile(around, hold), _held_points(part, np.linalg.norm(points, axis=1)), 0.0


def _held_points(part: FreePart, radii: Array) -> Array:
    for number, radius in part.held_points:
        if not 1 <= number <= len(radii):
            raise JobError(f"{part.name}.held_points names point {number}; there are {len(radii)}")
        radii[number - 1] = radius
    return radii


def _bounds(part: FreePart, profile: Profile, start: Array, envelope_mm: float | None) -> Array:
    """Return the bounds (n, 2) of the control radii; a held point has one value."""
    low, high = part.radius_mm or (profile.hold_radius_mm, envelope_mm or float(start.max()))
    if not max(low, profile.least_radius_mm) < high:
        raise JobError(f"{part.name}: control points have no room between {low:g} and {high:g} mm")
    bounds = np.tile([max(low, profile.least_radius_mm), high], (profile.count, 1))
    for number, radius in part.held_points:
        bounds[number - 1] = radius
    return bounds


def _radii_mm(section: Region, angles: Array) -> tuple[Array, Array]:
    """Return the first and last crossing of rays from the axis with a section's outline, at angles."""
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


def _sector(profile: Profile, far_mm: float) -> Array:
    """Return the outline of everything of a sector beyond the hold radius, in the profile's axes."""
    arc = profile.arc_mm
    return np.concatenate([arc * (far_mm / profile.hold_radius_mm), arc[::-1]])


def _past(z_mm: tuple[float, float]) -> tuple[float, float]:
    return z_mm[0] - PAST_MM, z_mm[1] + PAST_MM


def _prism(outline: Array, web: FreeWeb, z_mm: tuple[float, float]) -> Solid:
    return Solid.prism(Region.of([outline @ web.matrix.T]), *z_mm)


def with_profiles(
    free: FreeMetal, radii_mm: Sequence[Array], thickness_mm: Sequence[float | None]
) -> tuple[Solid, float]:
    """Return the crank with these profiles (rotor frame), and by how much held volume differs, as a share.

    Old metal beyond the new outline is cut away and the new body added: metal that is old and new stays in
    one piece, without seams.
    """
    cut, added = Solid.nothing(), Solid.nothing()
    for web in free.webs:
        profile, thickness = free.profiles[web.part], thickness_mm[web.part]
        outline = Region.of([profile.polygon_mm(radii_mm[web.part]) @ web.matrix.T])
        sector = Region.of([_sector(profile, free.far_mm) @ web.matrix.T])
        reach = web.reach_mm(thickness)
        cut = cut + Solid.prism(sector - outline.grown(SKIN_MM), *_past(web.z_mm))
        for low, high in _thinner(web.z_mm, reach):
            cut = cut + Solid.prism(sector, low, high)
        added = added + Solid.prism(outline, *reach)
    total = (free.solid - cut) + added
    return total, (total - free.region - added).volume_mm3 / free.held.volume_mm3 - 1.0


def _thinner(old: tuple[float, float], new: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the heights that a thinner web leaves."""
    found = []
    if new[0] > old[0] + SNAP_MM:
        found.append((old[0] - PAST_MM, new[0]))
    if new[1] < old[1] - SNAP_MM:
        found.append((new[1], old[1] + PAST_MM))
    return found


def _refuse_held(held: Solid, design: DesignJob) -> None:
    """Refuse a start whose held metal stands outside the envelope."""
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
            f"{key}: held metal stands {values[worst] - limit:.3f} mm beyond {abs(limit):g} mm, at ({at}) "
            "mm; needed a wider envelope, or this metal free"
        )
