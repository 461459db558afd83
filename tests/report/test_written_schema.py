"""JSON Schemas are made from typed records."""

from typing import Annotated, Any, Literal, NotRequired, TypedDict

from autobalance.declare import Range
from autobalance.declare.schema import open_keys, schema_of


class Inner(TypedDict):
    """A record in a record."""

    kind: Literal["a", "b"]


@open_keys
class Outer(TypedDict):
    """One of everything."""

    size_mm: Annotated[float, "how long", Range(least=0)]
    inner: NotRequired[Inner | None]
    counts: list[int] | None
    free: dict[str, Any]


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
