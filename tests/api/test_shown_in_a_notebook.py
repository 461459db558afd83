"""Results show themselves in a notebook: verdict, numbers, pictures, tables."""

import pickle
import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import autobalance as ab
from autobalance.errors import JobError, UsageError
from autobalance.report.plots import Plots
from autobalance.verbs.entry import Entries
from tests.libraries import uninstalled

CHAIN = {
    "inertia": [{"name": "flywheel", "kg_mm2": 20000.0}, {"name": "pulley", "kg_mm2": 4000.0}],
    "spring": [{"N_m_rad": 9000.0}],
}


@pytest.fixture(scope="module")
def torsion() -> Any:
    return ab.torsion(CHAIN)


@pytest.fixture(scope="module")
def balanced() -> ab.BalanceResult:
    job = {
        "engine": {"rotating_g": {"big_end": 134.0}, "reciprocating_g": {"piston": 261.5}},
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
        "correction": {"method": "shoulder"},
    }
    return ab.balance(ab.Job.from_dict(job), crank=ab.generate("single", segments=24).crank)


def test_a_list_of_a_report_is_a_table_with_columns() -> None:
    cuts = Entries([{"web": 1, "depth_mm": 2.5}, {"web": 2, "depth_mm": None, "note": "<b>"}])
    assert cuts == pickle.loads(pickle.dumps(cuts))
    np.testing.assert_array_equal(cuts.column("web"), [1.0, 2.0])
    assert np.isnan(cuts.column("depth_mm")[1])
    assert "<td>2.5</td>" in cuts._repr_html_()
    assert "&lt;b&gt;" in cuts._repr_html_()
    with pytest.raises(UsageError, match="no 'angle' in this list; its keys: web, depth_mm, note"):
        cuts.column("angle")
    with pytest.raises(UsageError, match="note is not a number everywhere"):
        cuts.column("note")


def test_a_table_is_a_data_frame_where_pandas_is() -> None:
    pandas = pytest.importorskip("pandas")
    frame = Entries([{"web": 1, "depth_mm": 2.5}, {"web": 2}]).to_pandas()
    assert list(frame.columns) == ["web", "depth_mm"]
    assert pandas.isna(frame.depth_mm[1])


def test_a_result_gives_the_lists_of_its_report_by_name(torsion: Any) -> None:
    np.testing.assert_allclose(
        torsion.table("modes").column("frequency_hz")[-1],
        np.sqrt(9000.0 * (1.0 / 0.02 + 1.0 / 0.004)) / (2.0 * np.pi),
    )
    with pytest.raises(UsageError, match=r"no list 'mode'; its lists: .*modes"):
        torsion.table("mode")


def test_a_result_shows_its_words_and_its_first_plot(torsion: Any) -> None:
    assert "natural frequencies" in repr(torsion)
    shown = torsion._repr_html_()
    assert "flywheel" in shown
    assert "<svg" in shown


def test_what_is_no_job_is_told_what_one_is() -> None:
    for verb in (ab.balance, ab.forces, ab.compare):
        with pytest.raises(JobError, match="job is 3; expected a job, the path of a job file, or a dict"):
            verb(3)  # type: ignore[arg-type]


def test_plots_draw_themselves(torsion: Any) -> None:
    plots = torsion.plots()
    assert isinstance(plots, Plots)
    assert ET.fromstring(plots["torsion-modes"]._repr_svg_()).tag.endswith("svg")
    assert plots["torsion-modes"]["png"].startswith(b"\x89PNG")
    assert "torsion-modes" in plots._repr_html_()
    assert pickle.loads(pickle.dumps(plots)) == plots


def test_a_plot_is_drawn_when_its_file_is_first_read(torsion: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(Figure, "savefig", lambda *_, **how: drawn.append(how["format"]))
    plots = torsion.plots()
    assert (len(plots["torsion-modes"]), drawn) == (2, [])
    _ = plots["torsion-modes"]["svg"]
    _ = plots["torsion-modes"]["svg"]
    assert drawn == ["svg"]
    with pytest.raises(KeyError):
        _ = plots["torsion-modes"]["pdf"]


def test_a_balance_shows_its_verdict_the_permitted_circle_and_its_cuts(balanced: ab.BalanceResult) -> None:
    shown = balanced._repr_html_()
    assert "Within tolerance" in shown
    assert shown.count("p-ok permitted") == (1 + len(balanced.tolerance.planes))
    assert f"<td>{balanced.corrections[0].depth_mm:.6g}</td>" in shown
    assert "shoulder" in balanced.corrections._repr_html_()


def test_a_crank_shows_its_numbers_and_a_picture(balanced: ab.BalanceResult) -> None:
    shown = balanced.crank._repr_html_()
    assert f"{balanced.crank.mass_g:.6g} g" in shown
    assert "e-1" not in shown.split("<img")[0]  # dust is zero
    assert "data:image/png;base64," in shown


def test_a_view_without_the_widget_is_a_picture(
    balanced: ab.BalanceResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    uninstalled(monkeypatch, "anywidget")
    for each in (balanced, balanced.crank):
        assert each.show()._repr_png_().startswith(b"\x89PNG")


def test_a_view_with_the_widget_turns(balanced: ab.BalanceResult) -> None:
    pytest.importorskip("anywidget")
    assert balanced.show().kind == "result"
    assert balanced.crank.show().kind == "crank"


def test_a_job_is_one_line() -> None:
    job = ab.Job.from_dict(
        {
            "crankshaft": {"file": "crank.stl", "unit": "mm", "density_kg_m3": 7850.0},
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
            "correction": {"method": "drill"},
        }
    )
    assert repr(job) == "<autobalance job job.toml: crank.stl, factor 0.5, G 6.3 at 9000 rpm>"
