"""Check of a report against its JSON Schema: presence, type and bounds of every key.

Rules among values (``allOf``) are checked with the values. Keys that a schema does not name are not a fault
here: they are listed as not checked.
"""

from __future__ import annotations

import reprlib
from collections.abc import Iterator, Mapping
from typing import Any

from jsonschema import Draft202012Validator, ValidationError, validators

from autobalance.errors import FormatError

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
