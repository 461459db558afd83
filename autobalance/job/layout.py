"""Input beyond weights: layout of the cylinders, whose work this is, what the shop has."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from autobalance.declare import ANY, COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.errors import JobError
from autobalance.job.model import BalanceShaftEntry, Bolted, CylinderLayout, LinkRod, RodOnScales
from autobalance.job.solids import SOLID_ROD
from autobalance.toml_files.document import text_of, toml_of
from autobalance.toml_files.keys import plain, read
from autobalance.toml_files.typed_units import in_base_units
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.user_folders import shop_file

# Input of forces and balance shafts beyond weights: layout of the cylinders, the bare rod, shafts.


Sense = Literal["forward", "backward"]
Kind = Literal["plain", "articulated"]
VERBS = "forces, shafts, cycle, orders"
OF_WEIGHTS = "balance, compare, recut, study, batch, factor, parts"
"""Verbs that read the weights of rods: also those of link rods and of a rod measured from its solid."""

BANK_DEG = Key(
    "bank_deg",
    float | tuple[float, ...],
    "direction of the cylinder, from the rotor's x axis at crank angle 0, or a list of one for each rod",
    ANY,
    None,
    not_empty="must hold one angle for each rod",
    verbs=VERBS,
)
LAYOUT = Key(
    "layout",
    says="arrangement of the cylinders",
    default=FILLED,
    verbs=VERBS,
    keys=(
        BANK_DEG,
        Key(
            "kind",
            Kind,
            "rods of a crankpin: side by side, or links on a master (`[[engine.throw.link]]`)",
            ANY,
            "plain",
        ),
        Key("rod_pitch_mm", float, "distance between the rods of a throw, along the axis", ANY, 0.0),
        Key("offset_mm", float, "offset of the cylinder's axis from the crank axis", ANY, 0.0, verbs=VERBS),
    ),
)


def _link_weight(name: str, says: str) -> Key:
    part = Key("", float, "its weight", NOT_NEGATIVE, typed="g")
    return Key(name, float, says, NOT_NEGATIVE, None, named=part, usual="the throw's")


LINK = Key(
    "link",
    says="link rods on this throw's master rod, in an articulated engine",
    many=True,
    default=(),
    verbs=f"{OF_WEIGHTS}, {VERBS}",
    keys=(
        Key("cylinder", int, "number of the cylinder in the engine", COUNTED),
        Key("bank_deg", float, "direction of its cylinder"),
        Key("rod_length_mm", float, "distance from knuckle pin to wrist pin", POSITIVE),
        Key("knuckle_radius_mm", float, "distance from the crankpin to the knuckle pin", POSITIVE),
        Key(
            "knuckle_angle_deg",
            float,
            "angle of the knuckle pin about the crankpin, from the master rod's axis",
        ),
        _link_weight("rotating_g", "mass at its knuckle pin, a number or a table of named weights"),
        _link_weight("reciprocating_g", "mass at its wrist pin, a number or a table of named weights"),
    ),
)
ON_SCALES = (
    Key("big_end_g", float, "reading of the scale under the big end", NOT_NEGATIVE),
    Key("small_end_g", float, "reading of the scale under the small end", NOT_NEGATIVE),
    Key("inertia_kg_mm2", float, "inertia about its centre of mass", POSITIVE, None),
    Key("solid", dict, "file from which it was measured, in the job of a report", default=FILLED),
)
ROD = Key(
    "rod",
    says="the bare connecting rod",
    keys=ON_SCALES,
    forms=(Key("", says="on two scales", keys=ON_SCALES), SOLID_ROD),
    default=None,
    verbs=f"{OF_WEIGHTS}, forces, shafts, cycle",
)
BOLTED = (
    Key("name", str, "name of the shaft"),
    Key("eccentricity_mm", float, "distance of its centre of mass from its axis"),
    Key("cad_g", float, "mass in the CAD model", NOT_NEGATIVE),
    Key("weighed_g", float, "mass on the scale", NOT_NEGATIVE, None),
)
SHAFTS = Key(
    "shafts",
    says="balance shafts",
    many=True,
    default=(),
    verbs="forces, shafts, parts, cycle, orders",
    keys=(
        Key("order", int, "speed divided by the crank speed", COUNTED),
        Key("sense", Sense, "direction of rotation, with the crank or against it"),
        Key("product_g_mm", float, "unbalance; or the sum of `weight`", default=None),
        Key("phase_deg", float, "angle of its unbalance at crank angle 0", ANY, 180.0),
        Key("place_mm", tuple[float, float], "position of its axis, rotor frame", ANY, (0.0, 0.0)),
        Key(
            "z_mm",
            float,
            "position of its unbalance along the axis, rotor frame",
            ANY,
            None,
            usual="at the reference of moments",
        ),
        Key("weight", says="weights bolted on", keys=BOLTED, many=True, default=()),
    ),
)


def layout_of(values: Values, throws: Sequence[Values]) -> CylinderLayout:
    """Return ``[engine.layout]`` with the bank angles of the throws that differ."""
    by_throw = {each["number"]: _radians(each["bank_deg"]) for each in throws}
    return CylinderLayout(
        _radians(values["bank_deg"]),
        {number: banks for number, banks in by_throw.items() if banks is not None},
        values["rod_pitch_mm"],
        values["offset_mm"],
    )


def links_of(place: str, values: Sequence[Values]) -> tuple[LinkRod, ...]:
    """Return the link rods of a throw.

    Raises
    ------
    JobError
        If two have one cylinder.
    """
    numbers = [each["cylinder"] for each in values]
    for number in numbers:
        if numbers.count(number) > 1:
            raise JobError(f"{place}.link has cylinder {number} twice; each link needs another cylinder")
    return tuple(
        LinkRod(
            each["cylinder"],
            math.radians(each["bank_deg"]),
            each["rod_length_mm"],
            each["knuckle_radius_mm"],
            math.radians(each["knuckle_angle_deg"]),
            _sum_g(each["rotating_g"]),
            _sum_g(each["reciprocating_g"]),
        )
        for each in values
    )


def _sum_g(weight: float | Values | None) -> float | None:
    """Return a weight, or the sum of named ones; None where the throw's count."""
    return sum(weight.values()) if isinstance(weight, dict) else weight


def _radians(angles_deg: float | tuple[float, ...] | None) -> tuple[float, ...] | None:
    if angles_deg is None:
        return None
    return tuple(
        math.radians(angle) for angle in (angles_deg if isinstance(angles_deg, tuple) else (angles_deg,))
    )


def rod_of(values: Values | None) -> RodOnScales | None:
    """Return ``[engine.rod]``; None where it is absent."""
    if values is None:
        return None
    inertia = values["inertia_kg_mm2"]
    return RodOnScales(
        values["big_end_g"],
        values["small_end_g"],
        None if inertia is None else inertia * G_MM2_PER_KG_MM2,
        dict(values["solid"]),
    )


def shafts_of(tables: Sequence[Values]) -> tuple[BalanceShaftEntry, ...]:
    """Return ``[[shafts]]``.

    Raises
    ------
    JobError
        If one has its product and weights, or neither.
    """
    return tuple(_shaft(values, f"shafts[{place}]") for place, values in enumerate(tables, 1))


def _shaft(values: Values, where: str) -> BalanceShaftEntry:
    weights = tuple(Bolted(**each) for each in values["weight"])
    product = values["product_g_mm"]
    if weights and product is not None:
        raise JobError(f"{where}.product_g_mm is given beside weights; must be one or the other")
    if not weights and product is None:
        raise JobError(f"{where}.product_g_mm is missing")
    return BalanceShaftEntry(
        values["order"],
        values["sense"] == "forward",
        sum(_weight_g(item) * item.eccentricity_mm for item in weights) if weights else product,
        math.radians(values["phase_deg"]),
        values["place_mm"],
        weights,
        values["z_mm"],
    )


def _weight_g(item: Bolted) -> float:
    return item.cad_g if item.weighed_g is None else item.weighed_g


def shaft_values(values: Values) -> Values:
    """Return a balance shaft as in the report: its product, or its weights."""
    other = "product_g_mm" if values["weight"] else "weight"
    return {key: plain(value) for key, value in values.items() if key != other}


# The tables [job] and [shop]: whose work this is, and what the shop has; kept in the report.


DrillSeries = Literal["mm", "inch", "letter", "number"]

JOB = Key(
    "job",
    says="customer, engine and operator; kept in the report",
    default=None,
    verbs="all",
    keys=(
        Key("part", str, "name of the part; names of papers begin with it", default=None, example="V8"),
        Key("customer", str, "name of the customer", default=None, example="A. Customer"),
        Key("engine", str, "name of the engine", default=None, example="CRF 250 R"),
        Key("serial", str, "serial number of the crank", default=None, example="C-0417"),
        Key("operator", str, "name of the operator", default=None, example="B. Turner"),
        Key("note", str, "free text", default=None, example="second set of pistons"),
    ),
)
SLUG = (
    Key("diameter_mm", float, "diameter of the slug", POSITIVE),
    Key("length_mm", float, "length of the slug", POSITIVE),
    Key("density_kg_m3", float, "density of the slug's metal", POSITIVE, 17000.0),
)
SHOP = Key(
    "shop",
    says="the shop and its equipment; kept in the report",
    default=None,
    verbs="all",
    keys=(
        Key("name", str, "name of the shop", default=None, example="Turner & Daughters, crankshafts"),
        Key("logo", str, "picture, relative to the file that names it", default=None, example="logo.png"),
        Key("units", Literal["metric", "inch"], "in which it works", default=None, example="metric"),
        Key(
            "drills",
            DrillSeries | tuple[float, ...],
            'drills available: a series, a diameter, or a list such as `[8.0, "1/2 in"]`',
            POSITIVE,
            None,
            typed="mm",
            not_empty="leave it out, or name one",
            example=[8.0, 10.0, "1/2 in"],
            or_one=True,
        ),
        Key(
            "slugs",
            says="heavy-metal slugs in stock",
            keys=SLUG,
            many=True,
            default=(),
            example=[{"diameter_mm": 25.4, "length_mm": 12.7, "density_kg_m3": 17000.0}],
        ),
        Key(
            "washers_g",
            tuple[float, ...],
            "washers that bob-weights are stacked from",
            POSITIVE,
            None,
            example=[1.0, 2.0, 5.0, 10.0],
        ),
        Key(
            "machine",
            str,
            "file of the balancing machine, for `autobalance machine`, relative to the file that names it",
            default=None,
            example="MACHINE.toml",
        ),
    ),
)


# A shop's own file, ``shop.toml``: found beside a job, or else in the user's configuration folder.


FILES = ("logo", "machine")
"""Keys that are paths, relative to the file that they are in."""


def with_shop(raw: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return the tables of a job with those of the shop's file; the job's own ``[shop]`` goes first.

    Raises
    ------
    FileError, JobError
        If the shop's file cannot be read, or is wrong; the message begins with its path.
    """
    path, own = shop_file(folder), raw.get("shop", {})
    if path is None or not isinstance(own, Mapping):
        return raw
    try:
        content = in_base_units(toml_of(text_of(path, "shop's file"), path.name))
        read(content, (SHOP,))
    except JobError as error:
        raise error.within(str(path)) from None
    return {**raw, "shop": {**located(content.get("shop", {}), path.parent), **own}}


def located(shop: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return a shop's table whose files are named from anywhere, not from the folder of its file."""
    named = {key: shop[key] for key in FILES if shop.get(key) is not None}
    return {**shop, **{key: (folder / name).resolve().as_posix() for key, name in named.items()}}
