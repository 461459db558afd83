"""Weights of a job from solids: the mass of a part's model, with its uncertainty."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.declare import COUNTED, NOT_NEGATIVE, Key, Values
from autobalance.errors import AutobalanceError, JobError
from autobalance.job.density import density_keys
from autobalance.job.model import Distribution, LengthUnit
from autobalance.toml_files.keys import read
from autobalance.toml_files.typed_units import WEIGHT_TABLES
from autobalance.units import G_PER_MM3_PER_KG_M3

BODY = (
    Key("file", str, "solid file, relative to the job file"),
    Key("unit", LengthUnit, "length unit of the file, if its format carries no unit", default=None),
    *density_keys("the part"),
    Key("density_pm_kg_m3", float, "uncertainty of the density", NOT_NEGATIVE, 0.0),
    Key("body", int | str, "number or name of one of several bodies", default=None),
)
"""Source of a part's solid, and its weight."""
SOLID = Key(
    "",
    says="weight measured from a solid",
    keys=(
        *BODY,
        Key("pieces", int, "number of pieces", COUNTED, 1),
        Key("distribution", Distribution, "distribution of the ± in `study`", default=None, verbs="study"),
    ),
)
SOLID_ROD = Key("", says="rod measured from its solid: end weights, length and inertia", keys=BODY)


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
    part = read(value, SOLID.keys, where)
    density = part["density_kg_m3"]
    mass, unsure = (part["pieces"] * each for each in _mass_g(part, folder, density, where))
    pm = math.hypot(unsure, mass * part["density_pm_kg_m3"] / density)
    more = {} if part["distribution"] is None else {"distribution": part["distribution"]}
    return {"g": mass, "pm": pm, **more}


def _mass_g(part: Values, folder: Path, density_kg_m3: float, where: str) -> tuple[float, float]:
    """Return the mass of a solid, the part that its facets hide added, and its uncertainty [g]."""
    from autobalance.solid.chordal_error.of_mesh import chordal_error_of_mesh
    from autobalance.solid.formats.read import read as read_solid

    density = density_kg_m3 * G_PER_MM3_PER_KG_M3
    try:
        source = read_solid(folder / part["file"], part["unit"], part["body"])
    except AutobalanceError as error:
        raise JobError(f"{where}: {error}") from None
    mass = source.volume_mm3 * density
    if source.exact is not None:
        return mass, 0.0
    hidden = chordal_error_of_mesh(source.solid.mesh, density)
    return mass + hidden.missing.mass_g, hidden.mass_bar_g
