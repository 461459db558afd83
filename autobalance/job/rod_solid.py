"""The connecting rod of a job, taken from its solid: end weights, length and inertia come from there."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.declare import Values
from autobalance.errors import AutobalanceError, JobError
from autobalance.job.solid_weights import SOLID_ROD
from autobalance.toml_files.keys import read
from autobalance.units import G_PER_MM3_PER_KG_M3

if TYPE_CHECKING:
    from autobalance.crank.connecting_rod import MeasuredRod

SCALE_KEYS = ("big_end_g", "small_end_g", "inertia_kg_mm2")
PLACES = {"rotating_g": "connecting_rod_big_end", "reciprocating_g": "connecting_rod_small_end"}
"""Table of weights → the name that a rod's end has in it."""
LENGTH_MM, LENGTH_SHARE = 0.1, 0.005
"""A rod length that is given may differ from the measured one by the larger of these."""
KG_MM2_PER_G_MM2 = 1e-3


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
