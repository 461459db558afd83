"""Faults planted in the text of programs, and machine files that cannot be: each is refused in one line."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.command import main
from autobalance.correction.machining import HoleOperation
from autobalance.errors import FormatError, JobError
from autobalance.machining.area_moves import MachinedCrank, Stock
from autobalance.machining.input import read_machine_tool
from autobalance.machining.interpreter import read_program
from autobalance.machining.run import NcRun, nc_run, refuse_travel, simulated
from autobalance.toml_files.document import toml_text
from tests import nc_jobs
from tests.jobs import without_advice

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]
SEGMENTS = 32


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return nc_jobs.balanced(tmp_path_factory.mktemp("faults"), "radial", SEGMENTS)


@pytest.fixture(scope="module")
def part(report: Path) -> MachinedCrank:
    return nc_jobs.part_of(report)


@pytest.fixture(scope="module")
def run(part: MachinedCrank) -> NcRun:
    return nc_run(part, read_machine_tool(nc_jobs.machine()))


def replayed(run: NcRun, edit: Callable[[str], str]) -> NcRun:
    programs = []
    for program in run.programs:
        text = edit(program.text)
        assert text != program.text
        programs.append(replace(program, text=text, moves=tuple(read_program(text))))
    return simulated(run.part, run.machine, run.plan, programs)


def moved(letter: str, by: float, line: str = "G83") -> Callable[[str], str]:
    def edit(text: str) -> str:
        def word(found: re.Match[str]) -> str:
            return f"{letter}{float(found[1]) + by:.4f}"

        rows = [
            re.sub(rf"{letter}(-?[\d.]+)", word, row) if line in row else row for row in text.splitlines()
        ]
        return "\n".join(rows)

    return edit


def other_sign(text: str) -> str:
    return re.sub(r"A(\d+\.\d+)", lambda found: f"A{360.0 - float(found[1]):.4f}", text)


def first_hole_missing(text: str) -> str:
    rows = text.splitlines()
    rows.remove(next(row for row in rows if "G83" in row))
    return "\n".join(rows)


FAULTS: dict[str, tuple[Callable[[str], str], str]] = {
    "sign": (other_sign, "beyond the plan"),
    "too deep": (moved("Z", -0.1), "takes"),
    "too shallow": (moved("Z", 0.1), "takes"),
    "a hole missing": (first_hole_missing, "takes 0 g of"),
    "beside": (moved("X", 0.5), "beyond the plan"),
    "low rapid": (moved("Z", -8.0, "G0"), "too near to web"),
    "low plane": (moved("R", -4.0), "too near to web"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_refused(run: NcRun, name: str) -> None:
    edit, why = FAULTS[name]
    with pytest.raises(JobError, match=why):
        replayed(run, edit)


def test_flutes_are_those_of_drills_and_mills() -> None:
    turning = {key: value for key, value in nc_jobs.tool(4, "turning").items() if key != "flute_mm"}
    found = read_machine_tool(nc_jobs.machine(tool=[turning]))
    assert found.tools[0].flute_mm == found.tools[0].stick_out_mm == 95.0
    drill = nc_jobs.tool(1, "drill", diameter_mm=10.0)
    del drill["flute_mm"]
    with pytest.raises(JobError, match=r"tool\[1\].flute_mm is missing; a drill needs it"):
        read_machine_tool(nc_jobs.machine(tool=[drill]))


def test_comments_of_fanuc_hold_no_end_of_a_block(part: MachinedCrank) -> None:
    run = nc_run(part, read_machine_tool(nc_jobs.machine(post="fanuc")))
    for program in run.programs:
        assert "RUN 100 MM ABOVE THE PART FIRST, NOT PROVEN ON A MACHINE" in program.text
        assert ";" not in program.text


def test_a_holder_that_is_too_wide_is_refused(part: MachinedCrank) -> None:
    drill = nc_jobs.tool(
        1, "drill", diameter_mm=10.0, flute_mm=20.0, stick_out_mm=20.0, holder=[[80.0, 50.0]]
    )
    deeper = []
    for cut in part.cuts:
        assert isinstance(cut.operation, HoleOperation)
        deeper.append(replace(cut, operation=replace(cut.operation, depth_mm=19.0)))
    deep = replace(part, cuts=tuple(deeper))
    with pytest.raises(JobError, match=r"holder of tool 1 reaches \d+\.\d mm into web \d at cut \d"):
        nc_run(deep, read_machine_tool(nc_jobs.machine(tool=[drill])))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("G2 X1.0000\nM30", "G2"),
        ("G0 X1.0000 K3.0000\nM30", "K"),
        ("G0 X1.0000", "no M30"),
        ("M30\nG0 X1.0000", "after M30"),
        ("G0 X=1\nM30", "not understood"),
        ("G81 X0.0000 Y0.0000 Z1.0000 R2.0000\nM30", "no known height"),
    ],
)
def test_the_interpreter_takes_nothing_that_it_does_not_know(text: str, why: str) -> None:
    with pytest.raises(FormatError, match=why):
        read_program(text)


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "unknown key": (nc_jobs.machine(machine={"post": "fanuc", "max_rmp": 1}), "max_rmp is an unknown key"),
    "post": (nc_jobs.machine("heidenhain"), "expected one of linuxcnc, fanuc"),
    "tool twice": (nc_jobs.machine(tool=[nc_jobs.tool(1, "drill", diameter_mm=9.0)] * 2), "another tool has"),
    "rpm": (nc_jobs.machine(tool=[nc_jobs.tool(1, "drill", diameter_mm=10.0, rpm=9000)]), "machine.max_rpm"),
    "no speed": (
        nc_jobs.machine(tool=[nc_jobs.tool(1, "drill", diameter_mm=10.0, cutting_m_min=90.0)]),
        "has both of rpm and cutting_m_min",
    ),
    "no tool": (
        nc_jobs.machine(tool=[nc_jobs.tool(1, "drill", diameter_mm=9.0)]),
        "no tool fits; expected a drill with diameter_mm = 10",
    ),
    "short flutes": (
        nc_jobs.machine(tool=[nc_jobs.tool(1, "drill", diameter_mm=10.0, flute_mm=2.0)]),
        "flute_mm = 2",
    ),
    "crankpin": (nc_jobs.machine(zero={"angle": "crankpin 9", "z_mm": 0.0}), 'zero.angle is "crankpin 9"'),
    "no tools": (nc_jobs.machine(tool=[]), "[[tool]] is missing"),
    "datum": (nc_jobs.machine(zero={"angle": 0.0, "z_mm": "G"}), 'zero.z_mm is "G"'),
    "code": (nc_jobs.machine(rotary={"unclamp": "M11"}), "not a code of LinuxCNC"),
    "travel": (
        nc_jobs.machine(machine={"post": "fanuc", "max_rpm": 8000, "travel_mm": [100.0, 400.0, 400.0]}),
        "of X for the crank",
    ),
    "travel of z": (
        nc_jobs.machine(machine={"post": "fanuc", "max_rpm": 8000, "travel_mm": [500.0, 400.0, 90.0]}),
        "of Z for the crank and tool 1",
    ),
    "sign": (nc_jobs.machine(rotary={"sign": 2}), "rotary.sign is 2"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_machine_file_that_cannot_be(part: MachinedCrank, name: str) -> None:
    values, why = BAD[name]
    with pytest.raises(JobError) as raised:
        nc_run(part, read_machine_tool(values))
    assert why in str(raised.value)
    assert "\n" not in str(raised.value)


def test_what_no_set_up_reaches_is_left_out(part: MachinedCrank) -> None:
    without = nc_jobs.machine()
    del without["rotary"]
    found = nc_run(part, read_machine_tool(without))
    assert found.programs == ()
    assert not found.is_complete
    assert {each.why for each in found.plan.not_programmed} == {"the machine file has no [rotary] axis"}
    assert found.residual.magnitude_g_mm > 10.0 * part.residual.magnitude_g_mm


def test_metal_left_on_purpose_is_what_the_machine_will_read(part: MachinedCrank, run: NcRun) -> None:
    values = nc_jobs.machine()
    values["zero"]["finish_mm"] = 0.5
    found = nc_run(part, read_machine_tool(values))
    per_mm = sum(math_hypot(cut.item["unbalance_per_mm_g_mm"]) for cut in part.cuts)
    assert found.residual.magnitude_g_mm == pytest.approx(0.5 * per_mm, rel=0.1)
    assert found.left_mm3 > run.left_mm3 + 50.0


def math_hypot(values: list[float]) -> float:
    return float((values[0] ** 2 + values[1] ** 2) ** 0.5)


TOML = """
[machine]
post = "fanuc"
max_rpm = 8000
[rotary]
sign = -1
unclamp = "M11"
clamp = "M10"
[zero]
angle = 90.0
z_mm = "F"
[[tool]]
number = 1
kind = "drill"
diameter_mm = 10.0
flute_mm = 40.0
stick_out_mm = 80.0
holder = [[32.0, 60.0]]
rpm = 800
feed_mm_min = 90.0
"""


def test_the_command_writes_all_files(
    report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    machine = tmp_path / "machine.toml"
    machine.write_text(TOML, encoding="utf-8")
    assert main(["nc", str(report), str(machine), "-o", str(tmp_path / "nc"), "--json", "-"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert {each.name for each in (tmp_path / "nc").iterdir()} == {"nc.json", "setup.pdf", "setup-R.nc"}
    text = (tmp_path / "nc" / "setup-R.nc").read_text(encoding="ascii")
    lines = text.splitlines()
    assert (lines[0], lines[1], lines[-2], lines[-1]) == ("%", "O1000", "M30", "%")
    assert max(map(len, lines)) <= 80
    assert all(line == line.upper() for line in lines)
    assert (
        lines.index("M11")
        < next(k for k, line in enumerate(lines) if line.startswith("G0 A"))
        < lines.index("M10")
    )
    item = json.loads(report.read_text(encoding="utf-8"))["corrections"][0]
    angle = (-(item["angle_deg"] - 90.0)) % 360.0
    assert f"G0 A{angle:.4f}" in lines
    assert values["simulated"]["gouged_mm3"] == 0.0
    assert values["command"] == "nc"


def test_an_edited_report_is_refused_and_nothing_written(
    report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(report.parent.parent, folder)
    machine = tmp_path / "machine.toml"
    machine.write_text(TOML, encoding="utf-8")
    path = folder / "out" / "report.json"
    values = json.loads(path.read_text(encoding="utf-8"))
    values["corrections"][0]["depth_mm"] += 1.0
    path.write_text(json.dumps(values), encoding="utf-8")
    assert main(["nc", str(path), str(machine), "-o", str(tmp_path / "nc")]) == 3
    assert "but" in capsys.readouterr().err
    (folder / "out" / "balanced.stl").unlink()
    assert main(["nc", str(path), str(machine), "-o", str(tmp_path / "nc")]) == 3
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert not (tmp_path / "nc").exists()


def test_programs_are_text_in_python(report: Path) -> None:
    result = ab.nc(report, nc_jobs.machine(), finish_mm=0.2)
    assert list(result.programs) == ["setup-R.ngc"]
    assert "0.2 mm are left on every depth" in result.programs["setup-R.ngc"]


@pytest.mark.parametrize("name", BAD)
def test_the_command_refuses_a_machine_file_in_one_line(
    report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    values, why = BAD[name]
    machine = tmp_path / "machine.toml"
    machine.write_text(toml_text(values), encoding="utf-8")
    assert main(["nc", str(report), str(machine), "-o", str(tmp_path / "nc")]) == 3
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert why in error
    assert [each.name for each in tmp_path.iterdir()] == ["machine.toml"]


def other_version(values: dict[str, Any]) -> None:
    values["schema_version"] = "0.1"


def no_cuts(values: dict[str, Any]) -> None:
    values["corrections"] = []


OTHER_REPORTS: dict[str, tuple[Callable[[dict[str, Any]], None], str]] = {
    "another version": (other_version, "schema_version"),
    "no cuts": (no_cuts, "corrections"),
}


@pytest.mark.parametrize("name", OTHER_REPORTS)
def test_the_command_refuses_another_report_in_one_line(
    report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    edit, why = OTHER_REPORTS[name]
    folder = tmp_path / "copy"
    shutil.copytree(report.parent.parent, folder)
    machine = tmp_path / "machine.toml"
    machine.write_text(TOML, encoding="utf-8")
    path = folder / "out" / "report.json"
    values = json.loads(path.read_text(encoding="utf-8"))
    edit(values)
    path.write_text(json.dumps(values), encoding="utf-8")
    assert main(["nc", str(path), str(machine), "-o", str(tmp_path / "nc")]) == 3
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert why in error
    assert not (tmp_path / "nc").exists()


@pytest.mark.parametrize(("report_name", "machine_name"), [("none.json", "machine.toml"), ("", "none.toml")])
def test_what_is_not_there_is_one_line(
    report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], report_name: str, machine_name: str
) -> None:
    (tmp_path / "machine.toml").write_text(TOML, encoding="utf-8")
    path = tmp_path / report_name if report_name else report
    assert main(["nc", str(path), str(tmp_path / machine_name), "-o", str(tmp_path / "nc")]) == 3
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert (report_name or machine_name) in error
    assert not (tmp_path / "nc").exists()


def test_a_report_above_tolerance_is_programmed_and_ends_with_4(tmp_path: Path) -> None:
    with without_advice():
        path = nc_jobs.balanced(
            tmp_path / "crank", "radial", SEGMENTS, change=(" }", ", max_depth_mm = 2.5, max_holes = 1 }")
        )
    assert json.loads(path.read_text(encoding="utf-8"))["outcome"] == "above_tolerance"
    machine = tmp_path / "machine.toml"
    machine.write_text(TOML, encoding="utf-8")
    assert main(["nc", str(path), str(machine), "-o", str(tmp_path / "nc")]) == 4
    values = json.loads((tmp_path / "nc" / "nc.json").read_text(encoding="utf-8"))
    assert values["not_programmed"] == []
    assert values["simulated"]["used_share"] > 1.0


def test_a_tool_is_not_driven_into_the_table(tmp_path: Path) -> None:
    upright = nc_jobs.part_of(nc_jobs.balanced(tmp_path / "axial", "axial", SEGMENTS))
    run = nc_run(upright, read_machine_tool(nc_jobs.machine()))
    stock = Stock(upright.before, upright.anatomy)
    edit = moved("Z", -200.0)
    low = [replace(program, moves=tuple(read_program(edit(program.text)))) for program in run.programs]
    refuse_travel(run.programs, stock, run.machine, run.zero)
    with pytest.raises(JobError, match=r"tool 1 goes [\d.]+ mm below the crank's end, into the table"):
        refuse_travel(low, stock, run.machine, run.zero)
