"""External balance: what damper and flexplate carry, against statics by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pypdf import PdfReader

import autobalance as ab
from autobalance.balancing.external import carried, carried_unbalances, with_external
from autobalance.balancing.rotor_from_job import tolerance_of
from autobalance.command import main
from autobalance.errors import JobError
from autobalance.job.model import ExternalPart
from autobalance.job.read import load
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

TOLERANCE = Tolerance.of(
    grade_mm_s=6.3,
    service_speed_rad_s=600.0,
    rotor_mass_g=20000.0,
    z_centre_mm=150.0,
    planes_z_mm=(0.0, 300.0),
    judge="dynamic",
)
BARE = Unbalance(np.array([900.0, -400.0]), np.array([4.1e5, 2.3e5]))


def left(parts: list[ExternalPart], found: list[Any]) -> Unbalance:
    resultant = BARE.resultant_g_mm + sum(found)
    moment = BARE.moment_g_mm2 + sum(part.z_mm * each for part, each in zip(parts, found, strict=True))
    return Unbalance(np.asarray(resultant), np.asarray(moment))


def test_two_parts_cancel_resultant_and_moment() -> None:
    parts = [ExternalPart("flexplate", 420.0), ExternalPart("damper", -60.0)]
    found = carried(parts, BARE, TOLERANCE)
    residual = left(parts, found)
    assert residual.resultant_g_mm == pytest.approx([0.0, 0.0], abs=1e-9)
    assert residual.moment_g_mm2 == pytest.approx([0.0, 0.0], abs=1e-6)


def test_one_part_leaves_the_least_worst_plane() -> None:
    parts = [ExternalPart("flywheel", 360.0)]
    found = carried(parts, BARE, TOLERANCE)
    worst = TOLERANCE.used_share(left(parts, found))
    rng = np.random.default_rng(4)
    size = np.abs(BARE.resultant_g_mm).max()
    for step in (1.0, 0.1, 1e-2, 1e-3):
        for _ in range(200):
            other = [found[0] + step * size * rng.normal(size=2)]
            assert TOLERANCE.used_share(left(parts, other)) > worst * (1.0 - 1e-6)


def test_limits_and_directions_are_kept() -> None:
    parts = [
        ExternalPart("damper", -60.0, max_g_mm=300.0, angle_rad=math.pi),
        ExternalPart("flexplate", 420.0, max_g_mm=500.0),
    ]
    found = carried(parts, BARE, TOLERANCE)
    assert abs(found[0][1]) < 1e-9
    assert -300.0 * (1.0 + 1e-6) <= found[0][0] <= 1e-6
    assert math.hypot(*found[1]) <= 500.0 * (1.0 + 1e-6)
    assert TOLERANCE.used_share(left(parts, found)) < TOLERANCE.used_share(BARE)


# --- a whole run --------------------------------------------------------------------------------------------


def job(folder: Path, external: str, **part: Any) -> Path:
    crank = folder / "crank.stl"
    if not crank.exists():
        assert main(["generate", "single", "-o", str(crank), "--segments", "32"]) == 0
    text = f"""
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850
[engine]
rod_length_mm = 150
rotating_g = {{ big_end = 420.0 }}
reciprocating_g = {{ piston = 690.0 }}
[balance]
factor = 0.5
grade = 16
speed_rpm = 6000
external = "{external}"
[[balance.external_part]]
name = "damper"
z_mm = -330.0
unbalance_g_mm = [-2000.0, 0.0]
[[balance.external_part]]
name = "flexplate"
z_mm = 330.0
[correction]
method = "drill"
"""
    file = folder / f"{external}.toml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("external")


def test_solved_parts_leave_nothing_to_cut_and_verify_agrees(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = folder / "out"
    assert main(["balance", str(job(folder, "solve")), "-o", str(out)]) == 0
    assert "External part" in capsys.readouterr().out
    report = json.loads((out / "report.json").read_text("utf-8"))
    assert report["corrections"] == []
    assert report["outcome"] == "already_within_tolerance"
    damper, flexplate = report["external"]
    # by hand: the crank with its bob-weights as a crank without external parts has them
    assert all(plane["magnitude_g_mm"] < 1e-6 for plane in report["initial"]["planes"])
    own = ab.balance(ab.Job.from_dict(raw(folder))).report
    low, high = (plane["z_mm"] for plane in own["tolerance"]["planes"])
    vectors = [np.array(plane["unbalance_g_mm"]) for plane in own["initial"]["planes"]]
    resultant, moment = sum(vectors), low * vectors[0] + high * vectors[1]
    a = -(330.0 * resultant - moment) / 660.0
    b = -(330.0 * resultant + moment) / 660.0
    assert damper["unbalance_g_mm"] == pytest.approx(a, rel=1e-6, abs=1e-3)
    assert flexplate["unbalance_g_mm"] == pytest.approx(b, rel=1e-6, abs=1e-3)
    assert damper["change_g_mm"] == pytest.approx(a + np.array([2000.0, 0.0]), rel=1e-6, abs=1e-3)
    assert damper["magnitude_g_mm"] == pytest.approx(math.hypot(*a), rel=1e-9)
    # each off by its ± the worst way: still permitted, and no more
    pm, permitted = damper["pm_g_mm"], report["tolerance"]["permissible_g_mm"]
    assert 0.0 < 2.0 * pm <= permitted * (1.0 + 1e-9)
    assert main(["verify", str(out / "report.json")]) == 0


def test_a_further_stage_paper_and_page_know_the_parts(folder: Path) -> None:
    """What a machine reads with the parts on is what is cut; what is left is what they may be off by."""
    first = folder / "first"
    ab.balance(job(folder, "solve")).write(first, only=("json", "pdf", "card", "html"))
    texts = [
        " ".join(" ".join(page.extract_text() for page in PdfReader(first / name).pages).split())
        for name in ("sheet.pdf", "bob-weights.pdf")
    ]
    external = json.loads((first / "report.json").read_text("utf-8"))["external"]
    for text in (*texts, (first / "report.html").read_text("utf-8")):
        for part in external:
            assert part["name"] in text
    assert f"{external[0]['magnitude_g_mm']:.2f}" in texts[0]
    reading = {
        "urr_percent": 95.0,
        "umar_g_mm": 0.5,
        "plane": [
            {"at": "A", "g_mm": 120.0, "angle_deg": 200.0},
            {"at": "B", "g_mm": 80.0, "angle_deg": 190.0},
        ],
    }
    stage = ab.recut(first / "report.json", reading)
    stage.write(first / "stage-2", only=("json",))
    assert ab.verify(first / "stage-2" / "report.json").holds
    assert stage.report["initial"]["planes"][0]["magnitude_g_mm"] == pytest.approx(120.0)
    for part, before in zip(stage.report["external"], external, strict=True):
        assert part["unbalance_g_mm"] == pytest.approx(before["unbalance_g_mm"])
        assert 0.0 < part["pm_g_mm"] < before["pm_g_mm"]


def raw(folder: Path) -> dict[str, Any]:
    import tomllib

    found = tomllib.loads(job(folder, "solve").read_text("utf-8"))
    found["crankshaft"]["file"] = str(folder / "crank.stl")
    del found["balance"]["external"], found["balance"]["external_part"]
    return found


def test_neutral_carries_nothing_and_detroit_what_is_fitted(folder: Path) -> None:
    values = raw(folder)
    parts = [{"name": "damper", "z_mm": -30.0, "unbalance_g_mm": [-2000.0, 50.0]}]
    attached = {}
    for name in ("neutral", "detroit"):
        made = ab.Job.from_dict(
            {**values, "balance": {**values["balance"], "external": name, "external_part": parts}}
        )
        crank = ab.generate("single", segments=24).crank
        tolerance = tolerance_of(made, crank.measured.anatomy, crank.measured.moments)
        fitted = with_external(made, crank.measured, tolerance, 0.5)
        residual = Unbalance(np.zeros(2), np.zeros(2))
        (damper,) = carried_unbalances(fitted, tolerance, residual)
        attached[name] = [each.unbalance_g_mm for each in fitted.engine.attached]
        assert damper.unbalance_g_mm.tolist() == ([0.0, 0.0] if name == "neutral" else [-2000.0, 50.0])
    assert attached == {"neutral": [], "detroit": [(-2000.0, 50.0)]}


DAMPER = {"name": "damper", "z_mm": 0.0}


@pytest.mark.parametrize(
    ("balance", "said"),
    [
        ({"external": "solve"}, "expected one or two parts, and none without it"),
        ({"external_part": [DAMPER]}, "expected one or two parts, and none without it"),
        ({"external": "solve", "external_part": [DAMPER, DAMPER]}, "two parts named 'damper'"),
    ],
)
def test_bad_input_is_one_line(folder: Path, balance: dict[str, Any], said: str) -> None:
    values = raw(folder)
    values["balance"] |= balance
    with pytest.raises(JobError, match=said) as refused:
        ab.Job.from_dict(values)
    assert "\n" not in str(refused.value)


def test_parts_of_a_workbook_are_those_of_the_job(tmp_path: Path) -> None:
    example = Path(__file__).parents[2] / "examples" / "external-v8-job.toml"
    assert main(["init", str(example), "-o", str(tmp_path / "job.xlsx")]) == 0
    found, there = (load(file).balance for file in (tmp_path / "job.xlsx", example))
    assert found.external == "solve"
    assert found.external_parts == there.external_parts
    assert [part.name for part in found.external_parts] == ["damper", "flexplate"]
