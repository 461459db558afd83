"""Checks of a cut's listed values against its metal, and which metal belongs to which correction."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.correction import KINDS
from autobalance.correction.contract import Limits
from autobalance.correction.holes.sites import in_sectors
from autobalance.correction.trace import Before, Metal, Reading, Trace
from autobalance.errors import AutobalanceError, ClaimError, FormatError
from autobalance.job import describe
from autobalance.job.from_options import differences
from autobalance.job.read import load
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array
from autobalance.value_classes import dataclass
from autobalance.verification.claims import ROUNDING, Claims
from autobalance.verification.solids import Files

# Assignment of the metal that went or came to the corrections.


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


# Checks of a cut's listed label, place and values against those measured of its metal.


STATED = ("face", "web", "radius_mm", "angle_deg", "z_mm")
"""Keys for the machinist that every correction must have beside its measured values."""
LENGTH_SHARE = 2e-4
ROUGH_SHARE = 5e-3
"""Largest share of crumbs of the rough face in the metal of a cut in a scanned face."""
UNIT_LENGTH = 1e-6
LENGTH_MM = 2e-3
ANGLE_DEG = 0.05


def check_label(part: Claims) -> None:
    if "label" not in part.values:
        return
    try:
        label = KINDS[part.get("kind", str)].label(part.values)
    except (LookupError, TypeError, ValueError):
        raise FormatError(f"{part.name}: {part.place} lacks what its label is made of") from None
    part.same("label", f"cut {part.get('number', int)}: {label}")


def check_place(part: Claims) -> None:
    """Check angle, z, radius of entry and feed direction against the position; ``STATED`` must be there."""
    for key in STATED:
        part.get(key, object)
    x, y, z = part.array("position_mm", (3,))
    size = max(math.hypot(x, y, z), 1.0)
    if math.hypot(x, y) > LENGTH_MM:
        within = ROUNDING * 360.0 * size / math.hypot(x, y)
        part.near_angle("angle_deg", math.degrees(math.atan2(y, x)), within)
    part.near("z_mm", z, size)
    if "entry_radius_mm" in part.values:
        part.near("entry_radius_mm", math.hypot(x, y), size)
    if part.values.get("inward") is not None:
        length = float(np.linalg.norm(part.array("inward", (3,))))
        if not abs(length - 1.0) <= UNIT_LENGTH:
            raise ClaimError(f"{part.name}: {part.path('inward')} is {length:.9g} long; expected length 1")


def check_file_place(part: Claims, rotor_to_file: Array) -> None:
    """Check place and direction in the file's own coordinates against those in the rotor frame."""
    if "file_position_mm" in part.values:
        place = rotor_to_file[:3, :3] @ part.array("position_mm", (3,)) + rotor_to_file[:3, 3]
        part.near("file_position_mm", place, max(float(np.linalg.norm(place)), 1.0))
    if part.values.get("file_axis") is None:
        return
    stated = next((key for key in ("inward", "normal") if part.values.get(key) is not None), None)
    if stated is not None:
        axis = part.array(stated, (3,))
    else:
        axis = np.array([0.0, 0.0, -part.get("side", float) if "side" in part.values else 1.0])
    if stated == "normal" and not KINDS[part.get("kind", str)].adds_metal:
        axis = -axis
    part.near("file_axis", rotor_to_file[:3, :3] @ axis, 1.0)


def check_implied(part: Claims, implied: Mapping[str, Any]) -> None:
    """Compare a correction's values with those that follow without its metal."""
    for key, value in implied.items():
        if isinstance(value, Reading):
            part.near(key, value.value, value.within, 1.0)
        elif value is None or isinstance(value, str | int) or key == "outline":
            part.same(key, value)
        else:
            size = float(np.linalg.norm(np.asarray(value, dtype=np.float64)))
            part.near(key, value, max(size, 1.0))


def compare(part: Claims, measured: Mapping[str, Any], metal: Metal, rough_mm: float) -> None:
    """Compare a correction's values with those measured of its metal, within limits by unit.

    The start of metal at a scanned face is known to its roughness.
    """
    skin_mm3 = metal.area_mm2 * metal.near_mm
    share = VALUE_TOLERANCE_SHARE if rough_mm == 0.0 else ROUGH_SHARE
    reach = float(np.abs(metal.corners).max(initial=0.0))
    crumbs_mm = 0.0 if rough_mm == 0.0 else rough_mm + ROUGH_SHARE * reach  # of a centre
    volume_mm3 = sum(piece.volume_mm3 for piece in metal.pieces)
    thin = min(1.0, skin_mm3 / volume_mm3) if volume_mm3 > 0.0 else 0.0  # 1: a layer of a few roundings
    for key, value in measured.items():
        if isinstance(value, Reading):
            size = float(np.linalg.norm(value.value))
            part.near(key, value.value, 2.0 * share * size + value.within + 1e-3, 1.0)
            continue
        if value is None or isinstance(value, str | list) or (isinstance(value, int) and "_" not in key):
            part.same(key, value)
            continue
        size = float(np.linalg.norm(np.asarray(value, dtype=np.float64)))
        if key.endswith("_deg"):
            part.near_angle(
                key, float(value), ANGLE_DEG + math.degrees(4.0 * metal.near_mm / max(reach, 1.0))
            )
        elif key in ("normal", "inward"):
            part.near(key, value, VALUE_TOLERANCE_SHARE, 1.0)
        elif key.endswith("_per_mm_g_mm") or key.endswith("_mm2"):
            part.near(key, value, (2.0 * share + thin) * size + 1e-3, 1.0)
        elif key.endswith("_mm") and not key.endswith("_g_mm"):
            moved_mm = reach * thin + crumbs_mm if key in ("position_mm", "radius_mm") else rough_mm
            near_mm = 2.0 * metal.near_mm + moved_mm
            part.near(key, value, LENGTH_MM + LENGTH_SHARE * size + near_mm, 1.0)
        else:
            skin = skin_mm3 if key.endswith("_mm3") else skin_mm3 * metal.density_g_mm3
            skin *= reach if key.endswith("_g_mm") else 1.0
            part.near(key, value, share * size + skin, 1.0)


# Checks of a report's limits against the job file, and of its cuts against these limits.


KEY = "job.correction"
DEEPER_MM = 2e-3
"""Largest excess of a depth over its limit: rounding of a file moves faces."""
THINNER_MM = 5e-3
"""Largest shortfall of a wall from its limit: walls are printed to hundredths, limits are exact."""
OFF_POSITION_DEG = 3.0
"""Largest angle between a position and the axis of an old hole that counts as the one there."""
BESIDE_DEG = 0.05
MOST_LISTED = 5
"""Changed keys of a job that a warning names."""


def check_limits_of_job(claims: Claims, folder: Path, files: Files) -> None:
    """Check the correction's limits against the job file, if it exists, and repeat its warnings.

    A job that was changed after its run proves nothing about the report; a warning then lists the
    differences.

    Raises
    ------
    ClaimError
        If the limits differ, and the job file is older than the report.
    """
    claims.against("the job file")
    path = _job_file(claims, folder)
    if path is None:
        claims.ledger.why_not[KEY] = (
            "its job file is missing; only the cuts were checked against these limits"
        )
        return
    in_file = _job_now(claims, path, files)
    if in_file is None:
        claims.ledger.why_not[KEY] = f"{path.name} can not be read as the job that ran"
        return
    reported = claims.get("job", dict)
    differs = list(differences(reported.get("correction"), in_file.get("correction"), KEY))
    report = folder / claims.name
    if not differs:
        claims.hold(KEY)
    elif report.is_file() and path.stat().st_mtime <= report.stat().st_mtime:
        key, claimed, there = differs[0]
        raise ClaimError(f"{claims.name}: {key} is {claimed!r}, but it is {there!r} in {path}")
    else:
        claims.ledger.why_not[KEY] = f"{path.name} was changed after the run"
    _warn_of_changes(claims, path, in_file)


def warn_of_changed_job(claims: Claims, folder: Path, files: Files) -> None:
    """Warn of limits that the job file has now and had not in the run; a stage has separate limits."""
    path = _job_file(claims, folder)
    in_file = None if path is None else _job_now(claims, path, files)
    if path is not None and in_file is not None:
        _warn_of_changes(claims, path, {**in_file, "correction": claims.get("job", dict).get("correction")})


def _job_file(claims: Claims, folder: Path) -> Path | None:
    name = claims.get("job", dict).get("file")
    path = folder / name if isinstance(name, str) and name else None
    return path if path is not None and path.is_file() else None


def _job_now(claims: Claims, path: Path, files: Files) -> Mapping[str, Any] | None:
    """Return the job file as a report has it; None, and a warning, if it is not such a job any more."""
    settings = claims.values.get("job_set", [])
    try:
        return files.once(("job", str(path), repr(settings)), lambda: _described(path, settings))
    except AutobalanceError as error:
        claims.warnings.append(
            f"{path.name} was changed after the run and no longer such a job: {str(error).splitlines()[0]}"
        )
        return None


def _described(path: Path, settings: Any) -> Mapping[str, Any]:
    """Return a job file as a report has it."""
    values: Mapping[str, Any] = json.loads(json.dumps(describe(load(path, tuple(map(str, settings))))))
    return values


def _warn_of_changes(claims: Claims, path: Path, in_file: Mapping[str, Any]) -> None:
    reported = {key: value for key, value in claims.get("job", dict).items() if key != "file"}
    here = {key: value for key, value in in_file.items() if key != "file"}
    found = [each.words() for each in differences(reported, here, "job")]
    if not found:
        return
    more = f"; and {len(found) - MOST_LISTED} more" if len(found) > MOST_LISTED else ""
    claims.warnings.append(
        f"{path.name} was changed after the run: {'; '.join(found[:MOST_LISTED])}{more}. "
        "This report is of the job as it was; balance again for the new one"
    )


def check_within_limits(part: Claims, limits: Limits | None) -> None:
    """Refuse a cut beyond its limits of depth, wall, positions or sectors.

    Raises
    ------
    ClaimError
        If it does not.
    """
    kind = part.get("kind", str)
    sunk = part.values.get("deepened_from_mm")
    depth = abs(part.get("depth_mm", float)) + (
        0.0 if sunk is None else float(part.get("deepened_from_mm", float))
    )
    most = getattr(limits, "max_depth_mm", None)
    if most is not None and depth > most + DEEPER_MM:
        raise ClaimError(
            f"{part.name}: {part.path('depth_mm')} makes {depth:.9g}; job.correction.{kind}.max_depth_mm "
            f"is {most:.9g}"
        )
    left = 0.0 if part.values.get("depth_left_mm") is None else float(part.get("depth_left_mm", float))
    if left < -DEEPER_MM:
        raise ClaimError(f"{part.name}: {part.path('depth_left_mm')} is {left:.9g}; expected at least 0")
    if most is not None and depth + left > most + DEEPER_MM:
        raise ClaimError(
            f"{part.name}: {part.path('depth_left_mm')} is {left:.9g} beyond {depth:.9g}; "
            f"job.correction.{kind}.max_depth_mm is {most:.9g}"
        )
    least, wall = getattr(limits, "min_wall_mm", None), part.values.get("wall_left_mm")
    if least is not None and wall is not None and not part.values.get("fills_a_hole"):
        wall = part.get("wall_left_mm", float)
        if wall < least - THINNER_MM:
            raise ClaimError(
                f"{part.name}: {part.path('wall_left_mm')} is {wall:.9g}; job.correction.{kind}.min_wall_mm "
                f"is {least:.9g}"
            )
    positions = getattr(limits, "positions", None)
    if positions is not None:
        angle = part.get("angle_deg", float)
        if all(abs(math.remainder(angle - each[0], 360.0)) > OFF_POSITION_DEG for each in positions):
            raise ClaimError(
                f"{part.name}: {part.path('angle_deg')} is {angle:.9g}, at none of "
                f"job.correction.{kind}.positions"
            )
    sectors = getattr(limits, "sectors_deg", None)
    if sectors is not None:
        angle = part.get("angle_deg", float)
        near = (angle - BESIDE_DEG, angle, angle + BESIDE_DEG)
        if not any(in_sectors(math.radians(each), sectors) for each in near):
            raise ClaimError(
                f"{part.name}: {part.path('angle_deg')} is {angle:.9g}, outside of "
                f"job.correction.{kind}.sectors_deg"
            )
