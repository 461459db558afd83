"""The job that ``init`` writes for a crank: what was found filled in, what only the user knows marked."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from autobalance.job.toml.keys import Key, plain
from autobalance.job.toml.text import toml_value
from autobalance.job.toml.typed_units import FILL_IN
from autobalance.job.workbook import Row

WIDTH = 108


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
class Found:
    """What recognition found, as keys and values of a job.

    ``hints`` are keys that say what was recognised but need not be said.
    """

    file: str
    unit: str | None
    density_kg_m3: float | None
    crankpin_in_file: bool
    stroke_mm: float
    planes_mm: tuple[float, float] | None
    method: str
    throws: int
    hints: Mapping[str, Any] = field(default_factory=dict)
    asked: Mapping[str, Any] = field(default_factory=dict)
    body: int | str | None = None
    parts: OtherParts = OtherParts()


def job_rows(found: Found) -> list[Row]:
    """Return the rows of a job, headings with an empty key."""
    return [
        *_crankshaft(found),
        *_engine(found),
        *_balance(found),
        *_correction(found),
    ]


def _heading(text: str) -> Row:
    return Row("", meaning=text)


def _crankshaft(found: Found) -> list[Row]:
    density = FILL_IN if found.density_kg_m3 is None else found.density_kg_m3
    rows = [
        _heading("The crank's file and what must be known to read it"),
        Row("crankshaft.file", found.file, "", "the crank's solid model, relative to this job"),
    ]
    if found.unit is not None:
        rows.append(Row("crankshaft.unit", found.unit, "", "mm, cm, m or inch: the format carries none"))
    if found.body is not None and "body" not in found.asked:
        rows.append(Row("crankshaft.body", found.body, "", "the crank among the file's bodies, recognised"))
    rows += [
        Row("crankshaft.density_kg_m3", density, "kg/m³", "of its material; steel 7850, cast iron 7200"),
        Row("crankshaft.density_pm_kg_m3", 20.0, "kg/m³", "by how much that may be off", active=False),
    ]
    if not found.crankpin_in_file:
        meaning = "the crankpin is pressed in and not in the file"
        rows.append(Row("crankshaft.crankpin_in_file", False, "", meaning))
    rows += [
        Row(f"crankshaft.{key}", value, "", "as given to init")
        for key, value in found.asked.items()
        if key not in ("file", "unit", "density_kg_m3", "crankpin_in_file")
    ]
    return rows + [
        Row(f"crankshaft.{key}", value, "", "recognised; say it only to overrule that", active=False)
        for key, value in found.hints.items()
        if key not in found.asked
    ]


def _engine(found: Found) -> list[Row]:
    rotating = {
        "connecting_rod_big_end": "the rod's big end, by two scales",
        "big_end_bearing": "bearing or shells",
    }
    reciprocating = {
        "connecting_rod_small_end": "the rod's small end, by two scales",
        "piston": "bare piston",
        "wrist_pin": "",
        "rings_clips_oil": "rings, clips, and the oil on them",
    }
    note = (
        "; also { g = 158.0, pm = 0.5 }, { oz = 5.6 }, or a solid:"
        ' { file = "pin.stl", unit = "mm", density_kg_m3 = 7850 }'
    )
    parts = found.parts
    length = parts.rod_length_mm or 2.0 * found.stroke_mm
    per_throw = parts.rods_per_throw
    rows = [
        _heading("What hangs on the crank; weights are of one connecting rod" + note),
        Row("engine.stroke_mm", found.stroke_mm, "mm", "measured; checked against the geometry"),
        Row("engine.rod_length_mm", length, "mm", "eye to eye; for forces", active=False),
        Row(
            "engine.rods_per_throw",
            per_throw if per_throw > 1 else 2,
            "",
            "connecting rods on a crankpin, 1 unless told",
            active=per_throw > 1,
        ),
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
    if not found.crankpin_in_file:
        rows.append(Row("engine.crankpin_g.crankpin", FILL_IN, "g", "the crankpin, which is not in the file"))
    rows.append(Row("engine.crankpin_g.oil", 4.0, "g", "what sits in a crankpin, of one throw", active=False))
    return rows


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


def _balance(found: Found) -> list[Row]:
    dynamic = found.planes_mm is not None
    usual = "0.5 to 0.65 for singles, 0.5 for vee twins" if found.throws < 3 else "0 where throws cancel"
    rows = [
        _heading("What is asked of the balanced crank"),
        Row("balance.factor", FILL_IN, "", f"share of the reciprocating mass to balance, 0 to 1 ({usual})"),
        Row("balance.grade", FILL_IN, "mm/s", "balance quality grade G: 6.3 in racing, 16 coarser"),
        Row("balance.speed_rpm", FILL_IN, "1/min", "highest service speed"),
        Row(
            "balance.judge",
            "dynamic" if dynamic else "static",
            "",
            "dynamic: the resultant and each tolerance plane; static: the resultant alone",
        ),
    ]
    if found.planes_mm is not None:
        meaning = "z of the tolerance planes: the middle of the outermost main journals"
        rows.append(Row("balance.tolerance_planes_mm", list(found.planes_mm), "mm", meaning))
    return rows


def _correction(found: Found) -> list[Row]:
    return [
        _heading("How metal may be taken off or added; every limit has a default (see the list of keys)"),
        Row(
            "correction.method",
            found.method,
            "",
            "one kind or a list: shoulder, turn, drill, slug, add, ...",
        ),
        Row("correction.min_wall_mm", 3.0, "mm", "metal to leave", active=False),
        Row("correction.prefer", "simple", "", "or least_metal, fewest_holes, ...", active=False),
        Row(
            "correction.drill.diameters_mm",
            [8.0, 10.0, 12.0],
            "mm",
            "drills at hand; unset: picked from 4 to 25 mm",
            active=False,
        ),
        Row("correction.drill.zone", "counterweights", "", "or anywhere", active=False),
        Row("correction.drill.max_holes", 6, "", "on each counterweight", active=False),
    ]


def table_rows(key: Key) -> list[Row]:
    """Return a table with all of its keys as hints, as they are declared."""
    rows = [_heading(key.says[:1].upper() + key.says[1:])]
    for each in key.keys:
        value = each.example if each.default in (None, ()) else plain(each.default)
        rows.append(Row(f"{key.name}.{each.name}", value, each.unit, in_plain_text(each.says), active=False))
    return rows


def in_plain_text(says: str) -> str:
    """Return a key's meaning without the marks of the documentation.

    Examples
    --------
    >>> in_plain_text("a list, `[8.0]`: see [step.md](step.md)")
    'a list, [8.0]: see step.md'
    """
    return re.sub(r"\[([^]]+)\]\([^)]+\)", r"\1", says).replace("`", "").replace("**", "")


def commented_toml(rows: Iterable[Row]) -> str:
    """Return rows as a TOML document with a comment for each key; hints stand commented out."""
    lines: list[str] = []
    table = ""
    for row in rows:
        if not row.key:
            lines += ["", *_wrapped(row.meaning)]
            table = ""
            continue
        here, _, key = row.key.rpartition(".")
        if here != table:
            lines += [f"[{here}]"] if not table else ["", f"[{here}]"]
            table = here
        mark = "" if row.active else "# "
        unit = f"[{row.unit}] " if row.unit else ""
        lines.append(f"{mark}{key} = {toml_value(row.value)}  # {unit}{row.meaning}".rstrip(" #"))
    return "\n".join(lines).strip() + "\n"


def _wrapped(text: str) -> Sequence[str]:
    import textwrap

    return [f"# {line}" for line in textwrap.wrap(text, WIDTH)]
