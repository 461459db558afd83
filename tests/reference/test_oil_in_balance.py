"""Oil in bob-weights, balance, verify, a machine's reading: against the metal that bores took."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.drawn_cranks.design import PRESETS, DrawnShaft
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.errors import ClaimError, FormatError
from autobalance.paper.workbook import xlsx
from autobalance.report.records.balanced import BalancedReport
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.verbs.inspect import TableOptions
from tests.report.test_workbook import lines

SEGMENTS = 24
CRANK = replace(PRESETS["single"], crankpin=DrawnShaft(32.0, 24.0, 14.0), segments=SEGMENTS)
"""An oil hole crosses the crankpin's bore."""
OIL = 870e-6


def job(folder: Path, oil: bool = True) -> ab.Job:
    values: dict[str, Any] = {
        "crankshaft": {"file": str(folder / "crank.stl"), "unit": "mm", "density_kg_m3": 7850.0},
        "engine": {
            "rod_length_mm": 120.0,
            "rotating_g": {"big_end": 180.0},
            "reciprocating_g": {"piston": 330.0},
            "attached": [{"name": "damper", "mass_g": 300.0, "unbalance_g_mm": [40.0, 90.0], "z_mm": 70.0}],
            **({"oil": {}} if oil else {}),
        },
        "balance": {"factor": 0.5, "grade": 40.0, "speed_rpm": 5000},
        "correction": {"method": "drill", "drill": {"diameters_mm": [10.0]}},
    }
    return ab.Job.from_dict(values)


@dataclass(frozen=True)
class Run:
    folder: Path
    report: dict[str, Any]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("oil")
    mesh = crank_solid(CRANK, SEGMENTS).mesh
    ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850).write(folder / "crank.stl")
    result = ab.balance(job(folder))
    result.write(folder / "out", only=("json",))
    return Run(folder, json.loads((folder / "out" / "report.json").read_text()))


def oil_by_difference(run: Run) -> Moments:
    """Return the oil as the metal that bore and drilling took, moved into the report's frame."""
    plain = replace(CRANK, oil_hole_mm=0.0, crankpin=replace(CRANK.crankpin, bore_mm=0.0))
    taken = (crank_solid(plain, SEGMENTS) - crank_solid(CRANK, SEGMENTS)).moments(OIL)
    return taken.moved(np.array(run.report["frame"]["file_to_rotor"]))


def test_the_oil_is_what_bores_and_drillings_took(run: Run) -> None:
    wanted = oil_by_difference(run)
    (oil,) = run.report["oil"]
    assert oil["throw"] == 1
    assert oil["mass_g"] == pytest.approx(wanted.mass_g, rel=1e-3)
    assert oil["centre_mm"] == pytest.approx(wanted.centre_mm.tolist(), abs=0.02)
    inertia = (wanted.inertia_g_mm2 / 1000.0).tolist()
    assert np.array(oil["inertia_kg_mm2"]) == pytest.approx(np.array(inertia), abs=2e-3 * inertia[0][0])
    (throw,) = run.report["crank"]["throws"]
    along = wanted.first_g_mm[0] / throw["crank_radius_mm"]  # throw 1 stands on x
    assert oil["on_crankpin_g"] == pytest.approx(along, rel=1e-3)
    (bob,) = run.report["engine"]["bob_weights"]
    assert bob["mass_g"] == bob["fit_g"] == pytest.approx(180.0 + 0.5 * 330.0 + along, abs=0.01)


def test_the_unbalance_has_all_of_it(run: Run) -> None:
    """Whole resultant and moment, not the part that a bob-weight stands for."""
    dry = ab.inspect(job(run.folder, oil=False), table=TableOptions()).report["section_table"]["sums"]
    wanted = oil_by_difference(run)
    for key, add in (("unbalance_g_mm", wanted.first_g_mm[:2]), ("moment_g_mm2", wanted.second_g_mm2[:2, 2])):
        change = np.array(run.report["initial"][key]) - np.array(dry[key])
        assert change == pytest.approx(add, abs=2e-3 * float(np.linalg.norm(add)))


def test_the_section_table_adds_up_to_the_same(run: Run) -> None:
    report = ab.inspect(job(run.folder), table=TableOptions()).report
    for key in ("unbalance_g_mm", "moment_g_mm2"):
        assert report["section_table"]["sums"][key] == pytest.approx(run.report["initial"][key], abs=1e-6)


def test_verify_finds_the_oil_in_the_crank_again(run: Run, tmp_path: Path) -> None:
    path = run.folder / "out" / "report.json"
    checked = ab.verify(path)
    assert checked.holds
    assert not [each for each in checked.report["not_checked"] if each["key"].startswith("oil")]
    for key, value in (("mass_g", 9.0), ("on_crankpin_g", 1.0), ("throw", 2)):
        wrong = json.loads(path.read_text())
        wrong["oil"][0][key] = value
        falsified = path.with_name("falsified.json")
        falsified.write_text(json.dumps(wrong))
        with pytest.raises((ClaimError, FormatError), match=r"oil|unbalance|bob_weights|planes"):
            ab.verify(falsified)


def test_a_machine_reads_the_dry_crank_and_a_further_stage_puts_the_oil_back(run: Run) -> None:
    """What was left is what a stage that follows the reading begins with: no oil was on the machine."""
    machine = {
        "kind": "hard",
        "speed_rpm": 600,
        "reading": {"urr_percent": 95.0, "umar_g_mm": 0.5},
        "rotor": {"report": str(run.folder / "out" / "report.json")},
    }
    read = ab.machine(machine)
    read.write(run.folder)
    stage = ab.recut(run.folder / "out" / "report.json", run.folder / "reading.toml")
    for key in ("unbalance_g_mm", "moment_g_mm2"):
        size = float(np.linalg.norm(oil_by_difference(run).second_g_mm2[:2, 2]))
        wanted = run.report["residual"][key]
        assert stage.report["initial"][key] == pytest.approx(wanted, abs=1e-6 * size)
    assert stage.report["oil"] == run.report["oil"]
    stage.write(run.folder / "stage-2", only=("json",))
    assert ab.verify(run.folder / "stage-2" / "report.json").holds


def test_the_workbook_counts_oil_and_attached_parts(run: Run, tmp_path: Path) -> None:
    (tmp_path / "book.xlsx").write_bytes(xlsx(BalancedReport.read(run.report)))
    cells = lines(tmp_path / "book.xlsx")
    before, after = cells["Magnitude"]
    assert before == pytest.approx(run.report["initial"]["magnitude_g_mm"], abs=1e-6)
    assert after == pytest.approx(run.report["residual"]["magnitude_g_mm"], abs=1e-6)
    assert cells["Bob-weight"] == [pytest.approx(run.report["engine"]["bob_weights"][0]["mass_g"])]


def test_a_crank_without_room_for_oil_is_told_of(tmp_path: Path) -> None:
    bare = replace(PRESETS["single"], oil_hole_mm=0.0, segments=16)
    mesh = crank_solid(bare, 16).mesh
    ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850).write(tmp_path / "crank.stl")
    warnings = ab.forces(job(tmp_path)).warnings
    assert any("engine.oil: the crank has no bore or drilling" in each for each in warnings)
