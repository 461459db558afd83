"""The command ``batch``: many jobs, whatever happens to the processes that do them."""

from __future__ import annotations

import csv
import itertools
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from autobalance.command import main
from autobalance.errors import FileError, JobError
from autobalance.studies.batch.input import read_batch_list
from autobalance.studies.batch.journal import held
from autobalance.studies.batch.verb import batch
from tests.cranks import Shape, make_crank
from tests.jobs import ROOT
from tests.worker_tasks import DEADLY, balance_unless_deadly

pytestmark = pytest.mark.usefixtures("cranks_read_once")

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.rotating_g]
rod = 300.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = 0.5
grade = 16
speed_rpm = 6000
judge = "static"
[correction]
method = "turn"
"""


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a crank, its job and a list of five rows, two of which fail."""
    from autobalance.solid.formats.write import encode

    folder = tmp_path_factory.mktemp("batch")
    solid, _ = make_crank([0.0], Shape(segments=48))
    (folder / "crank.stl").write_bytes(encode(solid.mesh, "stl", 1.0))
    (folder / "job.toml").write_text(JOB, "utf-8")
    (folder / "list.csv").write_text(
        "name;job;crank;balance.factor\nhalf;job.toml;;0.5\nless;job.toml;crank.stl;0.45\n"
        "no crank;job.toml;missing.stl;\nmuch;job.toml;;1.0\nwrong;job.toml;;7\n",
        "utf-8",
    )
    return folder


@pytest.fixture(scope="module")
def whole(work: Path) -> Path:
    """The results of the list, done in one go by one process."""
    batch(work / "list.csv", work / "whole", workers=1)
    return work / "whole"


def table(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / "results.csv").read_text("utf-8").splitlines()))


def journal(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "journal.jsonl").read_text("utf-8").splitlines()]


def test_each_row_has_its_result(whole: Path) -> None:
    rows = table(whole)
    assert [row["name"] for row in rows] == ["half", "less", "no_crank", "much", "wrong"]
    assert [row["exit_code"] for row in rows[2:5:2]] == ["3", "3"]
    assert rows[2]["message"].endswith("missing.stl does not exist")
    assert "balance.factor is 7; must be 0 to 1" in rows[4]["message"]
    assert list(rows[0])[-1] == "balance.factor"
    for row in (rows[0], rows[1], rows[3]):
        report = json.loads((whole / "rows" / row["name"] / "report.json").read_text("utf-8"))
        assert row["outcome"] == report["outcome"]
        assert float(row["residual_g_mm"]) == report["residual"]["magnitude_g_mm"]
        solid = report["outputs"]["solid"]
        assert row["solid_sha256"] == ("" if solid is None else solid["sha256"])
        assert main(["verify", str(whole / "rows" / row["name"] / "report.json")]) == int(row["exit_code"])
    assert sorted(line["row"] for line in journal(whole)) == [1, 2, 3, 4, 5]
    assert (whole / "results.xlsx").stat().st_size > 0
    page = (whole / "summary.html").read_text("utf-8")
    assert "missing.stl" in page
    places = [float(x) for x in re.findall(r'<text x="([\d.]+)" y="205" text-anchor="middle">', page)]
    assert len(places) >= 4
    assert min(b - a for a, b in itertools.pairwise(places)) > 25.0  # no number stands on another


@pytest.mark.skipif("AUTOBALANCE_SHAKEN" in os.environ, reason="holds two processes to the last digit")
def test_a_row_is_what_balance_gives(work: Path, whole: Path) -> None:
    assert main(["balance", str(work / "job.toml"), "--no-report", "-o", str(work / "alone")]) in (0, 4)
    name = "balanced.stl"
    assert (work / "alone" / name).read_bytes() == (whole / "rows" / "half" / name).read_bytes()


def test_what_is_done_is_taken_over(work: Path, whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (whole / "results.csv").read_bytes()
    stamp = (whole / "rows" / "less" / "report.json").stat().st_mtime_ns
    (whole / "rows" / "half" / "balanced.stl").write_bytes(b"spoilt")
    with (whole / "journal.jsonl").open("a") as stream:
        stream.write('{"row": 9, "name": "cut o')
    assert main(["batch", str(work / "list.csv"), "-o", str(whole), "--workers", "1", "--json", "-"]) == 4
    found = json.loads(capsys.readouterr().out)
    assert (found["rows"], found["taken_over"], found["failed"], found["lost"]) == (5, 4, 2, 0)
    assert (whole / "results.csv").read_bytes() == before
    assert (whole / "rows" / "less" / "report.json").stat().st_mtime_ns == stamp
    assert sorted(line["row"] for line in journal(whole)) == [1, 2, 3, 4, 5]


def test_after_a_kill_the_rest_is_done_as_if_nothing_had_happened(work: Path, whole: Path) -> None:
    killed = work / "killed"
    command = [sys.executable, "-m", "autobalance", "batch", str(work / "list.csv"), "-o", str(killed)]
    process = subprocess.Popen([*command, "--workers", "2"], cwd=ROOT, start_new_session=True)
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline and process.poll() is None:
        path = killed / "journal.jsonl"
        if path.exists() and any('"exit_code": 3' not in line for line in path.read_text().splitlines()):
            break
        time.sleep(0.02)
    workers = _children(process.pid)
    process.kill()
    process.wait()
    assert _ended(workers)
    done = {line["name"]: line["finished"] for line in journal(killed)}
    result = batch(work / "list.csv", killed, workers=1).report
    assert result["taken_over"] == len(done)
    assert (killed / "results.csv").read_bytes() == (whole / "results.csv").read_bytes()
    again = {line["name"]: line["finished"] for line in journal(killed)}
    assert len(again) == len(journal(killed)) == 5
    assert all(again[name] == finished for name, finished in done.items())


def _children(pid: int) -> list[int]:
    found = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(word) for word in found.read_text().split()] if found.exists() else []


def _ended(pids: list[int]) -> bool:
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        if not any(_runs(pid) for pid in pids):
            return True
        time.sleep(0.05)
    return False


def _runs(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{pid}/stat")
    return not (state.exists() and state.read_text().split(") ")[1].startswith("Z"))


def test_a_folder_of_cranks_for_one_job(work: Path, tmp_path: Path) -> None:
    (tmp_path / "series").mkdir()
    for name in ("b 2.stl", "a.stl"):
        (tmp_path / "series" / name).write_bytes((work / "crank.stl").read_bytes())
    rows = read_batch_list(tmp_path / "series", work / "job.toml").rows
    assert [(row.name, row.crank) for row in rows] == [("a", "a.stl"), ("b_2", "b 2.stl")]
    assert rows[0].read().crankshaft.file == work / os.path.relpath(tmp_path / "series" / "a.stl", work)
    assert [row.name for row in read_batch_list(work).rows] == ["job"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("job\n", "has no rows"),
        ("job,colour\njob.toml,red\n", "unknown column 'colour'"),
        ("job,balance.factr\njob.toml,0.5\n", "unknown column 'balance.factr'"),
        ("job,name\njob.toml,a/b\njob.toml,a b\n", "are both named 'a_b'"),
        ("name\nfirst\n", "names no job"),
    ],
)
def test_what_is_no_list_is_refused(work: Path, tmp_path: Path, text: str, said: str) -> None:
    (work / "bad.csv").write_text(text, "utf-8")
    with pytest.raises(JobError, match=said):
        batch(work / "bad.csv", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "place",
    [
        "o/rows/half/report.json",
        "o/rows/x.json",
        "o/results.csv",
        "./o/journal.jsonl",
        "list.csv",
        "job.toml",
        "crank.stl",
    ],
)
def test_the_report_takes_no_place_of_a_result_or_a_row(
    place: str,
    work: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is refused before anything is done: a balanced solid was written over, with exit code 0 or 4."""
    for name in ("crank.stl", "job.toml", "list.csv"):
        (tmp_path / name).write_bytes((work / name).read_bytes())
    monkeypatch.chdir(tmp_path)
    assert main(["batch", "list.csv", "-o", "o", "--workers", "1", "--json", place]) == 2
    printed = capsys.readouterr().err
    assert place in printed
    assert printed.count("\n") == 1
    assert not Path("o").exists()
    for name in ("crank.stl", "job.toml", "list.csv"):
        assert Path(name).read_bytes() == (work / name).read_bytes()


def test_a_folder_that_is_held_is_refused(work: Path, tmp_path: Path) -> None:
    with held(tmp_path), pytest.raises(FileError, match="is held by another batch"):
        batch(work / "list.csv", tmp_path, workers=1)


def test_an_interrupt_ends_with_130(work: Path, tmp_path: Path) -> None:
    rows = "".join(f"r{number},job.toml,0.{300 + number}\n" for number in range(60))  # none ends before it
    (work / "sixty.csv").write_text(f"name,job,balance.factor\n{rows}", "utf-8")
    command = [sys.executable, "-m", "autobalance", "batch", str(work / "sixty.csv"), "-o"]
    command.append(str(tmp_path / "o"))
    process = subprocess.Popen([*command, "--workers", "1"], cwd=ROOT, stderr=subprocess.PIPE)
    while not (tmp_path / "o" / "journal.jsonl").exists():
        time.sleep(0.02)
    workers = _children(process.pid)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert b"Traceback" not in said
    assert _ended(workers)


def test_a_row_whose_worker_dies_each_time_is_lost_and_the_others_are_done(
    work: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from autobalance.studies.batch import run as batch_row

    monkeypatch.setattr(batch_row, "balance_row", balance_unless_deadly)
    (work / "deadly.csv").write_text(
        f"name,job,balance.factor\nfirst,job.toml,0.5\nkiller,job.toml,{DEADLY}\n", "utf-8"
    )
    result = batch(work / "deadly.csv", tmp_path / "out", workers=1)
    assert result.exit_code == 4
    assert (result.report["within"], result.report["lost"]) == (1, 1)
    first, killer = table(tmp_path / "out")
    assert (first["outcome"], killer["outcome"], killer["exit_code"]) == ("within_tolerance", "lost", "1")
    assert killer["message"] == "its worker died on each of 3 tries"
    lines = {line["name"]: line for line in journal(tmp_path / "out")}
    assert (lines["killer"]["exit_code"], lines["killer"]["try"]) == (1, 3)
    monkeypatch.undo()
    again = batch(work / "deadly.csv", tmp_path / "out", workers=1, fresh=True).report
    assert (again["taken_over"], again["lost"]) == (0, 0)


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_same_bits(work: Path, whole: Path) -> None:
    """Those of one process, though a worker of two is killed when the first row is done."""
    script = [sys.executable, "-m", "tests.cluster_run", str(work / "list.csv"), str(work / "cluster")]
    run = subprocess.run(script, cwd=ROOT, check=True, capture_output=True, text=True, timeout=300)
    said = json.loads(run.stdout.splitlines()[-1])
    assert said["ends"] == [[0, False, 1], [1, False, 1], [2, True, 3], [3, False, 1], [4, False, 1]]
    assert re.search(r"worker tcp://.* has autobalance .*; expected 0\.0\.other", said["version"])
    assert (work / "cluster" / "results.csv").read_bytes() == (whole / "results.csv").read_bytes()
    assert sorted(line["row"] for line in journal(work / "cluster")) == [1, 2, 3, 4, 5]


def test_reports_name_their_files_from_where_they_lie_wherever_the_worker_was(
    work: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker with another working folder writes the same; crank and job are found from the report."""
    from autobalance.studies.batch import run as batch_row
    from autobalance.studies.batch.input import read_batch_list
    from autobalance.studies.batch.run import _Tasks, _Todo

    monkeypatch.chdir(work)
    row = read_batch_list(Path("list.csv"), None).rows[0]
    job = row.read()
    assert job.crankshaft.file is not None
    tasks = _Tasks([_Todo(row, job, job.crankshaft.file, "")], ("json",), Path("out"))
    task = tasks[0]
    here = json.loads(batch_row.balance_row(task).files["report.json"])
    monkeypatch.chdir(tmp_path)
    there = json.loads(batch_row.balance_row(task).files["report.json"])
    for report in (here, there):
        del report["seconds"]
    assert there == here
    place = work / "out" / "rows" / row.name
    assert (place / here["input"]["file"]).resolve() == (work / job.crankshaft.file).resolve()
    assert (place / here["job"]["file"]).resolve() == (work / row.job_file).resolve()
    assert not Path(here["job"]["file"]).is_absolute()
