"""Strict reader of a report's JSON, and its check against the schema."""

from __future__ import annotations

import json
import reprlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from jsonschema import Draft202012Validator, ValidationError, validators

from autobalance.errors import FileError, FormatError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.solid.formats.table import endings

# Strict reader of a report's JSON: known version, no key twice, no number out of bounds.


MAX_NUMBER = 1e30
"""Largest size of a number: no report holds a larger one, and products stay finite."""
VERSIONS = (1,)
"""Readable versions of reports."""

Number = TypeVar("Number", int, float)


def read_report(path: Path) -> Mapping[str, Any]:
    """Return the values of a report's JSON.

    Raises
    ------
    FileError
        If it cannot be read.
    FormatError
        If it is not a JSON object, has a key twice or a number that cannot be, or is of an unknown version.
    """
    if path.is_dir():
        inside = path / "report.json"
        raise FileError(f"{path} is a folder; expected a report" + f", such as {inside}" * inside.is_file())
    if path.suffix.lower() in endings() and path.is_file():
        raise FormatError(f"{path} is a solid, not a report; expected the report.json beside it")
    with file_errors(f"read the report {path}"):
        refuse_pipe(path)
        note_read(path)
        data = path.read_bytes()
    try:
        values = json.loads(
            data,
            parse_float=lambda text: _limited(float(text)),
            parse_int=lambda text: _limited(int(text)),
            parse_constant=_not_a_number,
            object_pairs_hook=_each_once,
        )
    except UnicodeDecodeError:
        raise FormatError(f"{path} is not JSON, not even text; expected the report.json of a run") from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path} is not JSON: {str(error).splitlines()[0]}") from None
    if not isinstance(values, dict):
        raise FormatError(f"{path} is not a report: its JSON is not an object")
    if "command" in values:
        refuse_version(path.name, values)
    return values


def refuse_version(name: str, values: Mapping[str, Any]) -> None:
    """Refuse a report of an unknown version: its keys may mean something else.

    Raises
    ------
    FormatError
        If it is of such a version, or of none.
    """
    version = values.get("schema_version")
    if isinstance(version, bool) or version not in VERSIONS:
        known = ", ".join(map(str, VERSIONS))
        raise FormatError(f"{name}: schema_version is {version!r}; expected one that is known here: {known}")


def _limited(number: Number) -> Number:
    if abs(number) > MAX_NUMBER:
        raise ValueError(f"it holds a number beyond {MAX_NUMBER:g}")
    return number


def _not_a_number(word: str) -> float:
    raise ValueError(f"it holds the number {word}")


def _each_once(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    entries: dict[str, Any] = {}
    for key, value in pairs:
        if key in entries:
            raise ValueError(f"it has the key {key!r} twice in one object")
        entries[key] = value
    return entries


# Check of a report against its JSON Schema: presence, type and bounds of every key.
#
# Rules among values (``allOf``) are checked with the values. Keys that a schema does not name are not a
# fault here: they are listed as not checked.


EXPECTED: Mapping[str, str] = {
    "minimum": "at least {}",
    "maximum": "at most {}",
    "exclusiveMinimum": "more than {}",
    "exclusiveMaximum": "less than {}",
    "minItems": "{} entries at least",
    "maxItems": "{} entries at most",
    "minLength": "{} letters at least",
    "pattern": "text like {}",
    "enum": "one of {}",
}
NULL = {"type": "null"}


def _named_keys(
    validator: Any, others: Any, instance: Any, schema: Mapping[str, Any]
) -> Iterator[ValidationError]:
    """Check unnamed keys against ``additionalProperties`` where that is a schema; else pass them."""
    if isinstance(others, Mapping):
        yield from Draft202012Validator.VALIDATORS["additionalProperties"](
            validator, others, instance, schema
        )


def _is_whole(_checker: Any, value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _left_to_the_values(*_: Any) -> Iterator[ValidationError]:
    return iter(())


VALIDATOR = validators.extend(
    Draft202012Validator,
    {"additionalProperties": _named_keys, "allOf": _left_to_the_values},
    type_checker=Draft202012Validator.TYPE_CHECKER.redefine("integer", _is_whole),
)


def refuse_by_schema(name: str, values: Mapping[str, Any], schema: Mapping[str, Any]) -> None:
    """Refuse a report that does not conform to its schema.

    Parameters
    ----------
    name : str
        Of the report, for the message.
    values : mapping
        Its JSON.
    schema : mapping
        JSON Schema.

    Raises
    ------
    FormatError
        At the first fault.
    """
    fault = next(VALIDATOR(schema).iter_errors(values), None)
    if fault is None:
        return
    fault = _innermost(fault)
    place = "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in fault.absolute_path)
    if fault.validator == "required":
        missing = next(key for key in fault.validator_value if key not in fault.instance)
        place = f"{place}.{missing}".removeprefix(".")
        raise FormatError(f"{name}: {place} is missing; is this a report of autobalance balance?")
    raise FormatError(f"{name}: {place.removeprefix('.')} is {_found_and_expected(fault)}")


def _innermost(fault: ValidationError) -> ValidationError:
    """Return the fault within the likeliest branch of a choice: the first that is not for null."""
    while fault.context:
        branches = fault.validator_value
        meant = next((number for number, each in enumerate(branches) if each != NULL), 0)
        fault = next(each for each in fault.context if each.schema_path[0] == meant)
    return fault


def _found_and_expected(fault: ValidationError) -> str:
    rule, value = fault.validator_value, reprlib.repr(fault.instance)
    if fault.validator == "type":
        types = [rule] if isinstance(rule, str) else rule
        return f"of the wrong type: {value}; expected {' or '.join(types)}"
    listed = ", ".join(map(str, rule)) if isinstance(rule, list) else str(rule)
    return f"{value}; expected {EXPECTED.get(str(fault.validator), '{}').format(listed)}"
