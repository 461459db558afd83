"""Registry of the kinds of correction, by their names and their limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from autobalance.correction.contract import Limits
from autobalance.correction.kind import Kind, Workpiece
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.solid.csg.solid import Solid

_KINDS: dict[str, Kind[Any]] = {}
KINDS: Mapping[str, Kind[Any]] = MappingProxyType(_KINDS)
"""Every kind by its name, in the order of registration."""


def register(kind: Kind[Any]) -> None:
    """Register a kind of correction.

    Raises
    ------
    TypeError
        If it lacks an attribute of `Kind`, or its name or limits are taken.
    """
    for fault in _faults(kind):
        raise TypeError(f"{type(kind).__name__} is not a kind of correction: {fault}")
    _KINDS[kind.name] = kind


def _faults(kind: Kind[Any]) -> Iterator[str]:
    for text in ("name", "verb", "noun", "datum"):
        value = getattr(kind, text, None)
        if not isinstance(value, str) or not value.strip():
            yield f"its {text} is {value!r}; expected a text"
            return
    if not kind.name.isidentifier() or kind.name != kind.name.lower():
        yield f"its name is {kind.name!r}; expected a key of lower-case letters"
    if kind.name in _KINDS:
        yield f"the name {kind.name!r} is taken"
    limits = getattr(kind, "limits", None)
    if not (isinstance(limits, type) and issubclass(limits, Limits) and limits is not Limits):
        yield f"its limits are {limits!r}; expected a class derived from Limits"
        return
    if any(other.limits is limits for other in _KINDS.values()):
        yield f"the limits {limits.__name__} are another kind's"
    if not is_dataclass(limits) or "__dataclass_fields__" not in vars(limits):
        yield f"its limits {limits.__name__} are not a dataclass"
        return
    for each in fields(limits):
        if each.default is MISSING and each.default_factory is MISSING:
            yield f"{limits.__name__}.{each.name} has no default; expected one: method alone is enough"
    if kind.search_levels < 1:
        yield f"search_levels is {kind.search_levels}; expected 1 or more"
    if kind.remedy is not None and not isinstance(kind.remedy, limits):
        yield f"its remedy is {kind.remedy!r}; expected {limits.__name__}"


def kind_of(limits: Limits) -> Kind[Any]:
    return next(kind for kind in _KINDS.values() if type(limits) is kind.limits)


def finishing(methods: Sequence[Limits]) -> Limits:
    """Return the limits of a kind that makes the last cuts on the machine: a job's own, else the defaults."""
    for limits in methods:
        if kind_of(limits).finishes:
            return limits
    return next(kind for kind in _KINDS.values() if kind.finishes).limits()


def face_depths_mm(
    solid: Solid, anatomy: Anatomy, density_g_mm3: float, faces: tuple[Face, ...], rims: Sequence[Face]
) -> dict[str, float]:
    """Return the largest default depths of faces and rims, by their ids, where metal limits them."""
    nowhere = (0.0, np.zeros(2))
    work = Workpiece(solid, anatomy, faces, density_g_mm3, (nowhere, nowhere))
    depths: dict[str, float] = {}
    for kind in _KINDS.values():
        depths |= kind.face_depths_mm(work, rims)
    return depths


def mixes() -> tuple[tuple[str, ...], ...]:
    """Return the names of the kinds that ``compare`` tries: each alone, then with those it is mixed with."""
    alone = [(name,) for name in _KINDS]
    return (*alone, *((name, other) for name, kind in _KINDS.items() for other in kind.mixed_with))
