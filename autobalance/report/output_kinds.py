"""A kind of file for people that a run can write, and those of the registry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from autobalance import registry

if TYPE_CHECKING:
    from autobalance.report.material import FileMaterial


# A kind of file for people that a balancing run can write.


class OutputKind(NamedTuple):
    """A kind of file beside the solid and ``report.json``.

    Attributes
    ----------
    name : str
        As ``--only`` and ``write(only=...)`` take it.
    files : mapping
        Key in ``outputs`` of the report → name of the file.
    make : callable
        Material of a run → bytes by the same keys.
    is_usual : bool
        Whether it is written if nothing is chosen.
    is_to_fill : bool
        Whether people write into it afterwards: then it is not listed in ``outputs``, and one that lies there
        is left as it is.
    is_paper : bool
        Whether it is handed on: its name then begins with part and serial, where the job has them.
    require : callable
        Raises ``FormatError`` where the extra that it needs is not installed.
    """

    name: str
    files: Mapping[str, str]
    make: Callable[[FileMaterial], Mapping[str, bytes]]
    is_usual: bool = True
    require: Callable[[], None] = lambda: None
    is_to_fill: bool = False
    is_paper: bool = False

    def named(self, prefix: str) -> Mapping[str, str]:
        """Return the files by their keys, with a prefix if they are papers."""
        return {key: prefix * self.is_paper + name for key, name in self.files.items()}


# Kinds of files for people, those of ``registry.OUTPUT_KINDS`` and what is registered besides.


_KINDS: dict[str, OutputKind] = {}
KINDS: Mapping[str, OutputKind] = MappingProxyType(_KINDS)
"""Kinds by name, in the order in which they are made."""


def register(kind: OutputKind) -> None:
    """Enter a kind of file.

    Raises
    ------
    ValueError
        If its name, or the name or key of one of its files, is taken.
    """
    names = {*page_names(), *(key for each in _KINDS.values() for key in each.files)}
    for name in (*kind.files, *kind.files.values()):
        if name in names:
            raise ValueError(f"an output of the name {name!r} is there already")
    if kind.name in _KINDS:
        raise ValueError(f"the output kind {kind.name!r} is there already")
    _KINDS[kind.name] = kind


def usual() -> tuple[str, ...]:
    """Return the names of the kinds that are written if nothing is chosen."""
    return tuple(name for name, kind in _KINDS.items() if kind.is_usual)


def to_fill() -> frozenset[str]:
    """Return the keys of files that people write into afterwards."""
    return frozenset(key for kind in _KINDS.values() if kind.is_to_fill for key in kind.files)


def names_to_fill() -> frozenset[str]:
    """Return the names of files that people write into afterwards, and that stay as they are then."""
    return frozenset(name for kind in _KINDS.values() if kind.is_to_fill for name in kind.files.values())


def choices() -> tuple[str, ...]:
    """Return the names that can be chosen: ``json``, which is always written, and the kinds."""
    return ("json", *_KINDS)


def page_names(prefix: str = "") -> tuple[str, ...]:
    """Return the names of all files that the kinds may write; those of papers begin with ``prefix``."""
    return tuple(name for kind in _KINDS.values() for name in kind.named(prefix).values())


for _place in registry.OUTPUT_KINDS:
    register(registry.loaded(_place))
