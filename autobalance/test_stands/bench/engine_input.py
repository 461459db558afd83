"""``BENCH.toml`` of a whole engine: its job, speeds, and the cranks to try in it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.declare import POSITIVE, SHARE, Key, Values
from autobalance.errors import JobError
from autobalance.toml_files.keys import read_document
from autobalance.value_classes import dataclass

ENGINE = (
    Key("job", str, "job of the engine, with [cycle]; relative to this file"),
    Key("speeds_rpm", tuple[float, ...], "speeds held; default the job's", POSITIVE, None),
    Key("run_up_rpm", tuple[float, float], "first and last speed of a run-up without load", POSITIVE, None),
)
VARIANT = (
    Key("name", str, "name", default=""),
    Key("crank", str, "crank file that replaces the job's", default=None),
    Key("factor", float, "an ideal crank of this factor in place of its unbalance", SHARE, None),
    Key("set", tuple[str, ...], 'keys of the job: "cycle.flywheel_kg_mm2=2000"', default=()),
)
ENGINE_BENCH_KEYS = (
    Key("engine", says="a whole engine on the stand", keys=ENGINE),
    Key(
        "variant",
        says="cranks to try; default: as it is, and the usual factors",
        keys=VARIANT,
        many=True,
        default=(),
    ),
)
USUAL_FACTORS = (0.0, 0.28, 0.5, 0.64, 1.0)
MOST_POINTS = 1000


@dataclass(frozen=True)
class Variant:
    """A crank in the engine: another file, an ideal factor, changed keys of the job."""

    name: str
    crank: Path | None = None
    factor: float | None = None
    settings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class EngineBench:
    """The file; ``speeds_rpm`` None: the job's own."""

    values: Values
    job: Path
    speeds_rpm: tuple[float, ...] | None
    run_up_rpm: tuple[float, float] | None
    variants: tuple[Variant, ...]


def read_engine_bench(source: str | Path | Mapping[str, Any]) -> EngineBench:
    """Read the bench file of a whole engine, or its structure (files relative to the working folder).

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible.
    """
    folder = Path() if isinstance(source, Mapping) else Path(source).parent

    def bench(values: Values) -> EngineBench:
        return _engine_bench(values, folder)

    return read_document(source, "bench file", ENGINE_BENCH_KEYS, bench)


def _engine_bench(values: Values, folder: Path) -> EngineBench:
    engine = values["engine"]
    run_up = engine["run_up_rpm"]
    if run_up is not None and not run_up[0] < run_up[1]:
        raise JobError(
            f"engine.run_up_rpm is [{run_up[0]:g}, {run_up[1]:g}]; the first must be the lower one"
        )
    if engine["speeds_rpm"] == ():
        raise JobError("engine.speeds_rpm is an empty list; expected at least one speed")
    if not values["variant"]:
        values["variant"] = [{"name": "as it is", "crank": None, "factor": None, "set": ()}]
        values["variant"] += [
            {"name": f"factor {factor:g}", "crank": None, "factor": factor, "set": ()}
            for factor in USUAL_FACTORS
        ]
    if len(values["variant"]) * len(engine["speeds_rpm"] or (1,)) > MOST_POINTS:
        raise JobError(f"more than {MOST_POINTS} variants and speeds; list fewer")
    variants = tuple(
        Variant(
            each["name"] or f"variant {number}",
            None if each["crank"] is None else folder / each["crank"],
            each["factor"],
            each["set"],
        )
        for number, each in enumerate(values["variant"], 1)
    )
    names = [each.name for each in variants]
    for name in names:
        if names.count(name) > 1:
            raise JobError(f"two variants are called {name!r}; give each its own name")
    return EngineBench(values, folder / engine["job"], engine["speeds_rpm"], run_up, variants)
