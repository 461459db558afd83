"""Tables of a job that an add-on declares and reads: the job carries what it makes of them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from autobalance import registry
from autobalance.declare import Key, Values
from autobalance.toml_files.keys import plain


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
