"""The envelopes of cuts.

A cut's envelope is a set of convex pieces: hulls of a few corners, grown by a radius, each corner moving in a
straight line with the depth. A hole is one bar, a pocket a few blocks, a lowered face the prisms under its
triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.solid.csg.region import Region
from autobalance.types import Array

OUTLINE_MM = 0.1
"""Distance by which an outline may be simplified outwards for its envelope."""


@dataclass(frozen=True, eq=False)
class Envelope:
    """Convex pieces that enclose the metal that a cut takes, adds or replaces (rotor frame).

    At depth d a piece is all that lies within ``radius_mm`` (n,) of the hull of its corners
    ``start_mm + d motion`` (n, k, 3).
    """

    start_mm: Array
    motion: Array
    radius_mm: Array

    def corners(self, depth_mm: float) -> Array:
        """Return the pieces' corners (n, k, 3) at a depth."""
        return self.start_mm + depth_mm * self.motion

    def joined(self, other: Envelope) -> Envelope:
        return Envelope(*(np.concatenate(pair) for pair in zip(self._parts, other._parts, strict=True)))

    @property
    def _parts(self) -> tuple[Array, Array, Array]:
        return self.start_mm, self.motion, self.radius_mm


def bar(start_mm: Array, end_mm: Array, per_mm: Array, radius_mm: float) -> Envelope:
    """Return the envelope of a round bar between two points; the second moves with the depth."""
    return Envelope(
        np.stack([start_mm, end_mm])[None], np.stack([0.0 * per_mm, per_mm])[None], np.array([radius_mm])
    )


def drawn_out(region: Region, height_mm: float, per_mm: float, to_rotor: Array) -> Envelope:
    """Return the envelope over a plane region at a height, one end moving in z by ``per_mm`` a depth."""
    wider = region.grown(OUTLINE_MM).simplified(0.5 * OUTLINE_MM)
    base = wider.triangles()
    level = np.full((len(base), 3, 1), height_mm)
    foot = np.concatenate([base, level], axis=2) @ to_rotor[:3, :3].T + to_rotor[:3, 3]
    moving = np.broadcast_to(per_mm * to_rotor[:3, 2], foot.shape)
    start = np.concatenate([foot, foot], axis=1)
    return Envelope(start, np.concatenate([0.0 * moving, moving], axis=1), np.zeros(len(base)))


def blocks(low: Array, high: Array, low_motion: Array, high_motion: Array) -> Envelope:
    """Return the envelope of blocks between two sets of corners (n, k, 3), which may move with the depth."""
    corners, motion = np.concatenate([low, high], axis=1), np.concatenate([low_motion, high_motion], axis=1)
    return Envelope(corners, motion, np.zeros(len(low)))


def sector_corners(inner_mm: Array, outer_mm: Array, start_rad: Array, end_rad: Array) -> Array:
    """Return the corners (n, 4, 2) of quadrilaterals around sectors of rings about the origin."""
    far = outer_mm / np.cos(0.5 * (end_rad - start_rad))
    pairs = [(inner_mm, start_rad), (inner_mm, end_rad), (far, start_rad), (far, end_rad)]
    return np.stack([np.stack([r * np.cos(a), r * np.sin(a)], axis=-1) for r, a in pairs], axis=1)
