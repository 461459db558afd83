"""Differences and common parts of two solids, without loss of metal, and double metal of one made single."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from autobalance.errors import OverlapError
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.types import Array
from autobalance.value_classes import dataclass

ADD_UP = 1e-9
"""Share of a solid's volume by which both differences may miss the difference of the two volumes, or both
parts of a split solid the whole."""
TURNS = ((1.0, 2.0, 3.0, 4.0), (5.0, -1.0, 3.0, 2.0), (4.0, 3.0, -2.0, 1.0))
"""Quaternions of turns after which no plane is parallel to an axis that it was parallel to before."""


def differences(one: Solid, other: Solid) -> tuple[Solid, Solid]:
    """Return the first of two solids less the second, and the second less the first.

    Where many planes of both are square to the axes and differ by rounding alone, manifold3d 3.5 may drop a
    wedge of metal between them: one of 926 mm³ lost 56. Then the volumes do not add up, and both solids are
    taken from each other in another position, if no plane is square to an axis.
    """
    more = one.volume_mm3 - other.volume_mm3
    best, least = (one - other, other - one), np.inf
    for turn in (None, *TURNS):
        pair = best if turn is None else _turned(one, other, _placement(turn))
        off = abs(pair[0].volume_mm3 - pair[1].volume_mm3 - more)
        if off < least:
            best, least = pair, off
        if least <= ADD_UP * one.volume_mm3:
            break
    return best


def common(one: Solid, other: Solid) -> Solid:
    """Return the metal that two solids share.

    A piece of metal left by an earlier boolean may carry films without volume. Along them manifold3d 3.5
    drops metal, in any position: half a millimetre at the end of a 617 mm³ strip next to a turned rim. Then
    the shared and the remaining metal do not add up, and the boolean is repeated with the piece built again
    from its triangles, then in other positions.
    """
    best, least = Solid.nothing(), np.inf
    for inside, outside in _splits(one, other):
        off = abs(inside.volume_mm3 + outside.volume_mm3 - one.volume_mm3)
        if off < least:
            best, least = inside, off
        if least <= ADD_UP * one.volume_mm3:
            break
    return best


def _splits(one: Solid, other: Solid) -> Iterator[tuple[Solid, Solid]]:
    """Yield the parts of the first solid inside and outside of the second, done again each time."""
    yield one.split(other)
    anew = one.built_anew() or one
    yield anew.split(other)
    for turn in TURNS:
        placement = _placement(turn)
        inside, outside = anew.moved(placement).split(other.moved(placement))
        yield inside.moved(placement.T), outside


def _turned(one: Solid, other: Solid, placement: Array) -> tuple[Solid, Solid]:
    """Return the differences of two solids, taken where ``placement`` (4, 4) puts them."""
    first, second = one.moved(placement), other.moved(placement)
    back = placement.T  # a rotation alone
    return (first - second).moved(back), (second - first).moved(back)


def _placement(quaternion: tuple[float, float, float, float]) -> Array:
    """Return the rotation (4, 4) of a quaternion."""
    w, *v = np.array(quaternion) / np.linalg.norm(quaternion)
    axis = np.array(v)
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    turned = np.eye(4)
    turned[:3, :3] = np.eye(3) + 2.0 * (w * cross + cross @ cross)
    return turned


# Double metal of one closed mesh: its volume, its place, and a solid in which it counts once.
#
# Booleans multiply winding numbers. With w at a point of body A, A - A has w - w², which is nothing if w is
# 0 or 1. So a body less itself is just its wrongly counted part, with its own surfaces as its outline.


ROUNDING_SHARE = 1e-7
"""Share of a solid that may be left to count twice when it was united: rounding of coordinates."""
HALVINGS = 8
"""Most halvings of a box around doubled metal before uniting is given up."""


@dataclass(frozen=True, eq=False)
class SelfOverlap:
    """Metal counted by a solid more than once, or as negative.

    Attributes
    ----------
    volume_mm3 : float
        Error of the solid's volume, each part counted as often as it is too much or too little.
    centre_mm : (3,) float
        Of the largest piece, in the solid's coordinates.
    bounds : (2, 3) float
        Of all of it.
    """

    volume_mm3: float
    centre_mm: Array
    bounds: Array


def self_overlap(solid: Solid) -> SelfOverlap | None:
    """Measure the metal that a solid counts twice; None if nothing is counted twice.

    A cut along the whole surface: ten times as long as building the solid.
    """
    wrong = solid - solid
    if wrong.is_empty:
        return None
    largest = min(wrong.pieces(), key=lambda piece: piece.volume_mm3)
    doubled = mesh_moments(largest.mesh, 1.0)
    if not doubled.mass_g < 0.0:  # w - w² is: what is left is folded triangles, no metal
        return None
    return SelfOverlap(-0.5 * wrong.volume_mm3, doubled.centre_mm, wrong.bounds)  # (w² - w) / 2


def united(solid: Solid) -> Solid:
    """Return a solid in which metal that counts twice counts once.

    Cut out by a box, the two layers of doubled metal are separate bodies, and those can be united. If they
    are still connected in a corner of the box, halves of the box separate them.

    Raises
    ------
    OverlapError
        If the layers cannot be parted, or metal counts as negative.
    """
    left = ROUNDING_SHARE * solid.volume_mm3
    result = _united(solid, left, HALVINGS)
    wrong = self_overlap(result)
    if wrong is not None and wrong.volume_mm3 > left:
        x, y, z = wrong.centre_mm
        raise OverlapError(
            f"the solid overlaps itself and could not be united: {wrong.volume_mm3:.4g} mm³ still count "
            f"wrongly around ({x:.6g}, {y:.6g}, {z:.6g}) mm in the file's coordinates",
            wrong.volume_mm3,
        )
    return result


def _united(solid: Solid, left_mm3: float, halvings: int) -> Solid:
    """Return a solid with its layers united, apart from volumes that are small enough to leave."""
    wrong = self_overlap(solid)
    if wrong is None or wrong.volume_mm3 <= left_mm3 or halvings == 0:
        return solid
    box = Solid.box(*wrong.bounds)
    pieces = (solid & box).pieces()
    if not pieces:  # too thin to be cut: nothing of it can be parted
        return solid
    if len(pieces) > 1:
        inside = _united(union(pieces), left_mm3, halvings - 1)
    else:
        inside = union([_united(half, left_mm3, halvings - 1) for half in _halves(pieces[0], wrong.bounds)])
    outside = solid - box
    return inside if outside.is_empty else union([outside, inside])


def _halves(solid: Solid, bounds: Array) -> list[Solid]:
    """Cut a solid in two across the longest edge of a box."""
    low, high = bounds
    axis = int(np.argmax(high - low))
    middle = 0.5 * (low[axis] + high[axis])
    end, start = high.copy(), low.copy()
    end[axis] = start[axis] = middle
    return [solid & Solid.box(low, end), solid & Solid.box(start, high)]
