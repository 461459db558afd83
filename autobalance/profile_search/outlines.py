"""Outlines of profiles as plane regions and prisms (rotor frame)."""

from __future__ import annotations

import numpy as np

from autobalance.profile_search.profile import Profile
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

PAST_MM = 1e-5
"""Distance by which a cut passes the ends of the free metal: anything thinner is not metal."""


def sector_mm(profile: Profile, far_mm: float) -> Array:
    """Return the outline of a sector between the hold radius and ``far_mm``, in the profile's axes."""
    arc = profile.arc_mm
    return np.concatenate([arc * (far_mm / profile.hold_radius_mm), arc[::-1]])


def past(z_mm: tuple[float, float]) -> tuple[float, float]:
    """Return a range widened by ``PAST_MM`` at both ends."""
    return z_mm[0] - PAST_MM, z_mm[1] + PAST_MM


def prism(outline: Array, matrix: Array, z_mm: tuple[float, float]) -> Solid:
    """Return the prism of an outline in a profile's axes, turned to a web by its matrix (2, 2)."""
    return Solid.prism(Region.of([outline @ matrix.T]), *z_mm)


def placed_along(start_mm: Array, along: Array) -> Array:
    """Return the motion (4, 4) that takes the origin to a point and z to a direction."""
    helper = np.eye(3)[int(np.abs(along).argmin())]
    x = np.cross(helper, along)
    x = x / np.linalg.norm(x)
    motion = np.eye(4)
    motion[:3, :3] = np.column_stack([x, np.cross(along, x), along])
    motion[:3, 3] = start_mm
    return motion
