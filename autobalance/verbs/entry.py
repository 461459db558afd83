"""Values of a report, read by attribute or by key, and its lists as tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from autobalance.errors import FormatError, UsageError

if TYPE_CHECKING:
    from autobalance.types import Array


class Entry(Mapping[str, Any]):
    """A table of a report whose keys are attributes too.

    Examples
    --------
    >>> residual = Entry({"magnitude_g_mm": 0.25, "planes": [{"name": "A"}]})
    >>> residual.magnitude_g_mm, residual["magnitude_g_mm"], residual.planes[0].name
    (0.25, 0.25, 'A')
    """

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._values = dict(values)

    def __getitem__(self, key: str) -> Any:
        return _viewed(self._values[key])

    def __getattr__(self, key: str) -> Any:
        if key.startswith("_") or key not in self._values:  # before ``_values`` exists, too
            raise AttributeError(key)
        return _viewed(self._values[key])

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._values]

    def __repr__(self) -> str:
        return f"Entry({self._values!r})"

    def __reduce__(self) -> tuple[type[Entry], tuple[dict[str, Any]]]:
        """Pickle the values."""
        return Entry, (self._values,)


def _viewed(value: Any) -> Any:
    if isinstance(value, Mapping):
        return Entry(value)
    if not isinstance(value, list):
        return value
    if value and is_tables(value):
        return Entries(value)
    return tuple(_viewed(item) for item in value)


def is_tables(value: Any) -> bool:
    """Return whether a value of a report is a list of tables, which may be empty."""
    return isinstance(value, list) and all(isinstance(each, Mapping) for each in value)


class Entries(tuple[Entry, ...]):
    """A list of a report's tables: a tuple that is a table in a notebook, columns of numbers, a data frame.

    Examples
    --------
    >>> cuts = Entries([{"web": 1, "depth_mm": 2.5}, {"web": 2, "depth_mm": 1.5}])
    >>> cuts[1].web, cuts.column("depth_mm")
    (2, array([2.5, 1.5]))
    """

    __slots__ = ()

    def __new__(cls, values: Iterable[Mapping[str, Any]] = ()) -> Self:
        """Take the tables."""
        return super().__new__(cls, (each if isinstance(each, Entry) else Entry(each) for each in values))

    def __getnewargs__(self) -> tuple[tuple[Entry, ...]]:
        """Pickle the tables."""
        return (tuple(self),)

    def column(self, key: str) -> Array:
        """Return the values of a key, one for each table, NaN for a missing one: an array (n, ...).

        Raises
        ------
        UsageError
            If no table has the key, or a value is not a number.
        """
        if not any(key in each for each in self):
            known = (
                ", ".join(dict.fromkeys(name for each in self for name in each)) or "none, the list is empty"
            )
            raise UsageError(f"there is no {key!r} in this list; its keys: {known}")
        values = [each.get(key) for each in self]
        try:
            return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
        except (TypeError, ValueError):
            raise UsageError(f"{key} is not a number everywhere; expected a key of numbers") from None

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame, a row for each table.

        Raises
        ------
        FormatError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise FormatError("a data frame needs pandas: pip install pandas") from None
        return pandas.DataFrame([dict(each) for each in self])

    def _repr_html_(self) -> str:
        from autobalance.report.notebook import box, records

        return box(records(self))


def entries(values: list[dict[str, Any]]) -> Entries:
    """Return the rows of a table of a report."""
    return Entries(values)
