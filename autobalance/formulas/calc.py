"""``calc``: any formula of ``autobalance.theory`` by its name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from autobalance.theory.calling import call, plain
from autobalance.value_classes import dataclass
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.report.records.answers import CalcReport


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
