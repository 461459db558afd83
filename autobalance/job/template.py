"""The job that ``init`` writes for a crank: recognised values filled in, those to enter marked."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Collection, Iterable, Mapping
from dataclasses import field, replace
from typing import Any, Literal, get_args, get_origin

from autobalance.declare import REQUIRED, Key
from autobalance.errors import JobError
from autobalance.job.balance import BALANCE
from autobalance.job.layout import JOB
from autobalance.job.limits import correction_key
from autobalance.job.read_crankshaft import CRANKSHAFT
from autobalance.job.read_engine import ENGINE
from autobalance.job.tables import key_at
from autobalance.job.workbook import Row
from autobalance.toml_files.document import toml_value
from autobalance.toml_files.keys import plain
from autobalance.toml_files.typed_units import FILL_IN
from autobalance.value_classes import dataclass

WIDTH = 108
ORIGINAL_TITLE = (
    "Weights of the original parts, if they differ from the new ones in [engine], as before a lighter "
    'piston. All "FILL IN": the parts are the same. With these weights, balance.factor may stay "FILL IN": '
    'it is then "original", the factor that the crank had with these parts'
)
WORDS = ("share",)
"""Units that the meaning gives in words."""


@dataclass(frozen=True)
class OtherParts:
    """The other bodies of an assembly with the crank, as tables that say where a part's solid is.

    Attributes
    ----------
    rod : mapping or None
        Of the connecting rod.
    rod_length_mm : float
    rods_per_throw : int
    weights : mapping
        Table of weights → name → part.
    unknown : mapping
        Name → part, where it is not known what it is.
    alike : int
        Bodies that belong to further rods, not listed.
    """

    rod: Mapping[str, Any] | None = None
    rod_length_mm: float = 0.0
    rods_per_throw: int = 1
    weights: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    unknown: Mapping[str, Any] = field(default_factory=dict)
    alike: int = 0


@dataclass(frozen=True)
class RecognisedCrank:
    """Results of recognition, as keys and values of a job.

    ``hints`` are keys with recognised values that need not be set; ``factor_hint`` is a suggestion for the
    balance factor. ``two_rods_fit``: the crankpins are wide enough for two rods. ``known`` are further
    keys with their values.
    """

    file: str
    unit: str | None
    density_kg_m3: float | None
    crankpin_in_file: bool
    stroke_mm: float
    planes_mm: tuple[float, float] | None
    method: str
    factor_hint: str = ""
    two_rods_fit: bool = False
    hints: Mapping[str, Any] = field(default_factory=dict)
    asked: Mapping[str, Any] = field(default_factory=dict)
    body: int | str | None = None
    parts: OtherParts = OtherParts()
    known: Mapping[str, Any] = field(default_factory=dict)


def job_rows(crank: RecognisedCrank) -> list[Row]:
    """Return the rows of a job, headings with an empty key."""
    rows = [
        *_crankshaft(crank),
        *_engine(crank),
        *_original(crank),
        *_balance(crank),
        *_correction(crank),
        *table_rows(JOB),
    ]
    for key, value in crank.known.items():
        rows = _with_value(rows, key, value)
    return rows


def _with_value(rows: list[Row], key: str, value: Any) -> list[Row]:
    """Return rows in which a key has a value; the sum of all weights replaces those to fill in."""
    table, _, name = key.rpartition(".")
    if name == "all":
        first = next((place for place, row in enumerate(rows) if row.key.startswith(f"{table}.")), None)
        rows = [row for row in rows if not (row.key.startswith(f"{table}.") and row.value == FILL_IN)]
        new = Row(key, value, "g", "of one connecting rod, all parts together")
        if first is not None:
            return [*rows[:first], new, *rows[first:]]
    for place, row in enumerate(rows):
        if row.key == key:
            return [*rows[:place], replace(row, value=value, active=True), *rows[place + 1 :]]
    try:
        new = declared_row(key, key_at(key), value, "as given to init")
    except KeyError:
        raise JobError(f"{key} is an unknown key") from None
    own = [place for place, row in enumerate(rows) if row.key.rpartition(".")[0] == table]
    if own:
        return [*rows[: own[-1] + 1], new, *rows[own[-1] + 1 :]]
    return [*rows, Row("", meaning=table), new]


def _heading(text: str) -> Row:
    return Row("", meaning=text)


def _row(key: str, value: Any, note: str = "", *, active: bool = True) -> Row:
    """Return a row with the unit and meaning that the key is declared with, a note of this crank first."""
    return declared_row(key, key_at(key), value, note, active=active)


def declared_row(path: str, key: Key, value: Any, note: str = "", *, active: bool = True) -> Row:
    """Return a row as its key is declared: what it may be, and what it means in a sentence."""
    says = in_plain_text(key.says).partition(". ")[0]
    choices = [f'"{each}"' for each in get_args(key.hint)] if get_origin(key.hint) is Literal else []
    may_be = "" if any(each in says for each in choices) else ", ".join(choices)
    meaning = "; ".join(word for word in (note, may_be, says) if word)
    return Row(path, value, "" if key.unit in WORDS else key.unit, meaning, active)


def _crankshaft(crank: RecognisedCrank) -> list[Row]:
    density = FILL_IN if crank.density_kg_m3 is None else crank.density_kg_m3
    rows = [_heading(_title(CRANKSHAFT)), _row("crankshaft.file", crank.file)]
    if crank.unit is not None:
        rows.append(_row("crankshaft.unit", crank.unit))
    if crank.body is not None and "body" not in crank.asked:
        rows.append(_row("crankshaft.body", crank.body, "recognised"))
    rows += [
        _row("crankshaft.density_kg_m3", density, "steel 7850, cast iron 7200"),
        _row("crankshaft.density_pm_kg_m3", 20.0, active=False),
    ]
    if not crank.crankpin_in_file:
        rows.append(_row("crankshaft.crankpin_in_file", False))
    rows += [
        _row(f"crankshaft.{key}", value, "as given to init")
        for key, value in crank.asked.items()
        if key not in ("file", "unit", "density_kg_m3", "crankpin_in_file")
    ]
    return rows + [
        _row(f"crankshaft.{key}", value, "recognised; set it only to change that", active=False)
        for key, value in crank.hints.items()
        if key not in crank.asked
    ]


USUAL_PARTS: Mapping[str, Mapping[str, str]] = {
    "rotating_g": {
        "connecting_rod_big_end": "the rod's big end, by two scales",
        "big_end_bearing": "bearing or shells",
    },
    "reciprocating_g": {
        "connecting_rod_small_end": "the rod's small end, by two scales",
        "piston": "bare piston",
        "wrist_pin": "",
        "rings_clips_oil": "rings, clips, and the oil on them",
    },
    "crankpin_g": {"oil": "other parts on or in the crankpin"},
}
"""Parts that an engine has, by their table: name → what it is."""


def _engine(crank: RecognisedCrank) -> list[Row]:
    rotating, reciprocating = dict(USUAL_PARTS["rotating_g"]), dict(USUAL_PARTS["reciprocating_g"])
    note = "; weights of one connecting rod: a number, { g = 158.0, pm = 0.5 }, { oz = 5.6 }"
    parts = crank.parts
    per_throw = parts.rods_per_throw
    rows = [
        _heading(_title(ENGINE) + note),
        _row("engine.stroke_mm", crank.stroke_mm, "measured"),
        _row("engine.rod_length_mm", parts.rod_length_mm or 2.0 * crank.stroke_mm, active=False),
        _rods_per_throw(crank, per_throw),
        *_rod(parts),
    ]
    if parts.rod is not None:
        del rotating["connecting_rod_big_end"], reciprocating["connecting_rod_small_end"]
    for table, names in (("rotating_g", rotating), ("reciprocating_g", reciprocating)):
        solids = dict(parts.weights.get(table, {}))
        rows += [
            _weight(f"engine.{table}.{name}", solids.pop(name, None), text) for name, text in names.items()
        ]
        rows += [_weight(f"engine.{table}.{name}", solid, "") for name, solid in solids.items()]
        if table == "reciprocating_g":
            rows += [_unknown(name, part) for name, part in parts.unknown.items()]
    if not crank.crankpin_in_file:
        rows.append(Row("engine.crankpin_g.crankpin", FILL_IN, "g", "the crankpin, which is not in the file"))
    rows.append(Row("engine.crankpin_g.oil", 4.0, "g", "other parts on or in the crankpin", active=False))
    return rows


def _original(crank: RecognisedCrank) -> list[Row]:
    """Return the rows of the parts that the crank was balanced for, each as ``[engine]`` has one now."""
    tables = {name: USUAL_PARTS[name] for name in ("rotating_g", "reciprocating_g")}
    rows = [
        Row(f"original.{table}.{name}", FILL_IN, "g", f"new: engine.{table}.{name}")
        for table, names in tables.items()
        for name in names
    ]
    if not crank.crankpin_in_file:
        key = "crankpin_g.crankpin"
        rows.append(Row(f"original.{key}", FILL_IN, "g", f"new: engine.{key}"))
    return [_heading(ORIGINAL_TITLE), *rows]


def _rods_per_throw(crank: RecognisedCrank, per_throw: int) -> Row:
    """Return the row of the rods on a crankpin: to fill in where two fit and the file shows none."""
    if per_throw > 1 or not crank.two_rods_fit or crank.parts.rod is not None:
        return _row("engine.rods_per_throw", per_throw if per_throw > 1 else 2, active=per_throw > 1)
    note = "1, or 2 in a vee engine: the crankpins are wide enough for two"
    return _row("engine.rods_per_throw", FILL_IN, note)


def _rod(parts: OtherParts) -> list[Row]:
    """Return the rows of the rod's solid, whose ends need no weighing."""
    if parts.rod is None:
        return []
    more = f"; {parts.alike} bodies of further rods are not listed" if parts.alike else ""
    meanings = {"file": "the connecting rod's solid: end weights, length and inertia are measured" + more}
    values = {**parts.rod, "density_kg_m3": FILL_IN}
    return [
        Row(f"engine.rod.{key}", value, "kg/m³" if key == "density_kg_m3" else "", meanings.get(key, ""))
        for key, value in values.items()
    ]


def _weight(key: str, solid: Mapping[str, Any] | None, text: str) -> Row:
    """Return the row of a weight: of its solid where the file has it, else left to fill in."""
    if solid is None:
        return Row(key, FILL_IN, "g", text)
    meaning = "; ".join(word for word in ("recognised by its place", text) if word)
    return Row(key, {**solid, "density_kg_m3": FILL_IN}, "g", meaning)


def _unknown(name: str, part: Mapping[str, Any]) -> Row:
    meaning = f"body {part['body']!r} of {part['file']}: not recognised; here if it goes with the piston"
    key = f"engine.reciprocating_g.{name}"
    return Row(key, {**part, "density_kg_m3": FILL_IN}, "g", meaning, active=False)


def _balance(crank: RecognisedCrank) -> list[Row]:
    rows = {
        "factor": _row("balance.factor", FILL_IN, crank.factor_hint),
        "grade": _row("balance.grade", FILL_IN, "6.3 for racing; 16 is coarser"),
        "speed_rpm": _row("balance.speed_rpm", FILL_IN),
        "judge": _row("balance.judge", "static" if crank.planes_mm is None else "dynamic"),
    }
    if crank.planes_mm is not None:
        key = "tolerance_planes_mm"
        rows[key] = _row(f"balance.{key}", list(crank.planes_mm), "middles of the outermost main journals")
    return [_heading(_title(BALANCE)), *rows.values(), *_hints(BALANCE, "balance", rows)]


def _correction(crank: RecognisedCrank) -> list[Row]:
    key = correction_key()
    of_kind = next(each for each in key.keys if each.name == crank.method)
    return [
        _heading(_title(key) + "; a limit in a line with # has the value shown there"),
        _row("correction.method", crank.method),
        _row("correction.prefer", "simple", active=False),
        _row("correction.depth_tolerance_mm", 0.05, active=False),
        *_hints(of_kind, f"correction.{crank.method}", ()),
    ]


def _hints(key: Key, path: str, shown: Collection[str]) -> list[Row]:
    """Return the unset keys of a table, each with its default or an example of it."""
    rows = []
    for each in key.keys:
        value = each.example if each.default in (None, ()) else plain(each.default)
        if each.name not in shown and each.default is not REQUIRED:
            rows.append(declared_row(f"{path}.{each.name}", each, value, active=False))
    return rows


def _title(key: Key) -> str:
    says = in_plain_text(key.says)
    return says[:1].upper() + says[1:]


def table_rows(key: Key) -> list[Row]:
    """Return a table with all of its keys as hints, as they are declared."""
    return [_heading(_title(key)), *_hints(key, key.name, ())]


def described_rows(rows: Iterable[Row]) -> list[Row]:
    """Return rows of a job with the unit and meaning that each key is declared with."""
    described = []
    for row in rows:
        try:
            described.append(declared_row(row.key, key_at(row.key), row.value))
        except KeyError:  # a key that is none, left for the reader to refuse
            described.append(row)
    return described


def in_plain_text(says: str) -> str:
    """Return a key's meaning without the marks of the documentation.

    Examples
    --------
    >>> in_plain_text("a list, `[8.0]`: see [step.md](step.md)")
    'a list, [8.0]: see step.md'
    """
    return re.sub(r"\[([^]]+)\]\([^)]+\)", r"\1", says).replace("`", "").replace("**", "")


def commented_toml(rows: Iterable[Row], kept: Collection[str] = ()) -> str:
    """Return rows as a TOML document with a comment for each key; hints are commented out.

    So does the heading of a table of the top level that holds hints alone, unless it is ``kept``.
    """
    rows = list(rows)
    active = {row.key.partition(".")[0] for row in rows if row.active} | set(kept)
    lines: list[str] = []
    table = ""
    for row in rows:
        if not row.key:
            lines += ["", *(f"# {line}" for line in textwrap.wrap(row.meaning, WIDTH))]
            table = ""
            continue
        here, _, key = row.key.rpartition(".")
        if here != table:
            heading = f"[{here}]" if here.partition(".")[0] in active else f"# [{here}]"
            lines += [heading] if not table else ["", heading]
            table = here
        mark = "" if row.active else "# "
        unit = f"[{row.unit}] " if row.unit else ""
        value = "..." if row.value is None else toml_value(row.value)
        lines.append(f"{mark}{key} = {value}  # {unit}{row.meaning}".rstrip(" #"))
    return "\n".join(lines).strip() + "\n"
