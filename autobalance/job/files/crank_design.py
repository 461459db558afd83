"""Read the description of a crankshaft to generate, as strictly as a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from autobalance.crank.parametric.design import Design, preset
from autobalance.errors import JobError
from autobalance.job.model import EngineParts
from autobalance.job.read_engine import ENGINE, engine_of
from autobalance.job.toml.document import toml_of
from autobalance.job.toml.keys import read
from autobalance.job.toml.table import Table


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
        For text that is no TOML, unknown or missing keys, wrong types and impossible values.
    """
    raw = toml_of(text, source)
    try:
        return _design_and_engine(raw, source.rpartition(".")[0] or source)
    except JobError as error:
        raise JobError(f"{source}: {error}") from None


def design_from(values: Mapping[str, Any]) -> tuple[Design, EngineParts | None]:
    """Return the design that a mapping says, with the structure of the TOML file, and the weights if any.

    Raises
    ------
    JobError
        As ``read_design``.
    """
    return _design_and_engine(dict(values), "crank")


def _design_and_engine(raw: dict[str, Any], name: str) -> tuple[Design, EngineParts | None]:
    root = Table(raw, "", ("preset", "engine", *_keys(Design)))
    base = table_of(preset(root.value("preset", str))) if "preset" in root else {}
    described = {key: value for key, value in raw.items() if key not in ("preset", "engine")}
    design = _design({"name": name, **_merged(base, described)})
    if "engine" not in root:
        return design, None
    engine = read({"engine": root.raw["engine"]}, (ENGINE,))["engine"]
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
    return _design(_merged(table_of(design), change))


def table_of(value: Any) -> Any:
    """Return a design as the table that describes it, keys without a value left out."""
    if is_dataclass(value):
        pairs = ((item.name, getattr(value, item.name)) for item in fields(value))
        return {key: table_of(item) for key, item in pairs if item is not None}
    return [table_of(item) for item in value] if isinstance(value, tuple) else value


def _merged(base: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in change.items():
        old = merged.get(key)
        merged[key] = _merged(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return merged


def _keys(kind: Any) -> tuple[str, ...]:
    return tuple(item.name for item in fields(kind))


def _design(raw: dict[str, Any]) -> Design:
    design: Design = _dataclass(Design, Table(raw, "", _keys(Design)))
    return design


def _dataclass(kind: Any, table: Table) -> Any:
    """Read a table whose keys are the fields of a dataclass."""
    hints = get_type_hints(kind)
    names = [
        item.name
        for item in fields(kind)
        if item.name in table or (item.default is MISSING and item.default_factory is MISSING)
    ]
    return kind(**{name: _value(hints[name], table, name) for name in names})


def _value(hint: Any, table: Table, key: str) -> Any:
    arms = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    kind = next(arm for arm in arms if arm is not type(None))
    if is_dataclass(kind):
        if key not in table:
            return table.value(key, dict)  # says that it is missing
        return _dataclass(kind, table.table(key, _keys(kind)))
    item = get_args(kind)[0] if get_origin(kind) is tuple else None
    if is_dataclass(item) and key in table:
        return tuple(_dataclass(item, each) for each in table.tables(key, _keys(item)))
    return table.value(key, kind)
