"""``autobalance bearing`` from the command line: text, JSON, series, plots, exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from autobalance.command import main

FILM = """
kind = "hydrodynamic"
speed_rpm = [2000, 4000]
diameter_mm = 50
length_mm = 20
radial_clearance_mm = 0.025
viscosity_Pa_s = 0.01
load_N = 2000
solver = "ocvirk"
"""
HISTORY = """
[history]
file = "series.csv"
x = "main_1_x_N"
y = "main_1_y_N"
"""


def written(folder: Path, text: str = FILM) -> Path:
    path = folder / "bearing.toml"
    path.write_text(text, encoding="utf-8")
    rows = "".join(f"{5 * row},{1500 + 10 * row},0\n" for row in range(72))
    (folder / "series.csv").write_text("angle_deg,main_1_x_N,main_1_y_N\n" + rows)
    return path


def test_people_read_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bearing", str(written(tmp_path))]) == 0
    shown = capsys.readouterr().out
    assert "Hydrodynamic journal bearing" in shown
    assert "eccentricity ratio" in shown
    assert "Sommerfeld number" in shown


def test_json_is_all_of_standard_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bearing", str(written(tmp_path)), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert list(report)[:4] == ["schema_version", "autobalance", "command", "input"]
    assert report["command"] == "bearing"
    assert [row["speed_rpm"] for row in report["rows"]] == [2000, 4000]


def test_series_and_plots_are_written(tmp_path: Path, rough_plots: None) -> None:
    pytest.importorskip("matplotlib")
    path, series = written(tmp_path, FILM + HISTORY), tmp_path / "orbit.csv"
    assert main(["bearing", str(path), "--series", str(series), "--plots", str(tmp_path / "plots")]) == 0
    assert series.read_text().startswith("angle_deg,e_x,e_y,film_mm\n0,")
    assert len(series.read_text().splitlines()) == 73
    names = {file.name for file in (tmp_path / "plots").iterdir()}
    assert names == {
        f"{name}.{ending}"
        for name in ("film-pressure", "orbit", "film-thickness", "moment")
        for ending in ("svg", "png")
    }


def test_a_series_without_a_history_is_wrong_use(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path)
    assert main(["bearing", str(path), "--series", str(tmp_path / "orbit.csv")]) == 2
    assert "needs a [history]" in capsys.readouterr().err
    assert not (tmp_path / "orbit.csv").exists()


def test_contact_is_no_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, FILM.replace("load_N = 2000", "load_N = 200000000"))
    assert main(["bearing", str(path), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["limit"] == "contact"
    assert report["friction"]["moment_N_m"] is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("viscosity_Pa_s = 0.01", "viscosity_Pa_s = 0"), "bearing.toml: viscosity_Pa_s is 0; must be > 0"),
        (("length_mm = 20", "lenght_mm = 20"), "did you mean 'length_mm'"),
        (('kind = "hydrodynamic"', "kind ="), "not valid TOML"),
    ],
)
def test_bad_input_is_one_line_and_3(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], words: str
) -> None:
    path = written(tmp_path, FILM.replace(*change))
    assert main(["bearing", str(path)]) == 3
    error = capsys.readouterr().err
    assert words in error
    assert error.startswith("autobalance: error: ")
    assert error.count("\n") == 1


def test_a_missing_file_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bearing", str(tmp_path / "none.toml")]) == 3
    assert "none.toml" in capsys.readouterr().err
