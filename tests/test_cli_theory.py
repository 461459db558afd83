"""The commands ``forces``, ``shafts``, ``parts`` and ``grade``: what they print, write and refuse."""

from __future__ import annotations

import json
import math
import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.report.plots import FILLS, STYLES
from autobalance.running_gear.slider_crank import harmonic_coefficient
from tests.coarse import bundled_corners
from tests.jobs import BUNDLED, main, write_stl
from tests.libraries import uninstalled

SPEED = 15200 * 2.0 * math.pi / 60.0
PRIMARY_N = 261.5 * 26.9 * SPEED**2 * 1e-6

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
crankpin_in_file = false
[engine]
rod_length_mm = 104.0
stroke_mm = 53.8
[engine.rotating_g]
big_end = { g = 95.04, pm = 0.3 }
bearing = 39.00
[engine.reciprocating_g]
small_end = { g = 34.00, pm = 0.4 }
rest = 227.50
[engine.crankpin_g]
crankpin = 114.65
[balance]
factor = 0.28
grade = 6.3
speed_rpm = 15200
[correction]
method = "shoulder"
"""


@pytest.fixture
def job(tmp_path: Path) -> Path:
    path = tmp_path / "job.toml"
    path.write_text(JOB, "utf-8")
    write_stl(tmp_path / "crank.stl", bundled_corners("straight"))
    return path


@pytest.fixture
def whole(job: Path) -> Path:
    """Return the job with the bundled crank itself."""
    shutil.copy(BUNDLED / "straight" / "crank.stl", job.parent)
    return job


def printed(capsys: pytest.CaptureFixture[str], *words: object) -> Any:
    """Run a command with ``--json -`` and return what it printed."""
    assert main([*(str(word) for word in words), "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


def refused(capsys: pytest.CaptureFixture[str], code: int, *words: object) -> str:
    """Run a command that must fail with one line and return that line."""
    assert main([str(word) for word in words]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


def more(job: Path, text: str, old: str = "", new: str = "") -> Path:
    """Change and extend a job."""
    job.write_text(job.read_text("utf-8").replace(old, new) + text, "utf-8")
    return job


# --- forces


def test_forces_of_the_motocross_crank(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = printed(capsys, "forces", whole)
    assert report["command"] == "forces"
    assert report["speed_rpm"] == 15200
    as_file, balanced = report["states"]
    assert as_file["balance_factor"] == pytest.approx(0.8183, abs=2e-4)
    orders = {order["order"]: order for order in balanced["force"]["orders"]}
    assert orders[1.0]["force_x_n"] == pytest.approx(0.72 * PRIMARY_N, rel=1e-4)
    assert orders[1.0]["force_y_n"] == pytest.approx(0.28 * PRIMARY_N, rel=1e-4)
    assert orders[1.0]["backward_n"] == pytest.approx(0.5 * PRIMARY_N, rel=1e-4)
    assert orders[2.0]["greatest_force_n"] == pytest.approx(
        harmonic_coefficient(2, 26.9 / 104.0) * PRIMARY_N, rel=1e-4
    )
    assert orders[0.5]["greatest_force_n"] == 0.0
    assert report["factors"]["least_first_order"] == pytest.approx(0.5)
    mains = balanced["loads"]["main_bearings"]
    assert mains[0]["greatest_n"] == pytest.approx(mains[1]["greatest_n"], rel=1e-3)  # a symmetric crank
    torque = balanced["loads"]["torque"]
    assert abs(torque["mean_n_m"]) < 1e-9 * torque["greatest_n_m"]


def test_measured_and_ideal_cranks_agree_where_the_measured_one_is_balanced(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = printed(capsys, "forces", job)["states"][0]["balance_factor"]
    more(job, "", "factor = 0.28", f"factor = {found!r}")
    as_file, ideal = printed(capsys, "forces", job)["states"]
    for key in ("greatest_n", "greatest_inline_n", "greatest_transverse_n"):
        assert as_file["force"][key] == pytest.approx(ideal["force"][key], rel=1e-3)
    for one, other in zip(as_file["loads"]["main_bearings"], ideal["loads"]["main_bearings"], strict=True):
        assert one["greatest_n"] == pytest.approx(other["greatest_n"], rel=2e-3)


def test_an_overhung_crank_has_force_and_moment_at_its_one_bearing(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All forces of a balanced single act in its cylinder's plane: the bearing takes them by their lever."""
    crank = ab.generate("single", file="crank.stl", settings={"journals": "first", "segments": 24})
    (job.parent / "overhung.stl").write_bytes(crank.data)
    text = (
        '[crankshaft]\nfile = "overhung.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0\n[engine]\n'
        "rod_length_mm = 120.0\n[engine.rotating_g]\na = 300.0\n[engine.reciprocating_g]\nb = 400.0\n"
        '[balance]\nfactor = 0.4\ngrade = 6.3\nspeed_rpm = 6000\njudge = "static"\n'
        '[correction]\nmethod = "drill"\n'
    )
    (job.parent / "overhung.toml").write_text(text, encoding="utf-8")
    report = printed(capsys, "forces", job.parent / "overhung.toml")
    force, loads = (report["states"][1][key] for key in ("force", "loads"))
    (main_bearing,), support = loads["main_bearings"], loads["support"]
    assert support["z_mm"] == main_bearing["z_mm"] < -10.0
    assert main_bearing["greatest_n"] == support["greatest_n"] == pytest.approx(force["greatest_n"], rel=1e-9)
    lever_m = 1e-3 * (report["moments_about_z_mm"] - support["z_mm"])
    assert support["greatest_moment_n_m"] == pytest.approx(lever_m * force["greatest_n"], rel=1e-6)
    assert "statically determinate" in support["says"]
    assert main(["forces", str(job.parent / "overhung.toml")]) == 0
    assert "support (z -" in capsys.readouterr().out


def test_forces_are_printed_as_tables(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["forces", str(job), "--factors", "0,1", "--transverse-weight", "2"]) == 0
    out = capsys.readouterr().out
    for words in (
        "main bearing 2",
        "wrist pin of cylinder 1",
        "N·m, mean 0",
        "  1.0000 ",
        "2 times as badly",
    ):
        assert words in out


def test_another_speed_scales_by_its_square(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fast = printed(capsys, "forces", job)["states"][1]["force"]["greatest_n"]
    slow = printed(capsys, "forces", job, "--speed-rpm", 7600)["states"][1]["force"]["greatest_n"]
    assert fast == pytest.approx(4.0 * slow)


def test_a_bare_rod_takes_its_small_end_off_the_wrist_pin(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = printed(capsys, "forces", job)["states"][1]["loads"]["cylinders"][0]
    more(
        job,
        "",
        "[engine.rotating_g]",
        "[engine.rod]\nbig_end_g = 95.04\nsmall_end_g = 34.0\n[engine.rotating_g]",
    )
    less = printed(capsys, "forces", job)["states"][1]["loads"]["cylinders"][0]
    assert less["wrist_pin"]["greatest_n"] / whole["wrist_pin"]["greatest_n"] == pytest.approx(
        (261.5 - 34.0) / 261.5, rel=1e-6
    )
    assert less["crankpin"] == whole["crankpin"]


PLOTS = {
    "force-over-angle": ("crank angle [°]", "force [N]"),
    "force-polar": ("force along cylinder 1 [N]", "force across [N]"),
    "orders": ("order of the crank speed [-]", "maximum force [N]"),
    "main-bearings-polar": ("load along x [N]", "load along y [N]"),
    "wrist-pins-polar": ("load along x [N]", "load along y [N]"),
    "crankpins-polar": ("load along x [N]", "load along y [N]"),
    "torque-over-angle": ("crank angle [°]", "torque [N·m]"),
}


def assert_told_apart(svg: str) -> None:
    """Check that a plot has colours, greys and those that the colour-blind tell apart."""
    colours = {match.group() for match in re.finditer(r"#[0-9a-f]{6}\b", svg)}
    assert colours
    allowed = {*(str(style["color"]) for style in STYLES), *FILLS}
    assert {each for each in colours if len({each[1:3], each[3:5], each[5:7]}) > 1} <= allowed


@pytest.mark.slow
def test_plots_are_svg_and_png_with_axes_and_units(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], rough_plots: None
) -> None:
    folder = tmp_path / "plots"
    assert main(["forces", str(job), "--plots", str(folder)]) == 0
    assert {path.name for path in folder.iterdir()} == {f"{n}.{end}" for n in PLOTS for end in ("svg", "png")}
    for name, labels in PLOTS.items():
        svg = (folder / f"{name}.svg").read_text("utf-8")
        assert all(label in svg for label in labels)
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert_told_apart(svg)
    first = (folder / "force-polar.svg").read_bytes()
    assert main(["forces", str(job), "--plots", str(folder)]) == 0
    assert (folder / "force-polar.svg").read_bytes() == first
    assert "force-polar.svg" in capsys.readouterr().out


def test_without_matplotlib_one_line_says_what_to_install(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    uninstalled(monkeypatch, "matplotlib")
    error = refused(capsys, 3, "forces", job, "--plots", tmp_path / "plots")
    assert "pip install 'autobalance[plots]'" in error
    assert not (tmp_path / "plots").exists()


def test_forces_refuse_what_is_missing_or_wrong(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--factors is '0,x'" in refused(capsys, 2, "forces", job, "--factors", "0,x")
    assert "each must be 0 to 1" in refused(capsys, 2, "forces", job, "--factors", "0,2")
    assert "--speed-rpm is -1; must be > 0" in refused(capsys, 2, "forces", job, "--speed-rpm=-1")
    assert "--transverse-weight is -1" in refused(capsys, 2, "forces", job, "--transverse-weight=-1")
    assert "would overwrite the job" in refused(capsys, 2, "forces", job, "--json", job)
    text = job.read_text("utf-8")
    more(job, "", "rod_length_mm = 104.0\n")
    assert "engine.rod_length_mm is missing; forces need it" in refused(capsys, 3, "forces", job)
    job.write_text(text, "utf-8")
    more(job, "", "rod_length_mm = 104.0", "rod_length_mm = 20.0")
    assert "rod length is 20 mm; must be more than crank radius" in refused(capsys, 3, "forces", job)
    job.write_text(text, "utf-8")
    more(job, "", "stroke_mm = 53.8", "stroke_mm = 53.8\nrods_per_throw = 2")
    error = refused(capsys, 3, "forces", job)
    assert "engine.layout.bank_deg is missing; 2 rods on throw 1" in error
    assert error.count(job.name) == 1
    more(job, "", "[engine.rotating_g]", "[engine.layout]\nbank_deg = [0]\n[engine.rotating_g]")
    assert "engine.layout.bank_deg has 1 angle for the 2 rods" in refused(capsys, 3, "forces", job)
    more(job, "", "big_end = { g = 95.04", "big_end = { g = -95.04")
    assert "engine.rotating_g.big_end.g is -95.04; must be ≥ 0" in refused(capsys, 3, "forces", job)


def test_a_right_angled_twin_is_told_to_take_half(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more(job, "", "stroke_mm = 53.8", "stroke_mm = 53.8\nrods_per_throw = 2")
    more(
        job,
        "",
        "[engine.rotating_g]",
        "[engine.layout]\nbank_deg = [-45, 45]\nrod_pitch_mm = 10\n[engine.rotating_g]",
    )
    more(job, "", "factor = 0.28", "factor = 0.5")
    report = printed(capsys, "forces", job)
    first = report["states"][1]["force"]["orders"][1]
    assert first["order"] == 1.0
    assert first["greatest_force_n"] < 1e-6 * PRIMARY_N
    assert report["factors"]["least_first_order"] == pytest.approx(0.5)
    assert report["job"]["engine"]["layout"]["bank_deg"] == pytest.approx([-45.0, 45.0])


# --- shafts


def test_shafts_that_are_proposed_cancel_what_is_left(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = printed(capsys, "shafts", job)
    offers = {candidates["what"]: candidates["shafts"] for candidates in report["proposals"]}
    second = offers["all of the second order"]
    needed = harmonic_coefficient(2, 26.9 / 104.0) * 261.5 * 26.9
    assert [shaft["product_g_mm"] for shaft in second] == pytest.approx([needed / 8, needed / 8], rel=1e-4)
    forward, backward = offers["all of the first order"]
    assert forward["product_g_mm"] == pytest.approx(0.22 * 261.5 * 26.9, rel=1e-4)
    assert backward["product_g_mm"] == pytest.approx(0.5 * 261.5 * 26.9, rel=1e-4)
    assert offers["its backward part alone"] == [backward]
    lines = [
        "[[shafts]]\n"
        + "\n".join(
            f"{key} = {json.dumps(shaft[key])}" for key in ("order", "sense", "product_g_mm", "phase_deg")
        )
        for shaft in (*second, forward, backward)
    ]
    more(job, "\n".join(lines))
    left = {order["order"]: order for order in printed(capsys, "shafts", job)["with"]["orders"]}
    assert left[1.0]["greatest_force_n"] < 1e-6 * PRIMARY_N
    assert left[2.0]["greatest_force_n"] < 1e-6 * PRIMARY_N
    assert left[4.0]["greatest_force_n"] > 1e-4 * PRIMARY_N


SHAFT = """
[[shafts]]
order = 1
sense = "backward"
place_mm = [30.0, -40.0]
weight = [{ name = "counterweight", eccentricity_mm = 20.0, cad_g = 170.0, weighed_g = 171.7 },
          { name = "screws", eccentricity_mm = 5.0, cad_g = 12.0 }]
"""


def test_bolted_weights_are_weighed_and_the_roll_is_told(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more(job, SHAFT)
    report = printed(capsys, "shafts", job)
    (shaft,) = report["shafts"]
    assert shaft["product_g_mm"] == pytest.approx(171.7 * 20.0 + 60.0)
    assert shaft["weights"][0]["deviation"] == pytest.approx(0.01)
    force = shaft["product_g_mm"] * SPEED**2 * 1e-6
    assert report["with"]["greatest_roll_n_m"] == pytest.approx(0.050 * force, rel=1e-4)
    assert main(["shafts", str(job), "--units", "inch", "--plots", str(tmp_path / "p")]) == 0
    out = capsys.readouterr().out
    assert "(+1.00 %)" in out
    assert "not weighed" in out
    assert "oz·in" in out
    assert "with the job's shafts" in (tmp_path / "p" / "shafts-orders.svg").read_text("utf-8")


def test_moments_are_taken_about_a_chosen_place(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more(job, SHAFT.replace("order = 1", "order = 1\nz_mm = 25.0"))
    at_mains = printed(capsys, "shafts", job)
    assert at_mains["moments_about_z_mm"] == pytest.approx(0.0, abs=1e-3)
    elsewhere = printed(capsys, "shafts", job, "--reference-z", "10")
    assert elsewhere["moments_about_z_mm"] == 10.0
    first = next(order for order in elsewhere["without"]["orders"] if order["order"] == 1.0)
    assert first["greatest_moment_n_m"] == pytest.approx(0.010 * first["greatest_force_n"], rel=1e-3)
    forces = printed(capsys, "forces", job, "--reference-z", "10")
    assert forces["moments_about_z_mm"] == 10.0
    assert main(["forces", str(job)]) == 0
    assert "moments about z = " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('sense = "backward"', 'sense = "backwards"', "did you mean 'backward'?"),
        ("order = 1", "order = 0", "shafts[1].order is 0; must be ≥ 1"),
        ("order = 1", "order = 1\nproduct_g_mm = 5.0", "given beside weights; must be one or the other"),
        ("place_mm", "place", "shafts[1].place is an unknown key"),
        ("cad_g = 12.0", "cad_g = -1.0", "shafts[1].weight[2].cad_g is -1; must be ≥ 0"),
    ],
)
def test_shafts_refuse_what_is_wrong(
    job: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, words: str
) -> None:
    more(job, SHAFT.replace(old, new))
    assert words in refused(capsys, 3, "shafts", job)


def test_a_layout_without_angles_is_refused(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more(job, "", "[engine.rotating_g]", "[engine.layout]\nbank_deg = []\n[engine.rotating_g]")
    assert "engine.layout.bank_deg is an empty list" in refused(capsys, 3, "forces", job)


# --- parts


def test_parts_are_rolled_up_with_their_uncertainty(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more(job, "\n[[engine.throw]]\nnumber = 1\nrods = 2\nbank_deg = [0, 90]\n")
    every, first = printed(capsys, "parts", job)["throws"]
    assert every["number"] is None
    assert every["rotating"]["mass_g"] == pytest.approx(134.04)
    assert every["reciprocating"]["pm_g"] == pytest.approx(0.4)
    assert every["bob_weight_g"] == pytest.approx(321.91)
    assert every["bob_weight_pin_fitted_g"] == pytest.approx(207.26)
    assert every["bob_weight_pm_g"] == pytest.approx(math.hypot(0.3, 0.28 * 0.4))
    assert first["number"] == 1
    assert first["bob_weight_g"] == pytest.approx(114.65 + 2.0 * 207.26)
    assert first["bob_weight_pm_g"] == pytest.approx(2.0 * math.hypot(0.3, 0.28 * 0.4))


def test_parts_need_the_crank_only_for_its_original_factor(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = tomllib.loads(job.read_text("utf-8"))
    assert text["balance"]["factor"] == 0.28
    more(job, "", "crank.stl", "nowhere.stl")
    assert main(["parts", str(job), "--units", "inch"]) == 0
    out = capsys.readouterr().out
    assert "± 0.011 oz" in out
    assert "with the crankpin fitted" in out
    more(job, "", "factor = 0.28", 'factor = "original"')
    more(job, "\n[original.reciprocating_g]\npiston = 200.0\n[original.crankpin_g]\ncrankpin = 114.65\n")
    assert "nowhere.stl" in refused(capsys, 3, "parts", job)


def test_parts_show_what_two_masses_miss(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rod = "[engine.rod]\nbig_end_g = 95.04\nsmall_end_g = 34.0\ninertia_kg_mm2 = 300.0\n[engine.rotating_g]"
    more(job, "", "[engine.rotating_g]", rod)
    found = printed(capsys, "parts", job)["rod"]
    centre = 104.0 * 34.0 / 129.04
    assert found["centre_from_big_end_mm"] == pytest.approx(centre)
    assert found["couple_inertia_kg_mm2"] == pytest.approx(300.0 - 129.04e-3 * centre * (104.0 - centre))
    assert main(["parts", str(job)]) == 0
    assert "the bearing loads count the couple" in capsys.readouterr().out
    more(job, "", "big_end_g = 95.04\nsmall_end_g = 34.0", "big_end_g = 0\nsmall_end_g = 0")
    assert "engine.rod: mass of the connecting rod is 0 g" in refused(capsys, 3, "parts", job)


def drawn(folder: Path, names: dict[str, tuple[str, ...]]) -> dict[str, str]:
    """Check that a folder holds these plots, SVG and PNG, with these words; return the SVGs."""
    assert {path.name for path in folder.iterdir()} == {f"{n}.{end}" for n in names for end in ("svg", "png")}
    found = {name: (folder / f"{name}.svg").read_text("utf-8") for name in names}
    for name, words in names.items():
        assert all(f">{word}<" in found[name] for word in words), name
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert_told_apart(found[name])
    return found


def test_parts_are_drawn_with_their_uncertainty(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], rough_plots: None
) -> None:
    more(job, "\n[[engine.throw]]\nnumber = 1\nrods = 2\nbank_deg = [0, 90]\n")
    labels = ("motion of the parts [-]", "mass [g]", "every throw", "throw 1", "±, every throw")
    assert main(["parts", str(job), "--plots", str(tmp_path / "p")]) == 0
    assert "parts-weights.svg" in capsys.readouterr().out
    drawn(tmp_path / "p", {"parts-weights": labels})
    more(job, "", ", pm = 0.3", "")
    more(job, "", ", pm = 0.4", "")
    assert main(["parts", str(job), "--plots", str(tmp_path / "q")]) == 0
    (svg,) = drawn(tmp_path / "q", {"parts-weights": labels[:4]}).values()
    assert "±" not in svg


# --- grade


@pytest.mark.slow
def test_a_grade_is_drawn_between_its_neighbours(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rough_plots: None
) -> None:
    rotor = ["grade", "--mass", "2700", "--speed-rpm", "15200", "--plots"]
    assert main([*rotor, str(tmp_path / "p"), "--grade", "6.3"]) == 0
    lines = ("speed [1/min]", "G 16", "G 6.3", "G 2.5", "the rotor at its speed")
    found = drawn(
        tmp_path / "p",
        {"grade-specific": ("e_per [µm]", *lines), "grade-permissible": ("U_per [g·mm]", *lines)},
    )
    assert all(">G 40<" not in svg for svg in found.values())
    assert main([*rotor, str(tmp_path / "q"), "--residual", "7.39"]) == 0
    drawn(
        tmp_path / "q",
        {"grade-specific": ("G 6.3", "G 4.357", "G 2.5"), "grade-permissible": ("G 4.357",)},
    )
    assert main(["grade", "--plots", str(tmp_path / "all")]) == 0
    drawn(tmp_path / "all", {"grade-specific": ("e_per [µm]", "G 4000", "G 2.5")})
    assert main([*rotor, str(tmp_path / "none"), "--residual", "0"]) == 0
    drawn(tmp_path / "none", {"grade-specific": ("G 4000",), "grade-permissible": ("G 4000",)})
    capsys.readouterr()


def test_grade_permits_and_achieves(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["grade", "--grade", "6.3", "--speed-rpm", "15200", "--mass", "2.7", "--mass-unit", "kg"]
    report = printed(capsys, *words, "--residual", "7.39", "--planes", "-40", "40")
    assert report["permissible_g_mm"] == pytest.approx(10.6864168)
    assert report["specific_unbalance_um"] == pytest.approx(3.95793214)
    assert [plane["permissible_g_mm"] for plane in report["planes"]] == pytest.approx([5.34320839] * 2)
    assert report["achieved_grade_mm_s"] == pytest.approx(4.35665209)
    assert report["listed_grade_mm_s"] == 6.3
    off_centre = printed(capsys, *words, "--planes", "-40", "40", "--centre", "16")["planes"]
    assert off_centre[1]["permissible_g_mm"] == pytest.approx(0.7 * 10.6864168)
    in_ounces = printed(
        capsys, "grade", "--mass", "95.24", "--mass-unit", "oz", "--speed-rpm", 15200,
        "--residual", "0.0102628", "--residual-unit", "oz·in",
    )  # fmt: skip
    assert in_ounces["achieved_grade_mm_s"] == pytest.approx(4.3567, abs=1e-3)


def test_grade_alone_lists_the_grades(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["grade"]) == 0
    assert "G 630 " in capsys.readouterr().out
    coarse = ["grade", "--mass", "1000", "--speed-rpm", "6000", "--residual", "1e7"]
    assert main(coarse) == 0
    assert "coarser than any listed grade" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["--grade", "6.3"], "--mass and --speed-rpm missing"),
        (["--residual", "1", "--mass", "100"], "--speed-rpm missing"),
        (["--mass", "100", "--speed-rpm", "100"], "add --grade for the permissible unbalance, or --residual"),
        (["--grade=-1", "--mass", "1", "--speed-rpm", "1"], "--grade is -1; must be > 0"),
        (["--residual=-1", "--mass", "1", "--speed-rpm", "1"], "--residual is -1; must be ≥ 0"),
        (["--residual", "1", "--mass", "1", "--speed-rpm", "1", "--planes", "0", "1"], "--grade is missing"),
        (
            ["--grade", "1", "--mass", "1", "--speed-rpm", "1", "--planes", "1", "0"],
            "the first must be lower",
        ),
    ],
)
def test_grade_refuses_what_is_half_given(
    capsys: pytest.CaptureFixture[str], words: list[str], error: str
) -> None:
    assert error in refused(capsys, 2, "grade", *words)


# --- the report of ``balance``


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a balanced crank."""
    folder = tmp_path_factory.mktemp("forces")
    (folder / "job.toml").write_text(JOB, "utf-8")
    write_stl(folder / "crank.stl", bundled_corners("straight"))
    assert main(["balance", str(folder / "job.toml"), "-o", str(folder / "out"), "--no-report"]) == 0
    return folder / "out"


@pytest.mark.slow
def test_a_balance_report_tells_the_forces_before_and_after(
    whole: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = whole.parent / "out"
    assert main(["balance", str(whole), "-o", str(out), "--no-report"]) == 0
    capsys.readouterr()
    forces = json.loads((out / "report.json").read_text("utf-8"))["forces"]
    assert forces["speed_rpm"] == 15200
    before, after = (
        {order["order"]: order for order in forces[key]["orders"]} for key in ("before", "after")
    )
    assert before[1.0]["force_y_n"] == pytest.approx(0.8183 * PRIMARY_N, rel=1e-3)
    assert after[1.0]["force_y_n"] == pytest.approx(0.28 * PRIMARY_N, rel=3e-3)  # U_per is worth 0.15 %
    assert before[2.0] == after[2.0]  # no counterweight changes the second order
    ideal = printed(capsys, "forces", whole)["states"][1]["force"]
    assert forces["after"]["greatest_n"] == pytest.approx(ideal["greatest_n"], rel=3e-3)


@pytest.mark.slow
def test_without_a_rod_length_a_balance_report_has_the_first_order_alone(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more(job, "", "rod_length_mm = 104.0\n")
    out = job.parent / "out"
    assert main(["balance", str(job), "-o", str(out), "--no-report", "--verbose"]) == 0
    assert "against it" in capsys.readouterr().out
    forces = json.loads((out / "report.json").read_text("utf-8"))["forces"]
    assert forces["after"]["greatest_n"] is None
    assert [order["order"] for order in forces["after"]["orders"]] == [1.0]
    assert forces["after"]["orders"][0]["force_x_n"] == pytest.approx(0.72 * PRIMARY_N, rel=3e-3)


def test_without_the_cylinders_directions_a_balance_report_has_no_forces(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more(job, "", "stroke_mm = 53.8", "stroke_mm = 53.8\nrods_per_throw = 2")
    more(job, "", "factor = 0.28", "factor = 0.1")
    assert main(["balance", str(job), "-o", str(job.parent / "out"), "--json", "-", "--no-report"]) in (0, 4)
    assert json.loads(capsys.readouterr().out)["forces"] is None


def test_a_rod_too_short_stops_a_balance_before_it_cuts(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more(job, "", "rod_length_mm = 104.0", "rod_length_mm = 26.0")
    error = refused(capsys, 3, "balance", job, "-o", job.parent / "out")
    assert "rod length is 26 mm; must be more than crank radius" in error
    assert not (job.parent / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", ["after.greatest_n", "before.orders.1.force_y_n", "after.orders.3.greatest_force_n"]
)
def test_verify_checks_the_forces(
    done: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], path: str
) -> None:
    shutil.copytree(done, tmp_path / "out")
    shutil.copy(done.parent / "crank.stl", tmp_path)
    report = tmp_path / "out" / "report.json"
    assert main(["verify", str(report)]) == 0
    values = json.loads(report.read_text("utf-8"))
    place: Any = values["forces"]
    *way, key = path.split(".")
    for word in way:
        place = place[int(word)] if isinstance(place, list) else place[word]
    place[key] *= 1.001
    report.write_text(json.dumps(values), "utf-8")
    capsys.readouterr()
    assert key in refused(capsys, 3, "verify", report)
