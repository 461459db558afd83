"""Checks of a cut's listed label, place and values against those measured of its metal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from autobalance.correction import KINDS
from autobalance.correction.trace import Metal, Reading
from autobalance.errors import ClaimError, FormatError
from autobalance.types import Array
from autobalance.verification.claims import ROUNDING, Claims
from autobalance.verification.shared_out import VALUE_TOLERANCE_SHARE

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
