"""``calc``: any formula of ``autobalance.theory`` by its name."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, get_type_hints

import numpy as np

from autobalance import theory
from autobalance.errors import UsageError
from autobalance.value_classes import dataclass
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.report.records.answers import CalcReport


# Calls of any function of ``theory`` by its name, with values typed as text.


def names() -> tuple[str, ...]:
    return tuple(theory.__all__)


def function_named(name: str) -> Callable[..., Any]:
    """Return a function by its name.

    Raises
    ------
    UsageError If there is no such formula.
    """
    if name not in theory.__all__:
        from difflib import get_close_matches

        close = get_close_matches(name, theory.__all__, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        raise UsageError(f"calc has no formula {name!r}{hint} (`autobalance calc --list` lists all)")
    function: Callable[..., Any] = getattr(theory, name)
    return function


def summary_of(name: str) -> str:
    """Return the first line of a function's documentation."""
    return (inspect.getdoc(function_named(name)) or "").splitlines()[0]


def usage_of(name: str) -> str:
    """Return a function's keys and its documentation: formula, source, misprint."""
    function = function_named(name)
    keys = []
    for key, parameter in inspect.signature(function).parameters.items():
        optional = parameter.default is not inspect.Parameter.empty
        keys.append(f"[{key}={parameter.default}]" if optional else f"{key}=...")
    return f"autobalance calc {name} {' '.join(keys)}\n\n{inspect.getdoc(function)}"


def call(name: str, texts: Mapping[str, str]) -> Any:
    """Return the result of a function for values typed as text.

    Raises
    ------
    UsageError
        If a key is unknown or missing, or a value is of another type or impossible.
    """
    function = function_named(name)
    hints = get_type_hints(function)
    parameters = inspect.signature(function).parameters
    for key in texts:
        if key not in parameters:
            raise UsageError(f"{name} has no {key!r}; its keys are {', '.join(parameters)}")
    missing = [
        key
        for key, each in parameters.items()
        if key not in texts and each.default is inspect.Parameter.empty
    ]
    if missing:
        raise UsageError(f"{name}: {', '.join(missing)} missing; its keys are {', '.join(parameters)}")
    values = {key: _value(f"{name}: {key}", text, hints[key]) for key, text in texts.items()}
    try:
        with np.errstate(all="ignore"):
            result = function(**values)
    except (ValueError, ZeroDivisionError, OverflowError) as error:
        raise UsageError(f"{name}: {error}") from None
    if _has_infinity(plain(result)):
        raise UsageError(f"{name}: the result is infinite; expected values that it is finite for")
    return result


def _has_infinity(value: Any) -> bool:
    if isinstance(value, Mapping | list):
        return any(map(_has_infinity, value.values() if isinstance(value, Mapping) else value))
    return isinstance(value, float) and math.isinf(value)


def _value(where: str, text: str, hint: Any) -> Any:
    """Return a text as a value of a parameter's type."""
    hint_text = str(hint)
    if "Sequence[float]" in hint_text:
        return [_number(where, word) for word in text.strip("[] ").split(",") if word.strip()]
    if hint is str:
        return text
    if hint is int:
        try:
            return int(text)
        except ValueError:
            raise UsageError(f"{where} is {text!r}; must be a whole number") from None
    return _number(where, text)


def _number(where: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        raise UsageError(f"{where} is {text.strip()!r}; must be a number") from None
    if not abs(number) < float("inf"):  # also refuses NaN
        raise UsageError(f"{where} is {text.strip()}; must be a finite number")
    return number


def plain(result: Any) -> Any:
    """Return a result as values for JSON: a record becomes its fields."""
    if is_dataclass(result) and not isinstance(result, type):
        return {item.name: plain(getattr(result, item.name)) for item in fields(result)}
    if isinstance(result, Sequence) and not isinstance(result, str):
        return [plain(item) for item in result]
    return None if isinstance(result, float) and math.isnan(result) else result


@dataclass(frozen=True, eq=False, repr=False)
class CalcResult(VerbResult):
    """Result of a formula."""

    content: CalcReport

    def text(self, units: str = "metric") -> str:
        """Return the result's fields, one a line; units end the names."""
        result = self.content.result
        if isinstance(result, list):
            return _table(result) if all(isinstance(each, Mapping) for each in result) else _shown(result)
        if isinstance(result, Mapping):
            width = max(len(key) for key in result)
            return "\n".join(f"{key:<{width}}  {_shown(value)}" for key, value in result.items())
        return _shown(result)


def calc(name: str, values: Mapping[str, str]) -> CalcResult:
    """Return the result of a function of ``autobalance.theory`` for values typed as text.

    Parameters
    ----------
    name : str
        Name of the formula.
    values : mapping of str
        Its values by their keys, each as text.

    Raises
    ------
    UsageError
        If the name or a key is unknown, or a value is impossible.

    Examples
    --------
    >>> calc("swept_volume_cm3", {"bore_mm": "76.8", "stroke_mm": "53.8"}).text()
    '249.227'
    """
    from autobalance.report.records.answers import CalcReport

    result = plain(call(name, values))
    return CalcResult(CalcReport(name=name, input=values, result=result))


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return ", ".join(_shown(item) for item in value) if isinstance(value, list) else str(value)


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows of the same keys as columns, these in a line above them."""
    if not rows:
        return ""
    cells = [list(rows[0]), *([_shown(value) for value in row.values()] for row in rows)]
    wide = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join("  ".join(map(str.ljust, line, wide)).rstrip() for line in cells)
