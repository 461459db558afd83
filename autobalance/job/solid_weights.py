"""Weights that a job takes from solids: the mass of a part's model, with what is uncertain of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.errors import AutobalanceError, JobError
from autobalance.job.toml.table import NOT_NEGATIVE, POSITIVE, Table
from autobalance.job.toml.typed_units import WEIGHT_TABLES
from autobalance.units import G_PER_MM3_PER_KG_M3

KEYS = ("file", "unit", "density_kg_m3", "density_pm_kg_m3", "body", "distribution")


def with_weighed_solids(values: Mapping[str, Any], folder: Path, path: str = "") -> dict[str, Any]:
    """Return the tables of a job with the solids among its weights as ``g`` and ``pm``.

    Parameters
    ----------
    values : mapping
        In base units.
    folder : Path
        The solids' files are relative to it.

    Raises
    ------
    JobError
        If a solid's key is wrong, or its file cannot be weighed; it names the weight.
    """
    changed: dict[str, Any] = {}
    for key, value in values.items():
        where = f"{path}.{key}" if path else key
        if key in WEIGHT_TABLES and isinstance(value, Mapping):
            changed[key] = {
                name: _weighed(weight, folder, f"{where}.{name}") for name, weight in value.items()
            }
        elif isinstance(value, Mapping):
            changed[key] = with_weighed_solids(value, folder, where)
        elif isinstance(value, list):
            changed[key] = [
                with_weighed_solids(item, folder, f"{where}[{place}]") if isinstance(item, Mapping) else item
                for place, item in enumerate(value, 1)
            ]
        else:
            changed[key] = value
    return changed


def _weighed(value: Any, folder: Path, where: str) -> Any:
    if not isinstance(value, Mapping) or "file" not in value:
        return value
    table = Table(dict(value), where, KEYS)
    density = table.value("density_kg_m3", float, POSITIVE)
    off = table.optional("density_pm_kg_m3", float, NOT_NEGATIVE, default=0.0)
    mass, unsure = _mass_g(table, folder, density)
    pm = math.hypot(unsure, mass * off / density)
    more = {"distribution": value["distribution"]} if "distribution" in value else {}
    return {"g": mass, "pm": pm, **more}


def _mass_g(table: Table, folder: Path, density_kg_m3: float) -> tuple[float, float]:
    """Return the mass of a solid, what its facets hide added, and how far that may be off [g]."""
    from autobalance.solid.chordal_error.estimate import estimate_chordal_error
    from autobalance.solid.formats.read import read

    density = density_kg_m3 * G_PER_MM3_PER_KG_M3
    file = folder / table.value("file", str)
    try:
        source = read(file, table.optional("unit", str), table.optional("body", int | str))
    except AutobalanceError as error:
        raise JobError(f"{table.path}: {error}") from None
    mass = source.volume_mm3 * density
    if source.exact is not None:
        return mass, 0.0
    hidden = estimate_chordal_error(source.solid.mesh, density)
    return mass + hidden.missing.mass_g, hidden.mass_bar_g
