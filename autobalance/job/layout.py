"""What forces and balance shafts need beyond weights: where the cylinders stand, the bare rod, shafts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from autobalance.errors import JobError
from autobalance.job.model import BalanceShaftEntry, Bolted, CylinderLayout, RodOnScales
from autobalance.job.toml.table import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, Table
from autobalance.units import G_MM2_PER_KG_MM2

Sense = Literal["forward", "backward"]


def read_layout(engine: Table, throws: Sequence[Table]) -> CylinderLayout:
    """Read ``[engine.layout]`` and the bank angles of the throws that differ."""
    table = engine.table("layout", ("bank_deg", "rod_pitch_mm", "offset_mm"))
    by_throw = {}
    for throw in throws:
        banks = _banks(throw)
        if banks is not None:
            by_throw[throw.value("number", int, COUNTED)] = banks
    return CylinderLayout(
        _banks(table),
        by_throw,
        table.optional("rod_pitch_mm", float, ANY, default=0.0),
        table.optional("offset_mm", float, ANY, default=0.0),
    )


def _banks(table: Table) -> tuple[float, ...] | None:
    given = table.optional("bank_deg", float | tuple[float, ...])
    if given is None:
        return None
    angles = given if isinstance(given, tuple) else (given,)
    if not angles:
        raise JobError(f"{table.place('bank_deg')} is an empty list; must hold one angle for each rod")
    return tuple(math.radians(angle) for angle in angles)


def read_rod(engine: Table) -> RodOnScales | None:
    """Read ``[engine.rod]``; None where it is absent."""
    if "rod" not in engine:
        return None
    table = engine.table("rod", ("big_end_g", "small_end_g", "inertia_kg_mm2", "solid"))
    inertia = table.optional("inertia_kg_mm2", float, POSITIVE)
    return RodOnScales(
        table.value("big_end_g", float, NOT_NEGATIVE),
        table.value("small_end_g", float, NOT_NEGATIVE),
        None if inertia is None else inertia * G_MM2_PER_KG_MM2,
        table.table("solid", None).raw,
    )


SHAFT_KEYS = ("order", "sense", "product_g_mm", "phase_deg", "place_mm", "z_mm", "weight")
WEIGHT_KEYS = ("name", "eccentricity_mm", "cad_g", "weighed_g")


def read_shafts(root: Table) -> tuple[BalanceShaftEntry, ...]:
    """Read ``[[shafts]]``."""
    return tuple(_shaft(table) for table in root.tables("shafts", SHAFT_KEYS))


def _shaft(table: Table) -> BalanceShaftEntry:
    weights = tuple(_bolted(item) for item in table.tables("weight", WEIGHT_KEYS))
    if weights and "product_g_mm" in table:
        raise JobError(f"{table.place('product_g_mm')} is given beside weights; must be one or the other")
    product = sum(_weight_g(item) * item.eccentricity_mm for item in weights)
    sense: Sense = table.value("sense", Sense)
    return BalanceShaftEntry(
        table.value("order", int, COUNTED),
        sense == "forward",
        product if weights else table.value("product_g_mm", float),
        math.radians(table.optional("phase_deg", float, default=180.0)),
        table.optional("place_mm", tuple[float, float], default=(0.0, 0.0)),
        weights,
        table.optional("z_mm", float),
    )


def _weight_g(item: Bolted) -> float:
    return item.cad_g if item.weighed_g is None else item.weighed_g


def _bolted(table: Table) -> Bolted:
    return Bolted(
        table.value("name", str),
        table.value("eccentricity_mm", float),
        table.value("cad_g", float, NOT_NEGATIVE),
        table.optional("weighed_g", float, NOT_NEGATIVE),
    )
