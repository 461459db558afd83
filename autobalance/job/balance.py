"""The table [balance] of a job, and the cuts that it lists."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any, Literal

from autobalance.correction import KINDS, Limits
from autobalance.declare import ANY, COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, SHARE, Key, Values
from autobalance.errors import JobError
from autobalance.job.model import Attached, Balance, External, ExternalPart
from autobalance.rigid_rotor.margin import Margin
from autobalance.rigid_rotor.tolerance import Judge
from autobalance.toml_files.keys import plain
from autobalance.units import RAD_S_PER_RPM

# The table [balance] of a job: requirements on the balanced crank.


COUNTERWEIGHT_DEG = 180.0
"""Default angle of overbalance: opposite to crankpin 1."""
EXTERNAL_PART = (
    Key("name", str, "name of the place"),
    Key("z_mm", float, "position along the axis, rotor frame"),
    Key(
        "unbalance_g_mm", tuple[float, float], "unbalance it carries now [x, y], rotor frame", ANY, (0.0, 0.0)
    ),
    Key("max_g_mm", float, "largest unbalance that it can carry", POSITIVE, None, usual="any"),
    Key("angle_deg", float, "only angle at which it can carry it", ANY, None, usual="anywhere"),
)
BALANCE = Key(
    "balance",
    says="target of the balanced crank",
    default=FILLED,
    verbs="all",
    keys=(
        Key(
            "factor",
            float | Literal["original"],
            'share of the reciprocating mass to balance, 0 to 1, or `"original"`',
            SHARE,
            typed="share",
        ),
        Key(
            "grade",
            float,
            "balance quality grade G; crank drives of single-cylinder engines are listed at G 250 to G 630, "
            "racing "
            "practice uses G 6.3 on the crankshaft itself",
            POSITIVE,
            typed="mm/s",
        ),
        Key("speed_rpm", float, "maximum service speed", POSITIVE),
        Key(
            "judge",
            Judge,
            '`"dynamic"`: the resultant and each tolerance plane; `"static"`: the resultant alone',
            default="dynamic",
        ),
        Key(
            "margin",
            Margin,
            '`"expanded"`: the verdict needs the residual and its uncertainty together within the '
            "permissible unbalance",
            default="none",
        ),
        Key(
            "facet_correction",
            bool,
            "`true`: the metal between the mesh's facets and the smooth surface is estimated and added to "
            "all results; declined, with the reason, if that may not improve the results",
            default=False,
        ),
        Key(
            "rotor_mass_g",
            float,
            "mass of the rotor: crank before correction and all crankpins not in the file, no bob-weights",
            POSITIVE,
            None,
            usual="measured",
        ),
        Key(
            "tolerance_planes_mm",
            tuple[float, float],
            "z of both tolerance planes in the rotor frame, the lower one first",
            ANY,
            None,
            usual="mid-planes of the outermost main journals",
        ),
        Key(
            "overbalance_g_mm",
            float,
            "unbalance left on purpose for the last holes on the machine",
            NOT_NEGATIVE,
            0.0,
        ),
        Key("overbalance_deg", float, "angle of that unbalance", ANY, COUNTERWEIGHT_DEG),
        Key(
            "external",
            External,
            'unbalance of the external parts: `"solve"`: the value that needs no cut; `"neutral"`: zero; '
            '`"detroit"`: the value that they have now',
            ANY,
            "none",
        ),
        Key(
            "external_part",
            says="a damper, flexplate or flywheel that carries unbalance; one or two",
            keys=EXTERNAL_PART,
            many=True,
            default=(),
        ),
    ),
)


def balance_of(values: Values) -> Balance:
    """Return the requirements of ``[balance]``.

    Raises
    ------
    JobError
        If they contradict each other.
    """
    planes = values["tolerance_planes_mm"]
    if planes is not None and not planes[0] < planes[1]:
        raise JobError(
            f"balance.tolerance_planes_mm is [{planes[0]:g}, {planes[1]:g}]; the first must be the lower one"
        )
    return Balance(
        None if values["factor"] == "original" else values["factor"],
        values["grade"],
        values["speed_rpm"] * RAD_S_PER_RPM,
        values["judge"],
        values["rotor_mass_g"],
        planes,
        values["overbalance_g_mm"],
        math.radians(values["overbalance_deg"]),
        values["margin"],
        values["facet_correction"],
        values["external"],
        _external_parts(values),
    )


def fitted_parts(balance: Balance) -> tuple[Attached, ...]:
    """Return the external parts that count as they are, "detroit", as attached rotors."""
    if balance.external != "detroit":
        return ()
    return tuple(Attached(part.name, 0.0, part.unbalance_g_mm, part.z_mm) for part in balance.external_parts)


def _external_parts(values: Values) -> tuple[ExternalPart, ...]:
    parts = values["external_part"]
    if bool(parts) != (values["external"] != "none") or len(parts) > 2:
        raise JobError(
            f'balance.external is "{values["external"]}" with {len(parts)} [[balance.external_part]];'
            " expected one or two parts, and none without it"
        )
    if len({each["name"] for each in parts}) < len(parts):
        raise JobError(
            f"balance.external_part has two parts named {parts[0]['name']!r}; expected a name for each"
        )
    return tuple(
        ExternalPart(
            each["name"],
            each["z_mm"],
            each["unbalance_g_mm"],
            each["max_g_mm"],
            None if each["angle_deg"] is None else math.radians(each["angle_deg"]),
        )
        for each in parts
    )


# Cuts that a job lists, to be made exactly so: ``[[correction.cut]]`` with ``method = "listed"``.


FACE_KEYS = ("faces", "sector_deg", "max_depth_mm", "same_depth", "min_wall_mm")
"""Keys of the top level, which the kinds share whose limits have ``faces``."""
LISTED = "listed"
"""Method of a job that lists its cuts."""
LISTED_CUTS = Key(
    "cut",
    says='a cut that is made exactly as listed, with `method = "listed"`: keys as in the `corrections` of a '
    "report, whose entries may be copied whole. Keys that do not describe the cut are ignored. Angles are in "
    "the rotor frame. Limits apply if the method's own table sets them",
    many=True,
    default=(),
    keys=(
        Key("kind", Literal[tuple(KINDS)], "correction method"),
        Key("depth_mm", float, "depth from the method's datum; overrides all values that follow from it"),
        Key("web", int, "the web that is cut", COUNTED, None, usual="web of `face`"),
        Key("webs", tuple[int, ...], "turn: webs of one set-up", COUNTED, None, usual="web alone"),
        Key("face", str, "shoulder, add: id of the face, from `inspect`", default=None),
        Key("sector_deg", tuple[float, float], "shoulder, add: sector of the face", default=None),
        Key(
            "angle_deg",
            float,
            "drill, slug: angle about the crank axis",
            default=None,
            usual="of position_mm",
        ),
        Key(
            "direction",
            Literal["radial", "axial"],
            "drill, slug: direction of the hole",
            default=None,
            usual="the table's",
        ),
        Key("diameter_mm", float, "drill, slug: diameter of the hole", POSITIVE, None),
        Key("length_mm", float, "slug: length", POSITIVE, None),
        Key("density_kg_m3", float, "slug: density", POSITIVE, None, usual="the table's"),
        Key("point_angle_deg", float, "drill: 180 is flat", POSITIVE, None, usual="the table's"),
        Key(
            "entry_radius_mm",
            float,
            "axial holes: radius of the entry",
            POSITIVE,
            None,
            usual="of position_mm",
        ),
        Key(
            "z_mm",
            float,
            "holes: place of the axis; axial holes: side of the entry",
            default=None,
            usual="of position_mm",
        ),
        Key("position_mm", tuple[float, float, float], "entry of a hole", default=None, usual="by the above"),
        Key("entry_mm", tuple[float, float, float], "entry of a hole that was deepened", default=None),
        Key("inward", tuple[float, float, float], "holes: the feed; its z is enough", default=None),
        Key("deepened_from_mm", float, "drill: depth of the hole that is deepened", POSITIVE, None),
        Key("fills_a_hole", bool, "slug: pressed into an existing hole", default=False),
        Key("cutter_mm", float, "mill: its diameter", POSITIVE, None, usual="twice corner_radius_mm"),
        Key("corner_radius_mm", float, "mill: radius of its corners", POSITIVE, None, usual="the cutter"),
        Key("side", int, "mill: 1 from +z, -1 from -z", default=None, usual="of position_mm"),
        Key("face_z_mm", float, "mill: z of the cheek", default=None),
        Key("inner_radius_mm", float, "mill: smallest radius of the pocket", NOT_NEGATIVE, None),
        Key("outer_radius_mm", float, "mill: largest radius of the pocket", POSITIVE, None),
        Key("start_deg", float, "mill: where it begins, counter-clockwise", default=None),
        Key("end_deg", float, "mill: where it ends", default=None),
    ),
    ignored=(
        "number",
        "label",
        "radius_mm",
        "removed_mass_g",
        "removed_volume_mm3",
        "unbalance_change_g_mm",
        "unbalance_per_mm_g_mm",
        "moment_per_mm_g_mm2",
        "tool_volume_mm3",
        "file_position_mm",
        "file_axis",
        "normal",
        "face_height_mm",
        "new_height_mm",
        "new_face_area_mm2",
        "area_mm2",
        "outline",
        "outline_to_rotor",
        "entry_lift_mm",
        "point_mm",
        "drill",
        "deepened_at",
        "wall_left_mm",
        "depth_left_mm",
        "slug_mass_g",
        "slug_centre_mm",
        "centrifugal_load_N",
        "z_from_mm",
        "z_to_mm",
        "rim_radius_mm",
        "new_radius_mm",
    ),
)
"""A listed cut: what a kind needs to rebuild it; the rest of a report's entry may stay where it is copied."""


def kinds_listed(values: Values) -> tuple[str, ...]:
    """Return the kinds of the cuts that a job lists.

    Raises
    ------
    JobError
        If it lists none, or one lacks a key of its kind.
    """
    if not values["cut"]:
        raise JobError(f'correction.method is "{LISTED}": list the cuts, each as [[correction.cut]]')
    if values["keep"] is not None:
        raise JobError(
            f'correction.keep plans new depths, method "{LISTED}" keeps those listed; leave one out'
        )
    for item in numbered_cuts(values):
        where, kind = f"correction.cut[{item['number']}]", item["kind"]
        for key in KINDS[kind].described_by:
            if key not in item:
                raise JobError(f"{where}.{key} is missing; a cut of kind {kind} needs it")
        depth = item["depth_mm"]
        if depth == 0.0 or (depth < 0.0 and not KINDS[kind].adds_metal):
            raise JobError(f"{where}.depth_mm is {depth:g}; must be > 0")
    return tuple(dict.fromkeys(item["kind"] for item in values["cut"]))


def numbered_cuts(values: Values) -> tuple[dict[str, Any], ...]:
    """Return the cuts that a job lists, each with the keys that it has and its ``number`` in the list."""
    return tuple(
        {**{key: plain(value) for key, value in item.items() if value is not None}, "number": number}
        for number, item in enumerate(values["cut"], 1)
    )


def stated_limits(raw: Mapping[str, Any], kind: str) -> frozenset[str]:
    """Return the limits of a kind that a table ``[correction]`` states: its own, or those of all faces."""
    names = {each.name for each in fields(KINDS[kind].limits)}
    of_faces = {key for key in FACE_KEYS if key in raw} if "faces" in names else set()
    return frozenset({*raw.get(kind, {}), *of_faces} & names)


def planned_anew(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``[correction]`` for a stage after listed cuts: their kinds, with the settings of the first."""
    kinds: dict[str, Mapping[str, Any]] = {}
    for item in table["cut"]:
        kinds.setdefault(item["kind"], item)
    own = {
        name: {key: item[key] for key in KINDS[name].settings if item.get(key) is not None}
        | table.get(name, {})
        for name, item in kinds.items()
    }
    others = {key: value for key, value in table.items() if key != "cut"}
    return {**others, **own, "method": list(kinds)}


def shown_correction(values: Values, raw: Mapping[str, Any], limits: Mapping[str, Limits]) -> dict[str, Any]:
    """Return ``[correction]`` for the report: limits by kind, of listed cuts those that it states."""
    listed = LISTED in values["method"]
    tables = {name: plain(asdict(each)) for name, each in limits.items()}
    if listed:
        tables = {
            name: {key: table[key] for key in table if key in stated_limits(raw, name)}
            for name, table in tables.items()
        }
    cuts = [{key: value for key, value in each.items() if key != "number"} for each in numbered_cuts(values)]
    return {
        "method": [LISTED] if listed else list(limits),
        "prefer": values["prefer"],
        "min_gain_percent": values["min_gain_percent"],
        "depth_tolerance_mm": values["depth_tolerance_mm"],
        **({} if values["keep"] is None else {"keep": values["keep"]}),
        **({"cut": cuts} if listed else {}),
        **{name: table for name, table in tables.items() if table or not listed},
    }
