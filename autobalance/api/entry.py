"""Values of a report, read by attribute or by key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


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
        """Take the values of a table."""
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
    return tuple(_viewed(item) for item in value) if isinstance(value, list) else value


def entries(values: list[dict[str, Any]]) -> tuple[Entry, ...]:
    """Return the rows of a table of a report."""
    return tuple(Entry(value) for value in values)
