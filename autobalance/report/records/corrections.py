"""Cuts, added metal, and changes of the job that would reach the tolerance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from autobalance.correction import KINDS
from autobalance.declare import (
    ABSENT,
    INLINE,
    Absent,
    Angle,
    Like,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    Sha256,
    Triple,
    record,
)
from autobalance.declare.schema import open_keys
from autobalance.units import wrapped_deg

if TYPE_CHECKING:
    from autobalance.balancing import record as balancing
    from autobalance.balancing.kept import KeptPlan
    from autobalance.balancing.loop import Result
    from autobalance.correction.contract import Correction as CutMade
    from autobalance.crank.anatomy import Anatomy


@open_keys
@record
class CorrectionDetails:
    """Further values of a kind of correction, enough to make it."""

    entry_radius_mm: Annotated[NotNegative, "of position_mm: drill and slug"] | Absent = ABSENT
    inward: Annotated[Triple, "unit vector of the feed: drill and slug"] | Absent = ABSENT
    diameter_mm: Positive | Absent = ABSENT
    point_angle_deg: Annotated[float, "180: flat"] | Absent = ABSENT
    face_z_mm: Annotated[float, "where the depth of a milled pocket begins"] | Absent = ABSENT
    entry_lift_mm: (
        Annotated[
            NotNegative,
            "how far outside the entry the tool begins: drill, slug, a shoulder up in a fillet",
        ]
        | Absent
    ) = ABSENT
    entry_mm: Annotated[Triple | None, "entry of the first stage of a hole that is deepened"] | Absent = (
        ABSENT
    )
    point_mm: Annotated[NotNegative, "length of the point: drill and slug"] | Absent = ABSENT
    side: (
        Annotated[Literal[1, -1, None], "the side that the cutter comes from, +z or -z: mill, shoulder, add"]
        | Absent
    ) = ABSENT
    z_from_mm: Annotated[float, "ends of the turned stretch, beyond the web's faces: turn"] | Absent = ABSENT
    z_to_mm: float | Absent = ABSENT
    outline: (
        Annotated[
            Sequence[Sequence[Mapping[str, Any]]],
            "of the area at the new height, x and y of the rotor frame: loops of line [[x, y], [x, y]] and "
            "arc {centre, radius_mm, from_deg, to_deg}, each outer one before its islands: shoulder, add",
        ]
        | Absent
    ) = ABSENT
    outline_to_rotor: (
        Annotated[
            Sequence[Sequence[float]],
            "4x4: from the axes of an outline on a face that is not square to the axis",
        ]
        | Absent
    ) = ABSENT


@record
class Correction:
    """A cut, or metal that was added; a kind adds what it takes to make it."""

    kind: str
    number: Ordinal
    label: Annotated[str, "short name of the cut, for lists and trees"] | Absent = ABSENT
    face: str | None
    web: Ordinal | None
    position_mm: Annotated[
        Triple, "entry on the tool's axis for drill and slug, else the centre of the metal removed or added"
    ]
    radius_mm: NotNegative
    depth_mm: Annotated[
        float, "drill and slug: from the entry to the end of the full diameter; below 0 where metal comes"
    ]
    removed_mass_g: float
    removed_volume_mm3: float
    unbalance_change_g_mm: Pair
    unbalance_per_mm_g_mm: Pair | Absent | None = ABSENT
    moment_per_mm_g_mm2: Pair | Absent | None = ABSENT
    tool_volume_mm3: (
        Annotated[
            NotNegative,
            "of the tool's body on true surfaces, air included; bodies of triangles, as volume_mm3 of "
            "result.tools() has them, reach a little farther",
        ]
        | Absent
    ) = ABSENT
    file_position_mm: Annotated[Triple, "position_mm in file coordinates"] | Absent = ABSENT
    file_axis: (
        Annotated[
            Triple | None,
            "unit vector in file coordinates: into the metal for holes, pockets and lowered faces, "
            "+z of the rotor for rims, outward for added metal",
        ]
        | Absent
    ) = ABSENT
    details: Annotated[Mapping[str, Any], INLINE, Like(CorrectionDetails)]
    angle_deg: Annotated[Angle, "of position_mm, counter-clockwise seen from +z"]
    z_mm: Annotated[float, "of position_mm"]

    @classmethod
    def of(cls, number: int, cut: CutMade, anatomy: Anatomy) -> Self:
        """Return a correction as listed: the values of all kinds, the kind's own details, its place."""
        rate, back = cut.rate, anatomy.rotor_to_file
        item = {"face": cut.face, **cut.details}
        return cls(
            kind=cut.kind,
            number=number,
            label=f"cut {number}: {KINDS[cut.kind].label(item)}",
            face=cut.face,
            web=cut.web,
            position_mm=cut.position_mm,
            radius_mm=math.hypot(*cut.change.centre_mm[:2]),
            depth_mm=cut.depth_mm,
            removed_mass_g=-cut.change.mass_g,
            removed_volume_mm3=cut.removed_volume_mm3,
            unbalance_change_g_mm=cut.change.first_g_mm[:2],
            unbalance_per_mm_g_mm=None if rate is None else rate.first_g_mm[:2],
            moment_per_mm_g_mm2=None if rate is None else rate.second_g_mm2[:2, 2],
            tool_volume_mm3=cut.tool_volume_mm3,
            file_position_mm=back[:3, :3] @ cut.position_mm + back[:3, 3],
            file_axis=None if cut.axis is None else back[:3, :3] @ cut.axis,
            details=cut.details,
            angle_deg=wrapped_deg(math.degrees(math.atan2(cut.position_mm[1], cut.position_mm[0]))),
            z_mm=cut.position_mm[2],
        )


def kept_corrections(kept: KeptPlan, result: Result, anatomy: Anatomy) -> list[Correction]:
    """Return all cuts of a kept plan by their numbers: as they were made, the others with depth 0."""
    return [
        _unused(item)
        if place is None
        else Correction.of(int(item["number"]), result.corrections[place], anatomy)
        for item, place in kept.places(result)
    ]


def _unused(item: Mapping[str, Any]) -> Correction:
    """Return a kept cut that is not made: nothing is taken, nothing pressed in."""
    pressed_in = KINDS[item["kind"]].pressed_in
    label = f"cut {item['number']}: {KINDS[item['kind']].label(item)}"
    own = {each.name for each in fields(Correction)} - {"details"}
    details = {key: value for key, value in item.items() if key not in own}
    if pressed_in is not None:
        details[pressed_in[0]] = 0.0
    details |= {new: details[old] for new, old in AS_BEFORE.items() if new in details}
    listed = {key: item[key] for key in own if key in item}
    return Correction(**{**listed, **NO_METAL, "label": label, "details": details})


NO_METAL: Mapping[str, Any] = {
    "depth_mm": 0.0,
    "removed_mass_g": 0.0,
    "removed_volume_mm3": 0.0,
    "tool_volume_mm3": 0.0,
    "unbalance_change_g_mm": (0.0, 0.0),
}
"""Values of a kept cut of depth 0."""
AS_BEFORE: Mapping[str, str] = {"new_height_mm": "face_height_mm", "new_radius_mm": "rim_radius_mm"}
"""Values that stay unchanged at such a cut: a face's height, a rim's radius."""


@record
class PlanKept:
    """An earlier plan whose cuts were kept."""

    report: str
    sha256: Sha256
    cuts: Ordinal

    @classmethod
    def of(cls, kept: KeptPlan) -> Self:
        return cls(report=kept.report, sha256=kept.sha256, cuts=len(kept.items))


@record
class Overbalance:
    """Unbalance left on purpose, and the last holes that would use it up."""

    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    last_holes: Sequence[Correction]
    predicted_g_mm: NotNegative | None
    reason: str | None

    @classmethod
    def of(cls, left: balancing.Overbalance, anatomy: Anatomy) -> Self:
        return cls(
            unbalance_g_mm=left.unbalance.resultant_g_mm,
            magnitude_g_mm=left.unbalance.magnitude_g_mm,
            angle_deg=wrapped_deg(math.degrees(left.unbalance.angle_rad)),
            last_holes=[Correction.of(number, each, anatomy) for number, each in enumerate(left.holes, 1)],
            predicted_g_mm=None if left.predicted is None else left.predicted.magnitude_g_mm,
            reason=left.reason,
        )
