"""Two runs into one folder: nothing of the first is left beside the report of the second."""

import json
import os
from pathlib import Path

import pytest

import autobalance as ab
from autobalance.errors import FileError
from autobalance.report.files import Staging, earlier_report, remove_stale
from tests import jobs

PAPERS = ("--only", "html,csv,xlsx,reading")


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.slow
def test_papers_and_the_solid_of_another_job_are_removed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    jobs.balanced(jobs.bundled_job(tmp_path / "one"), out, 0, *PAPERS)
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    papers = {"report.html", "holes.csv", "balance.xlsx", "reading.toml"}
    assert names(out) == {"balanced.stl", "report.json", "notes.txt", *papers}
    shallow = jobs.bundled_job(tmp_path / "two", method='"shoulder"\nmax_depth_mm = 0.5', piston="140.0")
    solid = (out / "balanced.stl").read_bytes()
    with jobs.without_advice():
        jobs.balanced(shallow, out, 4, "--only", "csv")
    assert names(out) == {"balanced.stl", "report.json", "holes.csv", "notes.txt"}
    assert (out / "balanced.stl").read_bytes() != solid
    nothing = jobs.bundled_job(tmp_path / "three", grade="4000")
    capsys.readouterr()
    jobs.balanced(nothing, out, 0, "--no-report")
    assert names(out) == {"report.json", "notes.txt"}
    (said,) = capsys.readouterr().err.splitlines()
    assert "the permissible unbalance spans" in said
    assert jobs.run("verify", out / "report.json") == 0


@pytest.mark.slow
def test_what_was_changed_by_hand_stays_and_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    jobs.balanced(jobs.bundled_job(tmp_path / "one"), out, 0, "--only", "csv,reading")
    for name in ("holes.csv", "reading.toml"):
        (out / name).write_text("filled in", encoding="utf-8")
    capsys.readouterr()
    jobs.balanced(jobs.bundled_job(tmp_path / "two", piston="140.0"), out, 0, "--only", "reading")
    said = capsys.readouterr().err
    assert names(out) == {"balanced.stl", "report.json", "holes.csv", "reading.toml"}
    assert (out / "reading.toml").read_text(encoding="utf-8") == "filled in"
    assert "holes.csv of the earlier run was changed since and stays" in said
    assert "reading.toml was filled in for an earlier run and stays" in said


@pytest.mark.slow
def test_a_blank_reading_becomes_that_of_the_new_crank(tmp_path: Path) -> None:
    out = tmp_path / "out"
    jobs.balanced(jobs.bundled_job(tmp_path / "one"), out, 0, "--only", "reading")
    first = (out / "reading.toml").read_text(encoding="utf-8")
    report = jobs.balanced(jobs.bundled_job(tmp_path / "two", piston="140.0"), out, 0, "--only", "reading")
    second = (out / "reading.toml").read_text(encoding="utf-8")
    assert first != second
    assert f"bob_weights_g = [{report['engine']['bob_weights'][0]['fit_g']:.2f}]" in second


def _earlier(folder: Path, **files: str) -> None:
    """Write files and a report of this program that lists them."""
    from hashlib import sha256

    folder.mkdir(parents=True, exist_ok=True)
    outputs = {}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
        outputs[name] = {"file": name, "sha256": sha256(text.encode()).hexdigest()}
    head = {"autobalance": {"version": "0"}, "command": "nc", "outputs": outputs}
    (folder / "nc.json").write_text(json.dumps(head), encoding="utf-8")


@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("fails_at", ["nc.json", "old.ngc"])
def test_a_failure_leaves_the_old_set_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails_at: str, links: bool
) -> None:
    _earlier(tmp_path, **{"old.ngc": "old", "new.ngc": "as it was"})
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    replace, unlink = os.replace, Path.unlink

    def no_replace(source: Path, target: Path) -> None:
        if target.name == fails_at and source.read_bytes() == b"{}":
            raise OSError(28, "No space left on device")
        replace(source, target)

    def no_unlink(path: Path, missing_ok: bool = False) -> None:
        if path.name == fails_at:
            raise OSError(28, "No space left on device")
        unlink(path, missing_ok)

    def no_link(*_: object, **__: object) -> None:
        raise OSError(1, "Operation not permitted")

    monkeypatch.setattr(os, "replace", no_replace)
    monkeypatch.setattr(Path, "unlink", no_unlink)
    if not links:
        monkeypatch.setattr(os, "link", no_link)

    def put() -> None:
        with Staging([tmp_path]) as staging:
            for name, data in {"new.ngc": b"other", "further.ngc": b"new", "nc.json": b"{}"}.items():
                staging.add(tmp_path / name, data)
            remove_stale(staging, tmp_path / "nc.json", {})
            staging.commit()

    with pytest.raises(FileError, match="no space left"):
        put()
    monkeypatch.undo()
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_nothing_outside_of_the_folder_and_no_input_is_removed(tmp_path: Path) -> None:
    from hashlib import sha256

    inside, folder = tmp_path / "crank.stl", tmp_path / "out"
    inside.write_text("crank", encoding="utf-8")
    _earlier(folder, **{"input.stl": "crank", "gone.csv": "csv"})
    report = json.loads((folder / "nc.json").read_text(encoding="utf-8"))
    digest = sha256(b"crank").hexdigest()
    for name in ("../crank.stl", str(inside), "", ".", "missing.stl"):
        report["outputs"][name] = {"file": name, "sha256": digest}
    (folder / "nc.json").write_text(json.dumps(report), encoding="utf-8")
    with Staging([folder]) as staging:
        staging.add(folder / "nc.json", b"{}")
        assert remove_stale(staging, folder / "nc.json", {"input": {"file": "input.stl"}}) == ()
        staging.commit()
    assert names(folder) == {"nc.json", "input.stl"}
    assert inside.read_text(encoding="utf-8") == "crank"


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"autobalance": {}}', '{"command": "nc"}', "\x00", "[" * 9999]
)
def test_a_file_of_another_program_lists_nothing_of_ours(text: str, tmp_path: Path) -> None:
    (tmp_path / "nc.json").write_text(text, encoding="utf-8")
    assert earlier_report(tmp_path / "nc.json") is None


@pytest.mark.slow
def test_a_sheet_is_not_put_beside_the_report_of_another_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("one", "two"):
        jobs.computed(jobs.bundled_job(tmp_path / name), tmp_path / name / "out")
    one, two = tmp_path / "one" / "out", tmp_path / "two" / "out"
    capsys.readouterr()
    assert jobs.run("sheet", one / "report.json", "--only", "pdf", "-o", two) == 3
    assert f"{two} holds report.json of another run; choose another folder" in capsys.readouterr().err
    assert not (two / "sheet.pdf").exists()
    assert jobs.run("sheet", one / "report.json", "--only", "pdf") == 0
    assert (one / "sheet.pdf").is_file()


def test_cranks_and_jobs_that_a_person_names_stay_beside_each_other(tmp_path: Path) -> None:
    for name in ("one", "two"):
        drawn = ab.generate("single", file=tmp_path / f"{name}.stl", segments=16)
        drawn.write(tmp_path)
        ab.init(tmp_path / f"{name}.stl", unit="mm", file=tmp_path / f"{name}.toml").write(tmp_path)
    assert names(tmp_path) >= {"one.stl", "two.stl", "one.toml", "two.toml"}
