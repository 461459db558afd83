import io
import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

import autobalance as ab
from autobalance.command.console import ProgressLine
from autobalance.runtime import LIMITS_SOUGHT
from tests import jobs
from tests.coarse import bundled_corners


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def told(mode: str, stream: io.StringIO) -> str:
    times = iter([0.0, 0.1, 2.0, 6.0, 7.0])
    progress = ProgressLine(mode, stream, lambda: next(times))  # type: ignore[arg-type]
    for text in ("reading the crank", "cutting, pass 1", "writing"):
        progress(text)
    progress.done()
    return stream.getvalue()


def test_a_terminal_shows_what_runs_how_far_and_how_long_and_takes_it_away() -> None:
    text = told("usual", Terminal())
    assert "cutting, pass 1, about 2 s left" in text  # 45 % took 2.0 s
    assert " 65 %  writing, about 3 s left" in text
    assert text.endswith("\r\x1b[K")
    assert "\n" not in text


def test_a_file_or_pipe_and_quiet_show_nothing() -> None:
    assert told("usual", io.StringIO()) == ""
    assert told("quiet", Terminal()) == ""


def test_that_counterweights_are_too_light_is_told_without_a_terminal_too() -> None:
    stream = io.StringIO()
    line = ProgressLine("usual", stream)
    for _ in range(2):
        line("the counterweights are too light by 45 g·m, 22.5 g·m at each end")
        line("looking for limits that would suffice")
    line.done()
    words = "the counterweights are too light by 45 g·m, 22.5 g·m at each end; looking for what would help\n"
    assert stream.getvalue() == words
    quiet = io.StringIO()
    ProgressLine("quiet", quiet)("the counterweights are too light by 45 g·m")
    assert quiet.getvalue() == ""


@pytest.mark.slow
def test_compare_tells_each_kind_with_a_share_that_grows(tmp_path: Path) -> None:
    told: list[tuple[str, float]] = []
    job = jobs.bundled_job(tmp_path)
    jobs.write_stl(
        tmp_path / "crank.stl", bundled_corners(segments=24)
    )  # words and shares alone are looked at
    ab.compare(job, progress=lambda words, share: told.append((words, share)))
    kinds = [(words, share) for words, share in told if words.startswith("trying ")]
    assert [words for words, _ in kinds[:2]] == ["trying shoulder", "trying turn"]
    shares = [share for _, share in kinds]
    assert shares[0] == 0.1
    assert all(two > one for one, two in pairwise(shares))
    assert shares[-1] < 1.0


def test_verbose_keeps_a_line_for_each_step() -> None:
    assert told("verbose", io.StringIO()).count("\n") == 4


def test_json_on_standard_output_is_only_json_while_verbose(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import json

    job = jobs.bundled_job(tmp_path)
    assert (
        jobs.run("balance", job, "-o", tmp_path / "out", "--json", "-", "--verbose", "--only", "json,xlsx")
        == 0
    )
    out, err = capsys.readouterr()
    report = json.loads(out)
    assert set(report["outputs"]) == {"solid", "xlsx"}
    assert "cutting" in err
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"balanced.stl", "report.json", "balance.xlsx"}


def test_inspect_shows_its_steps_when_verbose_and_nothing_of_them_in_its_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    crank = jobs.bundled_job(tmp_path).with_name("crank.stl")
    words = ("inspect", crank, "--unit", "mm", "--no-crankpin", "--json", "-")
    assert jobs.run(*words, "--verbose") == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["command"] == "inspect"
    for step in ("reading and measuring", "looking for faces", "weighing the sections", "done"):
        assert re.search(rf"^ +[\d.]+ s  {step}", shown.err, re.MULTILINE)
    assert jobs.run(*words, "--quiet") == 0
    assert capsys.readouterr().err == ""


def test_no_report_writes_the_solid_and_the_json(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path)
    assert jobs.run("balance", job, "-o", tmp_path / "out", "--no-report") == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"balanced.stl", "report.json"}


def test_an_unknown_kind_of_page_is_wrong_use(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("balance", jobs.bundled_job(tmp_path), "--only", "html,docx") == 2
    assert "'docx' is not one of json, html, pdf, xlsx, png" in capsys.readouterr().err


def test_that_counterweights_are_too_light_stays_on_the_terminal_while_advice_goes_on() -> None:
    stream = Terminal()
    line = ProgressLine(stream=stream, clock=lambda: 0.0)
    for _ in range(2):  # once for the plan, once for the advice
        line("the counterweights are too light by 45 g·m, 22.5 g·m at each end")
    line("looking for limits that would suffice")
    line.done()
    assert len(re.findall(r"too light by 45 g·m, [^\r]*\n", stream.getvalue())) == 1
    assert stream.getvalue().index("too light") < stream.getvalue().index("looking for limits")


def test_a_terminal_is_told_that_the_search_for_advice_can_be_skipped() -> None:
    stream = Terminal()
    ProgressLine("usual", stream)(LIMITS_SOUGHT)
    assert f"{LIMITS_SOUGHT}; Ctrl-C skips this" in stream.getvalue()
