"""Whole runs of jobs with impossible numbers: a verdict or one clear line, never a traceback."""

from __future__ import annotations

import copy
import json
import math
import os
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests import jobs

EXAMPLES = max(5, int(os.environ.get("AUTOBALANCE_FUZZ", "60")) // 10)
RAW = tomllib.loads(
    (jobs.BUNDLED / "drafted" / "factor-original.toml").read_text(encoding="utf-8")
    + """
[[engine.attached]]
name = "flywheel"
mass_g = 1200.0
unbalance_g_mm = [2.0, 0.0]
z_mm = 80.0
"""
)
NUMBERS: list[Any] = [
    0,
    -1.0,
    5e-324,
    1e-300,
    1e-9,
    0.5,
    1,
    2,
    100,
    1e5,
    1e9,
    -1e9,
    1e12,
    1e100,
    1e308,
    -1e308,
]
KEYS = [
    ("crankshaft", "density_kg_m3"),
    ("crankshaft", "density_pm_kg_m3"),
    ("crankshaft", "unit"),
    ("crankshaft", "axis_point_mm"),
    ("crankshaft", "axis_direction"),
    ("engine", "stroke_mm"),
    ("engine", "rod_length_mm"),
    ("engine", "rods_per_throw"),
    ("engine", "rotating_g", "big_end_bearing"),
    ("engine", "reciprocating_g", "piston"),
    ("engine", "crankpin_g", "crankpin"),
    ("engine", "attached", 0, "mass_g"),
    ("engine", "attached", 0, "pm_g_mm"),
    ("engine", "attached", 0, "z_mm"),
    ("original", "reciprocating_g", "piston"),
    ("original", "crankpin_g", "crankpin"),
    ("balance", "factor"),
    ("balance", "grade"),
    ("balance", "speed_rpm"),
    ("balance", "margin"),
    ("balance", "rotor_mass_g"),
    ("balance", "tolerance_planes_mm"),
    ("balance", "overbalance_g_mm"),
    ("correction", "method"),
    ("correction", "max_depth_mm"),
    ("correction", "min_wall_mm"),
    ("correction", "depth_tolerance_mm"),
    ("correction", "sector_deg"),
    ("correction", "drill", "diameters_mm"),
    ("correction", "drill", "max_holes"),
    ("correction", "drill", "depth_step_mm"),
    ("correction", "slug", "max_slugs"),
    ("correction", "slug", "density_kg_m3"),
    ("correction", "turn", "min_radius_mm"),
]
WORDS: dict[str, list[Any]] = {
    "unit": ["mm", "cm", "m", "inch"],
    "margin": ["none", "expanded"],
    "method": ["shoulder", "turn", "drill", "slug", "add", ["turn", "drill"]],
}
LISTS = {
    "axis_point_mm": 3,
    "axis_direction": 3,
    "tolerance_planes_mm": 2,
    "sector_deg": 2,
    "diameters_mm": 1,
}


@st.composite
def changes(draw: st.DrawFn) -> list[tuple[tuple[Any, ...], Any]]:
    """Draw keys and what to put there."""
    found = []
    for path in draw(st.lists(st.sampled_from(KEYS), min_size=1, max_size=3, unique=True)):
        number = st.sampled_from(NUMBERS)
        if path[-1] in LISTS:
            value = draw(st.lists(number, min_size=LISTS[path[-1]], max_size=LISTS[path[-1]]))
        else:
            value = draw(st.sampled_from(WORDS.get(str(path[-1]), NUMBERS)))
        found.append((path, value))
    return found


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


@pytest.mark.slow
@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck))
@given(changed=changes())
@example(changed=[(("engine", "reciprocating_g", "piston"), 1e100)])
@example(changed=[(("balance", "speed_rpm"), 5e-324)])
@example(changed=[(("balance", "speed_rpm"), 1e308)])
@example(changed=[(("balance", "rotor_mass_g"), 1e-300)])
@example(changed=[(("balance", "rotor_mass_g"), 1e-9), (("balance", "grade"), 1e-9)])
@example(changed=[(("crankshaft", "axis_direction"), [1e100, 1e100, 1e308])])
@example(changed=[(("crankshaft", "axis_point_mm"), [1e-300, 1e308, -5.0])])
@example(changed=[(("original", "reciprocating_g", "piston"), 1e308)])
@example(changed=[(("engine", "attached", 0, "z_mm"), 1e100)])
@example(changed=[(("correction", "drill", "depth_step_mm"), 5e-324)])
def test_a_run_on_impossible_numbers(
    changed: list[tuple[tuple[Any, ...], Any]],
    tmp_path_factory: pytest.TempPathFactory,
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder = tmp_path_factory.mktemp("run")
    jobs.bundled_job(folder)
    raw: Any = copy.deepcopy(RAW)
    for path, value in changed:
        inner = raw
        for key in path[:-1]:
            inner = inner.setdefault(key, {}) if isinstance(inner, dict) else inner[key]
        inner[path[-1]] = value
    job = folder / "run.toml"
    job.write_text("\n".join(f"{key} = {toml(value)}" for key, value in raw.items()), encoding="utf-8")
    code = jobs.run("balance", job, "-o", folder / "out", "--no-report")
    said = capsys.readouterr()
    if code == 3:
        faults = said.err.splitlines()  # a line each
        assert faults
        assert all(line.startswith("autobalance: error: ") for line in faults)
        assert not (folder / "out").exists()
    else:
        assert code in (0, 4)
        report = jobs.report_of(folder / "out")
        assert (report["outcome"] == "above_tolerance") == (code == 4)
        assert jobs.run("verify", folder / "out" / "report.json") == code
        capsys.readouterr()
    shutil.rmtree(folder)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("finished")
    return folder / "out", jobs.balanced(jobs.bundled_job(folder), folder / "out")


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the path of every value within objects and lists."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, item in inner for found in places(item, (*path, key)))]


CLAIMS: list[Any] = [None, True, 0, -1, 1e30, -1e29, 1e308, 5e-324, 10**400, math.nan, "", "x", "../x"]
CLAIMS += [[], {}, [1, 2], [1, 2, 3], [[]], {"a": 1}]


@pytest.mark.slow
@settings(max_examples=5 * EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    changes=st.lists(
        st.tuples(st.floats(0, 1, exclude_max=True), st.sampled_from(CLAIMS)),
        min_size=1,
        max_size=2,
    )
)
def test_verify_of_a_changed_report(
    changes: list[tuple[float, Any]],
    finished: tuple[Path, dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder, report = finished
    values: Any = copy.deepcopy(report)
    every = places(report)[1:]
    for where, value in changes:
        path, inner = every[int(where * len(every))], values
        try:
            for key in path[:-1]:
                inner = inner[key]
            inner[path[-1]] = value
        except (KeyError, IndexError, TypeError):  # an earlier change took the way there
            continue
    (folder / "report.json").write_text(json.dumps(values), encoding="utf-8")
    code = jobs.run("verify", folder / "report.json")
    assert code in (0, 3)
    said = capsys.readouterr().err
    assert code == 0 or said.count("\n") == 1
