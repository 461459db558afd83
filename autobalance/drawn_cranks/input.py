"""Read the description of a crankshaft to generate, as strictly as a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass, replace
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from autobalance.declare import ANY, NOT_NEGATIVE, POSITIVE, REQUIRED, Key, Range, Values, encoded, names
from autobalance.drawn_cranks.design import LEAST_SEGMENTS, MOST_SEGMENTS, PRESETS, Design, preset
from autobalance.errors import JobError
from autobalance.job.model import EngineParts
from autobalance.job.read_engine import ENGINE, engine_of
from autobalance.toml_files.document import toml_of
from autobalance.toml_files.keys import read
from autobalance.toml_files.table import Table, unknown_keys
from autobalance.toml_files.typed_units import in_base_units

# Keys of a crank's description by dimensions: the fields of ``Design``, with their meanings.


MEANINGS: Mapping[str, str] = {
    "name": "name of the crank; by default the file's name",
    "stroke_mm": "stroke of the pistons: twice the crank radius",
    "main_journal": "the main journals",
    "crankpin": "the crankpins",
    "web": "the arms between journals and crankpins",
    "bays": "throws and flying webs between main journals, from the nose on",
    "counterweight": "sectors opposite the crankpins",
    "end_journal_width_mm": "width of the first and last main journal, if it differs",
    "fillet_mm": "radius where journals and crankpins meet webs",
    "oil_hole_mm": "diameter of the drilling from journal to crankpin; 0: none",
    "nose": "the free end at the first main journal",
    "flange": "the disc at the last main journal",
    "journals": '"first": overhung, without the last main journal',
    "crankpin_in_file": "false: pressed up, drawn in halves without its crankpins",
    "density_kg_m3": "density of the crank",
    "segments": "facets a turn",
    "diameter_mm": "diameter of the cylinder",
    "width_mm": "along the axis; of a journal from web to web, fillets included; of a keyway its slot's",
    "bore_mm": "diameter of the bore along it; 0: none",
    "thickness_mm": "along the axis; of a counterweight from the web's crankpin side",
    "outline": "the hull of two discs, or one disc about the crank's axis",
    "pin_end_radius_mm": "radius of a pear about the crankpin",
    "hub_radius_mm": "radius of a pear about the crank's axis",
    "disc_radius_mm": "radius of a disc about the crank's axis",
    "between_pins_mm": "thickness between two crankpins of one bay",
    "crankpins_deg": "angle of each crankpin of the bay",
    "counterweights": "whether its first and its last web carry one",
    "radius_mm": "outer, about the crank's axis",
    "fan_angle_deg": "angle of the sector",
    "inner_radius_mm": "radius at which the shoulder beyond the web begins",
    "draft_deg": "lean of the shoulder's straight edges",
    "length_mm": "along the axis",
    "end_diameter_mm": "diameter of a taper's free end",
    "keyway": "a slot along the nose, from its free end",
    "depth_mm": "depth of the slot",
    "bolts": "number of bolt holes",
    "bolt_diameter_mm": "diameter of each bolt hole",
    "bolt_circle_mm": "diameter of the circle of bolt holes",
}
"""Meanings of the fields by name."""
RULES: Mapping[str, Range] = {
    "stroke_mm": POSITIVE,
    "density_kg_m3": POSITIVE,
    "segments": Range(
        f"must be {LEAST_SEGMENTS} to {MOST_SEGMENTS}", least=LEAST_SEGMENTS, most=MOST_SEGMENTS
    ),
}
"""Ranges of numbers that exclude zero or have an upper bound."""


def _keys(kind: Any) -> tuple[Key, ...]:
    hints = get_type_hints(kind)
    return tuple(_key(item, hints[item.name]) for item in fields(kind))


def _key(item: Field[Any], hint: Any) -> Key:
    arms = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    kind = next(arm for arm in arms if arm is not type(None))
    default = REQUIRED if item.default is MISSING else item.default
    each = get_args(kind)[0] if get_origin(kind) is tuple else None
    if is_dataclass(kind) or is_dataclass(each):
        many = is_dataclass(each)
        keys = _keys(each if many else kind)
        return Key(item.name, says=MEANINGS[item.name], keys=keys, many=many, default=default)
    rule = RULES.get(item.name, NOT_NEGATIVE if kind in (int, float) else ANY)
    return Key(item.name, kind, MEANINGS[item.name], rule, default)


def _changes(keys: tuple[Key, ...]) -> tuple[Key, ...]:
    """Return the keys that may change a preset one by one; those of a list represent the whole list."""
    return tuple(
        replace(key, default=None, usual="as the preset", keys=key.keys if key.many else _changes(key.keys))
        for key in keys
    )


NAME = replace(_keys(Design)[0], default=None)
DESIGN: tuple[Key, ...] = (NAME, *_keys(Design)[1:])
PRESET = Key("preset", Literal[tuple(PRESETS)], "a bundled crank to begin with")
CRANK_FORMS: Mapping[str, tuple[Key, ...]] = {
    "from dimensions": (*DESIGN, ENGINE),
    "from a preset": (PRESET, *_changes(DESIGN), ENGINE),
}
"""Form of the file → all that may be at its top level."""


# Read the description of a crankshaft to generate, as strictly as a job.


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
