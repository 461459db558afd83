"""Every report's schema: what its record encodes to fits, and whatever is edited in it does not."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import types
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NotRequired, Union, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import autobalance as ab
from autobalance import registry
from autobalance.declare import (
    ABSENT,
    DEGREES,
    G_MM,
    HERTZ,
    INLINE,
    LAST,
    LOOSE,
    MM,
    MPA,
    RPM,
    UNWRITTEN,
    Absent,
    Degrees,
    KgMm2,
    Like,
    Named,
    NotNegative,
    Pair,
    Pattern,
    Range,
    Registered,
    Rpm,
    Size,
    Unit,
    changed,
    decoded,
    derived,
    encoded,
    fields_of,
    marks_of,
    record,
)
from autobalance.declare.schema import schema_of
from autobalance.types import Array
from tests.frozen.outputs import report_differences
from tests.mutations import knowing_sound_parts

BOUNDS = {"minimum": 0.5, "exclusiveMinimum": 0.5}


@record
class Inner:
    """A record in a record."""

    speed_rad_s: Rpm


@record
class Outer:
    """One of every way to write a field."""

    angle_rad: Degrees | None
    inertias_g_mm2: Sequence[KgMm2]
    unbalance_g_mm: Pair
    inner: Annotated[Inner, INLINE]
    more: Annotated[Mapping[str, float], INLINE]
    from_: Annotated[int, Named("from")]
    left_out: str | Absent = ABSENT


def outer() -> Outer:
    return Outer(
        angle_rad=math.pi,
        inertias_g_mm2=(np.float64(2.0e3), 3.0e3),
        unbalance_g_mm=np.array([1.0, 2.0]),
        inner=Inner(speed_rad_s=2.0 * math.pi),
        more={"kind_mm": 4.0},
        from_=7,
    )


def test_a_record_is_written_in_the_units_of_its_keys() -> None:
    assert encoded(outer()) == {
        "angle_deg": 180.0,
        "inertias_kg_mm2": [2.0, 3.0],
        "unbalance_g_mm": [1.0, 2.0],
        "speed_rpm": pytest.approx(60.0, rel=1e-15),
        "kind_mm": 4.0,
        "from": 7,
    }
    made = schema_of(Outer, {}, [])
    assert made["required"] == ["angle_deg", "inertias_kg_mm2", "unbalance_g_mm", "speed_rpm", "from"]
    assert made["additionalProperties"] is True  # what stands inline has any keys
    Draft202012Validator(made).validate(encoded(outer()))


@pytest.mark.parametrize("unit", [DEGREES, G_MM, HERTZ, MM, MPA, RPM], ids=lambda unit: unit.outside)
def test_a_typed_number_is_written_as_it_was_typed(unit: Unit) -> None:
    """3000 rpm are 314.159... rad/s, which are 3000.0000000000005 rpm by one division."""
    typed = [0.1 * tenths for tenths in range(1, 40000, 37)] + [100.0 * n for n in range(1, 200)]
    typed = [round(each, 1) for each in typed]
    assert [unit.written(unit.read(each)) for each in typed] == typed


def test_what_was_written_is_read_again() -> None:
    again = decoded(Outer, encoded(outer()))
    assert (again.angle_rad, again.from_, again.left_out, again.more) == (
        math.pi,
        7,
        ABSENT,
        {"kind_mm": 4.0},
    )
    assert again.inner.speed_rad_s == pytest.approx(2.0 * math.pi, rel=1e-15)
    assert again.inertias_g_mm2 == (2.0e3, 3.0e3)
    for wrong, place in (
        ({"angle_deg": "90"}, r"^\.angle_deg is '90'; expected float"),
        ({"inertias_kg_mm2": [1.0, None]}, r"^\.inertias_kg_mm2\[2\] is None"),
        ({"from": True}, r"^\.from is True; expected int"),
        ({"unbalance_g_mm": 1.0}, r"^\.unbalance_g_mm is 1.0; expected a list"),
    ):
        with pytest.raises(ValueError, match=place):
            decoded(Outer, encoded(outer()) | wrong)
    with pytest.raises(ValueError, match=r"^\.from is missing"):
        decoded(Outer, {key: each for key, each in encoded(outer()).items() if key != "from"})


def test_what_an_earlier_version_wrote_is_read_as_far_as_it_goes() -> None:
    """Its writing again leaves out what it lacks, and what is there must still be of its type."""
    earlier = {key: each for key, each in encoded(outer()).items() if key not in ("from", "angle_deg")}
    again = decoded(Outer, earlier, partly=True)
    assert (again.left_out, again.unbalance_g_mm, again.more) == (ABSENT, (1.0, 2.0), {"kind_mm": 4.0})
    with pytest.raises(AttributeError, match="from_"):
        _ = again.from_
    turned = encoded(changed(again, angle_rad=0.5 * math.pi))
    assert (set(turned), turned["angle_deg"]) == ({*earlier, "angle_deg"}, 90.0)
    assert not hasattr(again, "angle_rad")
    assert "unbalance_g_mm=(1.0, 2.0)" in repr(again)
    assert "from_" not in repr(again)
    with pytest.raises(ValueError, match=r"^\.unbalance_g_mm is 1.0; expected a list"):
        decoded(Outer, earlier | {"unbalance_g_mm": 1.0}, partly=True)


@dataclasses.dataclass(frozen=True, eq=False)
class Wave:
    """A record computed from what is not written, and one of its fields behind what is derived."""

    schema_name: ClassVar[str] = "sine"

    samples_mm: Annotated[Array, UNWRITTEN]
    parts: Annotated[tuple[float, ...], LAST]

    @derived
    def greatest_mm(self) -> NotNegative:
        return float(np.abs(self.samples_mm).max())

    @derived
    def angle_rad(self) -> Degrees:
        return self.parts[0] * math.pi


@record
class Waves:
    """A record of records, one of which its schema leaves open."""

    waves: Sequence[Wave]
    open: Annotated[Wave, LOOSE]


def test_what_is_derived_is_written_and_read() -> None:
    wave = Wave(np.array([1.0, -2.0]), (0.5, 0.25))
    written = encoded(Waves(waves=(wave,), open=wave))
    assert list(written["waves"][0].items()) == [
        ("greatest_mm", 2.0),
        ("angle_deg", 90.0),
        ("parts", [0.5, 0.25]),
    ]
    schema = schema_of(Waves, {}, [])
    assert schema["properties"]["waves"] == {"type": "array", "items": {"$ref": "#/$defs/sine"}}
    assert schema["properties"]["open"] == {"type": "object"}
    assert schema["$defs"]["sine"]["required"] == ["greatest_mm", "angle_deg", "parts"]
    said = {**written["waves"][0], "greatest_mm": 2.5}
    again = decoded(Waves, {"waves": [said], "open": said}).waves[0]
    assert (again.greatest_mm, again.angle_rad, again.parts) == (2.5, math.pi / 2.0, (0.5, 0.25))
    assert encoded(again) == said
    with pytest.raises(ValueError, match=r"^\.greatest_mm is missing"):
        decoded(Wave, {"parts": [0.5], "angle_deg": 90.0})


@pytest.mark.parametrize("name", registry.REPORTS)
def test_every_report_is_read_as_it_was_written(name: str) -> None:
    record = registry.loaded(registry.REPORTS[name])
    if name == "generate":  # a design that contradicts itself is refused
        report = json.dumps(ab.generate("single", segments=24).report)
    else:
        report = json.dumps(example(record))
    again = encoded(decoded(record, json.loads(report)))
    assert report_differences(report, json.dumps(again)) == []


CHANGED = re.compile(
    r"\b(?:report|rows?)(?:\[[^\]\n]+\])*(?:\[[^\]\n]+\] *[|+]?=(?!=)|\.(?:update|setdefault|pop|clear)\()"
)
"""A key set, or taken from, what a verb answers with."""


def test_no_report_is_changed_after_it_was_made() -> None:
    assert all(map(CHANGED.search, ('report["a"] = 1', 'report["a"]["b"] += 1', "result.report.pop('a')")))
    assert not any(map(CHANGED.search, ('report["a"] == 1', 'x = report["a"]', 'f(report["a"], b=2)')))
    rooms = ("verbs", "balancing", "command", "engines", "running_gear", "report", "studies", "formulas")
    more = ("test_stands", "finite_elements", "profile_search", "machining", "drawn_cranks", "paper")
    for path in (
        path for room in (*rooms, *more) for path in (Path(ab.__file__).parent / room).rglob("*.py")
    ):
        changed = CHANGED.search(path.read_text(encoding="utf-8"))
        assert changed is None, f"{path}: {changed}"


def test_no_verb_reads_the_report_of_another() -> None:
    """A result reads its own, for what it prints; examples in docstrings show theirs."""
    package = Path(ab.__file__).parent
    verbs = [*(package / "verbs").glob("*.py"), *package.rglob("verb.py"), *package.glob("formulas/*.py")]
    assert len(verbs) > 40
    for path in verbs:
        for line in path.read_text(encoding="utf-8").splitlines():
            assert ">>>" in line or not re.search(r"(?<!self)\.report\[", line), f"{path}: {line}"


def test_a_unit_that_the_name_does_not_end_in_is_refused() -> None:
    @dataclasses.dataclass
    class Wrong:
        angle_deg: Degrees

    Wrong.__annotations__["angle_deg"] = Degrees
    with pytest.raises(TypeError, match="must end in _rad"):
        fields_of(Wrong)


# --- every report -------------------------------------------------------------------------------------------


def example(hint: Any, bounds: Mapping[str, Any] = types.MappingProxyType({})) -> Any:
    """Return a JSON value that a type allows, the fullest: no null, no key left out."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is NotRequired:
        return example(inner[0], bounds)
    if origin is Annotated:
        like = [each.record for each in inner[1:] if isinstance(each, Like)]
        own = {
            word: value
            for each in inner[1:]
            if isinstance(each, Range | Size | Pattern)
            for word, value in each.schema().items()
        }
        return example(like[0] if like else inner[0], {**bounds, **own})
    if origin in (Union, types.UnionType):
        return example(next(each for each in inner if each not in (type(None), Absent)), bounds)
    if origin is Literal:
        return inner[0]
    if origin is tuple and inner[-1] is not Ellipsis:
        return [example(each) for each in inner]
    if origin in (list, tuple, Sequence, np.ndarray):
        item = inner[0] if origin is not np.ndarray else float
        return [example(item)] * max(bounds.get("minItems", 1), 1)
    if origin in (dict, Mapping):
        return {"any": example(inner[1])}
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return dict(_pairs(hint))
    if hasattr(hint, "__required_keys__"):
        return {key: example(each) for key, each in get_type_hints(hint, include_extras=True).items()}
    if hint is str:
        return "a" * 64 if "pattern" in bounds else "text"
    simple = {float: bounds.get("minimum", 0.5) or 0.5, int: 1, bool: True, Any: 1.5, object: 1.5}
    return max(simple[hint], bounds.get("minimum", simple[hint])) if hint is int else simple[hint]


def _pairs(of: type) -> Iterator[tuple[str, Any]]:
    for each in fields_of(of):
        registered = [mark for mark in marks_of(each.hint) if isinstance(mark, Registered)]
        if registered:
            yield from ((key, example(hint)) for key, hint in registered[0].types().items())
        elif each.inline:
            yield from example(each.hint).items()
        else:
            yield each.key, example(each.hint)


def edits(value: Any, schema: Mapping[str, Any], whole: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield what a value may be edited to: another type, a key misspelt or missing, at every place."""
    if "$ref" in schema:
        schema = whole["$defs"][schema["$ref"].rsplit("/", 1)[1]]
    if not schema or "anyOf" in schema:
        branches = [each for each in schema.get("anyOf", ()) if each != {"type": "null"}]
        if len(branches) == 1:
            yield from edits(value, branches[0], whole)
        return
    yield "type", (["not", {"this": None}] if isinstance(value, str | int | float) else 1.25)
    if isinstance(value, dict) and "properties" in schema:
        for key, inner in value.items():
            without = {name: each for name, each in value.items() if name != key}
            if key in schema["required"]:
                yield f"{key} missing", without
                if not schema["additionalProperties"]:
                    yield f"{key} misspelt", {**value, key + "x": inner}
            for what, edited in edits(inner, schema["properties"].get(key, {}), whole):
                yield f"{key}.{what}", {**value, key: edited}
    if isinstance(value, list) and isinstance(schema.get("items"), dict):
        for what, edited in edits(value[0], schema["items"], whole):
            yield f"[0].{what}", [edited, *value[1:]]


@pytest.mark.parametrize("name", registry.REPORTS)
def test_whatever_is_edited_in_a_report_is_refused(name: str) -> None:
    report = example(registry.loaded(registry.REPORTS[name]))
    schema = ab.schema(name)
    validator = knowing_sound_parts(Draft202012Validator)(schema)  # an edit leaves most as it was
    assert [each.message for each in validator.iter_errors(report)] == []
    found = list(edits(report, schema, schema))
    assert len(found) > len(schema["properties"])
    assert [what for what, edited in found if validator.is_valid(edited)] == []
