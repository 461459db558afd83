"""The JSON Schemas in the package are those of the typed records, and may be written anew from them."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired, TypedDict

import pytest

import autobalance.report.records
from autobalance.records import Bound
from autobalance.report.records.schema import open_keys, schema_of
from autobalance.report.records.written import written_schema


class Inner(TypedDict):
    """A record in a record."""

    kind: Literal["a", "b"]


@open_keys
class Outer(TypedDict):
    """One of everything."""

    size_mm: Annotated[float, "how long", Bound("minimum", 0)]
    inner: NotRequired[Inner | None]
    counts: list[int] | None
    free: dict[str, Any]


@pytest.mark.parametrize("name", ["report", "generate"])
def test_the_files_are_what_the_records_say(name: Literal["report", "generate"]) -> None:
    path = Path(autobalance.report.records.__file__).with_name(f"{name}.schema.json")
    assert json.loads(path.read_text(encoding="utf-8")) == written_schema(name)


def test_a_record_becomes_a_schema() -> None:
    assert schema_of(Outer, {"title": "t"}, []) == {
        "title": "t",
        "type": "object",
        "properties": {
            "size_mm": {"type": "number", "minimum": 0, "description": "how long"},
            "inner": {"anyOf": [{"$ref": "#/$defs/inner"}, {"type": "null"}]},
            "counts": {"type": ["array", "null"], "items": {"type": "integer"}},
            "free": {"type": "object"},
        },
        "required": ["size_mm", "counts", "free"],
        "additionalProperties": True,
        "$defs": {
            "inner": {
                "type": "object",
                "properties": {"kind": {"enum": ["a", "b"]}},
                "required": ["kind"],
                "additionalProperties": False,
            }
        },
    }
