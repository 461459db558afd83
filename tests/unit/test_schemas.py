"""Every schema is one, and allows what the program reads and writes."""

from __future__ import annotations

import json
from typing import Any

import jsonschema
import pytest

import autobalance as ab
from autobalance.bundled import bundled_folder
from autobalance.command import main
from autobalance.errors import UsageError
from autobalance.verbs.schema import NAMES

TRIALS: dict[str, Any] = {
    "initial": [[8.5, 60.0], [6.5, 205.0]],
    "trial": [{"plane": 1, "g_mm": 10.0, "angle_deg": 0.0, "readings": [[6.0, 125.0], [4.5, 230.0]]}],
}
MACHINE: dict[str, Any] = {
    "kind": "hard",
    "speed_rpm": 600.0,
    "planes_mm": [-40.0, 40.0],
    "rotor": {"mass_g": 1000.0, "z_mm": 0.0},
}


@pytest.mark.parametrize("name", NAMES)
def test_every_schema_is_one(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", name]) == 0
    printed = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator.check_schema(printed)
    assert printed == ab.schema(name)


def test_names_stand_one_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    assert capsys.readouterr().out.split("\n") == [*NAMES, ""]
    with pytest.raises(UsageError, match="does not exist; choose one of job"):
        ab.schema("jobb")


def test_what_is_read_and_written_fits() -> None:
    for value, name in (
        (TRIALS, "trials"),
        (ab.influence(TRIALS).report, "influence"),
        (MACHINE, "machine"),
        (json.loads(ab.machine(MACHINE).json()), "machine-report"),
    ):
        jsonschema.Draft202012Validator(ab.schema(name)).validate(value)


def test_bundled_jobs_fit() -> None:
    import tomllib

    validator = jsonschema.Draft202012Validator(ab.schema("job"))
    for path in sorted((bundled_folder() / "crf250r" / "drafted").glob("*.toml")):
        validator.validate(tomllib.loads(path.read_text(encoding="utf-8")))
