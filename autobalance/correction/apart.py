"""Pairs of cuts of any method whose envelopes are too close.

Distances are bounded from below, for all pairs at once: too near never counts as far enough.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.contract import Apart, Cut, Envelope
from autobalance.correction.holes.walls import segments_distance_mm
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

NEAR_MM = 1e-9
"""Shortfall of a distance that counts as rounding."""
TOUCHING_MM = 0.05
"""Metal between cuts without a separate wall, so that each removes its own metal."""
STEPS = 5
"""Halvings of the interval for the depth that two cuts may both have: to 3 % of the deeper one."""
BAR_STEPS = 16
"""The same for two bars, whose distance is exact and fast to compute."""
DIRECTIONS = 60
"""Directions tried for a plane between two pieces; what is undecided then counts as too near."""


def between_kinds(cuts: Sequence[Cut], kinds: Sequence[int]) -> tuple[Apart, ...]:
    """Return the pairs of cuts of different kinds that come too near, with the depth that both may have.

    Two cuts keep the greater of their walls between them.

    Parameters
    ----------
    cuts : sequence of Cut
    kinds : sequence of int
        Equal numbers for cuts that their own kind has compared already.
    """
    if len(set(kinds)) < 2:
        return ()
    most = np.array([cut.max_depth_mm for cut in cuts])
    walls = np.array([max(cut.clearance_mm, TOUCHING_MM) for cut in cuts])
    return keep_apart([cut.envelope for cut in cuts], most, walls, np.asarray(kinds))


def keep_apart(
    envelopes: Sequence[Envelope], most_mm: Array, wall_mm: Array, groups: NDArray[np.int_] | None = None
) -> tuple[Apart, ...]:
    """Return the pairs of envelopes nearer than the greater of their walls, with the depth both may have.

    Only envelopes of different groups are compared, if there are ``groups``.
    """
    pieces = _EnvelopePieces.of(envelopes, most_mm)
    one, other = _near_rooms(pieces, len(envelopes), wall_mm, groups)
    a, b = _near_pieces(pieces, one, other, wall_mm)
    if not len(a):
        return ()
    need = np.maximum(wall_mm[pieces.owner[a]], wall_mm[pieces.owner[b]])
    bars = pieces.is_bar[a] & pieces.is_bar[b]
    depth = np.full(len(a), np.inf)
    for rows, far_enough, steps in ((bars, _bars_are_apart, BAR_STEPS), (~bars, _hulls_are_apart, STEPS)):
        if rows.any():
            depth[rows] = _clear_depths(pieces, a[rows], b[rows], need[rows], far_enough, steps)
    pair = pieces.owner[a] * len(envelopes) + pieces.owner[b]
    pairs, place = np.unique(pair, return_inverse=True)
    least = np.full(len(pairs), np.inf)
    np.minimum.at(least, place, depth)
    return tuple(
        Apart(*divmod(int(number), len(envelopes)), float(most))
        for number, most in zip(pairs, least, strict=True)
        if most < np.inf
    )


@dataclass(frozen=True, eq=False)
class _EnvelopePieces:
    """All pieces of envelopes, padded to as many corners; ``low`` and ``high`` hold at every depth."""

    owner: Indices
    start_mm: Array
    motion: Array
    radius_mm: Array
    most_mm: Array
    is_bar: NDArray[np.bool_]
    low: Array
    high: Array

    @classmethod
    def of(cls, envelopes: Sequence[Envelope], most_mm: Array) -> _EnvelopePieces:
        counts = [len(envelope.start_mm) for envelope in envelopes]
        corners = max(envelope.start_mm.shape[1] for envelope in envelopes)
        owner = np.repeat(np.arange(len(envelopes)), counts)
        start = np.concatenate([_padded(envelope.start_mm, corners) for envelope in envelopes])
        motion = np.concatenate([_padded(envelope.motion, corners) for envelope in envelopes])
        radius, most = np.concatenate([envelope.radius_mm for envelope in envelopes]), most_mm[owner]
        every = np.concatenate([start, start + most[:, None, None] * motion], axis=1)
        is_bar = np.repeat([envelope.start_mm.shape[1] == BAR_CORNERS for envelope in envelopes], counts)
        low, high = every.min(axis=1) - radius[:, None], every.max(axis=1) + radius[:, None]
        return cls(owner, start, motion, radius, most, is_bar, low, high)

    def at(self, rows: Indices, depth_mm: Array) -> Array:
        """Return the corners (p, k, 3) of some pieces, each at a depth or as deep as it goes."""
        depth = np.minimum(depth_mm, self.most_mm[rows])[:, None, None]
        corners: Array = self.start_mm[rows] + depth * self.motion[rows]
        return corners


BAR_CORNERS = 2
"""Corners of an envelope that is a bar: its two ends."""


def _padded(corners: Array, count: int) -> Array:
    """Return pieces (n, k, 3) with their last corner repeated up to a count of corners."""
    return corners[:, np.minimum(np.arange(count), corners.shape[1] - 1)]


def gap_mm(pair: Sequence[Envelope], depths_mm: Array, wanted_mm: float) -> float:
    """Return the distance between two envelopes at their depths, where it is less than the wanted one."""
    low, high = 0.0, wanted_mm
    while high - low > GAP_MM:
        middle = 0.5 * (low + high)
        near = bool(keep_apart(pair, depths_mm, np.full(2, middle)))
        low, high = (low, middle) if near else (middle, high)
    return low


GAP_MM = 5e-4
"""Accuracy of the reported gap of two cuts that are too close."""


def _near_rooms(
    pieces: _EnvelopePieces, count: int, wall_mm: Array, groups: NDArray[np.int_] | None
) -> tuple[Indices, Indices]:
    """Return the pairs of envelopes whose boxes are too near."""
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, pieces.owner, pieces.low)
    np.maximum.at(high, pieces.owner, pieces.high)
    i, j = np.triu_indices(count, 1)
    if groups is not None:
        differ = groups[i] != groups[j]
        i, j = i[differ], j[differ]
    for axis in (2, 0, 1):  # along the crank most are far apart
        need = np.maximum(wall_mm[i], wall_mm[j])
        near = (low[i, axis] - high[j, axis] < need) & (low[j, axis] - high[i, axis] < need)
        i, j = i[near], j[near]
    return i, j


def _near_pieces(pieces: _EnvelopePieces, i: Indices, j: Indices, wall_mm: Array) -> tuple[Indices, Indices]:
    """Return the pairs of pieces of pairs of envelopes whose boxes are too near."""
    first = np.searchsorted(pieces.owner, np.arange(len(wall_mm) + 1))
    counts = np.diff(first)
    each = counts[i] * counts[j]
    pair = np.repeat(np.arange(len(i)), each)
    within = np.arange(len(pair)) - np.repeat(np.cumsum(each) - each, each)
    a = first[i[pair]] + within // counts[j[pair]]
    b = first[j[pair]] + within % counts[j[pair]]
    need = np.maximum(wall_mm[i], wall_mm[j])[pair][:, None]
    near = (pieces.low[a] - pieces.high[b] < need) & (pieces.low[b] - pieces.high[a] < need)
    rows = near.all(axis=1)
    return a[rows], b[rows]


AreApart = Callable[[Array, Array, Array], NDArray[np.bool_]]
"""Test of pairs of pieces: from the corners of both and distances, whether each pair is so far apart."""


def _clear_depths(
    pieces: _EnvelopePieces, a: Indices, b: Indices, need_mm: Array, are_apart: AreApart, steps: int
) -> Array:
    """Return the depth that both pieces of each pair may have: infinite for any, −1 for none."""
    need = need_mm + pieces.radius_mm[a] + pieces.radius_mm[b]

    def clear(rows: Indices, depth: Array) -> NDArray[np.bool_]:
        return are_apart(pieces.at(a[rows], depth), pieces.at(b[rows], depth), need[rows])

    depths = np.full(len(a), np.inf)
    every = np.arange(len(a))
    close = every[~clear(every, depths)]
    depths[close] = -1.0
    open_ = close[clear(close, np.zeros(len(close)))]
    low, high = np.zeros(len(open_)), np.maximum(pieces.most_mm[a[open_]], pieces.most_mm[b[open_]])
    for _ in range(steps):
        middle = 0.5 * (low + high)
        is_clear = clear(open_, middle)
        low, high = np.where(is_clear, middle, low), np.where(is_clear, high, middle)
    depths[open_] = low
    return depths


def _bars_are_apart(a: Array, b: Array, need_mm: Array) -> NDArray[np.bool_]:
    """Return whether straight segments are far enough apart, exactly (p,)."""
    far: NDArray[np.bool_] = segments_distance_mm(a[:, 0], a[:, 1], b[:, 0], b[:, 1]) >= need_mm - NEAR_MM
    return far


def _hulls_are_apart(a: Array, b: Array, need_mm: Array) -> NDArray[np.bool_]:
    """Return whether planes between convex hulls prove them far enough apart (p,).

    The nearest point of the hulls' difference to the origin is approached along its corners; each
    direction on the way bounds the distance from below, each point from above.

    References
    ----------
    E. G. Gilbert, "An iterative procedure for computing the minimum of a quadratic form on a convex set",
    SIAM J. Control 4 (1966).
    """
    apart = np.zeros(len(a), dtype=bool)
    rows = np.arange(len(a))
    nearest = a.mean(axis=1) - b.mean(axis=1)
    for _ in range(DIRECTIONS):
        length = np.sqrt((nearest**2).sum(axis=1))
        towards = nearest / np.maximum(length, 1e-12)[:, None]
        corner = _farthest(a[rows], -towards) - _farthest(b[rows], towards)
        bound = (towards * corner).sum(axis=1)
        apart[rows[bound >= need_mm[rows]]] = True
        still = (bound < need_mm[rows]) & (length >= need_mm[rows])
        rows, nearest, corner = rows[still], nearest[still], corner[still]
        if not len(rows):
            break
        step = corner - nearest
        size = np.maximum((step**2).sum(axis=1), 1e-24)
        share = np.clip(-(nearest * step).sum(axis=1) / size, 0.0, 1.0)
        nearest = nearest + share[:, None] * step
    return apart


def _farthest(corners: Array, direction: Array) -> Array:
    """Return the corner (p, 3) of each piece (p, k, 3) farthest along a direction (p, 3)."""
    along = np.einsum("pkx,px->pk", corners, direction)
    return np.take_along_axis(corners, along.argmax(axis=1)[:, None, None], axis=1)[:, 0]
