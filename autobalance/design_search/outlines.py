"""Outlines of profiles as plane regions and prisms (rotor frame)."""

from __future__ import annotations

import numpy as np

from autobalance.design_search.profile import Profile
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

PAST_MM = 1e-5
"""How far a cut goes past the heights of the free metal: what is thinner is not metal."""


def sector_mm(profile: Profile, far_mm: float) -> Array:
    """Return the outline of everything of a sector beyond the hold radius, in the profile's axes."""
    arc = profile.arc_mm
    return np.concatenate([arc * (far_mm / profile.hold_radius_mm), arc[::-1]])


def past(z_mm: tuple[float, float]) -> tuple[float, float]:
    """Return heights that go past both ends of a range."""
    return z_mm[0] - PAST_MM, z_mm[1] + PAST_MM


def prism(outline: Array, matrix: Array, z_mm: tuple[float, float]) -> Solid:
    """Return an outline in a profile's axes extruded, turned to a web by its matrix (2, 2)."""
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
