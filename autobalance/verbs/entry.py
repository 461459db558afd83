"""Values of a report, read by attribute or by key, and the bodies of its tools."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError, UsageError
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.solid.csg.solid import Solid
    from autobalance.types import Array


# Values of a report, read by attribute or by key, and its lists as tables.


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


# The bodies of a result's tools, for CAD programs: as triangles, and as exact shapes.


@dataclass(frozen=True, eq=False)
class CutTool:
    """The body that a correction subtracts from the crank, or adds to it; file coordinates [mm].

    Attributes
    ----------
    correction : int
        Its place in the report's ``corrections``, from 0.
    kind : str
        As in the report.
    label : str
        ``cut 3: drill ⌀12``.
    adds_metal : bool
    vertices_mm : (n, 3) float
    triangles : (m, 3) int
        Counter-clockwise seen from outside.
    volume_mm3 : float
        Of the body of these triangles, which begins outside of the metal; not of what it takes. The report's
        ``tool_volume_mm3`` is that of the body of ``to_shape()``: with true surfaces, and no wider than a
        lowered face.
    """

    correction: int
    kind: str
    label: str
    adds_metal: bool
    vertices_mm: NDArray[np.float64]
    triangles: NDArray[np.int64]
    volume_mm3: float
    entry: Mapping[str, Any]
    rotor_to_file: NDArray[np.float64]

    def to_shape(self) -> Any:
        """Return the body as a ``TopoDS_Shape`` of OCP with true surfaces, in mm.

        Raises
        ------
        FormatError
            If the CAD kernel is not installed, or the kind does not say its exact body.
        """
        from autobalance.correction import KINDS
        from autobalance.solid.cad.build import nothing, shape_of

        if self.entry["depth_mm"] == 0.0:  # a kept cut that is not needed
            return nothing()
        drawn = KINDS[self.kind].drawn(self.entry)
        if drawn is None:
            raise FormatError(f"{self.label}: the kind {self.kind!r} does not say its exact body")
        return shape_of(drawn, self.rotor_to_file)


def tools_of(
    corrections: Sequence[Mapping[str, Any]], bodies: Sequence[Solid], rotor_to_file: NDArray[np.float64]
) -> tuple[CutTool, ...]:
    """Return the tools of a report's ``corrections``, one a correction, in their order.

    ``bodies`` are in file coordinates [mm], to which ``rotor_to_file`` (4, 4) leads.
    """
    from autobalance.correction import KINDS

    return tuple(
        CutTool(
            number,
            str(entry["kind"]),
            str(entry["label"]),
            KINDS[entry["kind"]].adds_metal,
            body.mesh.vertices.copy(),  # the kept ones cannot be written, which manifold3d refuses
            body.mesh.triangles.copy(),
            float(body.volume_mm3),
            entry,
            rotor_to_file,
        )
        for number, (entry, body) in enumerate(zip(corrections, bodies, strict=True))
    )
