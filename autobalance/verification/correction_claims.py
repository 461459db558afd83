"""Each correction held against the metal that really went or came, and their sum against the whole."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalance.balancing.measuring import DEVIATION_MM
from autobalance.balancing.uncertainty_budget import spacing_mm
from autobalance.correction import KINDS, kind_of
from autobalance.correction.clearance import clear_of_roughness
from autobalance.correction.contract import Limits
from autobalance.correction.trace import Before, Metal, Reading, Trace
from autobalance.crank.anatomy import Anatomy
from autobalance.crank.faces import find_faces
from autobalance.errors import ClaimError, FormatError
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.difference import differences
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import Source
from autobalance.types import Array
from autobalance.verification.claims import ROUNDING, Claims
from autobalance.verification.limit_claims import check_within_limits
from autobalance.verification.shared_out import GRAINS, SHARE, Found, shared_out
from autobalance.verification.solids import Files

STATED = ("face", "web", "radius_mm", "angle_deg", "z_mm")
"""What the machinist reads of every correction, beside what is measured of it."""
LENGTH_SHARE = 2e-4
ROUGH_SHARE = 5e-3
"""Of the metal of a cut in a scanned face, crumbs of the rough face beside it are up to this share."""
UNIT_LENGTH = 1e-6
LENGTH_MM = 2e-3
ANGLE_DEG = 0.05
OTHER_KIND = "the metal of this kind of correction cannot be distinguished"
TORN = "its metal is thin and hangs together with the file's rounding: its amount and effect were checked"
THIN = "its metal is thinner than the files resolve places: only the sum of all was checked"
TOUCHING = "its metal touches that of another correction: only their sum was checked"


@dataclass(frozen=True, eq=False)
class Change:
    """A crank before and after, and what it takes to separate its cuts.

    ``whole`` is the change of the crank's moments, without what is pressed in.
    """

    before: Source
    after: Source
    whole: Moments
    anatomy: Anatomy
    job: Job
    files: Files

    @property
    def density_g_mm3(self) -> float:
        return self.job.crankshaft.density_g_mm3

    @property
    def near_mm(self) -> float:
        """How exactly places are known: what files round to, and how far facets lie from true surfaces."""
        rounding = max(spacing_mm(self.before), spacing_mm(self.after))
        if self.before.exact is None:
            return rounding
        return rounding + DEVIATION_MM

    def limits(self, kind: str) -> Limits | None:
        """Return what the job asks of a kind."""
        return next((each for each in self.job.methods if kind_of(each).name == kind), None)


def check_corrections(claims: Claims, change: Change, first_number: int | None = 1) -> None:
    """Check every correction of a report, and that they are all there is.

    Raises
    ------
    ClaimError
        If metal went that no correction lists, or a correction differs from what went.
    """
    parts = claims.entries("corrections")
    if not parts:
        _check_sum(claims, parts, change)
        claims.hold("corrections")
        _check_no_faces(claims)
        return
    traces = []
    first = int(parts[0].get("number", int)) if first_number is None else first_number
    for number, part in enumerate(parts, first):
        name = part.get("kind", str)
        if name not in KINDS or name not in change.job.method_names:
            raise ClaimError(
                f"{part.name}: {part.path('kind')} is {name!r}, but the job's method is "
                f"{', '.join(change.job.method_names)}"
            )
        part.hold("kind")
        part.same("number", number)
        _check_place(part)
        _check_file_place(part, change.anatomy.rotor_to_file)
        if not _is_kept_unused(claims, part):
            traces.append(KINDS[name].trace(part.values))
    _check_sum(claims, parts, change)
    _check_plan_kept(claims, parts)
    parts = [part for part in parts if part.get("depth_mm", float) != 0.0]
    for part in parts:
        check_within_limits(part, change.limits(part.get("kind", str)))
    files, key = change.files, (id(change.before), id(change.after))
    metal = files.once(("gone", *key), lambda: _gone(change))
    crank = files.once(("before", *key), lambda: _before(change))
    _check_faces(claims, crank)
    shared = shared_out(metal, parts, traces, crank, change.near_mm)
    for part, trace, pieces in zip(parts, traces, shared, strict=True):
        _check_one(part, trace, pieces, change, crank)
        _check_label(part)


def check_nothing_cut(claims: Claims) -> None:
    """Check that no correction is listed, but for those of a kept plan that are not made."""
    if "plan_kept" not in claims.values:
        claims.same("corrections", [])
        _check_no_faces(claims)
        return
    parts = claims.entries("corrections")
    for part in parts:
        if not _is_kept_unused(claims, part):
            raise ClaimError(f"{claims.name}: {part.place} has a depth, but the crank was not cut")
    _check_plan_kept(claims, parts)


def _check_no_faces(claims: Claims) -> None:
    if "faces" in claims.values:
        claims.same("faces", [])


def _is_kept_unused(claims: Claims, part: Claims) -> bool:
    """Return whether a cut is one of a kept plan that is not made: with depth 0 it takes nothing."""
    if "plan_kept" not in claims.values or part.get("depth_mm", float) != 0.0:
        return False
    for key in ("depth_mm", "removed_mass_g", "removed_volume_mm3", "tool_volume_mm3"):
        part.same(key, 0.0)
    part.same("unbalance_change_g_mm", [0.0, 0.0])
    return True


def _check_plan_kept(claims: Claims, parts: Sequence[Claims]) -> None:
    if "plan_kept" in claims.values:
        claims.same("plan_kept.cuts", len(parts))


def _check_label(part: Claims) -> None:
    if "label" not in part.values:
        return
    try:
        label = KINDS[part.get("kind", str)].label(part.values)
    except (LookupError, TypeError, ValueError):
        raise FormatError(f"{part.name}: {part.place} lacks what its label is made of") from None
    part.same("label", f"cut {part.get('number', int)}: {label}")


def _before(change: Change) -> Before:
    """Return the crank before, with its planar faces and where their triangles lie."""
    mesh = change.before.solid.mesh
    faces = find_faces(mesh, change.anatomy, change.before.surfaces)
    corners = mesh.moved(change.anatomy.file_to_rotor).corners
    patches = tuple(corners[face.triangles].mean(axis=1) for face in faces)
    return Before(mesh, change.anatomy, faces, patches)


def _check_place(part: Claims) -> None:
    """Check angle, z, radius of entry and direction of feed against the position; none may be left out."""
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


def _check_file_place(part: Claims, rotor_to_file: Array) -> None:
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


def _check_faces(claims: Claims, crank: Before) -> None:
    """Check the faces that are listed against those of the crank."""
    if "faces" not in claims.values:
        return
    faces, back = {face.id: face for face in crank.faces}, crank.anatomy.rotor_to_file
    named = {part.values.get("face") for part in claims.entries("corrections")} - {None}
    listed = {part.get("id", str) for part in claims.entries("faces")}
    if listed != named:
        raise ClaimError(f"{claims.name}: faces lists {sorted(listed)}; expected {sorted(map(str, named))}")
    if not listed:
        claims.hold("faces")
    for part in claims.entries("faces"):
        face = faces.get(part.get("id", str))
        if face is None:
            raise ClaimError(f"{part.name}: {part.path('id')} is {part.values['id']!r}, which is no face")
        centre = face.centroid_mm
        part.hold("id")
        part.same("kind", face.kind)
        part.same("web", face.web)
        for key, value in {
            "area_mm2": float(face.area_mm2),
            "normal": face.normal,
            "centroid_mm": centre,
            "file_centroid_mm": back[:3, :3] @ centre + back[:3, 3],
        }.items():
            part.near(key, value, max(float(np.linalg.norm(np.asarray(value))), 1.0))
        for key, off in {"rms_mm": face.rms_mm, "flatness_mm": face.flatness_mm}.items():
            if off is not None:
                part.near(key, off, 1.0)


def _check_sum(claims: Claims, parts: Sequence[Claims], change: Change) -> None:
    """Check that all corrections together are the whole change."""
    total, moved_g, moved_g_mm = Moments.zero(), 0.0, 0.0
    for part in parts:
        mass, unbalance = part.get("removed_mass_g", float), part.array("unbalance_change_g_mm", (2,))
        keys = KINDS[part.get("kind", str)].pressed_in
        slug = Moments.zero()
        if keys is not None:
            slug = Moments.point(part.get(keys[0], float), part.array(keys[1], (3,)))
        first = np.array([*unbalance, 0.0])
        total = total + Moments(-mass, first, np.zeros((3, 3))) - slug
        moved_g += abs(mass) + slug.mass_g
        moved_g_mm += float(np.linalg.norm(unbalance)) + float(np.linalg.norm(slug.first_g_mm[:2]))
    mesh = change.before.solid.mesh
    rounding = change.density_g_mm3 * 0.5 * float(mesh.doubled_areas.sum()) * change.near_mm
    off_g = abs(total.mass_g - change.whole.mass_g)
    off_g_mm = float(np.linalg.norm(total.first_g_mm[:2] - change.whole.first_g_mm[:2]))
    if not off_g <= SHARE * moved_g + rounding:
        raise ClaimError(
            f"{claims.name}: corrections take {-total.mass_g:.6g} g together, "
            f"but {-change.whole.mass_g:.6g} g are gone"
        )
    if not off_g_mm <= SHARE * moved_g_mm + rounding * mesh.diagonal_mm:
        raise ClaimError(
            f"{claims.name}: corrections change the unbalance by {_vector(total)} g·mm together, "
            f"but it changed by {_vector(change.whole)}"
        )
    near_g, near_g_mm = SHARE * moved_g + rounding, SHARE * moved_g_mm + rounding * mesh.diagonal_mm
    claims.note("corrections: mass that goes", -total.mass_g, -change.whole.mass_g, near_g)
    sums = total.first_g_mm[:2].tolist(), change.whole.first_g_mm[:2].tolist()
    claims.note("corrections: unbalance that changes", *sums, near_g_mm)


def _vector(moments: Moments) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in moments.first_g_mm[:2]) + "]"


# --- which metal is whose -----------------------------------------------------------------------------------


def _gone(change: Change) -> tuple[Solid, Solid]:
    """Return the metal that went, and that came, rotor frame."""
    went, came = differences(change.before.solid, change.after.solid)
    frame = change.anatomy.file_to_rotor
    return went.moved(frame), came.moved(frame)


# --- one of them --------------------------------------------------------------------------------------------


def _is_skin(part: Claims, skin: Solid, near_mm: float) -> bool:
    """Return whether a correction that is not found is as thin as rounding: its depth, or all that it took.

    A rim that is turned by little more than its facets stand back loses a film between two polygons.
    """
    if abs(part.get("depth_mm", float)) <= 2.0 * GRAINS * near_mm:  # a layer has two sides
        return True
    listed = abs(part.get("removed_volume_mm3", float))
    off = abs(listed - skin.volume_mm3)
    return skin.volume_mm3 > 0.0 and off <= SHARE * listed + near_mm * skin.area_mm2


def _check_one(
    part: Claims,
    trace: Trace | None,
    seen: Found,
    change: Change,
    crank: Before,
) -> None:
    limits = change.limits(part.get("kind", str))
    if limits is not None:
        limits = clear_of_roughness(limits, change.anatomy)  # as it was planned
    if trace is not None:
        _check_implied(part, trace.implied(crank, limits))
    mine, is_torn = seen.metal, seen.is_torn
    if trace is None or mine is None:
        part.ledger.why_not[part.place] = OTHER_KIND if trace is None else TOUCHING
        return
    if trace.takes_metal and not mine and _is_skin(part, seen.skin, change.near_mm):
        part.ledger.why_not[part.place] = THIN
        return
    if bool(mine) != trace.takes_metal:
        word = "no metal went or came there" if not mine else "metal went or came there"
        raise ClaimError(f"{part.name}: {part.place}: {word}")
    kind = KINDS[part.get("kind", str)]
    sign = 1.0 if kind.adds_metal else -1.0
    speed = change.job.balance.service_speed_rad_s
    metal = Metal(
        mine,
        change.density_g_mm3,
        crank,
        limits,
        speed,
        change.near_mm,
    )
    if is_torn:
        part.ledger.why_not[part.place] = TORN
        measured: dict[str, Any] = {}
    else:
        measured = dict(trace.read(metal))
    volume = metal.moments.scaled(sign)
    measured["removed_volume_mm3"] = -volume.mass_g
    weighed, keys = volume.scaled(change.density_g_mm3), kind.pressed_in
    if keys is None or not is_torn:
        if keys is not None:
            weighed = weighed + Moments.point(measured[keys[0]], np.asarray(measured[keys[1]]))
        centre = weighed.centre_mm
        measured |= {
            "removed_mass_g": -weighed.mass_g,
            "unbalance_change_g_mm": weighed.first_g_mm[:2],
            "radius_mm": math.hypot(centre[0], centre[1]),
        }
    if not kind.needs_faces:
        measured["face"] = None
    scan = change.anatomy.scan
    _compare(part, measured, metal, 0.0 if scan is None else scan.roughness_mm)


def _check_implied(part: Claims, implied: Mapping[str, Any]) -> None:
    """Compare what a report lists of a correction with what follows without looking at its metal."""
    for key, value in implied.items():
        if isinstance(value, Reading):
            part.near(key, value.value, value.within, 1.0)
        elif value is None or isinstance(value, str | int) or key == "outline":
            part.same(key, value)
        else:
            size = float(np.linalg.norm(np.asarray(value, dtype=np.float64)))
            part.near(key, value, max(size, 1.0))


def _compare(part: Claims, measured: Mapping[str, Any], metal: Metal, rough_mm: float) -> None:
    """Compare what a report lists of a correction with what was read, as exactly as its unit allows.

    Where metal of a scanned face begins is known to its roughness.
    """
    skin_mm3 = metal.area_mm2 * metal.near_mm
    share = SHARE if rough_mm == 0.0 else ROUGH_SHARE
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
            part.near(key, value, SHARE, 1.0)
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
