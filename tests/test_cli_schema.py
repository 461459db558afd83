"""Schemas for editors, and scripts that complete what is typed."""

import tomllib

import pytest
from jsonschema import Draft202012Validator

import autobalance as ab
from tests import jobs

JOBS = sorted(jobs.BUNDLED.rglob("*.toml")) + sorted((jobs.ROOT / "examples").glob("*-job.toml"))


def test_every_name_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """Each is printed, and checked, in tests/unit/test_schemas.py."""
    assert jobs.run("schema") == 0
    names = capsys.readouterr().out.split()
    assert {"job", "reading", "trials", "machine", "report", "inspect", "recut"} <= set(names)
    assert jobs.run("schema", "jobz") == 2
    assert "choose one of job, reading" in capsys.readouterr().err


@pytest.mark.parametrize("path", JOBS, ids=lambda path: path.stem)
def test_jobs_that_run_are_within_their_schema(path: object) -> None:
    values = tomllib.loads(path.read_text("utf-8"))  # type: ignore[attr-defined]
    Draft202012Validator(ab.schema("job")).validate(values)


def test_what_the_schema_refuses_the_program_refuses() -> None:
    validator = Draft202012Validator(ab.schema("job"))
    good = tomllib.loads((jobs.BUNDLED / "drafted" / "factor-0.28.toml").read_text("utf-8"))
    wrong = [
        {**good, "balanse": {}},
        {**good, "balance": {**good["balance"], "factor": 1.5}},
        {**good, "balance": {**good["balance"], "grade": 0}},
        {**good, "crankshaft": {**good["crankshaft"], "unit": "ft"}},
        {**good, "crankshaft": {**good["crankshaft"], "density": 1}},
        {**good, "correction": {"method": "grind"}},
        {**good, "correction": {"method": []}},
        {**good, "correction": {"method": "drill", "drill": {"diameter": [8]}}},
        {**good, "engine": {**good["engine"], "rods_per_throw": 0}},
    ]
    for values in wrong:
        assert not validator.is_valid(values)
        with pytest.raises(ab.AutobalanceError):
            ab.Job.from_dict(values, jobs.BUNDLED / "drafted")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completions_know_commands_and_options(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("completion", shell) == 0
    script = capsys.readouterr().out
    assert "balance" in script
    assert "no-report" in script
