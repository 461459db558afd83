"""Plausible falsehoods: every value of a report changed a little, one at a time."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Callable, Hashable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from jsonschema import ValidationError, validators

import autobalance as ab
from autobalance.correction import KINDS
from autobalance.report.balance.values import report as as_report
from autobalance.report.balance.values import schema
from autobalance.verification import correction_claims, cut_values, report_file
from autobalance.verification.check import check_claims
from autobalance.verification.checked import Checked
from autobalance.verification.claims import Claims
from autobalance.verification.cut_values import STATED
from autobalance.verification.solids import Files

Report = dict[str, Any]
Way = tuple[str | int, ...]
SCHEMA = schema()


def checked(report: Report, folder: Path, files: Files | None = None) -> Checked:
    """Hold a report against its files, which are read once."""
    return check_claims(Claims("report.json", report), folder, False, as_report, files, SCHEMA)


def knowing_sound_parts(validator_class: Any) -> Any:
    """Return validators that hold a part which several reports share against its schema once."""
    known: dict[tuple[str, int, int], tuple[Any, Any]] = {}  # holds the parts: no identity is used twice

    def once(name: str) -> Callable[..., Iterator[ValidationError]]:
        check = validator_class.VALIDATORS[name]

        def faults(validator: Any, rule: Any, part: Any, inside: Any) -> Iterator[ValidationError]:
            key = name, id(part), id(inside)
            if key not in known:
                yield from (here := list(check(validator, rule, part, inside) or ()))
                if not here:
                    known[key] = part, inside

        return faults

    keywords = {name: once(name) for name in ("properties", "items", "additionalProperties")}
    return validators.extend(validator_class, keywords)


@contextlib.contextmanager
def sound_parts_known() -> Iterator[None]:
    """Hold a part that several reports share against its schema once: most of a changed report is shared."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_file, "VALIDATOR", knowing_sound_parts(report_file.VALIDATOR))
        yield


class KnownTrace:
    """Trace of a cut that is read once off the same metal, and in equal surroundings."""

    def __init__(self, trace: Any, item: str, known: dict[Any, Any]) -> None:
        self._trace, self._item, self._known = trace, item, known

    def __getattr__(self, name: str) -> Any:
        return getattr(self._trace, name)

    def implied(self, crank: Any, limits: Any) -> Any:
        key = "implied", self._item, id(crank), repr(limits)
        return self._once(key, crank, lambda: self._trace.implied(crank, limits))

    def room(self, crank: Any) -> Any:
        return self._once(("room", self._item, id(crank)), crank, lambda: self._trace.room(crank))

    def read(self, metal: Any) -> Any:
        moments = metal.moments
        pieces = len(metal.pieces), moments.mass_g, *moments.first_g_mm, *moments.second_g_mm2.ravel()
        around = (
            id(metal.crank),
            repr(metal.limits),
            metal.density_g_mm3,
            metal.service_speed_rad_s,
            metal.near_mm,
        )
        key = "read", self._item, pieces, around
        return self._once(key, metal.crank, lambda: self._trace.read(metal))

    def _once(self, key: Hashable, crank: Any, work: Callable[[], Any]) -> Any:
        if key not in self._known:
            self._known[key] = crank, work()  # holds the crank: no identity is used twice
        return self._known[key][1]


class KnownKind:
    """Kind of correction whose traces know what they read."""

    def __init__(self, kind: Any, known: dict[Any, Any]) -> None:
        self._kind, self._known = kind, known

    def __getattr__(self, name: str) -> Any:
        return getattr(self._kind, name)

    def trace(self, item: Mapping[str, Any]) -> Any:
        trace = self._kind.trace(item)
        return None if trace is None else KnownTrace(trace, json.dumps(item, sort_keys=True), self._known)


@contextlib.contextmanager
def unchanged_cuts_known() -> Iterator[None]:
    """Read a cut off the metal once: of a changed report most cuts are as they were."""
    known: dict[Any, Any] = {}
    with pytest.MonkeyPatch.context() as patch:
        kinds = {name: KnownKind(kind, known) for name, kind in KINDS.items()}
        patch.setattr(correction_claims, "KINDS", kinds)
        for name in ("_pieces", "_shared_mm3"):  # of which piece is whose
            patch.setattr(cut_values, name, known_of_the_same(getattr(cut_values, name)))
        yield


def known_of_the_same(work: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of solids and numbers that does its work once for the same ones."""
    known: dict[Hashable, Any] = {}

    def once(*of: Any) -> Any:
        key = tuple(each if isinstance(each, float) else id(each) for each in of)
        if key not in known:
            known[key] = of, work(*of)  # holds the solids: no identity is used twice
        return known[key][1]

    return once


def leaves(value: Any, way: Way = ()) -> Iterator[Way]:
    """Yield the ways to all values that hold no objects."""
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from leaves(inner, (*way, key))
    elif isinstance(value, list) and any(isinstance(each, Mapping) for each in value):
        yield way
        for number, inner in enumerate(value):
            yield from leaves(inner, (*way, number))
    else:
        yield way


def place(way: Way) -> str:
    """Return a way as a report's keys are written, ``[]`` for every entry of a list."""
    text = "".join("[]" if isinstance(part, int) else f".{part}" for part in way)
    return text[1:]


def one_of_each(report: Report) -> list[Way]:
    """Return the ways to values, one for all entries of a list."""
    return list({place(way): way for way in leaves(report)}.values())


def falsehoods(value: Any) -> Iterator[Any]:
    """Yield what might stand in place of a value: numbers by 1 %, other texts, emptied lists, null."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield value + 1
    elif isinstance(value, float):
        yield value * 1.01 + (0.01 if abs(value) < 0.1 else 0.0)
    elif isinstance(value, str):
        yield f"{value}x"
    elif isinstance(value, list) and value:
        yield []
        numbers = [each for each in value if isinstance(each, float)]
        if len(numbers) == len(value):
            most = max(range(len(value)), key=lambda k: abs(value[k]))
            yield [
                each * 1.01 + (0.01 if abs(each) < 0.1 else 0.0) if k == most else each
                for k, each in enumerate(value)
            ]
    if value is None:
        yield 1.0
        yield "x"
    else:
        yield None


@sound_parts_known()
@unchanged_cuts_known()
def accepted(
    report: Report, folder: Path, under: tuple[str, ...] = (), files: Files | None = None
) -> list[str]:
    """Return the changes that are taken for true though their key is on no list of what was not checked.

    Only values ``under`` some keys are changed, where such are given. ``files`` may have been read before.
    """
    files, found = files or Files(), list[str]()
    checked(report, folder, files)
    for way in one_of_each(report):
        if under and way[0] not in under:
            continue
        value = at(report, way)
        for other in falsehoods(value):
            try:
                result = checked(changed(report, way, other), folder, files)
            except ab.AutobalanceError:
                continue
            if not _is_listed(place(way), [each.key for each in result.not_checked]):
                found.append(f"{place(way)}: {value!r} -> {other!r}")
    for key in STATED if report["corrections"] else ():
        first, *others = report["corrections"]
        left_out = {each: value for each, value in first.items() if each != key}
        with contextlib.suppress(ab.AutobalanceError):
            checked({**report, "corrections": [left_out, *others]}, folder, files)
            found.append(f"corrections[].{key} left out")
    return found


def _is_listed(name: str, keys: list[str]) -> bool:
    general = [re.sub(r"\[\d+\]", "[]", key) for key in keys]
    return any(name == key or name.startswith((f"{key}.", f"{key}[")) for key in general)


def at(report: Any, way: Way) -> Any:
    """Return the value at the end of a way."""
    for key in way:
        report = report[key]
    return report


def changed(report: Any, way: Way, value: Any) -> Any:
    """Return a report with another value at the end of a way; all that lies beside the way is shared."""
    if not way:
        return value
    copied: Any = list(report) if isinstance(report, list) else dict(report)
    copied[way[0]] = changed(report[way[0]], way[1:], value)
    return copied
