"""What a screen of 80 columns shows: verdict first, lines broken between words, units of the shop."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from autobalance.command.terminal import shop_units
from autobalance.declare import decoded
from autobalance.job import Job
from autobalance.report.balance.zero import FROM_CRANKPIN, cut_rows
from autobalance.report.display_units import ON_SCREEN
from autobalance.report.files import from_here
from autobalance.report.records.balanced import Cut
from autobalance.report.tables import DRAWN_BY, fitted, fitted_table, plain_table, whole
from tests import jobs
from tests.frozen.outputs import HERE

WIDTH = 80
PRINTED = sorted(path for path in HERE.glob("*.txt") if not path.name.startswith("help"))


@pytest.mark.parametrize("path", PRINTED, ids=lambda path: path.stem)
def test_no_line_that_a_command_printed_is_longer_than_the_screen(path: Path) -> None:
    printed = path.read_text(encoding="utf-8").partition("\n== ")[0]
    assert [line for line in printed.splitlines() if len(line) > WIDTH] == []


@pytest.mark.parametrize("units", ["metric", "inch"])
def test_a_table_of_46_cuts_has_a_line_a_cut(units: str) -> None:
    cuts = [cut(number) for number in range(1, 47)]
    token = DRAWN_BY.set(lambda rows: fitted_table(rows, WIDTH))
    try:
        lines = cut_rows("Cuts to make", cuts, ON_SCREEN[units], FROM_CRANKPIN).splitlines()
    finally:
        DRAWN_BY.reset(token)
    assert len(lines) == 47
    assert max(map(len, lines)) <= WIDTH
    shown = lines[-1].split()
    length = ["12.3", "mm"] if units == "metric" else ["0.4843", "in"]
    assert shown[:2] == ["46.", "drill"]
    assert shown[shown.index("359.9°") + 1 :][:2] == length


def cut(number: int) -> Cut:
    item = {
        "kind": "drill",
        "number": number,
        "face": None,
        "web": 12,
        "angle_deg": 359.9,
        "diameter_mm": 12.7,
        "depth_mm": 12.3,
        "removed_mass_g": 123.45,
        "radius_mm": 100.0,
        "entry_radius_mm": 104.25,
        "position_mm": [100.0, 0.0, -301.5],
    }
    return decoded(Cut, item, partly=True)


def test_lines_are_broken_between_words_and_never_between_a_number_and_its_unit() -> None:
    text = "  - add 847.0 g·mm of metal at 176.35° and 722.7 g·mm at 357.34°, ± 0.5 mm of G 6.3 everywhere"
    for width in range(20, 100):
        lines = fitted(text, width).split("\n")
        assert max(map(len, lines)) <= width
        assert " ".join(" ".join(lines).split()) == text.strip()
        joined = "\n".join(lines)
        for whole_word in ("847.0 g·mm", "722.7 g·mm", "± 0.5 mm", "G 6.3"):
            assert whole_word in joined
    assert fitted(text, 60).split("\n")[1].startswith("    ")


def test_a_path_with_blanks_stays_whole_and_a_setting_too() -> None:
    path = Path("my cranks") / "the long name of a folder" / "report.html"
    setting = '--set \'correction.method=["drill", "slug"]\''
    text = f"Written: {whole(path)}, {whole(path)} and run it again with {setting}: leaves 0.30"
    lines = fitted(text, 60).split("\n")
    assert sum(str(path) in line for line in lines) == 2
    assert any(setting in line for line in lines)


def test_columns_that_find_no_room_follow_below() -> None:
    rows = [("Section", *"abcdefgh"), *((f"  web {n}", *["123456789"] * 8) for n in (1, 2))]
    shown = fitted_table(rows, 40)
    assert max(map(len, shown.splitlines())) <= 40
    assert shown.count("web 1") == 3
    assert sorted("".join(shown.split())) == sorted(
        "".join(plain_table(rows).split()) + 2 * "Sectionweb1web2"
    )


def test_the_first_three_lines_answer_and_the_last_says_what_to_open(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job, out = jobs.bundled_job(tmp_path, grade="40"), tmp_path / "out"
    assert jobs.run("balance", job, "-o", out, "--only", "html") == 0
    report = jobs.report_of(out)
    lines = capsys.readouterr().out.splitlines()
    metal = sum(each["removed_mass_g"] for each in report["corrections"])
    assert lines[0] == "WITHIN TOLERANCE, proven"
    assert lines[1].startswith("factor 0.82 → 0.28: face webs 1-2, 2 cuts of 2.78")
    assert lines[1].endswith(f"({metal:.2f} g)")
    worst = max(
        zip(report["residual"]["planes"], report["tolerance"]["planes"], strict=True),
        key=lambda pair: pair[0]["magnitude_g_mm"] / pair[1]["permissible_g_mm"],
    )
    assert re.fullmatch(rf"left {worst[0]['magnitude_g_mm']:.2f} ± [\d.]+ of .* permitted \(.*\)", lines[2])
    assert lines[3] == ""
    assert lines[4].startswith("Cuts to make")
    assert lines[-1] == f"Open: {from_here(out / 'report.html')}"
    assert not any(line.startswith("Balance factor") for line in lines)


def test_open_shows_the_page_in_the_browser(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = tmp_path / "seen"
    monkeypatch.setenv("BROWSER", f"sh -c 'echo %s > {seen}'")
    job = jobs.pin_job(tmp_path, speed_rpm="100")  # nothing to cut
    assert jobs.run("balance", job, "-o", tmp_path / "out", "--only", "html", "--open") == 0
    assert seen.read_text().strip() == (tmp_path / "out" / "report.html").resolve().as_uri()


def test_units_of_the_shop_rule_every_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.pin_job(tmp_path)
    (tmp_path / "shop.toml").write_text('[shop]\nunits = "inch"\n', encoding="utf-8")
    assert shop_units(job) == "inch"
    assert shop_units(job, ["shop.units=metric"]) == "metric"
    assert jobs.run("inspect", tmp_path / "crank-with-pin.stl", "--unit", "mm") == 0
    assert " oz·in" in capsys.readouterr().out
    assert jobs.run("inspect", job) == 0
    assert " oz·in" in capsys.readouterr().out
    assert jobs.run("inspect", job, "--units", "metric") == 0
    assert " g·mm" in capsys.readouterr().out


def test_a_shop_in_inches_sets_depths_in_steps_of_five_thousandths(tmp_path: Path) -> None:
    def step_mm(**correction: object) -> object:
        raw = {
            "shop": {"units": "inch"},
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
            "correction": {"method": "drill", **correction},
        }
        (limits,) = Job.from_dict(raw).methods
        return limits.depth_step_mm  # type: ignore[attr-defined]

    assert step_mm() == pytest.approx(0.005 * 25.4)
    assert step_mm(drill={"depth_step_mm": 0.2}) == 0.2
