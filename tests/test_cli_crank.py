"""A crank's file in place of a job: options for its keys, one message for what is missing, its file."""

import json
import shlex
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.errors import JobError, UsageError
from autobalance.job.from_options import with_decimal_point
from tests import jobs

WEIGHTS = ("--rotating-g", "134.04", "--reciprocating-g", "261.5")
KNOWN = ("--unit", "mm", "--material", "steel", *WEIGHTS, "--crankpin-g", "114.65")
TARGET = ("--factor", "0.28", "--grade", "G6.3", "--speed-rpm", "15200", "--method", "shoulder")
IN_PYTHON: dict[str, Any] = {
    "unit": "mm",
    "density_kg_m3": 7850.0,
    "rotating_g": 134.04,
    "reciprocating_g": "0.2615 kg",
    "crankpin_g": 114.65,
    "factor": 0.28,
    "grade": 6.3,
    "speed_rpm": 15200,
    "method": "shoulder",
}


@pytest.fixture
def crank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the bundled crank as a relative path; it is pressed up, without its crankpin."""
    monkeypatch.chdir(tmp_path)
    jobs.bundled_job(tmp_path).rename(tmp_path / "by-hand.toml")
    return Path("crank.stl")


def report(path: str | Path) -> dict[str, Any]:
    values: dict[str, Any] = json.loads(Path(path).read_text("utf-8"))
    return values


def comparable(values: dict[str, Any]) -> dict[str, Any]:
    """Return a report without its times and the path of its job."""
    return {**values, "seconds": None, "job": {**values["job"], "file": None}}


def test_a_crank_is_balanced_and_its_job_gives_the_same_to_the_bit(crank: Path) -> None:
    assert jobs.run("balance", crank, *KNOWN, *TARGET, "--no-report") == 0
    folder = Path("crank-balanced")
    by_options = report(folder / "report.json")
    assert tomllib.loads((folder / "job.toml").read_text("utf-8"))["crankshaft"]["file"] == "../crank.stl"
    assert by_options["job"]["file"] == "job.toml"
    assert jobs.run("balance", folder / "job.toml", "-o", "again", "--no-report") == 0
    assert comparable(report("again/report.json")) == comparable(by_options)
    by_hand = jobs.computed(Path("by-hand.toml"), Path("hand"))
    assert by_options["tolerance"]["permissible_g_mm"] == by_hand["tolerance"]["permissible_g_mm"]
    assert by_options["corrections"][0]["depth_mm"] == pytest.approx(by_hand["corrections"][0]["depth_mm"])
    assert jobs.run("verify", folder / "report.json") == 0


def test_python_takes_the_same_by_the_same_names(crank: Path) -> None:
    result = ab.balance(crank, **IN_PYTHON)
    assert result.outcome == "within_tolerance"
    assert not Path("crank-balanced").exists()
    result.write("out", only=("json",))
    assert tomllib.loads(Path("out/job.toml").read_text("utf-8"))["crankshaft"]["file"] == "../crank.stl"
    assert jobs.run("balance", "out/job.toml", "-o", "again", "--no-report") == 0
    assert comparable(report("again/report.json")) == comparable(report("out/report.json"))
    with pytest.raises(TypeError, match="rotating"):
        ab.balance(crank, rotating=134.04)
    with pytest.raises(UsageError, match="--unit goes with a crank's file"):
        ab.balance("by-hand.toml", unit="mm")


def test_what_is_missing_is_asked_for_in_one_message_with_the_whole_command(
    crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for verb, missing in (
        ("balance", "--unit UNIT --density-kg-m3 KG_M3 --rotating-g 134.04 --reciprocating-g G --factor F"),
        ("compare", "--factor F --grade GRADE --speed-rpm RPM"),
        ("study", "--factor F --grade GRADE --speed-rpm RPM"),
        ("forces", "--reciprocating-g G --rod-length-mm MM --speed-rpm RPM"),
    ):
        assert jobs.run(verb, crank, "--rotating-g", "134.04", "--set", "job.engine=A 1") == 3
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert f"`autobalance {verb} crank.stl " in error
        assert missing in error
        assert error.endswith("--set 'job.engine=A 1'`\n")
        for word in missing.split():
            assert word[:2] != "--" or word in error.partition(";")[0] or word == "--rotating-g"
    assert not Path("crank-balanced").exists()
    given = [word for word in (*KNOWN, *TARGET) if word not in ("--grade", "G6.3")]
    assert jobs.run("balance", crank, *given) == 3
    assert "crank.stl: --grade is missing; type `autobalance balance" in capsys.readouterr().err
    without_pin = [word for word in (*KNOWN, *TARGET) if word not in ("--crankpin-g", "114.65")]
    assert jobs.run("balance", crank, *without_pin) == 3
    assert "pressed-up crank without its crankpin: --crankpin-g is missing" in capsys.readouterr().err
    assert jobs.run("balance", "no.stl", *KNOWN) == 3
    assert "no.stl does not exist" in capsys.readouterr().err


def test_factor_is_the_makers_where_the_old_weights_are_given(crank: Path) -> None:
    old = ("rotating_g.all=134.04", "reciprocating_g.all=242.7", "crankpin_g.crankpin=114.65")
    settings = [word for each in old for word in ("--set", f"original.{each}")]
    assert jobs.run("balance", crank, *KNOWN, *TARGET[2:], *settings, "--no-report") == 0
    found = report("crank-balanced/report.json")
    assert found["job"]["balance"]["factor"] == "original"
    assert found["balance_factor"]["target"] == pytest.approx(0.8816, abs=2e-3)


@pytest.mark.parametrize("option", ["--unit=mm", "--grade=6.3", "--rotating-g=3", "--method=drill"])
def test_beside_a_job_they_are_wrong_use(
    option: str, crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for verb in ("balance", "compare", "study", "forces", "init"):
        if verb != "init" or option not in ("--unit=mm", "--method=drill"):  # its own
            assert jobs.run(verb, "by-hand.toml", option) == 2
            assert "--set" in capsys.readouterr().err


def test_weights_have_units_and_a_comma_is_the_decimal_point(
    crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = ("--unit", "mm", "--density-kg-m3", "7850", "--crankpin-g", "0,11465 kg", "--rod-length-mm", "104")
    typed = ("--rotating-g", "4.728 oz", "--reciprocating-g", "261,5", "--speed-rpm", "9000")
    assert jobs.run("forces", crank, *base, *typed, "--json", "f.json") == 0
    printed = capsys.readouterr()
    assert "--reciprocating-g 261,5 is read as 261.5" in printed.err
    weights = report("f.json")["job"]["engine"]
    assert weights["rotating_g"]["all"] == pytest.approx(134.04, abs=0.01)
    assert weights["reciprocating_g"]["all"] == 261.5
    assert weights["crankpin_g"]["crankpin"] == pytest.approx(114.65)
    assert jobs.run("forces", crank, *base, *typed[:3], "1.234,5", *typed[4:]) == 3
    assert "'1.234,5', with signs for thousands and decimals" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["1.234,5", "1,234.5", "1,234,567", "1.234,5 g"])
def test_signs_for_thousands_are_refused(text: str) -> None:
    with pytest.raises(JobError, match="thousands"):
        with_decimal_point(text, "--rotating-g")


def test_a_job_that_somebody_changed_is_not_written_over(
    crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("balance", crank, *KNOWN, *TARGET, "--no-report") == 0
    assert jobs.run("balance", crank, *KNOWN, *TARGET, "--no-report", "--factor", "0.3") == 0
    job = Path("crank-balanced/job.toml")
    text = job.read_text("utf-8").replace("factor = 0.3", "factor = 0.31")
    job.write_text(text, "utf-8")
    capsys.readouterr()
    assert jobs.run("balance", crank, *KNOWN, *TARGET, "--no-report") == 3
    assert f"{job} was changed and would be lost" in capsys.readouterr().err
    assert job.read_text("utf-8") == text


def test_present_factor_is_shown_without_a_wanted_one(
    crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("inspect", crank, *KNOWN, "--json", "i.json") == 0
    present = report("i.json")["present"]
    assert present == pytest.approx(0.818, abs=2e-3)
    shown = f"Balance factor of the crank as it is, with these parts: {present:.4f}"
    assert shown in capsys.readouterr().out
    text = Path("crank-balanced/job.toml").read_text("utf-8")
    assert text.count('"FILL IN"') == 3
    for verb in ("inspect", "parts", "forces"):
        more = ("--set", "engine.rod_length_mm=104", "--speed-rpm", "9000") if verb == "forces" else ()
        assert jobs.run(verb, "crank-balanced/job.toml", *more, "--json", "o.json") == 0
        assert report("o.json")["present"] == pytest.approx(present, abs=1e-12)
    states = [state["name"] for state in report("o.json")["states"]]
    assert states == ["as the file is"]
    assert jobs.run("balance", "crank-balanced/job.toml") == 3
    assert 'balance.factor is "FILL IN"' in capsys.readouterr().err


def test_init_fills_in_what_is_given_and_offers_the_old_parts(crank: Path) -> None:
    assert (
        jobs.run("init", crank, *KNOWN, *TARGET, "-o", "job.toml", "--set", "engine.rod_length_mm=104") == 0
    )
    tables = tomllib.loads(Path("job.toml").read_text("utf-8"))
    assert tables["engine"]["rotating_g"] == {"all": 134.04}
    assert tables["original"]["reciprocating_g"]["piston"] == "FILL IN"
    assert jobs.run("balance", "job.toml", "-o", "out", "--no-report") == 0  # old parts that nobody filled in
    assert report("out/report.json")["job"]["original"] is None
    text = Path("job.toml").read_text("utf-8").replace("factor = 0.28", 'factor = "FILL IN"')
    old, rest = text.split("[original.rotating_g]")[0], text.split("[balance]")[1]
    weights = "[original.rotating_g]\nall = 134.04\n[original.reciprocating_g]\nall = 242.7\n"
    Path("old.toml").write_text(
        f"{old}{weights}[original.crankpin_g]\ncrankpin = 114.65\n[balance]{rest}", "utf-8"
    )
    assert jobs.run("balance", "old.toml", "-o", "out", "--no-report") == 0
    assert report("out/report.json")["balance_factor"]["target"] == pytest.approx(0.8816, abs=2e-3)


def test_options_are_not_abbreviated(crank: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy("by-hand.toml", "j.toml")
    for asked in (
        ("inspect", crank, "--uni", "mm"),
        ("balance", "j.toml", "--no-rep"),
        ("demo", "--out", "x"),
    ):
        assert jobs.run(*asked) == 2
        assert "unrecognized arguments" in capsys.readouterr().err


def test_help_version_and_gui_are_understood(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("help") == 0
    assert "COMMAND" in capsys.readouterr().out
    assert jobs.run("help", "balance") == 0
    assert "--rotating-g" in capsys.readouterr().out
    assert jobs.run("version") == 0
    assert ab.__version__ in capsys.readouterr().out
    assert jobs.run("gui", "--help") == 0
    assert "autobalance app" in capsys.readouterr().out


@pytest.mark.slow
def test_the_readmes_own_crank_path_ends_in_a_verified_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    readme = (jobs.ROOT / "README.md").read_text(encoding="utf-8")
    lines = [
        shlex.split(line, comments=True)
        for line in readme.replace("\\\n", " ").splitlines()
        if "autobalance " in line
    ]
    made = next(line for line in lines if line[:2] == ["autobalance", "generate"])
    own = next(line for line in lines if line[:3] == ["autobalance", "balance", "crank.stl"])
    assert jobs.run(*made[1:]) == 0
    assert jobs.run(*own[1:], "--no-report") == 0
    assert report("crank-balanced/report.json")["outcome"] == "within_tolerance"
    assert jobs.run("verify", "crank-balanced/report.json") == 0
