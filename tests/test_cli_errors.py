"""Wrong files, jobs and folders: one clear line, the right exit code, nothing left, old results kept."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pytest

from autobalance import command
from autobalance.balancing import loop
from autobalance.balancing.measured_crank import measure_crank
from autobalance.errors import FileError
from autobalance.report.balance import values
from autobalance.report.files import Staging
from autobalance.solid.mesh.measure import soup_moments
from tests import jobs
from tests.watched import interrupted_in

Spoil = Callable[[Path], None]
"""Makes something wrong in the folder of a job."""


def replaced(data: bytes) -> Spoil:
    def spoil(folder: Path) -> None:
        (folder / "crank.stl").write_bytes(data)

    return spoil


def edited(edit: Callable[[bytes], bytes]) -> Spoil:
    def spoil(folder: Path) -> None:
        path = folder / "crank.stl"
        path.write_bytes(edit(path.read_bytes()))

    return spoil


def missing(folder: Path) -> None:
    (folder / "crank.stl").unlink()


def a_folder(folder: Path) -> None:
    (folder / "crank.stl").unlink()
    (folder / "crank.stl").mkdir()


def opened(folder: Path) -> None:
    path = folder / "crank.stl"
    jobs.write_stl(path, jobs.corners_of(path)[::2])


def not_a_number(folder: Path) -> None:
    path = folder / "crank.stl"
    corners = jobs.corners_of(path)
    corners[7, 1, 2] = np.nan
    jobs.write_stl(path, corners)


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    corners = np.array([low, high])
    points = np.array(
        [[corners[i, 0], corners[j, 1], corners[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    )
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array([points[[a, *pair]] for a, b, c, d in quads for pair in ((b, c), (c, d))])


def no_crank(folder: Path) -> None:
    jobs.write_stl(folder / "crank.stl", box((0, 0, 0), (30, 40, 50)))


FILES: dict[str, tuple[Spoil, str]] = {
    "missing": (missing, r"crank\.stl does not exist"),
    "folder": (a_folder, r"crank\.stl is a folder"),
    "empty": (replaced(b""), r"crank\.stl: .*empty"),
    "truncated": (edited(lambda data: data[:-7]), r"crank\.stl: .*truncated"),
    "trailing": (edited(lambda data: data + b"abc"), r"crank\.stl: .*bytes left over"),
    "no triangles": (replaced(bytes(84)), r"crank\.stl: .*no triangles"),
    "NaN": (not_a_number, r"crank\.stl: triangle 8 .*not finite"),
    "open": (opened, r"crank\.stl: the mesh is open: \d+ edges"),
    "no crank": (no_crank, r"."),
}


@pytest.mark.parametrize("name", FILES)
def test_a_wrong_file(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spoil, message = FILES[name]
    job = jobs.bundled_job(tmp_path)
    spoil(tmp_path)
    refused(job, message, capsys)


def test_a_pin_given_twice_is_refused_before_the_crank_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    refused(jobs.bundled_job(tmp_path, crankpin_in_file="true"), "would count twice", capsys)


WRONG_JOBS: dict[str, tuple[dict[str, str], str]] = {
    "density 0": ({"density_kg_m3": "0"}, r"density_kg_m3 is 0; must be > 0"),
    "density absent": ({"density_kg_m3": ""}, r"density_kg_m3 is missing"),
    "density NaN": ({"density_kg_m3": "nan"}, r"density_kg_m3 is nan"),
    "speed < 0": ({"speed_rpm": "-1"}, r"speed_rpm is -1; must be > 0"),
    "speed absent": ({"speed_rpm": ""}, r"speed_rpm is missing"),
    "grade NaN": ({"grade": "nan"}, r"grade is nan"),
    "grade absent": ({"grade": ""}, r"grade is missing"),
    "factor": ({"factor": "1.5"}, r"factor is 1\.5; must be 0 to 1"),
    "no pin weight": ({"crankpin": ""}, r"engine\.crankpin_g\.crankpin is missing"),
    "unknown key": ({"grade": "6.3\nspeeed = 1"}, r"balance\.speeed is an unknown key"),
    "unknown unit": ({"unit": '"furlong"'}, r"crankshaft\.unit is 'furlong'"),
    "syntax": ({"grade": "= ="}, r"not valid TOML: .*line 29"),
    "stroke": ({"stroke_mm": "60.0"}, r"engine\.stroke_mm is 60, .*strokes 53\.800 mm.*within 0\.3 mm"),
    "stroke near": ({"stroke_mm": "54.1"}, r"engine\.stroke_mm is 54\.1, "),
    "wrong unit": ({"unit": '"cm"'}, r"engine\.stroke_mm is 53\.8, .*is crankshaft\.unit right"),
    "face point": ({"faces": "[[0.0, -34.0, 29.0]]"}, r"\[0, -34, 29\] mm lies on no planar face"),
    "face id": ({"faces": '["w9-z"]'}, r"'w9-z' is not on this crank"),
    "face twice": ({"faces": '["w1-a", "w1-a"]'}, r"w1-a twice"),
    "throw": ({"stroke_mm": "53.8\n[[engine.throw]]\nnumber = 2"}, r"throw number 2: the crank has 1 throw"),
    "other format": ({"file": '"crank.dwg"'}, r"'\.dwg' is not known"),
}


@pytest.mark.parametrize("name", WRONG_JOBS)
def test_a_wrong_job(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edits, message = WRONG_JOBS[name]
    refused(jobs.bundled_job(tmp_path, **edits), message, capsys)


def refused(job: Path, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Run a job twice: with no output folder, and with one that holds older results."""
    output = job.parent / "made" / "out"
    before = jobs.folder_state(job.parent)
    assert jobs.run("balance", job, "-o", output) == 3
    printed = capsys.readouterr()
    assert printed.out == ""
    assert re.search(message, printed.err), printed.err
    assert printed.err.startswith("autobalance: error: ")
    assert printed.err.count("\n") == 1
    assert not output.parent.exists()
    assert jobs.folder_state(job.parent) == before

    output.mkdir(parents=True)
    (output / "report.json").write_text("of an earlier run")
    (output / "balanced.stl").write_text("of an earlier run")
    before = jobs.folder_state(job.parent)
    assert jobs.run("balance", job, "-o", output) == 3
    assert jobs.folder_state(job.parent) == before


def test_a_missing_job(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("balance", tmp_path / "no.toml") == 3
    assert "cannot read the job" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_several_bodies_that_are_no_pressed_up_crank_are_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.pin_job(tmp_path)
    path = tmp_path / "crank-with-pin.stl"
    jobs.write_stl(path, np.concatenate([jobs.corners_of(path), box((200, 0, 0), (230, 40, 50))]))
    refused(job, r"holds 2 bodies \(1: .* mm³.*2: 60000 mm³", capsys)


def test_an_inverted_mesh_is_turned_round_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.pin_job(tmp_path)
    path = tmp_path / "crank-with-pin.stl"
    jobs.write_stl(path, jobs.corners_of(path)[:, ::-1])
    report = jobs.computed(job, tmp_path / "out")
    assert report["outcome"] == "within_tolerance"
    assert any("inside out" in repair for repair in report["input"]["repairs"])
    assert "autobalance: warning: " in (said := capsys.readouterr().err)
    assert "inside out: turned round" in said


def test_dynamic_needs_two_planes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A crank with one journal cut off: `inspect` works, `balance` names the key."""
    job = jobs.bundled_job(tmp_path, grade='6.3\njudge = "dynamic"')
    text = job.read_text(encoding="utf-8")
    extra = (
        "crankpin_in_file = false\naxis_point_mm = [0, 0, 0]\naxis_direction = [0, 0, 1]\n"
        "crankpins = [{ centre_mm = [0, 26.9, 0], diameter_mm = 28.0, width_mm = 16.0 }]\n"
        "main_journals = [{ centre_mm = [0, 0, 54.892], diameter_mm = 28.0, width_mm = 58.439 }]"
    )
    job.write_text(text.replace("crankpin_in_file = false", extra), encoding="utf-8")
    refused(job, r"balance\.tolerance_planes_mm is missing: .*dynamic.* 1 main journal", capsys)
    jobs.written(job, job.read_text(encoding="utf-8"), judge='"static"')
    report = jobs.computed(job, tmp_path / "out")
    assert report["tolerance"]["planes"] == []
    assert report["residual"]["planes"] == []


def test_an_original_factor_outside_its_range(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path, name="factor-original", density_kg_m3="15700")
    refused(job, r'balance\.factor = "original": the crank\'s factor .* is \d\.\d+; must be 0 to 1', capsys)


# --- the command line ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["balanse", "job.toml"],
        ["balance"],
        ["balance", "job.toml", "--units", "furlong"],
        ["balance", "job.toml", "--speed"],
        ["inspect", "crank.stl", "--unit", "furlong"],
        ["inspect", "crank.stl", "--density-kg-m3", "0"],
        ["inspect", "crank.stl", "--density-kg-m3", "nan"],
        ["inspect", "crank.stl", "--body", "first"],
        ["inspect", "crank.stl", "--json", "crank.stl"],
    ],
    ids=" ".join,
)
def test_wrong_use_is_two(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run(*arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "error" in printed.err


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["balance", "--help"], ["verify", "-h"]])
def test_help_and_version(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run(*arguments) == 0
    assert "autobalance" in capsys.readouterr().out


# --- where results cannot go --------------------------------------------------------------------------------


def test_an_output_folder_that_is_a_file_is_found_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    (tmp_path / "file").write_text("mine")
    damage(tmp_path)
    assert jobs.run("balance", job, "-o", tmp_path / "file") == 3
    assert "it is a file, not a folder" in capsys.readouterr().err
    assert jobs.run("balance", job, "-o", tmp_path / "file" / "below") == 3
    assert "cannot make the folder" in capsys.readouterr().err
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("name", ["report.json", "balanced.stl"])
def test_a_folder_in_the_place_of_a_result(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    (tmp_path / "out" / name).mkdir(parents=True)
    damage(tmp_path)
    assert jobs.run("balance", job, "-o", tmp_path / "out") == 3
    assert f"{name}: a folder has this name" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "said"), [("pipe", "it is a device; expected a file's name"), (".", "a folder")]
)
def test_what_is_no_file_is_not_replaced_by_one(name: str, said: str, tmp_path: Path) -> None:
    """``--json /dev/full`` put a file in the device's place; ``--json .`` was a traceback."""
    os.mkfifo(tmp_path / "pipe")
    with Staging([tmp_path]) as staging, pytest.raises(FileError, match=said):
        staging.add(tmp_path / name, b"")
    assert (tmp_path / "pipe").is_fifo()


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="root writes everywhere")
def test_a_folder_without_permission(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path)
    locked = tmp_path / "locked"
    locked.mkdir()
    locked.chmod(0o500)
    assert jobs.run("balance", job, "-o", locked) == 3
    assert "cannot write into the folder" in capsys.readouterr().err


def test_a_folder_that_refuses_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    job = jobs.bundled_job(tmp_path)
    opened: Any = Path.open

    def refuse(path: Path, mode: str = "r", *args: Any, **kinds: Any) -> Any:
        if "x" in mode:
            raise PermissionError(13, "Permission denied")
        return opened(path, mode, *args, **kinds)

    damage(tmp_path)
    monkeypatch.setattr(Path, "open", refuse)
    assert jobs.run("balance", job, "-o", tmp_path / "out") == 3
    assert "cannot write into the folder" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def damage(folder: Path) -> None:
    """Let who reads the crank end by an error of its own: the folder for the results is looked at before."""
    (folder / "crank.stl").write_bytes(b"no solid")


@pytest.mark.parametrize("target", ["crank.stl", "factor-0.28.toml"])
def test_the_report_does_not_destroy_what_was_read(
    target: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    before = jobs.folder_state(tmp_path)
    assert jobs.run("balance", job, "-o", tmp_path / "out", "--json", tmp_path / target) == 3
    assert "would destroy a file that the job reads" in capsys.readouterr().err
    assert jobs.folder_state(tmp_path) == before


def test_the_solid_does_not_destroy_the_crank(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path, file='"balanced.stl"')
    (tmp_path / "crank.stl").rename(tmp_path / "balanced.stl")
    assert jobs.run("balance", job, "-o", tmp_path) == 3
    assert "would destroy" in capsys.readouterr().err


class Full:
    """A file on a disk with room for ten more bytes."""

    def __init__(self, file: BinaryIO) -> None:
        self.file = file

    def __enter__(self) -> Full:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()

    def write(self, data: bytes) -> None:
        self.file.write(data[:10])
        raise OSError(28, "No space left on device")


def test_a_disk_that_is_full_leaves_the_earlier_results(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    job = jobs.bundled_job(tmp_path)
    jobs.computed(job, tmp_path / "out")
    before = jobs.folder_state(tmp_path)
    opened: Any = Path.open

    def full(path: Path, mode: str = "r", *args: Any, **kinds: Any) -> Any:
        file = opened(path, mode, *args, **kinds)
        return Full(file) if "x" in mode and ".report.json" in path.name else file

    monkeypatch.setattr(Path, "open", full)
    assert jobs.run("balance", job, "-o", tmp_path / "out") == 3
    assert "no space left on device" in capsys.readouterr().err
    assert jobs.folder_state(tmp_path) == before


def test_not_enough_memory_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    job = jobs.bundled_job(tmp_path)
    read = Path.read_bytes

    def too_large(path: Path) -> bytes:
        if path.name == "crank.stl":
            raise MemoryError
        return read(path)

    monkeypatch.setattr(Path, "read_bytes", too_large)
    # not jobs.run, which knows the crank if another test has read it
    assert command.main(["balance", str(job), "-o", str(tmp_path / "out")]) == 3
    assert "not enough memory" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


LITTLE = """
import resource, sys
from pathlib import Path
from autobalance.command import main
assert main(["inspect", "small.obj", "--unit", "mm"]) == 3  # all libraries are loaded
used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 26), used + (1 << 26)))
sys.exit(main(["inspect", "large.obj", "--unit", "mm"]))
"""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="no limit on memory here")
def test_little_memory_ends_in_one_line(tmp_path: Path) -> None:
    corners = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\n"
    (tmp_path / "small.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    (tmp_path / "large.obj").write_text(corners + "f 1 3 2\n" * 2_000_000)
    environment = {**os.environ, "PYTHONPATH": str(jobs.ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", LITTLE],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    last = done.stderr.splitlines()[-1]
    assert (done.returncode, last) == (3, "autobalance: error: not enough memory for this file")
    assert "Traceback" not in done.stderr


# --- Ctrl-C -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "where",
    [measure_crank, loop.balance, soup_moments, values.report],
    ids=lambda each: each.__name__,
)
def test_an_interrupted_run_leaves_nothing(
    where: Callable[..., Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    before = jobs.folder_state(tmp_path)

    with interrupted_in(where):
        assert jobs.run("balance", job, "-o", tmp_path / "out") == 130
    assert "interrupted" in capsys.readouterr().err
    assert jobs.folder_state(tmp_path) == before
    assert not (tmp_path / "out").exists()


def test_results_are_put_in_place_together(tmp_path: Path) -> None:
    """Ctrl-C of a command between the first and the second rename takes effect after the second."""
    import signal

    from autobalance.runtime import interruptible

    for name in ("a", "b"):
        (tmp_path / name).write_text("old")
    renamed = []
    replace = os.replace

    def interrupted(source: Path, target: Path) -> None:
        renamed.append(target.name)
        replace(source, target)
        signal.raise_signal(signal.SIGINT)

    def put_both() -> None:
        with Staging([tmp_path]) as staging:
            staging.add(tmp_path / "a", b"new")
            staging.add(tmp_path / "b", b"new")
            staging.commit()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.replace", interrupted)
        with pytest.raises(KeyboardInterrupt), interruptible():
            put_both()
    assert renamed == ["a", "b"]
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "new", "b": "new"}


def test_a_tolerance_that_no_planner_can_compute_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path, grade="1e-9", speed_rpm="1e9")
    assert jobs.run("balance", job, "-o", tmp_path / "out") == 3
    said = capsys.readouterr().err
    assert "the planner cannot compute with a permissible" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments", [["inspect", "NAME.stl"], ["verify", "NAME/report.json"], ["balance", "JOB", "-o", "NAME"]]
)
def test_a_name_that_is_too_long(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    given = [each.replace("NAME", str(tmp_path / ("x" * 300))).replace("JOB", str(job)) for each in arguments]
    before = jobs.folder_state(tmp_path)
    assert jobs.run(*given) == 3
    error = capsys.readouterr().err
    assert error.endswith("file name too long\n")
    assert error.count("\n") == 1
    assert jobs.folder_state(tmp_path) == before


def test_a_working_folder_that_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert (
        jobs.run("grade", "--grade", "6.3", "--mass", "1000", "--speed-rpm", "6000", "--json", "x.json") == 3
    )
    printed = capsys.readouterr().err
    assert printed == "autobalance: error: the folder that this runs in: no such file or directory\n"
