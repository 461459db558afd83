"""The table [crankshaft] of a job."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from autobalance.crank.anatomy import Overrides, PinHint
from autobalance.errors import JobError
from autobalance.job.model import (
    Crankshaft,
    LengthUnit,
)
from autobalance.job.toml.table import COUNTED, NOT_NEGATIVE, POSITIVE, Table
from autobalance.runtime import note_read
from autobalance.solid.formats.registry import names_bodies, needs_unit
from autobalance.units import G_PER_MM3_PER_KG_M3

if TYPE_CHECKING:
    pass


Vector = tuple[float, float, float]
CRANKSHAFT_KEYS = (
    "file",
    "unit",
    "density_kg_m3",
    "density_pm_kg_m3",
    "crankpin_in_file",
    "axis_point_mm",
    "axis_direction",
    "crankpins",
    "main_journals",
    "body",
)


def read_crankshaft(values: Mapping[str, Any], folder: Path) -> Crankshaft:
    """Return the crank that the keys of ``[crankshaft]`` say; its file is relative to ``folder``.

    Raises
    ------
    JobError
        If a key is unknown, missing, of the wrong type or impossible.
    """
    return crankshaft_of(Table({"crankshaft": dict(values)}, "", ("crankshaft",)), folder / "job.toml")


def crankshaft_of(root: Table, path: Path, *, crank_given: bool = False) -> Crankshaft:
    """Read the table; without a file only where a crank is given instead."""
    table = root.table("crankshaft", CRANKSHAFT_KEYS)
    if crank_given and "file" not in table:
        return _of_no_file(table)
    name = table.value("file", str)
    if not name:
        raise JobError("crankshaft.file is empty; must name a crank file, relative to the job")
    file = path.parent / name
    note_read(file)  # also by what needs only the weights
    unit: LengthUnit | None = table.optional("unit", LengthUnit)
    if unit is None and needs_unit(file):
        raise JobError(
            f"crankshaft.unit is missing; {file.suffix.upper()[1:]} carries no unit: one of mm, cm, m, inch"
        )
    density = table.value("density_kg_m3", float, POSITIVE)
    off = table.optional("density_pm_kg_m3", float, NOT_NEGATIVE)
    if off is not None and off >= density:
        raise JobError(f"crankshaft.density_pm_kg_m3 is {off:g}; must be < density_kg_m3, {density:g}")
    return Crankshaft(
        file,
        unit,
        density * G_PER_MM3_PER_KG_M3,
        _overrides(table),
        _body(table, file),
        None if off is None else off * G_PER_MM3_PER_KG_M3,
    )


def _of_no_file(table: Table) -> Crankshaft:
    density = table.optional("density_kg_m3", float, POSITIVE, default=0.0)
    off = table.optional("density_pm_kg_m3", float, NOT_NEGATIVE)
    return Crankshaft(
        None,
        table.optional("unit", LengthUnit),
        density * G_PER_MM3_PER_KG_M3,
        _overrides(table),
        None,
        None if off is None else off * G_PER_MM3_PER_KG_M3,
    )


def _body(table: Table, file: Path) -> int | str | None:
    names = str if names_bodies(file) else Literal["all"]
    body: int | str | None = table.optional("body", int | names, COUNTED)
    if body == "":
        raise JobError('crankshaft.body is empty; must be a number, the name of a part, or "all"')
    return body


def _overrides(table: Table) -> Overrides:
    direction = table.optional("axis_direction", Vector)
    if direction is not None and not any(direction):
        raise JobError("crankshaft.axis_direction is [0, 0, 0]; must point along the crank axis")
    point = table.optional("axis_point_mm", Vector)
    return Overrides(
        axis_point_mm=None if point is None else np.array(point),
        axis_direction=None if direction is None else np.array(direction),
        crankpins=_pins(table, "crankpins"),
        main_journals=_pins(table, "main_journals"),
        crankpin_in_file=table.optional("crankpin_in_file", bool, default=True),
    )


def _pins(table: Table, key: str) -> tuple[PinHint, ...] | None:
    if key not in table:
        return None
    pins = table.tables(key, ("centre_mm", "diameter_mm", "width_mm"))
    if not pins:
        raise JobError(f"{table.place(key)} is an empty list; leave it out, or name at least one")
    return tuple(
        PinHint(
            np.array(pin.value("centre_mm", Vector)),
            pin.optional("diameter_mm", float, POSITIVE),
            pin.optional("width_mm", float, POSITIVE),
        )
        for pin in pins
    )
