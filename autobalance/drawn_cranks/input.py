"""Read the description of a crankshaft to generate, as strictly as a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any, get_args, get_type_hints

from autobalance.declare import Values, encoded, names
from autobalance.drawn_cranks.design import Design, preset
from autobalance.drawn_cranks.keys import DESIGN
from autobalance.errors import JobError
from autobalance.job.model import EngineParts
from autobalance.job.read_engine import ENGINE, engine_of
from autobalance.toml_files.document import toml_of
from autobalance.toml_files.keys import read
from autobalance.toml_files.table import Table, unknown_keys
from autobalance.toml_files.typed_units import in_base_units


def read_design(text: str, source: str) -> tuple[Design, EngineParts | None]:
    """Read a crank description from TOML.

    Parameters
    ----------
    text : str
        TOML whose keys are those of ``Design``; ``preset`` names one to start from, and ``[engine]`` gives
        the weights on the throws as in a job.
    source : str
        Name of the file, for messages; without its ending, the crank's name if the text gives none.

    Raises
    ------
    JobError
        For text that is not TOML, unknown or missing keys, wrong types and impossible values.
    """
    raw = toml_of(text, source)
    try:
        return _design_and_engine(raw, source.rpartition(".")[0] or source)
    except JobError as error:
        raise JobError(f"{source}: {error}") from None


def design_from(values: Mapping[str, Any]) -> tuple[Design, EngineParts | None]:
    """Return the design of a mapping with the structure of the TOML file, and the weights if any.

    Raises
    ------
    JobError
        As ``read_design``.
    """
    return _design_and_engine(dict(values), "crank")


def _design_and_engine(raw: dict[str, Any], name: str) -> tuple[Design, EngineParts | None]:
    own = ("preset", "engine")
    described = {key: value for key, value in raw.items() if key not in own}
    base = encoded(preset(Table(raw, "", None).value("preset", str))) if "preset" in raw else {}
    design = _design({"name": name, **_merged(base, described)}, own)
    if "engine" not in raw:
        return design, None
    engine = read({"engine": raw["engine"]}, (ENGINE,))["engine"]
    return design, engine_of(engine, design.crankpin_in_file)


def with_settings(design: Design, settings: Mapping[str, Any]) -> Design:
    """Return a design with dotted keys set: ``{"counterweight.radius_mm": 60.0}``.

    Raises
    ------
    JobError
        As ``read_design``.
    """
    change: dict[str, Any] = {}
    for dotted, value in settings.items():
        *path, last = dotted.split(".")
        place = change
        for key in path:
            place = place.setdefault(key, {})
            if not isinstance(place, dict):
                raise JobError(f"{dotted} is set inside {key}, which is set to a value too")
        place[last] = value
    return _design(_merged(encoded(design), change))


def _merged(base: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in change.items():
        old = merged.get(key)
        merged[key] = _merged(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return merged


def _design(raw: dict[str, Any], beside: tuple[str, ...] = ()) -> Design:
    """Return the design of a table; ``beside`` are keys that a file may hold besides."""
    if unknown := unknown_keys(Table(raw, "", None), (*names(DESIGN), *beside)):
        raise JobError(*unknown)
    design: Design = _of_values(Design, read(in_base_units(raw), DESIGN))
    return design


def _of_values(kind: Any, values: Values) -> Any:
    """Return a dataclass of the values of its fields, tables as the dataclasses that they stand for."""
    return kind(**{name: _of_value(hint, values[name]) for name, hint in get_type_hints(kind).items()})


def _of_value(hint: Any, value: Any) -> Any:
    kinds = [arm for arm in (*get_args(hint), hint) if is_dataclass(arm)]
    if isinstance(value, dict):
        return _of_values(kinds[0], value)
    return tuple(_of_values(kinds[0], each) for each in value) if isinstance(value, list) else value
