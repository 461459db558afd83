"""A way in: a job made for a crank, filled in, put into a workbook and back; keys set from outside."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from openpyxl import load_workbook

import autobalance as ab
from autobalance.job.tables import key_at
from autobalance.toml_files.document import toml_text
from tests import jobs
from tests.coarse import bundled_corners

pytestmark = pytest.mark.usefixtures("cranks_read_once")

CRANK = jobs.BUNDLED / "straight" / "crank-with-pin.stl"
FILLED = {
    "crankshaft.density_kg_m3": 7850.0,
    "engine.rotating_g.connecting_rod_big_end": 95.04,
    "engine.rotating_g.big_end_bearing": 39.0,
    "engine.reciprocating_g.connecting_rod_small_end": 34.0,
    "engine.reciprocating_g.piston": 158.0,
    "engine.reciprocating_g.wrist_pin": 27.0,
    "engine.reciprocating_g.rings_clips_oil": 30.0,
    "balance.factor": 0.28,
    "balance.grade": 6.3,
    "balance.speed_rpm": 15200,
}


def refused(capsys: pytest.CaptureFixture[str], code: int, *arguments: str | Path) -> str:
    assert jobs.run(*arguments) == code
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


def filled() -> list[str]:
    return [word for key, value in FILLED.items() for word in ("--set", f"{key}={value}")]


@pytest.fixture
def crank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    jobs.write_stl(tmp_path / CRANK.name, bundled_corners("straight", pin=True))
    return tmp_path / CRANK.name


def report(path: Path) -> dict[str, Any]:
    values: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return values


def test_what_only_the_user_knows_is_left_and_the_rest_runs(
    crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("init", crank, "--unit", "mm", "--method", "shoulder") == 0
    job = crank.with_suffix(".toml")
    assert [line for line in job.read_text("utf-8").splitlines() if " = " in line and "#" not in line] == []
    error = refused(capsys, 3, "balance", job)
    assert 'crankshaft.density_kg_m3 is "FILL IN" (and 9 more); 10 left' in error
    assert jobs.run("balance", job, "--no-report", *filled(), "--json", "r.json") == 0
    found = report(Path("r.json"))
    assert found["job"]["engine"]["stroke_mm"] == 53.8
    assert found["job_set"] == [f"{key}={value}" for key, value in FILLED.items()]
    assert found["job"]["balance"]["tolerance_planes_mm"] == pytest.approx([-52.5516, 52.5516])


def test_inspect_needs_the_crankshaft_alone(crank: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("init", crank, "--unit", "mm", "--density-kg-m3", "7850") == 0
    assert jobs.run("inspect", "crank-with-pin.toml", "--json", "i.json") == 0
    from_file = ab.inspect(crank, unit="mm", density_kg_m3=7850.0).report
    assert report(Path("i.json"))["crank"] == from_file["crank"]
    capsys.readouterr()
    assert "--unit is not for a job" in refused(capsys, 2, "inspect", "crank-with-pin.toml", "--unit", "mm")
    with_set = ("--set", "crankshaft.density_kg_m3=7000", "--json", "s.json")
    assert jobs.run("inspect", crank, "--unit", "mm", *with_set) == 0
    assert report(Path("s.json"))["crank"]["mass_g"] == pytest.approx(
        from_file["crank"]["mass_g"] * 7.0 / 7.85
    )


def test_nothing_is_written_over_and_formats_need_their_unit(
    crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("init", crank, "--unit", "mm") == 0
    capsys.readouterr()
    assert "--force writes over it" in refused(capsys, 3, "init", crank, "--unit", "mm")
    assert jobs.run("init", crank, "--unit", "mm", "--force") == 0
    capsys.readouterr()
    assert "STL carries no unit" in refused(capsys, 3, "init", crank, "-o", "other.toml")
    assert "ends in .toml or .xlsx" in refused(capsys, 2, "init", crank, "--unit", "mm", "-o", "job.yaml")
    assert not Path("other.toml").exists()


@pytest.mark.parametrize("units", [["pm"], []])
def test_a_workbook_runs_to_the_same_numbers(
    crank: Path, capsys: pytest.CaptureFixture[str], units: list[str]
) -> None:
    assert jobs.run("init", crank, "--unit", "mm", "--method", "shoulder") == 0
    weight = "{ g = 158.0, pm = 0.1 }" if units else "158.0"
    settings = [*filled(), "--set", f"engine.reciprocating_g.piston={weight}"]
    assert jobs.run("init", "crank-with-pin.toml", "-o", "job.xlsx", *settings) == 0
    assert jobs.run("init", "job.xlsx", "-o", "back.toml") == 0
    assert jobs.run("balance", "crank-with-pin.toml", "--no-report", *settings, "--json", "a.json") == 0
    assert jobs.run("balance", "job.xlsx", "--no-report", "--json", "b.json") == 0
    assert jobs.run("balance", "back.toml", "--no-report", "--json", "c.json") == 0
    found = [report(Path(f"{name}.json")) for name in "abc"]
    for key in ("residual", "corrections", "initial", "balance_factor"):
        assert found[0][key] == found[1][key] == found[2][key]


def test_a_wrong_cell_is_named(crank: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("init", crank, "--unit", "mm", "-o", "job.xlsx", "--method", "shoulder") == 0
    capsys.readouterr()

    def changed(key: str, value: object, name: str | None = None) -> str:
        book = load_workbook("job.xlsx")
        sheet = book["Job"]
        for row in sheet.iter_rows(min_row=2):
            if row[0].value in FILLED and row[1].value == "FILL IN":
                row[1].value = FILLED[row[0].value]
            if row[0].value == key:
                row[0].value, row[1].value = name or key, value
        book.save("wrong.xlsx")
        return refused(capsys, 3, "balance", "wrong.xlsx", "--no-report")

    assert re.search(r"Job!B\d+: balance.grade is missing", changed("balance.grade", None))
    assert "Job!B" in changed("balance.grade", "fine")
    assert "balance.grade is 'fine'; must be a number" in changed("balance.grade", "fine")
    assert "balance.graed is an unknown key" in changed("balance.grade", 6.3, "balance.graed")
    assert "is in Job!B" in changed("balance.grade", 6.3, "balance.factor")
    assert "is a formula without a stored value" in changed("balance.grade", "=6+0.3")
    assert "has no sheet 'Job'" in _without_sheet(capsys)


def _without_sheet(capsys: pytest.CaptureFixture[str]) -> str:
    book = load_workbook("job.xlsx")
    book["Job"].title = "Sheet"
    book.save("other.xlsx")
    return refused(capsys, 3, "balance", "other.xlsx")


def test_units_that_people_type(crank: Path) -> None:
    values: dict[str, Any] = {
        "crankshaft": {"file": str(crank), "unit": "mm", "density_kg_m3": 7850.0},
        "engine": {
            "rotating_g": {"big_end": {"oz": 3.0, "pm": 0.1}},
            "reciprocating_g": {"piston": {"lb": 0.5}, "pin": {"kg": 0.05}},
        },
        "balance": {
            "factor": 0.5,
            "grade": 6.3,
            "speed_rpm": 9000,
            "overbalance_g_mm": "0.5 oz-in",
            "tolerance_planes_mm": ["-2 in", 50.8],
        },
        "correction": {"method": "drill", "drill": {"diameters_mm": ["3/8 in", '1/2"', 10]}},
    }
    path = crank.with_name("typed.toml")
    path.write_text(toml_text(values), encoding="utf-8")
    job = ab.read_job(path)
    weights = job.engine.default.weights
    assert weights.rotating["big_end"].mass_g == pytest.approx(3.0 * 28.349523125, rel=1e-15)
    assert weights.rotating["big_end"].pm_g == pytest.approx(2.8349523125, rel=1e-15)
    assert weights.reciprocating["piston"].mass_g == pytest.approx(226.796185, rel=1e-15)
    assert weights.reciprocating["pin"].mass_g == 50.0
    assert job.balance.overbalance_g_mm == pytest.approx(360.0389, abs=1e-4)
    assert job.balance.tolerance_planes_mm == (-50.8, 50.8)
    assert job.raw["correction"]["drill"]["diameters_mm"] == [9.525, 12.7, 10]


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("correction.drill.diameters_mm", '["9.5"]', "must be a number [mm] or a text with mm, cm, m, in"),
        ("correction.drill.diameters_mm", '["9.5 furlong"]', "correction.drill.diameters_mm[1]"),
        ("balance.overbalance_g_mm", '"3 lb.ft"', "with one of g·mm, kg·mm, g·cm, g·in, oz·in"),
        ("engine.rotating_g.x", "{ g = 1.0, oz = 2.0 }", "engine.rotating_g.x has g and oz"),
        (
            "engine.rotating_g.x",
            "{ stone = 1.0 }",
            "engine.rotating_g.x.g is missing; must have one of g, kg, oz",
        ),
        (
            "engine.rotating_g.x",
            '{ file = "no.stl", unit = "mm", density_kg_m3 = 7850 }',
            "no.stl does not exist",
        ),
        ("engine.throw[3].rods", "2", "the next is [1]"),
        ("balance.factor.x", "2", "is not a table"),
        ("balance..factor", "2", "is not a dotted key"),
    ],
)
def test_other_units_are_refused(
    crank: Path, key: str, value: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(crank.parent / "in")
    assert said in refused(capsys, 3, "balance", job, "--no-report", "--set", f"{key}={value}")


def test_a_weight_is_taken_from_its_solid(crank: Path) -> None:
    job = jobs.bundled_job(crank.parent / "in")
    import trimesh

    trimesh.creation.cylinder(radius=8.0, height=40.0, sections=256).export(job.with_name("pin.stl"))
    solid = '{ file = "pin.stl", unit = "mm", density_kg_m3 = 7850, density_pm_kg_m3 = 20 }'
    found = ab.read_job(job, [f"engine.reciprocating_g.wrist_pin={solid}"])
    weight = found.engine.default.weights.reciprocating["wrist_pin"]
    exact = 3.141592653589793 * 8.0**2 * 40.0 * 7850e-6
    assert weight.mass_g == pytest.approx(exact, rel=1e-5)
    assert weight.pm_g >= weight.mass_g * 20.0 / 7850.0
    assert abs(weight.mass_g - exact) <= weight.pm_g


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("crank-with-pin.stl", "type `autobalance balance crank-with-pin.stl --unit"),
        ("part.SLDPRT", "export STEP"),
    ],
)
def test_what_is_no_job_says_what_to_do(
    crank: Path, name: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path(name).touch()
    assert said in refused(capsys, 3, "balance", name)


def test_a_job_for_the_halves_of_a_pressed_up_crank(crank: Path, capsys: pytest.CaptureFixture[str]) -> None:
    halves = crank.parent / "halves.stl"
    jobs.write_stl(halves, bundled_corners())
    Path("halves.toml").write_text("", "utf-8")
    assert jobs.run("init", halves, "--unit", "mm", "--force", "--density-kg-m3", "7800") == 0
    assert "engine.crankpin_g.crankpin" in capsys.readouterr().out
    text = Path("halves.toml").read_text("utf-8")
    assert "crankpin_in_file = false" in text
    assert "density_kg_m3 = 7800.0" in text


def test_the_template_says_what_the_keys_are_declared_with(
    crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every key is there, each hint can be uncommented, and what was not filled in is the default."""
    assert jobs.run("init", crank, "--unit", "mm", "--method", "turn") == 0
    text = crank.with_suffix(".toml").read_text("utf-8")
    for key in (*key_at("balance").keys, *key_at("correction.turn").keys):
        assert re.search(rf"^(# )?{key.name} = .*  # .*\S", text, re.MULTILINE), key.name
    whole = re.sub(r"^# (?=\w+ = (?!\.\.\.)|\[)", "", text, flags=re.MULTILINE)
    Path("whole.toml").write_text(whole, "utf-8")
    assert ab.read_job("whole.toml", [f"{key}={value}" for key, value in FILLED.items()]).methods
    assert "--method is 'trun'; must be one of" in refused(capsys, 2, "init", crank, "--method", "trun")


def test_a_converted_job_says_what_its_keys_are(crank: Path) -> None:
    job = jobs.bundled_job(crank.parent / "in")
    assert jobs.run("init", job, "-o", "job.xlsx") == 0
    rows = {row[0]: row for row in load_workbook("job.xlsx")["Job"].iter_rows(values_only=True)}
    assert rows["balance.speed_rpm"][1:] == (15200, "1/min", "maximum service speed")
    assert rows["engine.rotating_g.big_end_bearing"][2] == "g"
    assert all(row[3] for row in rows.values())
