"""Options that stand for keys of a job, differences of two jobs, and a job in its file's own words."""

from __future__ import annotations

import copy
import math
import re
import shlex
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Final, NamedTuple

from autobalance.correction import KINDS
from autobalance.crank.anatomy import PinHint
from autobalance.errors import JobError, UsageError
from autobalance.job.balance import LISTED, planned_anew
from autobalance.job.layout import located, with_shop
from autobalance.job.model import CrankReadings, Crankshaft
from autobalance.job.read import Job, parse
from autobalance.job.read_crankshaft import described_holes, described_readings
from autobalance.solid.formats.registry import needs_unit
from autobalance.toml_files.document import set_key, toml_text, with_settings
from autobalance.toml_files.typed_units import FILL_IN
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.user_folders import SHOP_FILE

# Options of a command line that stand for keys of a job, and the job that they make of a crank's file.


Options = Mapping[str, Any]
"""Options by the names of `KEYS`; None if an option was left out."""

KEYS: Final[Mapping[str, str]] = {
    "unit": "crankshaft.unit",
    "density_kg_m3": "crankshaft.density_kg_m3",
    "material": "crankshaft.density",
    "rotating_g": "engine.rotating_g.all",
    "reciprocating_g": "engine.reciprocating_g.all",
    "crankpin_g": "engine.crankpin_g.crankpin",
    "rods_per_throw": "engine.rods_per_throw",
    "stroke_mm": "engine.stroke_mm",
    "rod_length_mm": "engine.rod_length_mm",
    "factor": "balance.factor",
    "grade": "balance.grade",
    "speed_rpm": "balance.speed_rpm",
    "method": "correction.method",
}
"""Option → the key of a job that it stands for."""
PLACEHOLDERS: Final[Mapping[str, str]] = {
    "unit": "UNIT",
    "density_kg_m3": "KG_M3",
    "rotating_g": "G",
    "reciprocating_g": "G",
    "crankpin_g": "G",
    "rod_length_mm": "MM",
    "factor": "F",
    "grade": "GRADE",
    "speed_rpm": "RPM",
}
USUAL_METHOD: Final = "drill"
JOB_NAME: Final = "job.toml"
HEADING: Final = "# The job of a command line, {crc:08x}: a copy that was changed is not written over.\n"
HEADED: Final = re.compile(r"# The job of a command line, ([0-9a-f]{8}): .*\n")
WEIGHTS: Final = ("rotating_g", "reciprocating_g")
TARGET: Final = ("factor", "grade", "speed_rpm")
NEEDS: Final[Mapping[str, Sequence[str]]] = {
    "balance": (*WEIGHTS, *TARGET),
    "compare": (*WEIGHTS, *TARGET),
    "study": (*WEIGHTS, *TARGET),
    "forces": (*WEIGHTS, "rod_length_mm", "speed_rpm"),
    "factor": WEIGHTS,
}
"""Command → options that it cannot do without, besides unit and density."""

BOTH_SIGNS = re.compile(r"\d\.\d+,\d|\d,\d+\.\d|\d,\d+,\d")
COMMA = re.compile(r"(?<=\d),(?=\d)")
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def with_decimal_point(text: str, option: str) -> str:
    """Return a typed number with a point for a decimal comma: 134,04 is 134.04.

    Raises
    ------
    JobError
        If it has both signs, so that one would be for thousands.

    Examples
    --------
    >>> with_decimal_point("134,04", "--rotating-g"), with_decimal_point("4.7 oz", "--rotating-g")
    ('134.04', '4.7 oz')
    """
    if BOTH_SIGNS.search(text):
        raise JobError(
            f"{option} is {text!r}, with signs for thousands and decimals; leave out those for thousands"
        )
    return COMMA.sub(".", text)


def typed(value: Any, option: str) -> Any:
    """Return an option as a job has it: a number, or a text with its unit that the job's reader converts."""
    if not isinstance(value, str):
        return value
    text = with_decimal_point(value.strip(), option)
    return float(text) if NUMBER.fullmatch(text) else text


def flag(name: str) -> str:
    """Return the option of a name."""
    return "--" + name.replace("_", "-")


def given(options: Options) -> dict[str, Any]:
    """Return the options that were typed or passed."""
    return {name: value for name, value in options.items() if value is not None}


def refuse_beside_job(options: Options, source: object) -> None:
    """Refuse options that stand for keys of a job beside a job, which has its own.

    Raises
    ------
    UsageError
        With the first such option.
    """
    for name in given(options):
        key = KEYS[name]
        raise UsageError(
            f"{flag(name)} goes with a crank's file; {source} is a job and has {key}:"
            f" --set {key}=... changes it"
        )


def tables_of_options(options: Options, settings: Sequence[str] = ()) -> dict[str, Any]:
    """Return the tables of a job that options and settings stand for, without its crank's file.

    Raises
    ------
    UsageError
        If two options exclude each other.
    JobError
        If a number has thousands separators, or a setting is not ``KEY=VALUE``.
    """
    found = given(options)
    if "density_kg_m3" in found and "material" in found:
        raise UsageError("--density-kg-m3 and --material are both given; leave one out")
    tables: dict[str, Any] = {"crankshaft": {}, "engine": {}, "balance": {}, "correction": {}}
    for name, value in found.items():
        read = _methods(value) if name == "method" else typed(value, flag(name))
        set_key(tables, KEYS[name], read)
    if "crankpin_g" in found:
        tables["crankshaft"]["crankpin_in_file"] = False
    tables["correction"].setdefault("method", USUAL_METHOD)
    return with_settings(tables, settings)


def _methods(value: Any) -> Any:
    names = [each.strip() for each in value.split(",")] if isinstance(value, str) else list(value)
    return names[0] if len(names) == 1 else names


def missing_options(command: str, crank: Path, tables: Mapping[str, Any]) -> list[str]:
    """Return the options that a command on a crank's file still needs beside some tables."""
    needed = ["unit"] if needs_unit(crank) else []
    needed += ["density_kg_m3", *NEEDS[command]]
    absent = [name for name in needed if not _is_there(tables, name)]
    return [name for name in absent if name != "factor" or "original" not in tables]


def _is_there(tables: Mapping[str, Any], name: str) -> bool:
    if name == "density_kg_m3" and "density" in tables.get("crankshaft", {}):
        return True
    if name in WEIGHTS:  # parts by their names, by --set
        return bool(tables.get("engine", {}).get(name))
    table, _, key = KEYS[name].partition(".")
    return key in tables.get(table, {})


def refuse_missing(
    command: str, crank: Path, missing: Sequence[str], options: Options, settings: Sequence[str]
) -> None:
    """Refuse a crank's file without the options that its job needs, with the whole command to type.

    Raises
    ------
    JobError
        That names each of them.
    """
    if missing:
        named = [f"{flag(name)} or --material" if name == "density_kg_m3" else flag(name) for name in missing]
        raise JobError(
            f"{crank}: {', '.join(named)} {'is' if len(named) == 1 else 'are'} missing; type"
            f" `{whole_command(command, crank, missing, options, settings)}`"
        )


def whole_command(
    command: str, crank: Path, missing: Iterable[str], options: Options, settings: Sequence[str]
) -> str:
    """Return a command line with what was typed, and placeholders for what is missing."""
    words = ["autobalance", command, shlex.quote(str(crank))]
    found, absent = given(options), set(missing)
    for name in KEYS:
        if name in found:
            value = found[name]
            text = (
                value if isinstance(value, str) else ",".join(value) if name == "method" else f"{value:.12g}"
            )
            words += [flag(name), shlex.quote(text)]
        elif name in absent:
            words += [flag(name), PLACEHOLDERS[name]]
    return " ".join([*words, *(f"--set {shlex.quote(each)}" for each in settings)])


def with_shop_of(tables: Mapping[str, Any], crank: Path) -> dict[str, Any]:
    """Return tables with those of the shop's file beside the crank; one for all jobs is read with the job."""
    if not (crank.parent / SHOP_FILE).is_file():
        return dict(tables)
    found = dict(with_shop(tables, crank.parent))
    return {**found, "shop": located(found["shop"], crank.parent)}


def job_text(tables: Mapping[str, Any]) -> str:
    """Return tables as a job's file, with a line by which a copy that was changed is known."""
    body = toml_text(tables)
    return HEADING.format(crc=zlib.crc32(body.encode())) + body


def was_changed(path: Path) -> bool:
    """Return whether a file exists that is not as a command wrote it, so that changes would be lost."""
    try:
        head, _, body = path.read_bytes().partition(b"\n")
    except FileNotFoundError:
        return False
    except OSError:
        return True
    found = HEADED.fullmatch(head.decode("utf-8", "replace") + "\n")
    return found is None or int(found[1], 16) != zlib.crc32(body)


def filled_in(tables: Mapping[str, Any], lacks: Iterable[str]) -> dict[str, Any]:
    """Return tables in which keys that were left open are to fill in."""
    return with_settings(tables, [f'{key}="{FILL_IN}"' for key in lacks])


# Differences between two jobs, key by key, in words.


class Difference(NamedTuple):
    """A value that two jobs have differently; None where one of them lacks it."""

    key: str
    was: Any
    now: Any

    def words(self) -> str:
        """Return both values in words.

        Examples
        --------
        >>> Difference("engine.stroke_mm", 50.0, None).words()
        'engine.stroke_mm was 50.0, is not set now'
        """

        def shown(value: Any) -> str:
            return "not set" if value is None else repr(value)

        return f"{self.key} was {shown(self.was)}, is {shown(self.now)} now"


def differences(was: Any, now: Any, key: str = "") -> Iterator[Difference]:
    """Yield the differences between two jobs, or two tables at a key; an empty table counts as missing."""
    if isinstance(was, dict | None) and isinstance(now, dict | None) and was != now:
        was, now = was or {}, now or {}
        for name in [*now, *(each for each in was if each not in now)]:
            yield from differences(was.get(name), now.get(name), f"{key}.{name}" if key else name)
    elif _are_tables(was) and _are_tables(now) and len(was) == len(now):
        for number, (one, other) in enumerate(zip(was, now, strict=True), 1):
            yield from differences(one, other, f"{key}[{number}]")
    elif was != now:
        yield Difference(key, was, now)


def _are_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, dict) for each in value)


# A job as plain values for the report: in the job file's own words, defaults filled in.


def describe(job: Job) -> dict[str, Any]:
    """Return the job as JSON values; None for an optional key that is missing.

    Everything has the units of the job file, so that ``parse`` takes it back once ``file`` and the Nones are
    dropped.
    """
    filled = copy.deepcopy(dict(job.filled))
    for key in job.lacks:
        table, _, name = key.partition(".")
        filled[table][name] = None
    return {"file": str(job.path.resolve()), "crankshaft": _crankshaft(job), **filled}


def _crankshaft(job: Job) -> dict[str, Any]:
    """Return the present table; a crank that is an object is in its place."""
    crank, hints, raw = job.crankshaft, job.crankshaft.overrides, job.raw.get("crankshaft", {})
    weighed = crank.weighed
    densities = {"density_kg_m3": crank.density_g_mm3, "density_pm_kg_m3": crank.density_pm_g_mm3}
    return {
        "file": raw.get("file", None if crank.file is None else str(crank.file)),
        "unit": crank.unit,
        **{
            key: None if density is None else _as_said(raw.get(key), density / G_PER_MM3_PER_KG_M3)
            for key, density in densities.items()
        },
        **_scan(crank, raw),
        **({} if weighed.scan_accuracy_mm is None else {"scan_accuracy_mm": weighed.scan_accuracy_mm}),
        **described_readings(weighed.readings),
        **described_holes(weighed.holes),
        "crankpin_in_file": crank.crankpin_in_file,
        "axis_point_mm": _listed(hints.axis_point_mm),
        "axis_direction": _listed(hints.axis_direction),
        "crankpins": None if hints.crankpins is None else [_pin(pin) for pin in hints.crankpins],
        "main_journals": None if hints.main_journals is None else [_pin(pin) for pin in hints.main_journals],
        "body": crank.body,
    }


def _scan(crank: Crankshaft, raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys that name the crank's scan, where its drawing is cut."""
    if crank.scan is None:
        return {}
    return {"scan_file": raw.get("scan_file", str(crank.scan.file)), "scan_unit": crank.scan.unit}


def _as_said(stated: float | None, now: float) -> float:
    """Return a number in the job's own digits, where it still has the job's value."""
    return float(stated) if stated is not None and math.isclose(stated, now, rel_tol=1e-12) else now


def _pin(pin: PinHint) -> dict[str, Any]:
    return {
        "centre_mm": _listed(pin.centre_mm),
        "diameter_mm": pin.diameter_mm,
        "width_mm": pin.width_mm,
    }


def _listed(values: Any) -> list[float] | None:
    return None if values is None else [float(value) for value in values]


# A job for ``recut``, with separate defaults.


USUAL_PREFERENCE = "simple"
"""Secondary objective of `balance` if a job sets no objective."""


def for_recut(job: Job, correction: Mapping[str, Any] | None) -> Job:
    """Return the job of a further stage, with the reading's ``[correction]``, if any, in place of the job's.

    Earlier set-ups are used first (``prefer = "same_setup"``), and existing holes may be deepened, unless the
    table sets otherwise. A report has ``"simple"`` if its job had no setting.
    """
    table = dict(job.raw["correction"] if correction is None else correction)
    if table.get("prefer", USUAL_PREFERENCE) == USUAL_PREFERENCE and (
        correction is None or "prefer" not in correction
    ):
        table["prefer"] = "same_setup"
    if table.get("method") in (LISTED, [LISTED]):
        table = planned_anew(table)
    method = table.get("method", [])
    for name in [method] if isinstance(method, str) else method:
        if name in KINDS and any(each.name == "deepen" for each in fields(KINDS[name].limits)):
            own = table.get(name) or {}
            table[name] = {**own, "deepen": True} if own.get("deepen") is None else own
    again = parse({**job.raw, "correction": table}, job.path, crank_given=True)
    # a scale, a micrometer and a scanner saw the crank before it was cut
    crankshaft = replace(job.crankshaft, readings=CrankReadings(), scan=None)
    # with external parts that were solved, and the oil of the crank as it came
    engine = replace(again.engine, attached=job.engine.attached, oil=job.engine.oil)
    return replace(again, settings=job.settings, crankshaft=crankshaft, engine=engine)
