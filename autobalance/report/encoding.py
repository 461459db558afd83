"""The one way from a result to JSON values: records, arrays and tables become what ``json`` writes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from autobalance.records import ABSENT, fields_of

Values = dict[str, Any]


def encoded(result: Any) -> Any:
    """Return a record, or any part of one, as JSON values.

    Parameters
    ----------
    result : record, mapping, sequence, array, number, text or None
        Records become tables, their fields in order, each in the unit that its annotation says.

    Examples
    --------
    >>> import numpy as np
    >>> from autobalance.engine.grade import Grade
    >>> encoded({"grades": (Grade(6.3, "general machinery"),), "unbalance_g_mm": np.array([0.0, 2.0])})
    {'grades': [{'grade_mm_s': 6.3, 'what': 'general machinery'}], 'unbalance_g_mm': [0.0, 2.0]}
    """
    if hasattr(result, "tolist"):  # an array, or one number of numpy's
        return result.tolist()
    if result is None or isinstance(result, str | int | float):
        return result
    if dataclasses.is_dataclass(result):
        return _table(result)
    if isinstance(result, Mapping):
        return {key: encoded(value) for key, value in result.items()}
    if isinstance(result, list | tuple):
        return [encoded(each) for each in result]
    raise TypeError(f"{type(result).__name__} has no place in a report")


def _table(result: Any) -> Values:
    table: Values = {}
    of: type = type(result)
    for each in fields_of(of):
        value = getattr(result, each.name)
        if value is ABSENT:
            continue
        if each.inline:
            table |= {} if value is None else encoded(value)
        else:
            table[each.key] = encoded(value if each.convert is None else _converted(value, each.convert))
    return table


def _converted(value: Any, convert: Callable[[float], float]) -> Any:
    """Return a number, or each number of a sequence or an array, in its other unit."""
    if value is None:
        return None
    if isinstance(value, list | tuple) or getattr(value, "ndim", None):
        return [_converted(each, convert) for each in value]
    return convert(float(value))
