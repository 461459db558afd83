"""Jobs with kinds of correction beyond the shoulder, through the program's own door."""

import json
from pathlib import Path
from typing import Any

import pytest

from autobalance.correction import mixes
from tests.coarse import bundled_corners
from tests.jobs import main, write_stl

FIXTURE = Path(__file__).parents[2] / "fixtures" / "crf250r" / "drafted"


def job(folder: Path, correction: str, balance: str = "") -> Path:
    """The bundled job with another correction, in a folder of its own."""
    write_stl(folder / "crank.stl", bundled_corners(segments=64))
    text = (FIXTURE / "factor-0.28.toml").read_text(encoding="utf-8")
    head = text[: text.index("[correction]")].replace("speed_rpm = 15200", f"speed_rpm = 15200\n{balance}")
    path = folder / "job.toml"
    path.write_text(f"{head}[correction]\n{correction}\n", encoding="utf-8")
    return path


def run(path: Path, code: int = 0) -> dict[str, Any]:
    assert main(["balance", str(path), "-o", str(path.parent / "out"), "--no-report"]) == code
    report: dict[str, Any] = json.loads((path.parent / "out" / "report.json").read_text(encoding="utf-8"))
    return report


def assert_verified(path: Path, code: int = 0) -> None:
    assert main(["verify", str(path.parent / "out" / "report.json")]) == code


@pytest.mark.slow
def test_a_turned_crank_leaves_the_overbalance_and_says_where_the_last_holes_belong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """1500 g·mm is what the MSU thesis (Ruckle 2014, 3.1.1) leaves for drilling after manufacture."""
    path = job(tmp_path, 'method = "turn"', "overbalance_g_mm = 1500.0\noverbalance_deg = 180.0")
    report = run(path)
    left = report["overbalance"]
    assert left["unbalance_g_mm"] == pytest.approx([-1500.0, 0.0], abs=1e-9)
    assert left["angle_deg"] == pytest.approx(180.0)
    assert report["residual"]["magnitude_g_mm"] < 0.11
    assert "Left for final drilling: 1500.00 g·mm" in capsys.readouterr().out
    holes = left["last_holes"]
    taken = sum(hole["unbalance_change_g_mm"][0] for hole in holes)
    assert taken == pytest.approx(1500.0, abs=5.0)
    assert left["predicted_g_mm"] < report["tolerance"]["permissible_g_mm"]
    assert_verified(path)


@pytest.mark.slow
def test_without_overbalance_there_is_none(tmp_path: Path) -> None:
    report = run(job(tmp_path, 'method = "turn"'))
    assert report["overbalance"] is None
    assert report["job"]["correction"]["prefer"] == "simple"


@pytest.mark.slow
def test_drilled_and_verified_with_the_fewest_holes(tmp_path: Path) -> None:
    keys = 'method = "drill"\nprefer = "{}"\n[correction.drill]\ndiameters_mm = [8.0, 10.0]'
    path = job(tmp_path, keys.format("fewest_holes"))
    few = run(path)
    assert_verified(path)
    light = run(job(tmp_path, keys.format("least_metal")))
    assert few["outcome"] == light["outcome"] == "within_tolerance"
    assert len(few["corrections"]) <= len(light["corrections"])
    for hole in few["corrections"]:
        assert hole["kind"] == "drill"
        assert hole["wall_left_mm"] >= 3.0 - 2e-3
        assert hole["depth_mm"] / 0.1 == pytest.approx(round(hole["depth_mm"] / 0.1), abs=1e-6)


@pytest.mark.slow
def test_slugs_are_verified_though_the_file_does_not_hold_them(tmp_path: Path) -> None:
    table = 'method = ["slug", "turn"]\n[correction.slug]\ndiameters_mm = [16.0]\nlengths_mm = [8.0, 12.0]'
    path = job(tmp_path, table)
    run(path)
    assert_verified(path)


@pytest.mark.slow
def test_compare_prints_a_table_and_writes_its_values(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = job(
        tmp_path,
        'method = "turn"\n[correction.drill]\ndiameters_mm = [10.0]\n[correction.slug]\n'
        "diameters_mm = [16.0]\nlengths_mm = [8.0, 12.0]\n[correction.mill]\ncutter_mm = 10.0",
    )
    target = tmp_path / "comparison.json"
    assert main(["compare", str(path), "--json", str(target)]) == 0
    values = json.loads(target.read_text(encoding="utf-8"))
    out = capsys.readouterr().out
    names = ["+".join(row["method"]) for row in values["rows"]]
    assert names == [mix for mix in map("+".join, mixes()) if mix in names]
    assert set(names) >= {"shoulder", "turn", "drill", "slug", "add"}
    assert any("+" in name for name in names)  # those that need both kinds; others are the row of one kind
    assert all(name in out for name in names)
    assert "turn" in values["unbeaten"]
    within = [row for row in values["rows"] if row["outcome"] == "within_tolerance"]
    assert all(row["residual_share"] <= 1.0 and row["capacity"] >= 0.99 for row in within)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("correction", "balance", "message"),
    [
        ('method = "drill"\n[correction.drill]\ndiameters_mm = [40.0]', "", "larger than the counterweight"),
        ('method = "drill"\n[correction.drill]\nmin_depth_mm = 30.0', "", "min_depth_mm = 30 is above"),
        ('method = "drill"\n[correction.drill]\nsectors_deg = []', "", "excludes every angle"),
        ('method = "slug"\n[correction.slug]\ndiameters_mm = [80.0]', "", "fits into any counterweight"),
        ('method = "turn"\n[correction.turn]\nmin_radius_mm = 80.0', "", "no web reaches beyond"),
        ('method = "turn"\nprefer = "cheapest"', "", "correction.prefer"),
        ('method = "turn"', "tolerance_planes_mm = [10.0, 10.0]", "tolerance_planes_mm"),
        ('method = "turn"', "overbalance_g_mm = -1.0", "overbalance_g_mm"),
    ],
)
def test_bad_limits_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], correction: str, balance: str, message: str
) -> None:
    path = job(tmp_path, correction, balance)
    assert main(["balance", str(path), "-o", str(tmp_path / "out")]) == 3
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()
