"""Assignment of the metal that went or came to the corrections."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.correction import KINDS
from autobalance.correction.trace import Before, Trace
from autobalance.solid.csg.solid import Solid, union
from autobalance.verification.claims import Claims

VALUE_TOLERANCE_SHARE = 1e-3
"""Share by which values measured of the metal may differ from a report's: facets, rounding."""
THICKNESS_IN_ROUNDINGS = 16.0
"""Thickness up to which metal counts as rounding, in roundings of the file."""


def _pieces(metal: Solid, near_mm: float) -> list[Solid]:
    """Return the pieces of metal that are thicker than rounding."""
    return [] if metal.is_empty else metal.thicker_pieces(THICKNESS_IN_ROUNDINGS * near_mm)


@dataclass(frozen=True, eq=False)
class SeparatedMetal:
    """A correction's metal, piece by piece; None where it cannot be separated from another's.

    ``is_torn`` if it hangs together with such wide flaps of the file's rounding that all of it is as thin as
    they. ``skin`` is the metal there if all of it is as thin as rounding.
    """

    metal: tuple[Solid, ...] | None
    is_torn: bool
    skin: Solid


def shared_out(
    metal_gone: tuple[Solid, Solid],
    parts: Sequence[Claims],
    traces: Sequence[Trace | None],
    crank: Before,
    near_mm: float,
) -> list[SeparatedMetal]:
    """Return the metal of each correction.

    Parameters
    ----------
    metal_gone : (Solid, Solid)
        The metal that went, and that came, rotor frame.
    parts, traces : sequences, one a correction
        Its listed values, and its expected trace in the metal.
    crank : Before
    near_mm : float
        Error of places.
    """
    rooms = [Solid.nothing() if trace is None else trace.room(crank) for trace in traces]
    adds = [KINDS[part.get("kind", str)].adds_metal for part in parts]
    mine: list[list[Solid]] = [[] for _ in parts]
    torn: set[int] = set()
    skins = [Solid.nothing()] * len(parts)
    for came in (False, True):
        candidates = [k for k, each in enumerate(adds) if each == came]
        metal, mixed = metal_gone[int(came)], []
        for piece in _pieces(metal, near_mm) if candidates else []:
            owners = [k for k in candidates if _holds(rooms[k], piece)]
            if len(owners) == 1 and not any(
                _hides(piece, rooms[k], parts[k]) for k in candidates if k not in owners
            ):
                mine[owners[0]].append(piece)
            else:
                mixed.append(piece)
        owned = union([piece for k in candidates for piece in mine[k]])
        for k in candidates:
            shares = any(_shared_mm3(rooms[k], piece) > ROUNDING_SHARE * piece.volume_mm3 for piece in mixed)
            is_torn = _misses_share(parts[k], mine[k])
            if (shares or is_torn or _misses_strip(parts[k], mine[k], near_mm)) and not rooms[k].is_empty:
                left = (metal & rooms[k]) - owned  # not of pieces built anew: those fill where they are thin
                more = _pieces(left, near_mm)
                # facets of a rim that is turned by little leave a strip each, thinner than flaps of rounding
                if mine[k] and _misses_strip(parts[k], [*mine[k], *more], near_mm):
                    more = left.pieces()
                mine[k] += more
                torn |= {k} if more and is_torn and not shares else set()
                skins[k] = Solid.nothing() if mine[k] else left
    touched: set[int] = set()
    for i, j in itertools.combinations(range(len(mine)), 2):
        touched |= _separated(parts, mine, i, j, near_mm)
    pieces_of = [None if trace is None or k in touched else tuple(mine[k]) for k, trace in enumerate(traces)]
    return [SeparatedMetal(pieces, k in torn, skins[k]) for k, pieces in enumerate(pieces_of)]


def _misses_share(part: Claims, pieces: Sequence[Solid]) -> bool:
    """Return whether a correction has no pieces or lacks too much of its listed volume."""
    return not pieces or _missing_mm3(part, pieces) > VALUE_TOLERANCE_SHARE * abs(
        part.get("removed_volume_mm3", float)
    )


def _misses_strip(part: Claims, pieces: Sequence[Solid], near_mm: float) -> bool:
    """Return whether a correction misses more volume than rounding of its surface.

    A strip of a thousandth of the metal, on the other side of the web, moves the centre by 0.1 mm.
    """
    rounding_mm3 = near_mm * sum(piece.area_mm2 for piece in pieces)
    return _misses_share(part, pieces) or _missing_mm3(part, pieces) > rounding_mm3


def _missing_mm3(part: Claims, pieces: Sequence[Solid]) -> float:
    listed: float = abs(part.get("removed_volume_mm3", float))
    return listed - sum(piece.volume_mm3 for piece in pieces)


ROUNDING_SHARE = 1e-9
"""Share of a piece up to which a remaining volume counts as zero."""
OWN_SHARE = 0.95
"""Share of a piece in a correction's room from which all of it is that correction's."""


def _holds(room: Solid, piece: Solid) -> bool:
    """Return whether a piece lies in a room, up to losses of a boolean between near planes."""
    return _shared_mm3(room, piece) > OWN_SHARE * piece.volume_mm3


def _hides(piece: Solid, room: Solid, part: Claims) -> bool:
    """Return whether a piece holds a notable share of the volume listed for a correction beside it."""
    listed: float = abs(part.get("removed_volume_mm3", float))
    return _shared_mm3(room, piece) > VALUE_TOLERANCE_SHARE * listed


def _shared_mm3(room: Solid, piece: Solid) -> float:
    if room.is_empty or np.any(room.bounds[0] > piece.bounds[1]) or np.any(piece.bounds[0] > room.bounds[1]):
        return 0.0
    return (room & piece).volume_mm3


def _separated(parts: Sequence[Claims], mine: list[list[Solid]], i: int, j: int, near_mm: float) -> set[int]:
    """Assign pieces claimed by two corrections to the nearer one; return both if pieces overlap in part."""
    for one in list(mine[i]):
        for other in list(mine[j]):
            apart = np.any(one.bounds[0] > other.bounds[1]) or np.any(other.bounds[0] > one.bounds[1])
            if apart:
                continue
            both, size = one & other, max(one.volume_mm3, other.volume_mm3)
            if both.volume_mm3 <= VALUE_TOLERANCE_SHARE * min(
                one.volume_mm3, other.volume_mm3
            ) or not _pieces(both, near_mm):
                continue  # halves of one face that meet in a sector's edge
            if both.volume_mm3 < (1.0 - VALUE_TOLERANCE_SHARE) * size:
                return {i, j}
            centre = both.moments(1.0).centre_mm
            away = [float(np.linalg.norm(parts[k].array("position_mm", (3,)) - centre)) for k in (i, j)]
            loser, piece = (j, other) if round(away[0] - away[1], 6) <= 0.0 else (i, one)
            mine[loser] = [each for each in mine[loser] if each is not piece]
    return set()
