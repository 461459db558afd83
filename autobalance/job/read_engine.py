"""The tables [engine] and [original] of a job."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.errors import JobError
from autobalance.job.layout import read_layout, read_rod
from autobalance.job.model import (
    Attached,
    Distribution,
    EngineParts,
    PartWeights,
    ThrowParts,
    Weight,
)
from autobalance.job.toml.table import COUNTED, NOT_NEGATIVE, POSITIVE, Table
from autobalance.job.toml.typed_units import WEIGHT_TABLES

if TYPE_CHECKING:
    pass


CRANKPIN = "crankpin"
"""The part in ``crankpin_g`` that is the pin itself."""


ATTACHED_KEYS = ("name", "mass_g", "unbalance_g_mm", "z_mm", "pm_g_mm")


def read_engine(root: Table, pin_in_file: bool) -> EngineParts:
    """Read ``[engine]``, whose weights must hold the crankpin where the file does not."""
    known = (
        "rod_length_mm",
        "stroke_mm",
        "rods_per_throw",
        *WEIGHT_TABLES,
        "throw",
        "attached",
        "layout",
        "rod",
    )
    table = root.table("engine", known)
    default = ThrowParts(table.optional("rods_per_throw", int, COUNTED, default=1), _weights(table))
    by_throw: dict[int, ThrowParts] = {}
    throws = table.tables("throw", ("number", "rods", "bank_deg", *WEIGHT_TABLES))
    for throw in throws:
        number = throw.value("number", int, COUNTED)
        if number in by_throw:
            raise JobError(f"{throw.place('number')} is {number} again; each throw may stand once")
        rods = throw.optional("rods", int, COUNTED, default=default.rods)
        by_throw[number] = ThrowParts(rods, default.weights.merged(_weights(throw)))
    _check_crankpin(table, default.weights, pin_in_file)
    for throw in throws:
        if pin_in_file:
            _check_crankpin(throw, _weights(throw), pin_in_file)
    return EngineParts(
        default,
        by_throw,
        tuple(_attached(item) for item in table.tables("attached", ATTACHED_KEYS)),
        rod_length_mm=table.optional("rod_length_mm", float, POSITIVE),
        stroke_mm=table.optional("stroke_mm", float, POSITIVE),
        layout=read_layout(table, throws),
        rod=read_rod(table),
    )


def read_original(root: Table, pin_in_file: bool, needed: bool) -> PartWeights | None:
    """Read the parts that the crank was balanced for; None where they are neither there nor needed."""
    if "original" not in root:
        if needed:
            raise JobError(
                '[original] is missing; balance.factor = "original" needs the weights that the crank was '
                "balanced for: original.rotating_g, original.reciprocating_g, original.crankpin_g"
            )
        return None
    table = root.table("original", WEIGHT_TABLES)
    weights = _weights(table)
    if needed and not weights.reciprocating:
        raise JobError(
            'original.reciprocating_g is missing; balance.factor = "original" needs the weights that the '
            "crank was balanced for"
        )
    _check_crankpin(table, weights, pin_in_file)
    return weights


def _weights(table: Table) -> PartWeights:
    rotating, reciprocating, crankpin = (_weight_table(table, key) for key in WEIGHT_TABLES)
    return PartWeights(rotating, reciprocating, crankpin)


def _weight_table(table: Table, key: str) -> dict[str, Weight]:
    weights = table.table(key, known=None)
    return {name: _weight(weights, name) for name in weights.raw}


def _weight(table: Table, name: str) -> Weight:
    if not isinstance(table.raw[name], dict):
        return Weight(table.value(name, float, NOT_NEGATIVE))
    weight = table.table(name, ("g", "pm", "distribution"))
    return Weight(
        weight.value("g", float, NOT_NEGATIVE),
        weight.optional("pm", float, NOT_NEGATIVE, default=0.0),
        weight.optional("distribution", Distribution),
    )


def _check_crankpin(table: Table, weights: PartWeights, pin_in_file: bool) -> None:
    """Refuse a crankpin that would count twice, or not at all."""
    key = f"{table.path}.crankpin_g.{CRANKPIN}"
    if pin_in_file and CRANKPIN in weights.crankpin:
        raise JobError(
            f"{key} is given, but crankshaft.crankpin_in_file is true: the crankpin would count twice; "
            "remove the weight, or set crankpin_in_file = false if the file holds no crankpin"
        )
    if not pin_in_file and CRANKPIN not in weights.crankpin:
        raise JobError(
            f"{key} is missing; crankshaft.crankpin_in_file = false needs the weight of the crankpin [g]"
        )


def _attached(table: Table) -> Attached:
    return Attached(
        table.value("name", str),
        table.value("mass_g", float, NOT_NEGATIVE),
        table.value("unbalance_g_mm", tuple[float, float]),
        table.value("z_mm", float),
        table.optional("pm_g_mm", float, NOT_NEGATIVE, default=0.0),
    )
