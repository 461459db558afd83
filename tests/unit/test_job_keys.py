"""Every key of a job: what the reader refuses, the schema refuses, and what fits passes both."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
from jsonschema import Draft202012Validator

from autobalance import job
from autobalance.command.main import main
from autobalance.correction import KINDS
from autobalance.declare import ANY, REQUIRED, Key, Large, Range
from autobalance.errors import JobError
from autobalance.job.tables import job_schema, job_tables
from autobalance.toml_files.keys import read
from autobalance.toml_files.table import MAX_NUMBER
from autobalance.toml_files.typed_units import in_base_units
from autobalance.units import G_PER

Path_ = tuple[str | int, ...]
Raw = dict[str, Any]

BASE: Raw = {
    "crankshaft": {"file": "crank.stl", "unit": "mm", "density_kg_m3": 7850.0},
    "engine": {"reciprocating_g": {"piston": 158.0}},
    "balance": {"factor": 0.28, "grade": 6.3, "speed_rpm": 15200},
    "correction": {"method": "shoulder"},
}
FITTING: Mapping[str, Any] = {
    "cycle": {"bore_mm": 70.0, "compression_ratio": 12.0, "heat_J": 500.0},
    "shafts": [{"order": 1, "sense": "forward", "product_g_mm": 5.0}],
    "assembly": [{"name": "damper", "mass_g": 100.0, "z_mm": 1.0, "unbalance_g_mm": [1.0, 0.0]}],
    "gear": [{"stations": [1, 2], "ratio": 2.0}],
    "gear.stations": [1, 2],
    "coupling": [{"station": 1, "torque_N_m": [0.0, 9.0], "twist_rad": [0.0, 0.1]}],
    "coupling.torque_N_m": [0.0, 8.0],
    "coupling.twist_rad": [0.0, 0.2],
    "damper": [{"station": 1, "kind": "ring", "inertia_kg_mm2": 9.0, "N_m_rad": 1e4, "N_m_s_rad": 1.0}],
    "damper.kind": "ring",
    "drive": {"shaft": [{"name": "pump", "speed": 2.0}]},
    "bearings.k_N_mm": 1e5,
    "strength.factor": {"bending": 2.0, "torsion": 1.5},
    "drive.belt.length_mm": 900.0,
    "drive.belt.pulley_mm": 50.0,
    "cycle.intake_closes_deg": -140.0,
    "cycle.exhaust_opens_deg": 120.0,
    "cycle.cylinder.intake_closes_deg": -140.0,
    "cycle.cylinder.exhaust_opens_deg": 120.0,
    "crankshaft.unit": "mm",
    "balance.tolerance_planes_mm": [-40.0, 40.0],
    "correction.sector_deg": [10.0, 20.0],
    "correction.shoulder.sector_deg": [10.0, 20.0],
    "correction.add.sector_deg": [10.0, 20.0],
    "correction.drill.sectors_deg": [[10.0, 20.0]],
    "correction.slug.sectors_deg": [[10.0, 20.0]],
    "correction.mill.sectors_deg": [[10.0, 20.0]],
    "crankshaft.density_pm_kg_m3": 20.0,
    "crankshaft.body": 1,
    "speed_rpm": 900.0,
    "assembly.correct_mm": [1.0],
    "correction.drill.min_depth_mm": 3.0,
    "correction.drill.max_depth_mm": 20.0,
    "correction.drill.max_obliquity_deg": 10.0,
    "grid": [120, 40],
}
"""Tables and values that fit together, by their path without places in lists."""


def number(rule: Range) -> float:
    return next(each for each in (1, 2, 1.2, 0.5, 50, 5e-4, 10_000) if rule.holds(each))


def sample(key: Key, path: str, known: Mapping[str, Any] = FITTING) -> Any:
    """Return a value that fits, as TOML has it; ``known`` are those of tables that must fit together."""
    if path in known:
        return copy.deepcopy(known[path])
    if key.named is not None:
        return {"part": sample(key.named, f"{path}.part", known)}
    if key.keys and key.hint is None:
        table = {each.name: sample(each, f"{path}.{each.name}", known) for each in key.keys if needed(each)}
        return [table] if key.many else table
    return fitting(key.hint, key.rule)


def needed(key: Key) -> bool:
    return key.default is REQUIRED


def fitting(hint: Any, rule: Range) -> Any:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Literal:
        return inner[0]
    if origin is tuple:
        return [fitting(each, rule) for each in inner if each is not Ellipsis]
    if inner:
        return fitting(inner[0], rule)
    return {bool: True, str: "text", dict: {"x": 1}}.get(
        hint, number(rule) if hint is not int else None
    ) or int(number(rule))


def wrong(key: Key) -> Iterator[Any]:
    """Yield values of another type, and out of range."""
    if key.named is not None and key.hint is not None:  # a number, or a table of named ones
        yield from ("text", True, [[[1]]], {"no": "text"})
        yield from beyond(key.rule, key.hint)
        return
    if (key.keys and key.hint is None) or key.named is not None:
        yield from (3, "text", True)
        return
    yield from ([[[1]]],) if key.hint is dict else ({"no": 1}, [[[1]]])
    arms = get_args(key.hint) if get_origin(key.hint) not in (tuple, Literal) else ()
    plain = [each for each in (arms or (key.hint,)) if each is not type(None)]
    if bool not in plain:
        yield True
    if str not in plain:
        yield "no such thing"
    numeric = [each for each in plain if each in (int, float, Large)]
    if not numeric:
        yield from beyond(key.rule, float) if key.or_one else (3.25,)
        return
    if plain == [int]:
        yield 1.5
    yield from beyond(key.rule, numeric[0])


def beyond(rule: Range, kind: Any) -> Iterator[float]:
    """Yield numbers out of range."""
    yield 10 * MAX_NUMBER if kind is not Large else 1e16
    step = 1 if kind is int else 1e-3
    if rule.one_of:
        yield max(rule.one_of) + 1
    for bound, beside in ((rule.least, -step), (rule.most, step), (rule.above, 0), (rule.below, 0)):
        if bound is not None and not rule.holds(bound + beside):
            yield bound + beside


def every_key(
    keys: tuple[Key, ...], raw: Raw, path: Path_ = (), known: Mapping[str, Any] = FITTING
) -> Iterator[tuple[Key, Path_, Raw]]:
    """Yield every key with its path and a job in which its table stands."""
    for key in keys:
        here = (*path, key.name)
        yield key, here, raw
        if dotted(here) == "shafts.weight":
            raw = with_value(raw, (*path, "product_g_mm"), None)
        held = with_value(raw, here, sample(key, dotted(here), known)) if not holds(raw, here) else raw
        if key.named is not None:
            part = (*here, "part")
            yield key.named, part, with_value(held, part, 1.0)
            for form in key.named.forms:
                within = with_value(
                    held, part, {each.name: sample(each, "", known) for each in form.keys if needed(each)}
                )
                if any("required" in each for each in form.shape.get("oneOf", ())):
                    within = with_value(within, part, {"g": 1.0})
                yield from every_key(form.keys, within, part, known)
        elif key.forms:
            for form in key.forms:
                within = with_value(
                    held, here, {each.name: sample(each, "", known) for each in form.keys if needed(each)}
                )
                yield from every_key(form.keys, within, here, known)
        elif key.keys:
            yield from every_key(key.keys, held, (*here, 0) if key.many else here, known)


def dotted(path: Path_) -> str:
    return ".".join(str(step) for step in path if isinstance(step, str))


def told(path: Path_) -> str:
    """Return a path as messages have it."""
    text = ""
    for step in path:
        text += f"[{step + 1}]" if isinstance(step, int) else f".{step}"
    return text[1:]


def holds(raw: Any, path: Path_) -> bool:
    for step in path:
        if isinstance(raw, dict) and step not in raw:
            return False
        raw = raw[step]
    return True


def with_value(raw: Raw, path: Path_, value: Any, rename: str = "") -> Raw:
    """Return a job with a value set, under another name, or taken away (None)."""
    changed: Any = copy.deepcopy(raw)
    inner = changed
    for step in path[:-1]:
        inner = inner.setdefault(step, {}) if isinstance(inner, dict) else inner[step]
    inner.pop(path[-1], None)
    if value is not None:
        inner[rename or path[-1]] = value
    return changed  # type: ignore[no-any-return]


@cache
def validator() -> Draft202012Validator:
    return Draft202012Validator(job_schema())


def complaint(raw: Raw) -> list[str]:
    try:
        job.parse(raw, Path("folder/job.toml"))
    except JobError as error:
        return list(error.lines)
    return []


def of_keys_alone(raw: Raw) -> list[str]:
    """Return what is wrong with single keys; two that fit may contradict each other all the same."""
    try:
        read(in_base_units(raw), job_tables())
    except JobError as error:
        return list(error.lines)
    return []


def both_refuse(
    raw: Raw,
    names: str,
    said: Callable[[Raw], list[str]] = complaint,
    schema: Draft202012Validator | None = None,
) -> None:
    """Check that a reader says something of the key that is named, and the schema refuses it."""
    lines = said(raw)
    assert any(names in line for line in lines), (names, lines)
    assert not (schema or validator()).is_valid(raw), f"the schema takes it: {lines}"


@pytest.mark.parametrize("name", [key.name for key in job_tables()])
def test_what_the_reader_refuses_the_schema_refuses(name: str) -> None:
    tables = tuple(key for key in job_tables() if key.name == name)
    for key, path, held in every_key(tables, BASE):
        where = told(path)
        of_a_weight = key.name in G_PER and not needed(key)
        other = "g" if of_a_weight else "density_kg_m3" if key.name == "density" else None
        raw = with_value(held, (*path[:-1], other), None) if other else held
        good = sample(key, dotted(path))
        fits = with_value(raw, path, good)
        in_a_solid = "file" in (at(raw, path[:-1]) or {}) and path[0] != "crankshaft"
        if not in_a_solid and where != "engine.rod.file":  # those are read from files that are not there
            assert of_keys_alone(fits) == [], where
            assert [each.message for each in validator().iter_errors(fits)] == [], where
        for value in wrong(key):
            both_refuse(with_value(raw, path, value), told(path[:-1]) if of_a_weight else where)
        is_none = of_a_weight or where.endswith(("part.file", "rod.file"))  # without it the table is another
        none = f"{told(path[:-1])}." + (
            "density_kg_m3 is an unknown key" if "rod.file" in where else "g is missing"
        )
        if key.name:  # free names cannot be misspelt
            misspelt = none if is_none else f"{where}x is an unknown key"
            both_refuse(with_value(raw, path, good, rename=f"{key.name}x"), misspelt)
        if needed(key) and key.name:
            both_refuse(with_value(raw, path, None), none if is_none else where)


def at(raw: Any, path: Path_) -> Any:
    for step in path:
        raw = raw[step] if isinstance(step, int) else raw.get(step, {})
    return raw if isinstance(raw, dict) else None


def test_a_range_is_in_its_words_and_in_the_schema() -> None:
    rule = Range("must be 0 or ≥ 0.1", least=0.1, besides=(0.0,))
    validates = Draft202012Validator(rule.schema()).is_valid
    for value in (-1.0, 0.0, 0.05, 0.1, 7.0):
        assert rule.holds(value) == validates(value)
    assert ANY.schema() == {}


def test_all_that_is_wrong_is_said_at_once() -> None:
    raw = copy.deepcopy(BASE)
    raw["balance"]["grade"] = -1
    raw["balance"]["sped_rpm"] = raw["balance"].pop("speed_rpm")
    raw["engine"]["stroke_mm"] = True
    raw["corection"] = raw.pop("correction")
    assert complaint(raw) == [
        "corection is an unknown key; did you mean 'correction'?",
        "engine.stroke_mm is true; must be a number",
        "balance.sped_rpm is an unknown key; did you mean 'speed_rpm'?",
        "balance.grade is -1; must be > 0",
        f"[correction] is missing; it needs at least method: one of {', '.join(KINDS)}",
    ]


def test_the_command_says_each_on_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "job.toml"
    path.write_text('[balance]\nfactor = 2\ngrade = 6.3\n[correction]\nmethod = "dril"\n', encoding="utf-8")
    assert main(["balance", str(path)]) == 3
    assert capsys.readouterr().err.splitlines() == [
        "autobalance: error: job.toml: crankshaft.file is missing",
        "autobalance: error: job.toml: balance.factor is 2; must be 0 to 1",
        "autobalance: error: job.toml: balance.speed_rpm is missing; it must be > 0",
        "autobalance: error: job.toml: correction.method is 'dril'; must be 'shoulder' or 'turn' or 'drill' "
        "or "
        "'slug' or 'add' or 'mill' or 'listed' or a list of them; did you mean 'drill'?",
    ]


def test_an_absent_table_is_one_line() -> None:
    raw = {key: value for key, value in BASE.items() if key != "balance"}
    assert complaint(raw) == ["balance.factor is missing; it must be 0 to 1"]


def test_a_key_a_level_too_high_is_told_its_table() -> None:
    keys = (Key("layout", keys=(Key("bank_deg", float),), default=None), Key("stroke_mm", float, default=1.0))
    with pytest.raises(
        JobError, match=r"^engine.bank_deg is an unknown key; did you mean engine.layout.bank_deg\?$"
    ):
        read({"bank_deg": 60.0}, keys, "engine")
