"""What a report says of its job and of its crank's file is held against its cuts and the file there."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests import jobs


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a drilled crank whose job file is no longer there."""
    folder = tmp_path_factory.mktemp("drilled")
    job = jobs.whole_job(folder / "in", method='"drill"', faces="")
    jobs.computed(job, folder / "out")
    job.unlink()
    return folder


def drilled_with_another_point(report: dict[str, Any]) -> None:
    report["job"]["correction"]["drill"]["point_angle_deg"] = 123.9


def of_another_file(report: dict[str, Any]) -> None:
    report["input"]["file"] = "../in/nowhere.stl"


@pytest.mark.parametrize(
    ("edit", "why"),
    [
        (drilled_with_another_point, "point_angle_deg is 123.9, but corrections"),
        (of_another_file, "input.file is '../in/nowhere.stl', but the job's crank is 'crank"),
    ],
)
def test_an_edit_is_refused(
    edit: Callable[[dict[str, Any]], None],
    why: str,
    result: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    shutil.copytree(result, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "out" / "report.json"
    assert jobs.run("verify", path) == 0
    report = json.loads(path.read_text(encoding="utf-8"))
    edit(report)
    path.write_text(json.dumps(report), encoding="utf-8")
    capsys.readouterr()
    assert jobs.run("verify", path) == 3
    assert why in capsys.readouterr().err
