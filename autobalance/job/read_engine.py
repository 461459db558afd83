"""The tables [engine] and [original] of a job."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from autobalance.declare import ANY, COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.errors import JobError
from autobalance.job.layout import BANK_DEG, LAYOUT, LINK, ROD, layout_of, links_of, rod_of
from autobalance.job.model import (
    Attached,
    CylinderLayout,
    Distribution,
    EngineParts,
    LinkRod,
    PartWeights,
    ThrowParts,
    Weight,
)
from autobalance.job.solids import SOLID
from autobalance.toml_files.keys import plain
from autobalance.toml_files.typed_units import WEIGHT_TABLES
from autobalance.units import G_PER, G_PER_MM3_PER_KG_M3

Turns = Literal["ccw", "cw"]
CRANKPIN = "crankpin"
"""The part in ``crankpin_g`` that is the pin itself."""

PM = Key("pm", float, "uncertainty of the weight, in its unit", NOT_NEGATIVE, 0.0)
DISTRIBUTION = Key(
    "distribution",
    Distribution,
    "distribution of that ± in `study`",
    default=None,
    usual="`[study]`",
    verbs="study",
)
WEIGHED = Key(
    "",
    says="on the scale",
    keys=(
        *(Key(unit, float, f"the weight [{unit}]", NOT_NEGATIVE, None) for unit in G_PER),
        PM,
        Key("pieces", int, "number of pieces; weight and ± are of one", COUNTED, 1),
        DISTRIBUTION,
    ),
    shape={"oneOf": [{"required": [unit]} for unit in G_PER]},
)
WEIGHT = Key(
    "",
    float,
    "its weight",
    NOT_NEGATIVE,
    typed="g",
    keys=(Key("g", float, "the weight", NOT_NEGATIVE), PM, DISTRIBUTION),
    forms=(WEIGHED, SOLID),
)
OF_A_ROD = "named weights of **one** connecting rod with its piston"
MEANINGS = {
    "rotating_g": f"masses that turn with the crankpin: {OF_A_ROD}",
    "reciprocating_g": f"reciprocating masses: {OF_A_ROD}",
    "crankpin_g": "named weights of one throw, however many rods: what sits on or in the crankpin and is "
    "not in "
    "the file. `crankpin` is the pin itself: required with `crankpin_in_file = false`, an error with `true`",
}
WEIGHTS = tuple(
    Key(name, says=MEANINGS[name], named=WEIGHT, default=FILLED, usual="none") for name in WEIGHT_TABLES
)
THROW = (
    Key("number", int, "number of the throw, from 1 along the rotor's z", COUNTED),
    Key("rods", int, "connecting rods on its crankpin", COUNTED, None, usual="`rods_per_throw`"),
    BANK_DEG,
    *WEIGHTS,
    LINK,
)
ATTACHED = (
    Key("name", str, "name of the part"),
    Key("mass_g", float, "mass", NOT_NEGATIVE),
    Key("unbalance_g_mm", tuple[float, float], "unbalance [x, y], rotor frame"),
    Key("z_mm", float, "position along the axis, rotor frame"),
    Key("pm_g_mm", float, "uncertainty of its unbalance", NOT_NEGATIVE, 0.0),
)
OIL_KG_M3 = 870.0
OIL = (
    Key("density_kg_m3", float, "density of the oil", POSITIVE, OIL_KG_M3),
    Key("filled", bool, "whether it fills them", default=True),
)
ENGINE = Key(
    "engine",
    says="parts attached to the crank",
    default=FILLED,
    verbs="all",
    keys=(
        Key(
            "rod_length_mm",
            float,
            "length from eye to eye",
            POSITIVE,
            None,
            verbs="forces, cycle, strength, orders, shafts, bench",
        ),
        Key("stroke_mm", float, "checked against the geometry, to 0.1 mm or 0.5 %", POSITIVE, None),
        Key("rods_per_throw", int, "connecting rods on each crankpin", COUNTED, 1),
        Key(
            "turns",
            Turns,
            "sense of turning seen from +z; angles on the crank stay counter-clockwise",
            ANY,
            "ccw",
        ),
        *WEIGHTS,
        Key(
            "throw",
            says="a throw that differs; a part named there takes the place of the part of the same name",
            keys=THROW,
            many=True,
            default=(),
        ),
        Key(
            "attached",
            says="a flywheel, damper, sprocket or alternator that turns with the crank and is out of balance",
            keys=ATTACHED,
            many=True,
            default=(),
        ),
        Key(
            "oil",
            says="oil in bores and drillings of crankpins and main journals",
            keys=OIL,
            default=None,
            verbs="all",
        ),
        LAYOUT,
        ROD,
    ),
)
ORIGINAL = Key(
    "original",
    says='the parts that the crank was balanced for; needed for `factor = "original"`',
    keys=WEIGHTS,
    default=None,
    verbs="all",
)


def engine_of(values: Values, pin_in_file: bool) -> EngineParts:
    """Return the parts of ``[engine]``; they must hold the crankpin where the file does not.

    Raises
    ------
    JobError
        If they contradict each other.
    """
    oil_g_mm3 = _oil_g_mm3(values["oil"])
    for table in (values, *values["throw"]) if oil_g_mm3 is not None else ():
        if "oil" in table["crankpin_g"]:
            raise JobError(
                "engine.crankpin_g.oil is given beside [engine.oil]; must be one or the other: the oil would"
                " count twice"
            )
    default = ThrowParts(values["rods_per_throw"], weights_of(values))
    by_throw: dict[int, ThrowParts] = {}
    for place, throw in enumerate(values["throw"], 1):
        number = throw["number"]
        if number in by_throw:
            raise JobError(f"engine.throw[{place}].number is {number} twice; each throw may be listed once")
        links = _links(f"engine.throw[{place}]", throw, values["layout"]["kind"])
        usual = 1 + len(links) if links else default.rods
        rods = usual if throw["rods"] is None else throw["rods"]
        if links and rods != usual:
            raise JobError(
                f"engine.throw[{place}].rods is {rods}; expected {usual}, a master and {len(links)} links"
            )
        by_throw[number] = ThrowParts(rods, default.weights.merged(weights_of(throw)), links)
    _check_crankpin("engine", default.weights, pin_in_file)
    if pin_in_file:
        for place, throw in enumerate(values["throw"], 1):
            _check_crankpin(f"engine.throw[{place}]", weights_of(throw), pin_in_file)
    return EngineParts(
        default,
        by_throw,
        tuple(Attached(**each) for each in values["attached"]),
        rod_length_mm=values["rod_length_mm"],
        stroke_mm=values["stroke_mm"],
        layout=layout_of(values["layout"], values["throw"]),
        rod=rod_of(values["rod"]),
        clockwise=values["turns"] == "cw",
        oil_g_mm3=oil_g_mm3,
    )


def _oil_g_mm3(values: Values | None) -> float | None:
    if values is None or not values["filled"]:
        return None
    density: float = values["density_kg_m3"]
    return density * G_PER_MM3_PER_KG_M3


def _links(place: str, throw: Values, kind: str) -> tuple[LinkRod, ...]:
    if throw["link"] and kind != "articulated":
        raise JobError(f'{place}.link is given; expected engine.layout.kind = "articulated" beside it')
    return links_of(place, throw["link"])


def original_of(values: Values | None, pin_in_file: bool, required: bool) -> PartWeights | None:
    """Return the parts for which the crank was balanced; None where they are neither there nor needed.

    Raises
    ------
    JobError
        If they are needed and missing.
    """
    if values is None:
        if required:
            raise JobError(
                '[original] is missing; balance.factor = "original" needs the weights that the crank was '
                "balanced for: original.rotating_g, original.reciprocating_g, original.crankpin_g"
            )
        return None
    weights = weights_of(values)
    if required and not weights.reciprocating:
        raise JobError(
            'original.reciprocating_g is missing; balance.factor = "original" needs the weights that the '
            "crank was balanced for"
        )
    _check_crankpin("original", weights, pin_in_file)
    return weights


def weights_of(values: Values) -> PartWeights:
    """Return the three tables of weights of a table that has them."""
    return PartWeights(
        *({name: _weight(each) for name, each in values[key].items()} for key in WEIGHT_TABLES)
    )


def _weight(value: float | Values) -> Weight:
    return (
        Weight(value["g"], value["pm"], value["distribution"]) if isinstance(value, dict) else Weight(value)
    )


def _check_crankpin(path: str, weights: PartWeights, pin_in_file: bool) -> None:
    """Refuse a crankpin that would count twice, or not at all."""
    key = f"{path}.crankpin_g.{CRANKPIN}"
    if pin_in_file and CRANKPIN in weights.crankpin:
        raise JobError(
            f"{key} is given, but crankshaft.crankpin_in_file is true: the crankpin would count twice; "
            "remove the weight, or set crankpin_in_file = false if the file holds no crankpin"
        )
    if not pin_in_file and CRANKPIN not in weights.crankpin:
        raise JobError(
            f"{key} is missing; crankshaft.crankpin_in_file = false needs the weight of the crankpin [g]"
        )


# --- as the report has them ---------------------------------------------------------------------------------


def engine_values(engine: EngineParts, values: Values) -> Values:
    """Return ``[engine]`` with its defaults; throws with all parts that hang on them."""
    own: Mapping[int, Sequence[float] | float | None] = {
        each["number"]: each["bank_deg"] for each in values["throw"]
    }
    links = {each["number"]: [plain(link) for link in each["link"]] for each in values["throw"]}
    layout = {"layout": plain(values["layout"])} if engine.layout != CylinderLayout() else {}
    if layout and values["layout"]["bank_deg"] is not None:
        layout["layout"]["bank_deg"] = _listed(values["layout"]["bank_deg"])
    throws = [
        {
            "number": number,
            "rods": parts.rods,
            **({} if own[number] is None else {"bank_deg": _listed(own[number])}),
            **weight_values(parts.weights),
            **({"link": links[number]} if links[number] else {}),
        }
        for number, parts in sorted(engine.by_throw.items())
    ]
    attached = [
        {key: plain(value) for key, value in each.items() if key != "pm_g_mm" or value}
        for each in values["attached"]
    ]
    rod = values["rod"]
    return {
        "rod_length_mm": engine.rod_length_mm,
        "stroke_mm": engine.stroke_mm,
        **layout,
        **(
            {}
            if rod is None
            else {"rod": {key: value for key, value in rod.items() if key != "solid" or value}}
        ),
        "rods_per_throw": engine.default.rods,
        **weight_values(engine.default.weights),
        "throw": throws,
        "attached": attached,
        **({"turns": "cw"} if engine.clockwise else {}),
        **({"oil": dict(values["oil"])} if values["oil"] is not None else {}),
    }


def weight_values(weights: PartWeights) -> dict[str, Any]:
    """Return the three tables of weights as a job has them."""
    tables = (weights.rotating, weights.reciprocating, weights.crankpin)
    return {
        key: {name: _weight_value(each) for name, each in table.items()}
        for key, table in zip(WEIGHT_TABLES, tables, strict=True)
    }


def _weight_value(weight: Weight) -> float | dict[str, float | str]:
    if weight.distribution is not None:
        return {"g": weight.mass_g, "pm": weight.pm_g, "distribution": weight.distribution}
    return {"g": weight.mass_g, "pm": weight.pm_g} if weight.pm_g else weight.mass_g


def _listed(angles: Sequence[float] | float | None) -> list[float]:
    return list(angles) if isinstance(angles, Sequence) else [] if angles is None else [angles]
