"""The room for oil in cranks against the metal that their bores and drillings took."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.command.main import main
from autobalance.crank.sections import oil_rooms
from autobalance.drawn_cranks.design import PRESETS, DrawnShaft
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import JobError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid

pytestmark = pytest.mark.usefixtures("cranks_read_once")

SEGMENTS = 24
CROSSED = replace(PRESETS["single"], crankpin=DrawnShaft(32.0, 24.0, 14.0), segments=SEGMENTS)
"""An oil hole crosses the crankpin's bore."""


@pytest.mark.parametrize("name", ["single", "crossed", "inline-4", "v-twin-45"])
def test_rooms_are_what_bores_and_drillings_took(name: str) -> None:
    design = CROSSED if name == "crossed" else replace(PRESETS[name], segments=SEGMENTS)
    anatomy = crank_anatomy(design, np.eye(4))
    plain = replace(design, oil_hole_mm=0.0, crankpin=replace(design.crankpin, bore_mm=0.0))
    drilled, solid = (crank_solid(each, SEGMENTS).moved(anatomy.file_to_rotor) for each in (design, plain))
    taken = (solid - drilled).moments(1.0)
    found = sum((room.filling for room in oil_rooms(drilled, anatomy)), Moments.zero())
    assert found.mass_g == pytest.approx(taken.mass_g, rel=1e-6)
    assert found.first_g_mm == pytest.approx(taken.first_g_mm, abs=1e-6 * taken.mass_g * 100.0)
    assert found.second_g_mm2 == pytest.approx(taken.second_g_mm2, abs=1e-6 * taken.mass_g * 1e4)


def test_a_solid_crank_has_no_room() -> None:
    plain = replace(PRESETS["single"], oil_hole_mm=0.0, segments=24)
    anatomy = crank_anatomy(plain, np.eye(4))
    assert oil_rooms(crank_solid(plain, 24).moved(anatomy.file_to_rotor), anatomy) == ()


def test_a_balance_hole_in_a_web_holds_no_oil() -> None:
    design = replace(PRESETS["single"], segments=24)
    anatomy = crank_anatomy(design, np.eye(4))
    solid = crank_solid(design, 24).moved(anatomy.file_to_rotor)
    web = anatomy.webs[0]
    place = np.array([-30.0, 3.0])
    hole = Solid.box(np.append(place - 3.0, web.z_min_mm - 5.0), np.append(place + 3.0, web.z_max_mm + 5.0))
    assert (solid & hole).volume_mm3 > 100.0
    before, after = (
        sum(room.filling.mass_g for room in oil_rooms(each, anatomy)) for each in (solid, solid - hole)
    )
    assert after == pytest.approx(before, rel=1e-9)


@pytest.fixture
def job(tmp_path: Path) -> Path:
    mesh = crank_solid(CROSSED, SEGMENTS).mesh
    ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850).write(tmp_path / "crank.stl")
    path = tmp_path / "job.toml"
    path.write_text(
        """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.reciprocating_g]
piston = 260.0
[engine.oil]
density_kg_m3 = 870.0
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 9000
[correction]
method = "drill"
""",
        encoding="utf-8",
    )
    return path


def test_a_crossed_bore_has_its_row(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(job), "--sections", "--json", "-"]) == 0
    rows = json.loads(capsys.readouterr().out)["section_table"]["rows"]
    (oil,) = [row for row in rows if row["kind"] == "oil"]
    plain = replace(CROSSED, oil_hole_mm=0.0, crankpin=replace(CROSSED.crankpin, bore_mm=0.0))
    taken = (crank_solid(plain, SEGMENTS) - crank_solid(CROSSED, SEGMENTS)).volume_mm3
    assert oil["mass_g"] == pytest.approx(taken * 870e-6, rel=1e-3)
    assert oil["name"] == "in crankpin 1, main journal 1"


def test_oil_that_does_not_fill_is_not_counted(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(job), "--sections", "--set", "engine.oil.filled=false", "--json", "-"]) == 0
    rows = json.loads(capsys.readouterr().out)["section_table"]["rows"]
    assert not [row for row in rows if row["kind"] == "oil"]


def test_oil_is_not_counted_twice(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(job), "--sections", "--set", "engine.crankpin_g.oil=4.0"]) == 3
    assert "engine.crankpin_g.oil is given beside [engine.oil]" in capsys.readouterr().err


def test_oil_without_weight_is_refused() -> None:
    values = {
        "engine": {"reciprocating_g": {"piston": 1.0}, "oil": {"density_kg_m3": 0.0}},
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
        "correction": {"method": "drill"},
    }
    with pytest.raises(JobError, match=r"engine.oil.density_kg_m3 is 0; must be > 0"):
        ab.Job.from_dict(values)
