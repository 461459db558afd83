"""Numbers typed with their unit: lengths, unbalances and weights become mm, g·mm and g."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from autobalance.declare import COUNTED
from autobalance.errors import JobError
from autobalance.materials import MATERIALS
from autobalance.toml_files.table import Faults, Table, did_you_mean, point_for_comma, shown, tell
from autobalance.units import G_MM_PER, G_PER
from autobalance.value_classes import dataclass

# Conversion of typed units: a job's lengths, unbalances and weights become mm, g·mm and g.
#
# Keys that end in ``_mm`` take ``"3/8 in"``, those in ``_g_mm`` ``"0.5 oz-in"``. A weight is a number of
# grams or a table with one unit of mass, of one piece or of several. ``density`` names a material.


WEIGHT_TABLES = ("rotating_g", "reciprocating_g", "crankpin_g")
FILL_IN = "FILL IN"
"""Placeholder in a job for values that the user must enter."""

LENGTHS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "inch": 25.4, '"': 25.4}
"""Millimetres in a unit as it is typed."""
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
LENGTH = re.compile(rf"\s*(?:({NUMBER})|(?:(\d+)\s+)?(\d+)\s*/\s*(\d+))\s*({'|'.join(LENGTHS)})\s*")
BETWEEN = re.compile(r"[·.\-*\s]")
UNBALANCE = re.compile(rf"\s*({NUMBER})\s*([A-Za-z·.\-*\s]+?)\s*")


def length_mm(text: str, where: str) -> float:
    """Return a length that is typed with its unit [mm].

    Raises
    ------
    JobError
        If there is no unit, or no known one.

    Examples
    --------
    >>> length_mm("3/8 in", "x_mm"), length_mm('1 1/2"', "x_mm"), length_mm("0.95 cm", "x_mm")
    (9.525, 38.1, 9.5)
    """
    match = LENGTH.fullmatch(text)
    if match is None or match[4] == "0":
        raise JobError(
            f'{where} is {shown(text)}; must be a number [mm] or a text with mm, cm, m, in or inch: "3/8 in"'
        )
    plain, whole, above, below, unit = match.groups()
    mm = LENGTHS[unit]
    if plain is not None:
        exact = Fraction(plain) * Fraction(str(mm))
        return float(exact)
    return float((Fraction(int(whole or 0)) + Fraction(int(above), int(below))) * Fraction(str(mm)))


def unbalance_unit(typed: str) -> str | None:
    """Return the name of a unit of unbalance from any of its spellings; None: it is unknown.

    Examples
    --------
    >>> unbalance_unit("oz-in"), unbalance_unit("gmm"), unbalance_unit("KG.MM"), unbalance_unit("lb")
    ('oz·in', 'g·mm', 'kg·mm', None)
    """
    bare = BETWEEN.sub("", typed).lower()
    return next((name for name in G_MM_PER if BETWEEN.sub("", name) == bare), None)


def unbalance_g_mm(text: str, where: str) -> float:
    """Return an unbalance that is typed with its unit [g·mm].

    Raises
    ------
    JobError
        If there is no unit, or no known one.

    Examples
    --------
    >>> round(unbalance_g_mm("0.5 oz-in", "x_g_mm"), 3), unbalance_g_mm("36 gmm", "x_g_mm")
    (360.039, 36.0)
    """
    match = UNBALANCE.fullmatch(text)
    unit = None if match is None else unbalance_unit(match[2])
    if match is None or unit is None:
        known = ", ".join(G_MM_PER)
        raise JobError(
            f'{where} is {shown(text)}; must be a number [g·mm] or a text with one of {known}: "0.5 oz-in"'
        )
    return float(match[1]) * G_MM_PER[unit]


def in_base_units(values: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Return the tables of a file with lengths in mm, unbalances in g·mm and weights in g.

    Raises
    ------
    JobError
        If a unit is missing or unknown.
    """
    faults = Faults()
    converted = gathered_in_base_units(values, faults, path)
    faults.refuse()
    return converted


def gathered_in_base_units(values: Mapping[str, Any], faults: Faults, path: str = "") -> dict[str, Any]:
    """Do the same; what is wrong is gathered, and stays as it was typed."""
    with faults.gathered():
        values = _with_density(values, path)
    converted = {}
    for key, value in values.items():
        converted[key] = value
        with faults.gathered():
            converted[key] = _converted(str(key), value, f"{path}.{key}" if path else key, faults)
    return converted


def _with_density(values: Mapping[str, Any], path: str) -> Mapping[str, Any]:
    """Return a table with the density of the material that it names."""
    name = values.get("density")
    if name is None:
        return values
    where = f"{path}.density" if path else "density"
    if "density_kg_m3" in values:
        raise JobError(f"{where} is given beside density_kg_m3; must be one or the other")
    if name == FILL_IN:
        return values
    if not isinstance(name, str) or name not in MATERIALS:
        close = did_you_mean(name, tuple(MATERIALS)) or f": {', '.join(MATERIALS)}"
        raise JobError(f"{where} is {shown(name)}; must be the name of a material{close}")
    rest = {key: value for key, value in values.items() if key != "density"}
    return {**rest, "density_kg_m3": MATERIALS[name].density_kg_m3}


def _converted(key: str, value: Any, where: str, faults: Faults) -> Any:
    if key in WEIGHT_TABLES and isinstance(value, Mapping):
        weights = dict.fromkeys(value, 1.0)  # stands for a refused one, whose keys are not refused again
        for name, weight in value.items():
            with faults.gathered():
                weights[name] = _weight(weight, f"{where}.{name}")
        return weights
    if isinstance(value, Mapping):
        return gathered_in_base_units(value, faults, where)
    if key == "g_mm" or key.endswith("_g_mm"):
        return _each(value, where, unbalance_g_mm, faults)
    if key.endswith("_mm") and not key.lower().endswith(("_kg_mm", "_n_mm")):
        return _each(value, where, length_mm, faults)
    if isinstance(value, list):
        return [
            gathered_in_base_units(item, faults, f"{where}[{place}]") if isinstance(item, Mapping) else item
            for place, item in enumerate(value, 1)
        ]
    return value


def _each(value: Any, where: str, convert: Callable[[str, str], float], faults: Faults) -> Any:
    if isinstance(value, str) and value != FILL_IN:
        pointed = point_for_comma(value)
        number = convert(pointed, where)
        if pointed != value:
            tell(where, value)
        return number
    if isinstance(value, list):
        places = enumerate(value, 1)
        return [_each(item, f"{where}[{place}]", convert, faults) for place, item in places]
    return gathered_in_base_units(value, faults, where) if isinstance(value, Mapping) else value


def _weight(value: Any, where: str) -> Any:
    """Return a weight with one unit of mass as grams; a number, and a solid, stay as they are."""
    if not isinstance(value, Mapping) or "file" in value:
        return value
    units = [unit for unit in value if unit in G_PER]
    if len(units) != 1:
        known = ", ".join(G_PER)
        if not units:
            raise JobError(f"{where}.g is missing; must have one of {known}, or file")
        raise JobError(f"{where} has {' and '.join(units)}; must have one of {known}, or file")
    unit, pieces = units[0], 1
    if "pieces" in value:
        pieces = Table(value, where, None).value("pieces", int, COUNTED)
    scale = G_PER[unit] * pieces
    return {
        ("g" if key == unit else key): _scaled(item, scale) if key in (unit, "pm") else item
        for key, item in value.items()
        if key != "pieces"
    }


def _scaled(value: Any, scale: float) -> Any:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * scale if number and scale != 1.0 else value


def refuse_unfilled(values: Mapping[str, Any]) -> None:
    """Refuse a job in which something is left to fill in.

    Raises
    ------
    JobError
        That names the first such key, and how many there are.
    """
    left = [path for path, value in leaves(values) if value == FILL_IN]
    if left:
        more = f" (and {len(left) - 1} more)" if len(left) > 1 else ""
        raise JobError(
            f'{left[0]} is "{FILL_IN}"{more}; {len(left)} left to fill in: enter them, only you know them'
        )


def leaves(values: Any, path: str = "") -> list[tuple[str, Any]]:
    """Return every value of nested tables and lists with its dotted path, lists counted from 1."""
    if isinstance(values, Mapping):
        items = [(f"{path}.{key}" if path else str(key), item) for key, item in values.items()]
    elif isinstance(values, list):
        items = [(f"{path}[{place}]", item) for place, item in enumerate(values, 1)]
    else:
        return [(path, values)]
    return [leaf for where, item in items for leaf in leaves(item, where)]


# Numbers typed with their unit.


@dataclass(frozen=True)
class TypedUnit:
    """A number typed as a text: its pattern, an example, and its conversion."""

    pattern: str
    example: str
    number: Callable[[str, str], float]

    def fits(self, text: str) -> bool:
        """Return whether a text is such a number."""
        return re.fullmatch(self.pattern, text) is not None


def _first_number(scale: float = 1.0) -> Callable[[str, str], float]:
    def number(text: str, _: str) -> float:
        match = re.search(NUMBER, text)
        assert match is not None  # by the pattern
        return float(match[0]) * scale

    return number


def _grams(text: str, _: str) -> float:
    match = re.fullmatch(rf"\s*({NUMBER})\s*({'|'.join(G_PER)})\s*", text)
    assert match is not None  # by the pattern
    return float(match[1]) * G_PER[match[2]]


def _rpm(text: str, _: str) -> float:
    number = re.search(NUMBER, text)
    assert number is not None  # by the pattern
    return float(number[0]) * (1000.0 if "krpm" in text else 1.0)


def _percent(text: str, _: str) -> float:
    return float(text.rstrip().removesuffix("%")) / 100.0


_LENGTH = rf"\s*({NUMBER}|(\d+\s+)?\d+\s*/\s*\d+)\s*({'|'.join(LENGTHS)})\s*"
_BETWEEN = r"[·.\-*\s]*"
_UNBALANCES = "|".join(
    _BETWEEN.join(f"[{each.lower()}{each.upper()}]" for each in name.replace("·", "")) for name in G_MM_PER
)
TYPED_UNITS = {
    "mm": TypedUnit(_LENGTH, "3/8 in", length_mm),
    "g·mm": TypedUnit(rf"\s*{NUMBER}\s*({_UNBALANCES})\s*", "0.5 oz-in", unbalance_g_mm),
    "g": TypedUnit(rf"\s*{NUMBER}\s*({'|'.join(G_PER)})\s*", "7.8 oz", _grams),
    "1/min": TypedUnit(rf"\s*{NUMBER}\s*(k?rpm|1/min|r/min)\s*", "9500 rpm", _rpm),
    "share": TypedUnit(rf"\s*{NUMBER}\s*%\s*", "50 %", _percent),
    "mm/s": TypedUnit(rf"\s*G\s*{NUMBER}\s*", "G 6.3", _first_number()),
}
"""Units of numbers that may be typed with them."""
