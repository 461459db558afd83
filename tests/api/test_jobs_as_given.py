"""A verb takes a job as it comes: read, by its file's path, or as a dict."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from tests import jobs
from tests.web_app import small

JOB = jobs.WITH_PIN.replace("crank-with-pin.stl", small.NAME).replace(
    "[engine.rotating_g]", "[engine]\nrod_length_mm = 110.0\n[engine.rotating_g]"
)


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("given")
    small.crank(folder)
    path = folder / "job.toml"
    path.write_text(JOB, encoding="utf-8")
    return path


@pytest.mark.parametrize("verb", [ab.balance, ab.forces, ab.shafts, ab.parts], ids=lambda verb: verb.__name__)
def test_a_path_a_dict_and_a_job_are_one(verb: Callable[..., Any], job: Path) -> None:
    values = tomllib.loads(JOB)
    values["crankshaft"]["file"] = str(job.with_name(small.NAME))
    found = [verb(each).report for each in (job, str(job), ab.read_job(job), values)]
    alike = [{k: v for k, v in each.items() if k not in ("seconds", "job", "input")} for each in found]
    assert len(alike[0]) > 3
    assert all(each == alike[0] for each in alike[1:])
