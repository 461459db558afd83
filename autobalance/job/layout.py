"""Input of forces and balance shafts beyond weights: layout of the cylinders, the bare rod, shafts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from autobalance.declare import ANY, COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.errors import JobError
from autobalance.job.model import BalanceShaftEntry, Bolted, CylinderLayout, LinkRod, RodOnScales
from autobalance.job.solid_weights import SOLID_ROD
from autobalance.toml_files.keys import plain
from autobalance.units import G_MM2_PER_KG_MM2

Sense = Literal["forward", "backward"]
Kind = Literal["plain", "articulated"]
VERBS = "forces, shafts, cycle, orders"

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
    verbs=VERBS,
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
    verbs="forces, shafts, parts, cycle",
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
