"""Kinds of files for people, those of ``registry.OUTPUT_KINDS`` and what is registered besides."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from autobalance import registry
from autobalance.report.output_kind import OutputKind

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
