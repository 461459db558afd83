"""Slips that people make at the command line, each answered with what to do."""

import json
import random
from pathlib import Path

import pytest

from autobalance.declare import POSITIVE, Key
from autobalance.errors import DecimalCommaWarning, JobError
from autobalance.job.layout import SHOP
from autobalance.toml_files.document import toml_of
from autobalance.toml_files.keys import json_schema, read
from autobalance.toml_files.typed_units import in_base_units
from tests import jobs

READING = "urr_percent = 95.0\numar_g_mm = 2.0\n"


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        (b"[engine]\npiston = 221,500 # g\n", 2, "write 221.500 or 221500"),
        (b"[engine]\npiston = { g = 221,500 }\n", 2, "write 221.500 or 221500"),
        (b"[balance]\n\nspeed_rpm = 15,200\n", 3, "write 15.200 or 15200"),
        (b"[balance]\nfactor = 1,234,5\n", 2, "is not valid TOML"),
        (b"[balance]\nfactor = .28\n", 2, "write 0.28"),
        (b"[balance]\nfactor = 5.\n", 2, "write 5.0"),
        (b"[balance]\nspeed_rpm = 11 000  # highest\n", 2, "; write 11000\n"),
        (b"[balance]\nspeed_rpm = 11 krpm\n", 2, '; put a number and its unit in quotes: "11 krpm"\n'),
        (b"[balance]\nfactor = 28 % # of it\n", 2, '; put a number and its unit in quotes: "28 %"\n'),
        (
            b'[crankshaft]\nfile = "C:\\Users\\me\\crank.stl"\n',
            2,
            "in paths write / for \\, or put the text in '...'",
        ),
        (b"[engine]\n# volume in mm\xb3\n", 2, "is 0xb3, in line 2; save it as UTF-8"),
        ("[engine]\n".encode("utf-16"), 1, "as UTF-16 begins; save it as UTF-8"),
    ],
)
@pytest.mark.parametrize("what", ["job", "reading"])
def test_a_slip_in_a_file_is_told_with_its_cure(
    what: str, text: bytes, line: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"{what}.toml"
    path.write_bytes(text)
    asked = ("balance", path) if what == "job" else ("recut", tmp_path / "report.json", path)
    assert jobs.run(*asked) == 3
    error = capsys.readouterr().err
    assert error.startswith(f"autobalance: error: {what}.toml is not ")
    assert said in error
    assert error.count("\n") == 1
    if "UTF-16" not in said:
        assert f"line {line}" in error


def test_a_decimal_comma_that_can_be_nothing_else_is_read_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path, factor="0,28", speed_rpm="15200,0  # highest")
    text = job.read_text(encoding="utf-8").replace("[correction]", "[correction] # 1,5")
    job.write_text(text, encoding="utf-8")
    assert (
        jobs.run("balance", job, "--json", "-", "--set", "balance.grade=6,3", "--set", 'job.note="a 1,5"')
        == 0
    )
    out, said = capsys.readouterr()
    told = [line for line in said.splitlines() if "decimal point" in line]
    factor = 1 + next(n for n, line in enumerate(text.splitlines()) if line.startswith("factor"))
    speed = 1 + next(n for n, line in enumerate(text.splitlines()) if line.startswith("speed_rpm"))
    ends = "; the comma is a decimal point"
    assert told == [
        f"autobalance: warning: {job.name}, line {factor}: 0,28 is read as 0.28{ends}",
        f"autobalance: warning: {job.name}, line {speed}: 15200,0 is read as 15200.0{ends}",
        f"autobalance: warning: --set balance.grade: 6,3 is read as 6.3{ends}",
    ]
    assert json.loads(out)["job"]["balance"]["factor"] == 0.28


def test_texts_with_a_decimal_comma_and_a_unit_are_read_too() -> None:
    text = "[engine.rotating_g]\nrod = { oz = 4,5, pm = 0,1 }\n"
    with pytest.warns(DecimalCommaWarning, match=r"line 2: (4,5|0,1) is read as"):
        assert toml_of(text, "job.toml") == {"engine": {"rotating_g": {"rod": {"oz": 4.5, "pm": 0.1}}}}
    keys = (Key("drill_mm", float, "", POSITIVE, 1.0), Key("mass", float, "", POSITIVE, 1.0, typed="g"))
    raw = {"drill_mm": "9,5 mm", "mass": "221,5 g"}
    with pytest.warns(DecimalCommaWarning, match="as 9.5 mm"):
        based = in_base_units(raw)
    with pytest.warns(DecimalCommaWarning, match="as 221.5 g"):
        assert read(based, keys) == {"drill_mm": 9.5, "mass": 221.5}
    with pytest.raises(JobError, match="221,500"):
        read({"mass": "221,500 g"}, keys)


def test_one_drill_of_a_shop_is_taken_for_a_list_of_one() -> None:
    key = next(key for key in SHOP.keys if key.name == "drills")
    values = [read({"drills": drills}, (key,))["drills"] for drills in (8, "1/2 in", "mm", [8, 10])]
    assert values == [(8.0,), (12.7,), "mm", (8.0, 10.0)]
    arms = json_schema("shop", (key,))["properties"]["drills"]["anyOf"]
    assert [arm.get("type") for arm in arms] == ["number", "string", None, "array"]


def test_valid_toml_with_commas_and_other_faults_is_given_no_cure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "job.toml"
    path.write_text("[correction]\ndiameters_mm = [8,10] 3\n", encoding="utf-8")
    assert jobs.run("balance", path) == 3
    said = capsys.readouterr().err
    assert "line 2" in said
    path.write_text('note = "1,5" x\n', encoding="utf-8")
    assert jobs.run("balance", path) == 3
    assert "decimal point" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["blance"], "'blance' is not a command; did you mean `balance`?"),
        (["balance", "a.toml", "--unti", "mm"], "unrecognized arguments: --unti mm; did you mean --unit?"),
        (["balance", "a.toml", "--rod", "3"], "--rod 3; did you mean --rod-length-mm or --rods-per-throw?"),
        (["inspect", "a.stl", "--uni", "mm"], "--uni mm; did you mean --unit or --units?"),
        (["zzz"], "'zzz' is not a command; expected one of `autobalance --help`"),
        (["balance", "a.toml", "b.toml"], "for several jobs: `autobalance batch FOLDER -o DIR`"),
    ],
)
def test_a_command_that_is_none_names_the_one_that_is(
    asked: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run(*asked) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "choose from" not in error


def test_a_file_that_is_not_there_is_not_asked_for_its_unit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for verb in ("inspect", "init", "rod"):
        assert jobs.run(verb, tmp_path / "missing.stl") == 3
        error = capsys.readouterr().err
        assert f"{tmp_path / 'missing.stl'} does not exist" in error
        assert "unit" not in error


def test_what_is_no_report_and_no_job_is_told_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "balanced.stl").write_bytes(b"\xdc" * 200)
    (tmp_path / "notes.bin").write_bytes(b"\xdc" * 200)
    (tmp_path / "report.json").write_text(json.dumps({"command": "balance"}), encoding="utf-8")
    for asked, said in (
        (
            ("verify", tmp_path / "balanced.stl"),
            "is a solid, not a report; expected the report.json beside it",
        ),
        (("verify", tmp_path / "notes.bin"), "is not JSON, not even text; expected the report.json of a run"),
        (("verify", tmp_path.parent), "is a folder; expected a report"),
        (
            ("sheet", tmp_path),
            f"expected a report, such as {tmp_path / 'report.json'}",
        ),
        (("balance", tmp_path / "report.json"), "report.json is a report, not a job; expected the job file"),
    ):
        assert jobs.run(*asked) == 3
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1


@pytest.mark.slow
def test_the_folder_of_a_result_stands_for_its_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    jobs.computed(jobs.bundled_job(tmp_path), tmp_path / "out")
    capsys.readouterr()
    assert jobs.run("verify", tmp_path / "out") == 0
    assert f"{tmp_path / 'out' / 'report.json'}: all " in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\x89PNG\r\n\x1a\n" + bytes(200), "this is not an STL file: it is a PNG picture"),
        (b"PK\x03\x04" + bytes(200), "this is not an STL file: it is a ZIP archive"),
        (b"ISO-10303-21;\nHEADER;" + bytes(200), "it is a STEP file: name it .step"),
        (
            random.Random(3).randbytes(5000),
            "this is not an STL file: after 80 bytes it has its number of triangles",
        ),
    ],
)
def test_another_file_called_stl_is_named(
    data: bytes, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "crank.stl").write_bytes(data)
    assert jobs.run("inspect", tmp_path / "crank.stl", "--unit", "mm") == 3
    assert said in capsys.readouterr().err


def test_each_key_of_the_header_says_what_it_is() -> None:
    from autobalance.job.layout import JOB

    assert {key.name: key.says for key in JOB.keys}["engine"] == "name of the engine"
