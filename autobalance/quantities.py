"""Texts with quantities in them, rendered last, in the units that a reader works in.

A `Text` is a string, and reads as metric text wherever a string does. It keeps its quantities, and is never
searched for numbers. Joined with ``+``, ``said`` or ``joined`` it stays one. In an f-string it becomes a
plain string, which is shown unchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, SupportsIndex

Unit = Literal["mm", "g", "g·mm", "g·m"]
UNITS: tuple[Unit, ...] = ("mm", "g", "g·mm", "g·m")


class Quantity(NamedTuple):
    """Numbers of one unit, as ``"{} to {}"`` puts them; each is written by ``form``, as ``.1f``.

    Thousands that ``form`` asks for are set apart by thin spaces.
    """

    pattern: str
    values: tuple[float, ...]
    unit: Unit
    form: str

    @property
    def metric(self) -> str:
        """Return the quantity as metric text."""
        numbers = (_number(each, self.form) for each in self.values)
        return f"{self.pattern.format(*numbers)} {self.unit}"


def _number(value: float, form: str) -> str:
    """Return a number; where the form sets thousands apart, as `wording.number` writes it."""
    if "," not in form:
        return format(value, form)
    text = format(value, form).replace(",", "\u202f")
    return text.replace("-", "−") if any(each in "123456789" for each in text) else text.removeprefix("-")


Part = str | Quantity


class Text(str):
    """A string with its quantities; ``parts`` are plain strings and quantities, in order."""

    __slots__ = ("parts",)
    parts: tuple[Part, ...]

    def __new__(cls, parts: Iterable[Part]) -> Text:
        given = tuple(parts)
        self = super().__new__(cls, "".join(each if isinstance(each, str) else each.metric for each in given))
        self.parts = given
        return self

    def __add__(self, other: str) -> Text:
        return Text((*self.parts, *parts_of(other)))

    def __radd__(self, other: str) -> Text:
        return Text((*parts_of(other), *self.parts))

    def __reduce_ex__(self, protocol: SupportsIndex) -> tuple[type[Text], tuple[tuple[Part, ...]]]:
        del protocol
        return Text, (self.parts,)


def parts_of(text: str) -> tuple[Part, ...]:
    """Return the parts of a text; a plain string is one part."""
    return text.parts if isinstance(text, Text) else (text,)


def said(template: str, *values: object) -> Text:
    """Return a text with quantities, texts or plain values in the place of each ``{}``.

    Examples
    --------
    >>> said("add {} at z {}, from throw {}", g_mm(720.08, ".1f"), mm(25.4, ".1f"), 1)
    'add 720.1 g·mm at z 25.4 mm, from throw 1'
    """
    between = template.split("{}")
    if len(between) != len(values) + 1:
        raise ValueError(f"{template!r} has {len(between) - 1} places for {len(values)} values")
    parts: list[Part] = [between[0]]
    for value, after in zip(values, between[1:], strict=True):
        if isinstance(value, Quantity):
            parts.append(value)
        else:
            parts += parts_of(value if isinstance(value, str) else str(value))
        parts.append(after)
    return Text(each for each in parts if each)


def joined(separator: str, texts: Iterable[str]) -> Text:
    """Return texts with a separator between them."""
    parts: list[Part] = []
    for text in texts:
        parts += ([separator] if parts else []) + list(parts_of(text))
    return Text(parts)


def mm(value: float, form: str) -> Quantity:
    return Quantity("{}", (value,), "mm", form)


def bare_mm(value: float) -> Quantity:
    """Return a size with three decimals at most, without zeros at its end."""
    return mm(round(float(value), 3), ".10g")


def g(value: float, form: str) -> Quantity:
    return Quantity("{}", (value,), "g", form)


def g_mm(value: float, form: str) -> Quantity:
    return Quantity("{}", (value,), "g·mm", form)


def span(values: Sequence[float], unit: Unit, form: str) -> Quantity:
    """Return the smallest and the largest of some values; one number if both read the same."""
    low, high = min(values), max(values)
    if format(low, form) == format(high, form):
        return Quantity("{}", (low,), unit, form)
    return Quantity("{} to {}", (low, high), unit, form)


def rendered(text: str, show: Callable[[Quantity], str]) -> str:
    """Return a text with each quantity as ``show`` writes it."""
    return "".join(each if isinstance(each, str) else show(each) for each in parts_of(text))


# --- as a report keeps them -------------------------------------------------------------------------------


def listed(text: str) -> list[Any]:
    """Return a text's parts as JSON values."""
    return [each if isinstance(each, str) else each._asdict() for each in parts_of(text)]


def with_parts(text: Any, parts: Any) -> Any:
    """Return a text of a report with its listed parts, where these are that text."""
    found = None if not isinstance(text, str) or parts is None else from_listed(parts)
    return found if found == text else text


def from_listed(parts: Any) -> Text | None:
    """Return the text of parts as a report lists them; None without parts."""
    try:
        return Text(each if isinstance(each, str) else _quantity(each) for each in parts)
    except (TypeError, ValueError, KeyError, IndexError, AttributeError):
        return None


def _quantity(values: Mapping[str, Any]) -> Quantity:
    if values["unit"] not in UNITS:
        raise ValueError(values["unit"])
    made = Quantity(
        str(values["pattern"]), tuple(map(float, values["values"])), values["unit"], values["form"]
    )
    if not made.metric:
        raise ValueError(made)
    return made
