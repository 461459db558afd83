"""Declarations of all tables of a job, and those of add-ons."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from autobalance import registry
from autobalance.declare import Key, Values
from autobalance.job.assembly import ASSEMBLY
from autobalance.job.balance import BALANCE
from autobalance.job.layout import JOB, SHAFTS, SHOP
from autobalance.job.limits import correction_key
from autobalance.job.read_crankshaft import CRANKSHAFT
from autobalance.job.read_engine import ENGINE, ORIGINAL
from autobalance.toml_files.keys import json_schema, plain
from autobalance.value_classes import dataclass

# Tables of a job that an add-on declares and reads: the job carries what it makes of them.


class TablesRead(NamedTuple):
    """Tables of a job that are right each by itself, defaults filled in, and as they are in the file."""

    values: Values
    raw: Mapping[str, Any]


def _as_they_stand(tables: AddonTables, read: TablesRead, _: object) -> Values:
    return {key.name: plain(read.values[key.name]) for key in tables.keys if key.name in read.raw}


@dataclass(frozen=True)
class AddonTables:
    """Declaration of an add-on's tables in a job.

    ``made`` returns what the job carries of them, by its type (``Job.table``); None: nothing. ``needs`` are
    tables that must be right for it. ``filled`` returns them for the report, defaults filled in.
    """

    keys: tuple[Key, ...]
    made: Callable[[TablesRead], object | None]
    needs: tuple[str, ...] = ()
    filled: Callable[[AddonTables, TablesRead, Any], Values] = _as_they_stand


def addon_tables(held: Collection[str]) -> tuple[AddonTables, ...]:
    """Return the declarations of those tables that a job holds, each once."""
    places = dict.fromkeys(place for key, place in registry.JOB_TABLES.items() if key in held)
    return tuple(registry.loaded(place) for place in places)


# Declarations of all tables of a job, each from the module that reads it.


OWN_KEYS = ("crankshaft", "engine", "original", "balance", "correction", "shafts", "job", "shop", "assembly")
TOP_KEYS = (*OWN_KEYS, *registry.JOB_TABLES)
"""Keys of the top level of a job."""


def job_tables(held: Mapping[str, Any] | None = None) -> tuple[Key, ...]:
    """Return the declarations of a job's tables.

    Of those of add-ons, and of the kinds of correction, only what is in ``held``; None: all.
    """
    names = TOP_KEYS if held is None else held
    tables = None if held is None else held.get("correction")
    correction = correction_key(tables if isinstance(tables, Mapping) else None)
    own = (CRANKSHAFT, ENGINE, ORIGINAL, BALANCE, correction, SHAFTS, JOB, SHOP, ASSEMBLY)
    return (*own, *(key for each in addon_tables(names) for key in each.keys))


def key_at(path: str) -> Key:
    """Return the declaration of a job's key, by its dotted path; of a free name, what all such names are.

    Raises
    ------
    KeyError If there is no such table.
    """
    keys: tuple[Key, ...] = job_tables()
    declared = None
    for step in path.split("."):
        name = step.partition("[")[0]
        named = declared.named if declared is not None else None
        declared = named or next((key for key in keys if key.name == name), None)
        if declared is None:
            raise KeyError(path)
        keys = (*declared.keys, *(key for form in declared.forms for key in form.keys))
    assert declared is not None
    return declared


def job_schema() -> dict[str, Any]:
    """Return the JSON Schema of a job as TOML is parsed."""
    return json_schema("job", job_tables())
