"""The values of a report by dotted path, checked one by one, and those left unchecked."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import field
from typing import Any, TypeVar

import numpy as np

from autobalance.declare import decoded
from autobalance.errors import ClaimError, FormatError
from autobalance.types import Array
from autobalance.value_classes import dataclass

# The values of a report by dotted path, checked one by one, and a ledger of what was checked.


T = TypeVar("T")

ROUNDING = 1e-9
"""Share by which a number may differ from its claim: sums in another order, no more."""

CORRECTED_SOLID = "the corrected solid, read from its file again"
INPUT_SOLID = "the solid that was corrected, read and recognised again"
BOTH_SOLIDS = "both solids: the metal removed from one to the other"
JOB = "values that follow from the job and the crank"
UNCERTAINTY_BUDGET = "the causes of uncertainty, summed again"
RECORD = "a new record made from the job and the files"
FILES = "the files beside the report"


@dataclass(frozen=True)
class Claim:
    """A value of a report that holds.

    ``name`` is its place (``tolerance.planes[1].permissible_g_mm``), ``value`` the claimed value,
    ``measured`` the one compared with it, in the same unit, ``how`` its source and how near both are.
    """

    name: str
    value: Any
    measured: Any
    how: str


@dataclass
class Ledger:
    """Proven claims and their places; ``source`` is that of the values compared with at present.

    ``why_not`` has the places that could not be checked; of files in ``unread`` only the hash was checked.
    """

    source: str = "the report itself"
    claims: list[Claim] = field(default_factory=list)
    places: set[str] = field(default_factory=set)
    warnings: list[str] = field(default_factory=list)
    why_not: dict[str, str] = field(default_factory=dict)
    unread: dict[str, str] = field(default_factory=dict)

    def knows(self, place: str) -> bool:
        """Return whether a value was checked, by itself or within a larger one."""
        if place in self.places:
            return True
        ends = (end for end, letter in enumerate(place) if letter in ".[")
        return any(place[:end] in self.places for end in ends)


@dataclass
class Claims:
    """A report's values, or those at a place in it (``tolerance.planes[1]``); lists count from 1.

    Raises
    ------
    FormatError
        Where a value is missing or of another type.
    ClaimError
        Where one is not what was measured.
    """

    name: str
    values: Mapping[str, Any]
    place: str = ""
    ledger: Ledger = field(default_factory=Ledger)

    @property
    def warnings(self) -> list[str]:
        return self.ledger.warnings

    def path(self, key: str) -> str:
        """Return a key's place in the whole report."""
        return f"{self.place}.{key}" if self.place else key

    def at(self, key: str, values: Mapping[str, Any]) -> Claims:
        """Return the claims in an object at a key."""
        return Claims(self.name, values, self.path(key), self.ledger)

    def get(self, path: str, kind: type[Any]) -> Any:
        """Return the value at a dotted path."""
        value: Any = self.values
        for key in path.split("."):
            if not isinstance(value, Mapping) or key not in value:
                raise FormatError(
                    f"{self.name}: {self.path(path)} is missing; is this a report of autobalance balance?"
                )
            value = value[key]
        if kind in (int, float):
            fits = _is_number(value) and isinstance(value, int if kind is int else int | float)
        else:
            fits = isinstance(value, kind)
        if not fits:
            raise FormatError(
                f"{self.name}: {self.path(path)} is of the wrong type; expected {kind.__name__}"
            )
        return value

    def array(self, path: str, shape: tuple[int, ...]) -> Array:
        """Return an array of numbers at a dotted path."""
        return self._as_array(path, self.get(path, list), shape)

    def _as_array(self, path: str, value: Any, shape: tuple[int, ...]) -> Array:
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.zeros(0)
        if array.shape != shape or not _holds_numbers(
            value
        ):  # numpy reads "1.5", true and null as numbers too
            expected = " x ".join(map(str, shape)) + " numbers" if shape else "a number"
            raise FormatError(f"{self.name}: {self.path(path)} is not {expected}")
        return array

    def record(self, of: type[T], path: str | None = None) -> T:
        """Return the record at a place, or that whose keys are among these."""
        try:
            return decoded(of, self.values if path is None else self.get(path, dict))
        except ValueError as error:
            place = self.path(f"{path or ''}{error}".lstrip("."))
            raise FormatError(f"{self.name}: {place}") from None

    def entries(self, path: str, count: int | None = None) -> list[Claims]:
        """Return the entries of a list of objects, each to be checked by itself.

        ``count`` is how many of them there should be, where that is known.
        """
        values = self.get(path, list)
        if count is not None and len(values) != count:
            raise ClaimError(
                f"{self.name}: {self.path(path)} has {len(values)} entries, but {count} were found"
            )
        for number, each in enumerate(values, 1):
            if not isinstance(each, dict):
                raise FormatError(f"{self.name}: {self.path(path)}[{number}] is not an object")
        return [self.at(f"{path}[{number}]", each) for number, each in enumerate(values, 1)]

    # --- checks -----------------------------------------------------------------------------------------

    def against(self, source: str) -> None:
        """Set the source that the checks that follow compare with."""
        self.ledger.source = source

    def hold(self, path: str, measured: Any = None, within: float | None = None) -> None:
        """Note a value that holds; ``within`` is its distance from the measured one at most, None: equal."""
        value = self.get(path, object)
        self.note(self.path(path), value, value if measured is None else measured, within)
        self.ledger.places.add(self.path(path))

    def note(self, name: str, value: Any, measured: Any, within: float | None = None) -> None:
        """Note a claim that holds and is not a single value of the report, such as a sum."""
        how = self.ledger.source if within is None else f"{self.ledger.source}, within {within:.2g}"
        self.ledger.claims.append(Claim(name, value, measured, how))

    def same(self, path: str, measured: object) -> None:
        """Check a value for equality: a text, a count, a list or None."""
        claimed = self.get(path, object)
        if claimed != measured or isinstance(claimed, bool) != isinstance(measured, bool):
            raise ClaimError(f"{self.name}: {self.path(path)} is {claimed!r}, but {measured!r} was found")
        self.hold(path, measured)

    def near(self, path: str, measured: Any, scale: float, rounding: float = ROUNDING) -> None:
        """Check a number or an array of them against a measurement, up to rounding of ``scale``."""
        value = self.get(path, object)
        if type(value) is float and type(measured) is float and abs(value - measured) <= rounding * scale:
            self.hold(
                path, measured, rounding * scale
            )  # most values by far; the rest is for lists and faults
            return
        measurement = np.asarray(measured, dtype=np.float64)
        if value is None:
            raise ClaimError(f"{self.name}: {self.path(path)} is null, but {_text(measurement)} was found")
        claimed = self._as_array(path, value, measurement.shape)
        if not np.all(np.abs(claimed - measurement) <= rounding * scale):  # also refuses NaN
            raise ClaimError(
                f"{self.name}: {self.path(path)} is {_text(claimed)}, but {_text(measurement)} was found"
            )
        self.hold(path, measurement.tolist(), rounding * scale)

    def near_angle(self, path: str, measured_deg: float, within_deg: float) -> None:
        """Check an angle in [0, 360) against a measurement modulo 360 degrees."""
        claimed = self.get(path, float)
        if not 0.0 <= claimed < 360.0:
            raise ClaimError(
                f"{self.name}: {self.path(path)} is {claimed:.9g}; expected an angle in [0, 360)"
            )
        self.near(path, near_turn(measured_deg, claimed), within_deg, 1.0)

    def alike(self, measured: Mapping[str, Any], rounding: float = ROUNDING, scale: float = 0.0) -> None:
        """Check all values of an object that were not checked before; missing keys are faults.

        Numbers may differ by ``rounding`` of the largest in the same object or list, at least of ``scale``.
        The angle of a magnitude may differ by as much as that moves it: the angle of nearly nothing is not a
        claim.
        """
        numbers = [abs(each) for value in measured.values() for each in _numbers(value)]
        size = max([scale, *numbers])
        for key, value in measured.items():
            if self.ledger.knows(self.path(key)):
                continue
            magnitude = measured.get("magnitude_g_mm")
            if key == "angle_deg" and _is_number(value) and isinstance(magnitude, int | float):
                within = rounding * size
                turn_deg = math.degrees(math.asin(within / magnitude)) if magnitude > within else 180.0
                self.near_angle(key, float(value), max(within, turn_deg))
            else:
                self._alike(key, value, rounding, size, scale)

    def _alike(self, key: str, value: Any, rounding: float, size: float, scale: float) -> None:
        if isinstance(value, Mapping):
            self.at(key, self.get(key, dict)).alike(value, rounding, scale)
        elif isinstance(value, list) and any(isinstance(each, Mapping) for each in value):
            for part, each in zip(self.entries(key, len(value)), value, strict=True):
                part.alike(each, rounding, scale)
        elif _is_numeric(value):
            self.near(key, value, size, rounding)
        else:
            self.same(key, value)


def _numbers(value: Any) -> list[float]:
    """Return a number, or the numbers of nested lists, as one list; none of any other value."""
    return np.asarray(value, dtype=np.float64).reshape(-1).tolist() if _is_numeric(value) else []


def _is_numeric(value: Any) -> bool:
    if isinstance(value, list):
        return bool(value) and all(map(_is_numeric, value))
    return _is_number(value)


def _holds_numbers(value: Any) -> bool:
    """Return whether a value is a number, or lists of nothing else."""
    return all(map(_holds_numbers, value)) if isinstance(value, list) else _is_number(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _text(value: Any) -> str:
    flat = np.asarray(value, dtype=np.float64).reshape(-1)
    text = ", ".join(f"{number:.9g}" for number in flat)
    return text if len(flat) == 1 else f"[{text}]"


def near_turn(angle_deg: float, claimed_deg: float) -> float:
    """Return an angle plus the whole turns that bring it nearest to the claim."""
    if not math.isfinite(claimed_deg):
        return angle_deg
    return angle_deg + 360.0 * round((claimed_deg - angle_deg) / 360.0)


# Values of a report that were not checked, with reasons.


# Where a kind can read one of these off the metal (`correction.holes.trace` does), it is checked there: the
# reasons below are for those that no check has touched.
PLANNED_ONLY = "found by the planner on the surfaces around each place; the files do not keep it"
NOT_CHECKED: Mapping[str, str] = {
    "job": "the request is taken unchecked; its consequences were checked",
    "job_set": "the request is taken unchecked",
    "autobalance": "which versions ran does not follow from the files",
    "seconds": "how long a run took does not follow from the files",
    "warnings": "free text, not checked",
    "notes": "free text, not checked",
    "weak_places": "words for people; webs and walls were checked",
    "bending": "finite elements on meshes that are not kept; `balance --fem` computes them again",
    "reason": "words for people, from plans that were tried",
    "reason_parts": "words for people; joined, they are the reason",
    "relaxations": "limits that the cuts did not have, from plans that were tried",
    "plan_kept": "the report whose cuts were kept is not read",
    "steps": "the solids and predictions of earlier passes are not kept",
    "overbalance": "the last holes are planned, not cut yet",
    "corrections[].wall_left_mm": PLANNED_ONLY,
    "corrections[].depth_left_mm": PLANNED_ONLY,
    "corrections[].cutter_mm": PLANNED_ONLY,
    "corrections[].drill": "what the shop calls the drill; its diameter was checked",
    "corrections[].sector_deg": "the metal does not show where the sector ends",
    "serial": "it is on the part, not in the files",
    "machine_reading": "the machine's reading is not checked",
    "stages": "earlier stages are checked with their own reports; readings are not checked",
    "true_surfaces": "counted by the CAD kernel while the run had both solids",
}
"""Reasons by place for values that do not follow from the files."""
NO_SOURCE = "there is no independent source to check it against"


@dataclass(frozen=True)
class NotChecked:
    """A value that was not checked, or a group of them; ``[]`` stands for every entry of a list."""

    key: str
    why: str


def not_checked(values: Mapping[str, Any], ledger: Ledger) -> tuple[NotChecked, ...]:
    """Return the values that no check noted, each group once; files that were not read come last."""
    reasons: dict[str, str] = {}
    for place in _leaves("", values):
        if not ledger.knows(place):
            key, why = _reason(place, ledger)
            reasons.setdefault(key, why)
    return tuple(NotChecked(key, why) for key, why in {**reasons, **ledger.unread}.items())


def _reason(place: str, ledger: Ledger) -> tuple[str, str]:
    """Return the group that a place belongs to, and why it was not checked."""
    general = re.sub(r"\[\d+\]", "[]", place)
    for known, name in ((ledger.why_not, place), (NOT_CHECKED, general)):
        keys = [key for key in known if name == key or name.startswith((f"{key}.", f"{key}["))]
        if keys:
            key = max(keys, key=len)
            return key, known[key]
    return general, NO_SOURCE


def _leaves(place: str, value: Any) -> Iterator[str]:
    """Yield the places of all values without inner values; a list of plain values counts as one."""
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from _leaves(f"{place}.{key}" if place else key, inner)
    elif isinstance(value, list) and any(isinstance(each, Mapping) for each in value):
        for number, inner in enumerate(value, 1):
            yield from _leaves(f"{place}[{number}]", inner)
    else:
        yield place
