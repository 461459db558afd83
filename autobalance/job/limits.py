"""The ``[correction]`` table becomes the limits of each kind of correction.

The limits of a kind are a frozen dataclass whose fields are named and typed as the keys of its table; the
kinds are those entered in ``autobalance.correction``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Literal, get_type_hints

from autobalance.correction import KINDS, Limits
from autobalance.correction.contract import Prefer
from autobalance.errors import CorrectionError, JobError
from autobalance.job.toml.table import ANY, NOT_NEGATIVE, POSITIVE, Rule, Table

FACE_KEYS = ("faces", "sector_deg", "max_depth_mm", "same_depth", "min_wall_mm")
"""Keys of the top level, which the kinds share whose limits have ``faces``."""

FINEST_STEP_MM = 1e-6
"""Of a machine; with a finer one the number of steps is no number any more."""
RULES: Mapping[str, Rule] = {
    "max_depth_mm": POSITIVE,
    "min_wall_mm": NOT_NEGATIVE,
    "crankcase_radius_mm": POSITIVE,
    "crankcase_gap_mm": NOT_NEGATIVE,
    "depth_step_mm": Rule(lambda x: x == 0.0 or x >= FINEST_STEP_MM, f"must be 0 or ≥ {FINEST_STEP_MM:g}"),
}


def correction_keys() -> tuple[str, ...]:
    """Return the keys of the ``[correction]`` table."""
    return (*FACE_KEYS, "method", "prefer", "depth_tolerance_mm", *KINDS)


def read_correction(root: Table) -> tuple[tuple[str, ...], tuple[Limits, ...]]:
    """Return the methods that a job names and the limits of each.

    Raises
    ------
    JobError
        If a key or value of ``[correction]`` is wrong.
    """
    if "correction" not in root:
        raise JobError(f"[correction] is missing; it needs at least method: one of {', '.join(KINDS)}")
    table = root.table("correction", correction_keys())
    names = _methods(table)
    for name in KINDS:  # a table of another method than the one asked for is checked all the same
        if name in table and name not in names:
            _limits(table, name)
    return names, tuple(_limits(table, name) for name in names)


def read_prefer(root: Table) -> Prefer:
    """Return what a job wants spared."""
    prefer: Prefer = root.table("correction", correction_keys()).optional("prefer", Prefer, default="simple")
    return prefer


def read_depth_tolerance_mm(root: Table) -> float | None:
    """Return by how much the depth of a cut may be off, None where a job does not say."""
    most: float | None = root.table("correction", correction_keys()).optional(
        "depth_tolerance_mm", float, NOT_NEGATIVE
    )
    return most


def limits_of_every_kind(raw: Mapping[str, Any]) -> dict[str, Limits]:
    """Return the limits of all kinds for a job as read: from its tables, else the defaults.

    Raises
    ------
    JobError
        If a value of a table is wrong.
    """
    table = Table(dict(raw.get("correction", {})), "correction", correction_keys())
    return {name: _limits(table, name) for name in KINDS}


def _methods(table: Table) -> tuple[str, ...]:
    method: Any = Literal[tuple(KINDS)]
    listed = isinstance(table.raw.get("method"), list)
    names: tuple[str, ...]
    names = table.value("method", tuple[method, ...]) if listed else (table.value("method", method),)
    if not names:
        raise JobError("correction.method is an empty list; must name at least one method")
    for place, name in enumerate(names):
        if name in names[:place]:
            raise JobError(f"correction.method names {name!r} twice")
    return names


def _limits(table: Table, name: str) -> Limits:
    """Return the limits of a method: its own table, over the top level's keys where it works on faces."""
    kind = KINDS[name].limits
    keys = tuple(field.name for field in fields(kind))
    own = table.table(name, keys)
    shared = {key: table.raw[key] for key in FACE_KEYS if key in table} if "faces" in keys else {}
    values = _values(Table(shared, table.path, None), kind) | _values(own, kind)
    try:
        limits = kind(**values)
    except CorrectionError as error:
        raise JobError(f"correction.{error}") from None
    return limits


def _values(table: Table, kind: type[Limits]) -> dict[str, Any]:
    hints = get_type_hints(kind)
    values = {key: table.value(key, hints[key], RULES.get(key, ANY)) for key in table.raw}
    if isinstance(sector := values.get("sector_deg"), tuple):  # a kind may call one angle so
        _refuse_empty_sector(table, sector)
    if values.get("faces") == ():
        raise JobError(f'{table.place("faces")} is an empty list; must be "auto" or name at least one face')
    return values


def _refuse_empty_sector(table: Table, sector: tuple[float, float]) -> None:
    if sector[0] == sector[1]:
        raise JobError(
            f"{table.place('sector_deg')} is [{sector[0]:g}, {sector[1]:g}]; its two angles must differ"
        )
