"""``inspect JOB --sections``: the section table with all that hangs on the crank, sums and verdict."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from autobalance.balancing.section_rows import RowKind, SectionRow, SectionTable
from autobalance.declare import encoded
from autobalance.report.balance.sections_text import section_table_text
from autobalance.report.balance.values import schema
from autobalance.report.records import sections as records
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.shape import Bar, tessellated
from autobalance.solid.formats.read import read
from tests import jobs
from tests.cranks import Shape, make_crank
from tests.reference.published import TABLE_2

DENSITY = 7.85e-3
JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.rotating_g]
big_end = 300.0
[engine.reciprocating_g]
piston = 400.0
[engine.crankpin_g]
{oil}
sludge_trap = 12.0
[[engine.attached]]
name = "flywheel"
mass_g = 1200.0
unbalance_g_mm = [250.0, -40.0]
z_mm = 80.0
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 9000
[correction]
method = "drill"
"""
SHAPE = Shape()
BORE_MM, RADIAL, AXIAL = 14.0, (10.0, 22.0), (12.0, 9.0)
"""Diameter of the crankpin's bore; diameter and depth below the rim of a radial hole, of an axial one."""


@pytest.fixture(scope="module")
def crank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A crank with a bored crankpin and, in its webs, a radial and an axial hole."""
    solid, anatomy = make_crank([0.0])
    web, other = anatomy.webs
    r, z = SHAPE.rim_radius, 0.5 * (web.z_min_mm + web.z_max_mm)
    bore = Bar((SHAPE.crank_radius, 0.0, -60.0), (SHAPE.crank_radius, 0.0, 60.0), BORE_MM)
    radial = Bar((-r - 9.0, 0.0, z), (-r + RADIAL[1], 0.0, z), RADIAL[0])
    axial = Bar((-45.0, 9.0, other.z_max_mm - AXIAL[1]), (-45.0, 9.0, other.z_max_mm + 5.0), AXIAL[0])
    for tool in (bore, radial, axial):
        solid = solid - tessellated(tool, 120)
    path = tmp_path_factory.mktemp("sections") / "crank.stl"
    jobs.write_stl(path, solid.mesh.corners)
    return path


def job(crank: Path, folder: Path, oil: str = "oil = 4.0") -> Path:
    (folder / "crank.stl").write_bytes(crank.read_bytes())
    path = folder / "job.toml"
    path.write_text(JOB.format(oil=oil), encoding="utf-8")
    return path


def inspected(capsys: pytest.CaptureFixture[str], path: Path, *options: str) -> dict[str, Any]:
    assert jobs.run("inspect", path, "--sections", *options, "--json", "-") == 0
    report: dict[str, Any] = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator(schema()).validate(report)
    return report


def rows_of(report: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [row for row in report["section_table"]["rows"] if row["kind"] == kind]


@pytest.mark.slow
def test_everything_that_hangs_on_the_crank_has_a_row_and_the_sums_are_those_of_balance(
    crank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = job(crank, tmp_path)
    report = inspected(capsys, path)
    found = report["section_table"]
    (bob,), (oil,), (trap,) = (rows_of(report, kind) for kind in ("bob-weight", "oil", "on crankpin"))
    assert (bob["mass_g"], oil["mass_g"], trap["mass_g"]) == pytest.approx((500.0, 4.0, 12.0))
    assert bob["unbalance_g_mm"] == pytest.approx([500.0 * SHAPE.crank_radius, 0.0], abs=1e-2)
    (wheel,) = rows_of(report, "attached")
    assert wheel["name"] == "flywheel"
    assert wheel["centre_mm"] == pytest.approx([250.0 / 1200.0, -40.0 / 1200.0, 80.0])
    assert wheel["moment_g_mm2"] == pytest.approx([20000.0, -3200.0])
    rows = found["rows"]
    for key in ("unbalance_g_mm", "moment_g_mm2"):
        total = np.sum([row[key] for row in rows], axis=0)
        np.testing.assert_allclose(total, found["sums"][key], atol=1e-6)
    assert jobs.run("balance", path, "-o", tmp_path / "out", "--no-report", "--json", "-") in (0, 4)
    initial = json.loads(capsys.readouterr().out)["initial"]
    assert found["sums"]["unbalance_g_mm"] == pytest.approx(initial["unbalance_g_mm"], abs=1e-3)
    assert found["sums"]["moment_g_mm2"] == pytest.approx(initial["moment_g_mm2"], abs=1e-2)
    assert [plane["magnitude_g_mm"] for plane in found["planes"]] == pytest.approx(
        [plane["magnitude_g_mm"] for plane in initial["planes"]], abs=1e-3
    )
    assert found["within"] is False


def test_balance_holes_are_rows_of_their_closed_form_and_the_webs_are_whole(
    crank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = inspected(capsys, job(crank, tmp_path))
    holes = {row["name"].split()[0]: row for row in rows_of(report, "balance hole")}
    assert set(holes) == {"axial", "radial"}
    axial = math.pi * (0.5 * AXIAL[0]) ** 2 * AXIAL[1] * DENSITY
    assert holes["axial"]["mass_g"] == pytest.approx(-axial, rel=1e-3)
    assert holes["axial"]["centre_mm"][:2] == pytest.approx([-45.0, 9.0], abs=1e-3)
    radial = math.pi * (0.5 * RADIAL[0]) ** 2 * RADIAL[1] * DENSITY
    assert holes["radial"]["mass_g"] == pytest.approx(-radial, rel=0.01)  # the rim is round
    weights = {row["number"]: row["mass_g"] for row in rows_of(report, "counterweight")}
    assert weights[1] == pytest.approx(weights[2], rel=1e-4)  # alike before they were drilled
    metal = {row["kind"] for row in report["sections"]}
    assert "balance hole" not in metal


def test_oil_fills_the_crankpins_bore_where_its_density_is_given(
    crank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = job(crank, tmp_path, oil="")
    report = inspected(capsys, path, "--oil-density-kg-m3", "870")
    (oil,) = rows_of(report, "oil")
    volume = math.pi * (0.5 * BORE_MM) ** 2 * (SHAPE.pin_width + 2.0 * SHAPE.web_width)
    assert oil["mass_g"] == pytest.approx(volume * 870e-6, rel=1e-3)
    assert oil["centre_mm"] == pytest.approx([SHAPE.crank_radius, 0.0, 0.0], abs=1e-2)
    twice = job(crank, tmp_path)
    assert jobs.run("inspect", twice, "--sections", "--oil-density-kg-m3", "870") == 3
    error = capsys.readouterr().err
    assert "engine.crankpin_g.oil is given beside --oil-density-kg-m3" in error
    assert error.count("\n") == 1


@pytest.mark.slow
def test_the_datum_moves_couples_and_nothing_else(
    crank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = job(crank, tmp_path)
    here = inspected(capsys, path)["section_table"]
    planes = {plane["name"]: plane["z_mm"] for plane in here["planes"]}
    for datum, place in (("A", planes["A"]), ("1/2 in", 12.7), ("front", None)):
        there = inspected(capsys, path, "--datum", datum)["section_table"]
        z = there["datum_mm"]
        assert place is None or z == pytest.approx(place)
        wanted = np.array(here["sums"]["moment_g_mm2"]) - z * np.array(here["sums"]["unbalance_g_mm"])
        np.testing.assert_allclose(there["sums"]["moment_g_mm2"], wanted, atol=1e-6)
        for key in ("planes", "within", "counterweights_wanted"):
            assert there[key] == here[key]
    mesh = read(path.parent / "crank.stl", "mm").solid
    assert there["datum_mm"] == pytest.approx(-0.5 * np.ptp(mesh.bounds[:, 2]), abs=1e-3)
    assert jobs.run("inspect", path, "--sections", "--datum", "back") == 2
    assert "or one of A, B, front, rear, centre" in capsys.readouterr().err
    assert jobs.run("inspect", path, "--datum", "A") == 2


def test_the_table_in_words_and_without_a_whole_job(
    crank: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = job(crank, tmp_path)
    assert jobs.run("inspect", path, "--sections") == 0
    text = capsys.readouterr().out
    for words in ("oil 1 (oil)", "attached 1 (flywheel)", "NOT WITHIN TOLERANCE", "plane A", "no couple"):
        assert words in text
    path.write_text(path.read_text().replace("grade = 6.3", 'grade = "FILL IN"'), encoding="utf-8")
    assert jobs.run("inspect", path, "--sections") == 0
    told = capsys.readouterr()
    assert "balance.grade is not filled in" in told.err
    assert "No verdict" in told.out
    assert "bob-weight" not in told.out


def source_table() -> SectionTable:
    """Return the sections of the source's Table 2 (kg there)."""
    rows: list[SectionRow] = []
    for name, mass, x, y, z, *_ in TABLE_2:
        kind: RowKind = "counterweight" if name.startswith("Counterweight") else "web"
        point = Moments.point(1000.0 * mass, np.array([x, y, z]))
        rows.append(SectionRow(kind, len(rows) + 1, name, point))
    tolerance = Tolerance.of(
        grade_mm_s=6.3,
        service_speed_rad_s=2000.0 * math.pi / 30.0,
        rotor_mass_g=1000.0 * sum(row[1] for row in TABLE_2),
        z_centre_mm=TABLE_2[0][4],
        planes_z_mm=(TABLE_2[1][4], TABLE_2[6][4]),
        judge="dynamic",
    )
    return SectionTable(tuple(rows), tolerance)


def test_ru_03_and_04_in_a_section_table() -> None:
    """Its static sums vanish, its couple does not; both counterweights would have to change."""
    found = source_table()
    values = encoded(records.SectionTable.of(found, 0.0))
    assert values["within"] is False
    assert values["sums"]["magnitude_g_mm"] < 15.0
    _, far = values["planes"]
    assert far["unbalance_g_mm"][1] == pytest.approx(16_510.0, rel=1e-3)
    first, second = values["counterweights_wanted"]
    products = [first["product_g_mm"][1] * 1e-3, second["product_g_mm"][1] * 1e-3]
    changes = [first["change_g_mm"][1] * 1e-3, second["change_g_mm"][1] * 1e-3]
    assert products == pytest.approx([-92.0814, -92.7509], abs=0.01)
    assert changes == pytest.approx([16.501, -16.507], abs=0.01)
    assert "NOT WITHIN TOLERANCE" in section_table_text(records.SectionTable.of(found, 0.0))
    aside = encoded(records.SectionTable.of(found, 100.0))
    moved = np.array(aside["sums"]["moment_g_mm2"]) - values["sums"]["moment_g_mm2"]
    np.testing.assert_allclose(moved, -100.0 * np.array(values["sums"]["unbalance_g_mm"]), atol=1e-6)
