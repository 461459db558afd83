"""JSON Schemas are made from typed records."""

from typing import Annotated, Any, Literal

from autobalance.declare import ABSENT, OMITTED, Absent, Range, record
from autobalance.declare.schema import open_keys, schema_of


@record
class Inner:
    """A record in a record."""

    kind: Literal["a", "b"]


@open_keys
@record
class Outer:
    """One of everything."""

    size_mm: Annotated[float, "how long", Range(least=0)]
    inner: Inner | Absent | None = ABSENT
    other: Annotated[Inner, OMITTED] = Inner(kind="a")
    counts: list[int] | None
    free: dict[str, Any]


def test_a_record_becomes_a_schema() -> None:
    assert schema_of(Outer, {"title": "t"}, []) == {
        "title": "t",
        "type": "object",
        "properties": {
            "size_mm": {"type": "number", "minimum": 0, "description": "how long"},
            "inner": {"anyOf": [{"$ref": "#/$defs/inner"}, {"type": "null"}]},
            "other": {"$ref": "#/$defs/inner"},
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
