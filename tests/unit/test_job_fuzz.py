"""Job files nobody meant to write: each is a job, or one clear line. ``make fuzz`` tries more of them."""

from __future__ import annotations

import copy
import datetime
import json
import os
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from autobalance import job
from autobalance.drawn_cranks.input import read_design
from autobalance.errors import AutobalanceError
from tests import jobs

EXAMPLES = int(os.environ.get("AUTOBALANCE_FUZZ", "30"))
FULL = (jobs.BUNDLED / "drafted" / "factor-original.toml").read_text(encoding="utf-8")
RAW = tomllib.loads(
    FULL[: FULL.index("faces = ")]
    + """faces = ["w1-a", [1.0, 2.0, 3.0]]
sector_deg = [120, 240]
depth_tolerance_mm = 0.02

[correction.drill]
diameters_mm = [8.0, 10.0]
point_angle_deg = 118.0
min_depth_mm = 2.0
max_depth_mm = 25.0
depth_step_mm = 0.1
max_holes = 6
min_wall_mm = 3.0
min_spacing_mm = 3.0
sectors_deg = [[150, 210]]

[correction.slug]
lengths_mm = [12.7]
density_kg_m3 = 17000.0
max_slugs = 4

[correction.turn]
min_radius_mm = 45.0
depth_step_mm = 0.1

[engine.layout]
bank_deg = [0.0]

[engine.rod]
big_end_g = 300.0
small_end_g = 100.0

[[engine.throw]]
number = 1
rods = 1
rotating_g = { big_end = { g = 3.0, pm = 0.1 } }

[[engine.attached]]
name = "flywheel"
mass_g = 1200.0
unbalance_g_mm = [250.0, 0.0]
z_mm = 80.0

[[shafts]]
order = 1
sense = "backward"
product_g_mm = 3500.0
"""
)
NUMBERS = st.one_of(
    st.integers(),
    st.integers(-(10**400), 10**400),
    st.floats(),
    st.sampled_from([0, -0.0, 1e308, -1e308, 5e-324, 1e-300, 2**63, -(2**63), 10**30]),
)
TEXTS = st.one_of(
    st.text(max_size=8), st.sampled_from(["auto", "all", "original", "../../x", "/", "\0", "nan"])
)
VALUES = st.recursive(
    st.one_of(NUMBERS, TEXTS, st.booleans(), st.dates(), st.just(datetime.time(1, 2))),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=6), inner, max_size=3)
    ),
    max_leaves=6,
)


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the path of every value within tables and lists."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, item in inner for found in places(item, (*path, key)))]


PLACES = places(RAW)[1:]


@st.composite
def changed(draw: st.DrawFn) -> dict[str, Any]:
    """Draw the bundled job with a few values replaced, taken away or added."""
    raw: Any = copy.deepcopy(RAW)
    for path in draw(st.lists(st.sampled_from(PLACES), min_size=1, max_size=3)):
        inner = raw
        try:
            for key in path[:-1]:
                inner = inner[key]
            match draw(st.sampled_from(["replace", "take", "add"])):
                case "replace":
                    inner[path[-1]] = draw(VALUES)
                case "take":
                    del inner[path[-1]]
                case "add":
                    inner[draw(TEXTS)] = draw(VALUES)
        except (KeyError, IndexError, TypeError):  # an earlier change took the way there
            continue
    assert isinstance(raw, dict)
    return raw


def complaint(read: Callable[[], object]) -> str:
    """Return what is wrong; nothing where nothing is. Any error but the program's own goes through."""
    try:
        read()
    except AutobalanceError as error:
        return str(error) or "an error without words\n"
    return ""


def is_one_line(text: str) -> bool:
    return "\n" not in text and len(text) < 2000


def described(found: job.Job) -> str:
    return json.dumps(job.describe(found), allow_nan=False)


@settings(max_examples=5 * EXAMPLES, deadline=None)
@given(raw=changed())
@example(raw={"two\nlines": 1})
@example(raw={"x" * 5000: 1})
@example(raw={**RAW, "balance": {**RAW["balance"], "grade": 1e100}})
@example(raw={**RAW, "balance": {**RAW["balance"], "grade": 5e-324}})
def test_changed_jobs_are_jobs_or_one_clear_error(raw: dict[str, Any]) -> None:
    assert is_one_line(complaint(lambda: described(job.parse(raw, Path("folder/job.toml")))))


@settings(max_examples=5 * EXAMPLES, deadline=None)
@given(
    edits=st.lists(
        st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 40), st.binary(max_size=6)), max_size=4
    )
)
def test_damaged_jobs_are_jobs_or_one_clear_error(
    edits: list[tuple[float, int, bytes]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    data = FULL.encode()
    for where, length, new in edits:
        at = int(where * len(data))
        data = data[:at] + new + data[at + length :]
    path = tmp_path_factory.getbasetemp() / "damaged.toml"
    path.write_bytes(data)
    assert is_one_line(complaint(lambda: described(job.load(path))))


@settings(max_examples=2 * EXAMPLES, deadline=None)
@given(data=st.one_of(st.binary(max_size=200), st.text(max_size=200).map(lambda text: text.encode())))
@example(data=b"[" * 100_000)
@example(data=b"a = " + b"[" * 100_000)
@example(data=b"a = " + b"{a=" * 100_000)
@example(data=b"a" + b".a" * 5_000 + b" = 1")
@example(data=b"a = " + b"9" * 100_000)
@example(data=b"a = 1e99999")
@example(data=b"\xef\xbb\xbf\xff")
def test_any_bytes_are_one_clear_error(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_bytes(data)
    assert is_one_line(complaint(lambda: described(job.load(path))))
    text = data.decode("utf-8", "replace")
    assert is_one_line(complaint(lambda: read_design(text, "any.toml")))
