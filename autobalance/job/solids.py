"""Weights of a job from solids: the connecting rod, and other parts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.declare import COUNTED, NOT_NEGATIVE, Key, Values
from autobalance.errors import AutobalanceError, JobError
from autobalance.job.model import Distribution, LengthUnit
from autobalance.job.read_crankshaft import density_keys
from autobalance.toml_files.keys import read
from autobalance.toml_files.typed_units import WEIGHT_TABLES
from autobalance.units import G_PER_MM3_PER_KG_M3, KG_MM2_PER_G_MM2

if TYPE_CHECKING:
    from autobalance.crank.connecting_rod import MeasuredRod


# Weights of a job from solids: the mass of a part's model, with its uncertainty.


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


# The connecting rod of a job, taken from its solid: end weights, length and inertia come from there.


SCALE_KEYS = ("big_end_g", "small_end_g", "inertia_kg_mm2")
PLACES = {"rotating_g": "connecting_rod_big_end", "reciprocating_g": "connecting_rod_small_end"}
"""Table of weights → the name that a rod's end has in it."""
LENGTH_MM, LENGTH_SHARE = 0.1, 0.005
"""A rod length that is given may differ from the measured one by the larger of these."""


def with_measured_rod(values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tables of a job with ``[engine.rod] file`` as weights, length and inertia.

    The big end goes to ``engine.rotating_g``, the small end to ``engine.reciprocating_g``, the length to
    ``engine.rod_length_mm``. Its weight on two scales and its inertia go to ``engine.rod``, whose ``solid``
    names their source.

    Parameters
    ----------
    values : mapping
        In base units.
    folder : Path
        The solid's file is relative to it.

    Raises
    ------
    JobError
        If the solid is not a rod, or a key that is given contradicts it; it names both.
    """
    engine = values.get("engine")
    rod = engine.get("rod") if isinstance(engine, Mapping) else None
    if not isinstance(engine, Mapping) or not isinstance(rod, Mapping) or "file" not in rod:
        return dict(values)
    _refuse_both(engine, rod)
    measured = _measured(read(rod, SOLID_ROD.keys, "engine.rod"), folder)
    weighed, off = measured.rod, measured.uncertainty
    _check_length(engine, rod, weighed.length_mm)
    ends = {
        "rotating_g": {"g": weighed.big_end_g, "pm": off.big_end_g},
        "reciprocating_g": {"g": weighed.small_end_g, "pm": off.small_end_g},
    }
    weights = {
        name: {PLACES[name]: {key: value for key, value in end.items() if value}, **engine.get(name, {})}
        for name, end in ends.items()
    }
    scales = {
        "big_end_g": weighed.big_end_g,
        "small_end_g": weighed.small_end_g,
        "inertia_kg_mm2": (weighed.inertia_g_mm2 or 0.0) * KG_MM2_PER_G_MM2,
        "solid": {**rod, "sha256": measured.source.sha256, "length_mm": weighed.length_mm},
    }
    length = engine.get("rod_length_mm", weighed.length_mm)
    return {**values, "engine": {**engine, **weights, "rod": scales, "rod_length_mm": length}}


def _refuse_both(engine: Mapping[str, Any], rod: Mapping[str, Any]) -> None:
    """Refuse a weight that the solid would count a second time."""
    for key in SCALE_KEYS:
        if key in rod:
            raise JobError(f"engine.rod.{key} is given beside engine.rod.file; must be one or the other")
    for table, name in PLACES.items():
        places = [("engine", engine)]
        throws = engine.get("throw")
        if isinstance(throws, list):
            places += [
                (f"engine.throw[{place}]", throw)
                for place, throw in enumerate(throws, 1)
                if isinstance(throw, Mapping)
            ]
        for where, holder in places:
            weights = holder.get(table)
            if isinstance(weights, Mapping) and name in weights:
                raise JobError(
                    f"{where}.{table}.{name} is given beside engine.rod.file, which puts it in; must be one"
                    " or the other"
                )


def _measured(rod: Values, folder: Path) -> MeasuredRod:
    from autobalance.crank.connecting_rod import measure_rod
    from autobalance.solid.formats.read import read as read_solid

    density, off = rod["density_kg_m3"], rod["density_pm_kg_m3"]
    if off >= density:
        raise JobError(f"engine.rod.density_pm_kg_m3 is {off:g}; must be < density_kg_m3, {density:g}")
    file = folder / rod["file"]
    try:
        source = read_solid(file, rod["unit"], rod["body"])
        return measure_rod(source, density * G_PER_MM3_PER_KG_M3, off * G_PER_MM3_PER_KG_M3)
    except AutobalanceError as error:
        text = str(error)
        raise JobError(f"engine.rod: {text if str(file) in text else f'{file}: {text}'}") from None


def _check_length(engine: Mapping[str, Any], rod: Mapping[str, Any], length_mm: float) -> None:
    length = engine.get("rod_length_mm")
    if not isinstance(length, int | float) or isinstance(length, bool):
        return
    if abs(length - length_mm) > max(LENGTH_MM, LENGTH_SHARE * length_mm):
        raise JobError(
            f"engine.rod_length_mm is {length:g}; engine.rod.file ({rod['file']}) measures {length_mm:.4g};"
            " correct one, or leave the length out"
        )
