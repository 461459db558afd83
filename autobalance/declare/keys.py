"""Keys of tables: what a TOML file may hold, declared once.

A table is a frozen dataclass whose fields declare in ``Annotated`` the content of the file. ``keys_of`` gives
the declaration. From it come reading with defaults, the echo of the input in a report, the JSON Schema for
editors, the job that ``init`` writes and the tables of the documentation. ``made`` makes the dataclass of the
input.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import field, replace
from functools import cache
from types import UnionType
from typing import Annotated, Any, NewType, TypeVar, Union, get_args, get_origin, get_type_hints

from autobalance.declare.fields import Named
from autobalance.declare.ranges import ANY, Range, TypedIn, Unit, converted, unit_of_name
from autobalance.value_classes import dataclass

T = TypeVar("T")

Large = NewType("Large", float)
"""Type hint of a number that may be larger, such as a stiffness [N/m]."""


class _Required:
    """Mark of a key that has no default."""

    def __repr__(self) -> str:
        return "REQUIRED"


REQUIRED = _Required()
FILLED: Any = ()


@dataclass(frozen=True)
class Key:
    """One key of a table: its name, type, rule and default, and what it means.

    ``keys`` makes it a separate table. With ``many`` it is an array of tables; with ``hint`` as well, a plain
    value or a table. ``named`` makes it a table whose keys are free names, and describes each. A table that
    may be missing has the default None, or ``FILLED``: then it exists with the defaults of its keys.
    ``forms`` are the tables that a file may hold in its place, if the input was brought to one form before.
    ``instead`` is the key that may be in its place, and then only one of both.

    ``typed`` is the unit of a number that may be typed with it, if the name does not end in a unit.
    ``not_empty`` is the remedy for an empty list or text; ``missing`` is an addition to the message if a key
    is missing. ``usual`` is a default that is not a value; ``verbs`` are the commands that read it.
    ``example`` is its value in a template if it has no default. ``shape`` is the rest of its JSON Schema.
    With ``or_one``, one number may be given for a list of one.
    ``ignored`` are names that a table of an array may have and that are not read.
    """

    name: str
    hint: Any = None
    says: str = ""
    rule: Range = ANY
    default: Any = REQUIRED
    keys: tuple[Key, ...] = ()
    many: bool = False
    named: Key | None = None
    forms: tuple[Key, ...] = ()
    instead: str = ""
    typed: str = ""
    not_empty: str = ""
    missing: str = ""
    usual: str = ""
    verbs: str = ""
    example: Any = None
    shape: Mapping[str, Any] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()
    or_one: bool = False

    @property
    def unit(self) -> str:
        """Unit of its numbers, by its name unless set otherwise; empty for a number without a unit."""
        return self.typed or unit_of_name(self.name)

    @property
    def typed_unit(self) -> str:
        """Unit with which its numbers may be typed; none if its name is that unit, as ``g`` in a weight."""
        return "" if self.name == self.unit else self.unit

    @property
    def read_by(self) -> tuple[str, ...]:
        """The verbs that read it, where not every one does."""
        return () if self.verbs in ("", "all") else tuple(self.verbs.split(", "))

    @property
    def is_table(self) -> bool:
        """Whether its value is a table, or a list of them."""
        return bool(self.keys) or self.named is not None


def names(keys: tuple[Key, ...]) -> tuple[str, ...]:
    """Return the names of keys, in their order."""
    return tuple(key.name for key in keys)


def optional(keys: tuple[Key, ...]) -> tuple[Key, ...]:
    """Return keys that are all optional: other keys replace them, or they overrule."""
    return tuple(replace(key, default=None) if key.default is REQUIRED else key for key in keys)


@dataclass(frozen=True)
class InFile:
    """Mark of a field with more to say of its key; the words are those of ``Key``.

    ``filled``: the key may be missing, though the field has no default: whoever makes the table fills it in.
    """

    usual: str = ""
    not_empty: str = ""
    missing: str = ""
    verbs: str = ""
    instead: str = ""
    example: Any = None
    shape: Mapping[str, Any] = field(default_factory=dict)
    filled: bool = False


@cache
def keys_of(table: type[Any]) -> tuple[Key, ...]:
    """Return the keys of a table, from the annotated fields of its dataclass.

    A field of another table, or of a tuple of them, is a table in the table, or an array of tables; one that
    may be None may be missing. Fields without ``Annotated`` are not keys.
    """
    return tuple(_key(each, hint) for each, hint in _fields(table))


def made(table: type[T], values: Mapping[str, Any], **others: Any) -> T:
    """Return a table's input as an instance of its dataclass, ``others`` as they are given.

    Parameters
    ----------
    table : type
        The dataclass.
    values : mapping
        By key, in the units of the file, defaults filled in.
    others : object
        Fields that are not keys, and those that take another value than the file's.
    """
    fields = {
        each.name: _inside(hint, values[_name(each, hint)])
        for each, hint in _fields(table)
        if each.name not in others
    }
    return table(**fields, **others)


def _fields(table: type[Any]) -> list[tuple[dataclasses.Field[Any], Any]]:
    hints = get_type_hints(table, include_extras=True)
    each_hint = [(each, hints[each.name]) for each in dataclasses.fields(table)]
    return [(each, hint) for each, hint in each_hint if get_origin(hint) is Annotated]


def _mark(hint: Any, of: type[T]) -> T | None:
    return next((mark for mark in get_args(hint)[1:] if isinstance(mark, of)), None)


def _name(each: dataclasses.Field[Any], hint: Any) -> str:
    if named := _mark(hint, Named):
        return named.name
    unit = _mark(hint, Unit)
    return each.name if unit is None else unit.key(each.name)


def _key(each: dataclasses.Field[Any], hint: Any) -> Key:
    more = _mark(hint, InFile) or InFile()
    typed = _mark(hint, TypedIn)
    held, many = _table_in(get_args(hint)[0])
    table: Any = held
    return Key(
        _name(each, hint),
        get_args(hint)[0] if table is None else None,
        _mark(hint, str) or "",
        _mark(hint, Range) or ANY,
        _default(each, hint, table, many),
        keys=() if table is None else keys_of(table),
        many=many,
        instead=more.instead,
        typed=typed.unit if typed else "",
        not_empty=more.not_empty,
        missing=more.missing,
        usual=more.usual,
        verbs=more.verbs,
        example=more.example,
        shape=more.shape,
    )


def _default(each: dataclasses.Field[Any], hint: Any, table: Any, many: bool) -> Any:
    """Return the default in the file's unit; a table that is there with its own defaults is filled."""
    if each.default_factory is not dataclasses.MISSING:
        return FILLED
    if each.default is dataclasses.MISSING:
        return None if (_mark(hint, InFile) or InFile()).filled else REQUIRED
    if table is not None and not many and each.default is not None:
        return FILLED
    unit = _mark(hint, Unit)
    return each.default if unit is None else converted(each.default, unit.written)


def _table_in(hint: Any) -> tuple[type[Any] | None, bool]:
    """Return the dataclass that a field holds, and whether it holds a tuple of them."""
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return hint, False
    if get_origin(hint) is tuple and get_args(hint)[-1] is Ellipsis:
        table, _ = _table_in(get_args(hint)[0])
        return table, table is not None
    if get_origin(hint) in (Union, UnionType):
        found = [_table_in(each) for each in get_args(hint) if each is not type(None)]
        return found[0] if len(found) == 1 else (None, False)
    return None, False


def _inside(hint: Any, value: Any) -> Any:
    """Return a value of a file in the unit of its field; tables become instances."""
    table, many = _table_in(get_args(hint)[0])
    if table is not None and value is not None:
        return tuple(made(table, each) for each in value) if many else made(table, value)
    unit = _mark(hint, Unit)
    return value if unit is None else converted(value, unit.read)
