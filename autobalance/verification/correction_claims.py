"""Checks of each correction against the metal that went or came, and of their sum against the whole."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalance.balancing.measuring import DEVIATION_MM
from autobalance.balancing.uncertainty_budget import spacing_mm
from autobalance.correction import KINDS
from autobalance.correction.contract import Limits, clear_of_roughness
from autobalance.correction.trace import Before, Metal, Trace
from autobalance.crank.anatomy import Anatomy
from autobalance.crank.faces import find_faces
from autobalance.errors import ClaimError
from autobalance.job import Job
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.difference import differences
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import Source
from autobalance.value_classes import dataclass
from autobalance.verification import cut_values
from autobalance.verification.claims import Claims
from autobalance.verification.solids import Files

SAME_POINT_DEG = 1e-6
OTHER_KIND = "the metal of this kind of correction cannot be distinguished"
TORN_METAL = (
    "its metal is thin and hangs together with the file's rounding: its amount and effect were checked"
)
THIN_METAL = "its metal is thinner than the files resolve places: only the sum of all was checked"
TOUCHING_METAL = "its metal touches that of another correction: only their sum was checked"


@dataclass(frozen=True, eq=False)
class Change:
    """A crank before and after correction, with anatomy and job to separate its cuts.

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
        """Error of places: rounding of both files, plus the deviation of facets from true surfaces."""
        rounding = max(spacing_mm(self.before), spacing_mm(self.after))
        if self.before.exact is None:
            return rounding
        return rounding + DEVIATION_MM

    def limits(self, part: Claims) -> Limits | None:
        """Return the job's limits for a correction; None where its kind is not among the job's methods."""
        return self.job.limits_at(part.values) if part.get("kind", str) in self.job.method_names else None


def check_corrections(claims: Claims, change: Change, first_number: int | None = 1) -> None:
    """Check every correction of a report, and that no other metal went.

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
        _check_point(claims, part, change.limits(part))
        cut_values.check_place(part)
        cut_values.check_file_place(part, change.anatomy.rotor_to_file)
        if not _is_kept_unused(claims, part):
            traces.append(KINDS[name].trace(part.values))
    _check_sum(claims, parts, change)
    _check_plan_kept(claims, parts)
    parts = [part for part in parts if part.get("depth_mm", float) != 0.0]
    for part in parts:
        cut_values.check_within_limits(part, change.limits(part))
    files, key = change.files, (id(change.before), id(change.after))
    metal = files.once(("gone", *key), lambda: _gone(change))
    crank = files.once(("before", *key), lambda: _before(change))
    _check_faces(claims, crank)
    shared = cut_values.shared_out(metal, parts, traces, crank, change.near_mm)
    for part, trace, pieces in zip(parts, traces, shared, strict=True):
        _check_one(part, trace, pieces, change, crank)
        cut_values.check_label(part)


def check_nothing_cut(claims: Claims) -> None:
    """Refuse listed corrections other than unused cuts of a kept plan."""
    if "plan_kept" not in claims.values:
        claims.same("corrections", [])
        _check_no_faces(claims)
        return
    parts = claims.entries("corrections")
    for part in parts:
        if not _is_kept_unused(claims, part):
            raise ClaimError(f"{claims.name}: {part.place} has a depth, but the crank was not cut")
    _check_plan_kept(claims, parts)


def _check_point(claims: Claims, part: Claims, limits: Limits | None) -> None:
    """Hold the point of the job's drill against that of a hole; a kept plan and a stage have their own.

    Raises
    ------
    ClaimError
        If the hole was drilled with another.
    """
    stated = getattr(limits, "point_angle_deg", None)
    if stated is None or "plan_kept" in claims.values:
        return
    cut = part.get("point_angle_deg", float)
    if claims.get("command", str) == "balance" and not math.isclose(cut, stated, abs_tol=SAME_POINT_DEG):
        raise ClaimError(
            f"{claims.name}: job.correction.drill.point_angle_deg is {stated:g}, "
            f"but {part.place} was drilled with {cut:g}"
        )


def _check_no_faces(claims: Claims) -> None:
    if "faces" in claims.values:
        claims.same("faces", [])


def _is_kept_unused(claims: Claims, part: Claims) -> bool:
    """Return whether a cut is an unused one of a kept plan, and check that it takes nothing."""
    if "plan_kept" not in claims.values or part.get("depth_mm", float) != 0.0:
        return False
    for key in ("depth_mm", "removed_mass_g", "removed_volume_mm3", "tool_volume_mm3"):
        part.same(key, 0.0)
    part.same("unbalance_change_g_mm", [0.0, 0.0])
    return True


def _check_plan_kept(claims: Claims, parts: Sequence[Claims]) -> None:
    if "plan_kept" in claims.values:
        claims.same("plan_kept.cuts", len(parts))


def _before(change: Change) -> Before:
    """Return the crank before correction, with its planar faces and the centres of their triangles."""
    mesh = change.before.solid.mesh
    faces = find_faces(mesh, change.anatomy, change.before.surfaces)
    corners = mesh.moved(change.anatomy.file_to_rotor).corners
    patches = tuple(corners[face.triangles].mean(axis=1) for face in faces)
    return Before(mesh, change.anatomy, faces, patches)


def _check_faces(claims: Claims, crank: Before) -> None:
    """Check the listed faces against those of the crank that corrections name."""
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
            raise ClaimError(f"{part.name}: {part.path('id')} is {part.values['id']!r}, which is not a face")
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
    """Check the sum of all corrections against the change of the crank's moments."""
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
    if not off_g <= cut_values.VALUE_TOLERANCE_SHARE * moved_g + rounding:
        raise ClaimError(
            f"{claims.name}: corrections take {-total.mass_g:.6g} g together, "
            f"but {-change.whole.mass_g:.6g} g are gone"
        )
    if not off_g_mm <= cut_values.VALUE_TOLERANCE_SHARE * moved_g_mm + rounding * mesh.diagonal_mm:
        raise ClaimError(
            f"{claims.name}: corrections change the unbalance by {_vector(total)} g·mm together, "
            f"but it changed by {_vector(change.whole)}"
        )
    near_g, near_g_mm = (
        cut_values.VALUE_TOLERANCE_SHARE * moved_g + rounding,
        cut_values.VALUE_TOLERANCE_SHARE * moved_g_mm + rounding * mesh.diagonal_mm,
    )
    claims.note("corrections: mass that goes", -total.mass_g, -change.whole.mass_g, near_g)
    sums = total.first_g_mm[:2].tolist(), change.whole.first_g_mm[:2].tolist()
    claims.note("corrections: unbalance that changes", *sums, near_g_mm)


def _vector(moments: Moments) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in moments.first_g_mm[:2]) + "]"


# --- metal by correction ------------------------------------------------------------------------------------


def _gone(change: Change) -> tuple[Solid, Solid]:
    """Return the metal that went and the metal that came, rotor frame."""
    went, came = differences(change.before.solid, change.after.solid)
    frame = change.anatomy.file_to_rotor
    return went.moved(frame), came.moved(frame)


# --- a single correction ------------------------------------------------------------------------------------


def _is_skin(part: Claims, skin: Solid, near_mm: float) -> bool:
    """Return whether a correction without metal is as thin as rounding, by its depth or by ``skin``.

    A rim that is turned by little more than its facets are back loses a film between two polygons.
    """
    if (
        abs(part.get("depth_mm", float)) <= 2.0 * cut_values.THICKNESS_IN_ROUNDINGS * near_mm
    ):  # a layer has two sides
        return True
    listed = abs(part.get("removed_volume_mm3", float))
    off = abs(listed - skin.volume_mm3)
    return (
        skin.volume_mm3 > 0.0 and off <= cut_values.VALUE_TOLERANCE_SHARE * listed + near_mm * skin.area_mm2
    )


def _check_one(
    part: Claims,
    trace: Trace | None,
    seen: cut_values.SeparatedMetal,
    change: Change,
    crank: Before,
) -> None:
    limits = change.limits(part)
    if limits is not None:
        limits = clear_of_roughness(limits, change.anatomy)  # as it was planned
    if trace is not None:
        cut_values.check_implied(part, trace.implied(crank, limits))
    mine, is_torn = seen.metal, seen.is_torn
    if trace is None or mine is None:
        part.ledger.why_not[part.place] = OTHER_KIND if trace is None else TOUCHING_METAL
        return
    if trace.takes_metal and not mine and _is_skin(part, seen.skin, change.near_mm):
        part.ledger.why_not[part.place] = THIN_METAL
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
        part.ledger.why_not[part.place] = TORN_METAL
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
    cut_values.compare(part, measured, metal, 0.0 if scan is None else scan.roughness_mm)
