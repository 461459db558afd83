"""What a run writes stays inside the folder that was chosen, whatever names and links it meets."""

from __future__ import annotations

import json
import os
import secrets
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from autobalance.errors import FileError
from autobalance.report import files
from autobalance.report.files import Staging
from autobalance.solid.formats.write import encode
from autobalance.verification.claims import Claims
from autobalance.verification.premises import claimed_job
from tests import jobs
from tests.geometry.test_solid_formats import TETRAHEDRON, archive, body, model

WRITTEN = {
    "balance.xlsx",
    "balanced.stl",
    "crank-after.png",
    "crank-before.png",
    "reading.toml",
    "report.html",
    "report.json",
    "sheet.pdf",
}

needs_links = pytest.mark.skipif(os.name == "nt", reason="Windows has other names and other links")


def files_in(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}


@pytest.mark.parametrize("name", ["..toml", ".toml", "-o.toml", "a b;c.toml", "~.toml", "%2e%2e.toml", "job"])
def test_results_of_any_job_name_go_beside_it(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "jobs"
    job = jobs.bundled_job(folder).rename(folder / name)
    before = files_in(tmp_path)
    assert jobs.run("balance", job, "--no-report") == 0
    out = f"jobs/{job.stem}-balanced"
    assert files_in(tmp_path) - before == {f"{out}/balanced.stl", f"{out}/report.json"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["../cranks/deep/../crank.stl", "../cranks/..crank.stl", "absolute"])
def test_results_do_not_follow_the_name_of_the_crank(name: str, tmp_path: Path) -> None:
    (tmp_path / "cranks" / "deep").mkdir(parents=True)
    place = tmp_path / "cranks" / "crank.stl" if name == "absolute" else tmp_path / "jobs" / name
    job = jobs.bundled_job(
        tmp_path / "jobs", file=json.dumps(str(place.resolve()) if name == "absolute" else name)
    )
    shutil.move(tmp_path / "jobs" / "crank.stl", place)
    before = files_in(tmp_path)
    jobs.balanced(job, tmp_path / "out")
    assert files_in(tmp_path) - before == {f"out/{one}" for one in WRITTEN}


@pytest.mark.parametrize("name", ["../../evil.model", "/evil.model", "3D/../../evil.MODEL", "C:\\evil.model"])
def test_names_inside_an_archive_are_never_written(name: str, tmp_path: Path) -> None:
    crank = tmp_path / "deep" / "crank.3mf"
    crank.parent.mkdir()
    crank.write_bytes(archive(model(TETRAHEDRON), name))
    assert jobs.run("inspect", crank, "--json", tmp_path / "deep" / "report.json") == 3  # it is no crank
    assert files_in(tmp_path) == {"deep/crank.3mf"}
    assert not Path("/evil.model").exists()


@needs_links
def test_links_in_the_folder_are_replaced_not_followed(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path / "jobs")
    out, victims = tmp_path / "out", tmp_path / "victims"
    out.mkdir()
    victims.mkdir()
    for name in WRITTEN:
        (victims / name).write_text("mine", encoding="utf-8")
        (out / name).symlink_to(victims / name)
    (out / "dangling").symlink_to(victims / "nothing")
    jobs.balanced(job, out)
    for name in WRITTEN:
        assert (victims / name).read_text(encoding="utf-8") == "mine"
        assert not (out / name).is_symlink() or name == "reading.toml"  # a reading that is filled in stays
    assert files_in(victims) == WRITTEN


@needs_links
def test_a_link_under_a_temporary_name_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody can know the name; where it is taken all the same, nothing is followed."""
    monkeypatch.setattr(secrets, "token_hex", lambda size: "0" * 2 * size)
    monkeypatch.setattr(os, "getpid", lambda: 1)
    victim = tmp_path / "victim"
    out = tmp_path / "out"
    out.mkdir()
    (out / f".report.json.{files._machine()}-1-00000000.part").symlink_to(victim)
    with Staging([out]) as staging, pytest.raises(FileError, match="cannot write"):
        staging.add(out / "report.json", b"{}")
    assert not victim.exists()


def test_a_name_may_be_as_long_as_the_folder_lets_it(tmp_path: Path) -> None:
    longest = tmp_path / ("r" * 250 + ".json")
    with Staging([tmp_path]) as staging:
        staging.add(longest, b"{}")
        staging.add(tmp_path / ("ß" * 120 + ".json"), b"{}")
        staging.commit()
    assert longest.read_bytes() == b"{}"
    too_long = tmp_path / ("r" * 300 + ".json")
    with Staging([tmp_path]) as staging, pytest.raises(FileError, match=r"cannot write .* name too long"):
        staging.add(too_long, b"{}")
    assert len(list(tmp_path.iterdir())) == 2


def test_a_job_whose_name_leaves_no_room_for_its_folders(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    job = job.rename(job.with_name("j" * 248 + ".toml"))
    assert jobs.run("balance", job) == 3
    said = capsys.readouterr().err
    assert "-balanced" in said
    assert "file name too long" in said
    assert said.count("\n") == 1


def test_what_a_killed_run_has_left_is_taken_away(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as gone:
        gone.wait()
    names = {
        "old": f".balanced.stl.{gone.pid}-0123abcd.part",
        "young": f".report.json.{gone.pid}-0123abcd.part",
        "alive": f".balanced.stl.{os.getpid()}-0123abcd.part",
        "another's": ".balanced.stl.part",
    }
    for name in names.values():
        (tmp_path / name).write_bytes(b"half")
        if name not in (names["young"], names["alive"]):
            os.utime(tmp_path / name, (0.0, 0.0))
    with Staging([tmp_path]) as staging:
        staging.add(tmp_path / "report.json", b"{}")
        staging.commit()
    kept = {"report.json", names["young"], names["alive"], names["another's"]}
    assert {path.name for path in tmp_path.iterdir()} == kept


def test_what_a_run_killed_just_now_has_left_is_taken_away_by_the_next(tmp_path: Path) -> None:
    """Of this machine: whether its process lives can be known, however young the file is."""
    code = (
        "import os, signal, sys; from pathlib import Path; from autobalance.report.files import Staging\n"
        "folder = Path(sys.argv[1])\n"
        "with Staging([folder]) as staging:\n"
        "    staging.add(folder / 'balanced.stl', b'half'); os.kill(os.getpid(), signal.SIGKILL)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=False)
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".balanced.stl.")
    with Staging([tmp_path]) as staging:
        waiting = tmp_path / "report.json"
        staging.add(waiting, b"{}")
        with Staging([tmp_path]):
            pass  # another run takes nothing away that is on its way
        staging.commit()
    assert [path.name for path in tmp_path.iterdir()] == ["report.json"]


@pytest.mark.parametrize("name", ["../evil", "/tmp/evil", "a/b", "a\\\\b", "", "two\\nlines"])
def test_a_generated_crank_is_named_after_no_path(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    (folder / "crank.toml").write_text(f'preset = "single"\nname = "{name}"\n', encoding="utf-8")
    assert jobs.run("generate", "crank.toml", "--segments", "16") == 3
    assert "must be a plain file name" in capsys.readouterr().err
    assert files_in(tmp_path) == {"here/crank.toml"}
    assert jobs.run("generate", "crank.toml", "--segments", "16", "-o", "named.stl") == 0
    assert files_in(tmp_path) == {"here/crank.toml", "here/named.stl"}


def test_verify_reads_the_solid_beside_the_report_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    jobs.computed(jobs.bundled_job(tmp_path), tmp_path / "out")
    shutil.move(tmp_path / "out" / "balanced.stl", tmp_path / "balanced.stl")
    report = jobs.report_of(tmp_path / "out")
    for name in ("../balanced.stl", str(tmp_path / "balanced.stl"), ".."):
        report["outputs"]["solid"]["file"] = name
        (tmp_path / "out" / "report.json").write_text(json.dumps(report), encoding="utf-8")
        assert jobs.run("verify", tmp_path / "out" / "report.json") == 3
        assert str(tmp_path / "out") in capsys.readouterr().err


@needs_links
def test_a_name_cannot_speak_to_the_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "\x1b[2Jcrank\n.stl"
    path.write_bytes(encode(body(8).mesh, "stl", 1.0)[:-1])
    assert jobs.run("inspect", path, "--unit", "mm") == 3
    said = capsys.readouterr().err
    assert "\x1b" not in said
    assert said.count("\n") == 1


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="names are text here")
def test_a_folder_whose_name_is_no_text(tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe"))
    job = jobs.bundled_job(folder)
    assert jobs.run("balance", job) == 0
    out = folder / "factor-0.28-balanced"
    assert {path.name for path in out.iterdir()} == WRITTEN
    assert jobs.run("verify", out / "report.json") == 0
    assert jobs.report_of(out)["job"]["file"] == f"../{job.name}"


def test_a_job_that_a_report_names_from_its_folder_is_found_there(tmp_path: Path) -> None:
    """A stage and a study of one looked for its files beside where they were begun."""
    job = jobs.bundled_job(tmp_path)
    report = jobs.balanced(job, tmp_path / "out", 0, "--only", "json")
    assert report["job"]["file"] == f"../{job.name}"
    found = claimed_job(Claims("report.json", report), tmp_path / "out")
    assert found.path.resolve() == job.resolve()
