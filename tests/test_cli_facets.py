"""What facets hide: added on demand, told where too coarse, checked by ``verify``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.balancing.facet_correction import FacetCorrection
from autobalance.balancing.record import MAX_DOUBT, needed
from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import crank_solid, exact_moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Share
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.formats.write import encode
from tests.jobs import report_of, run

NAME = "pressed-up-single"
JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = {density}
[engine.rotating_g]
big_end = 134.0
[engine.reciprocating_g]
piston = 261.5
[balance]
factor = 0.5
grade = {grade}
speed_rpm = 9000
facet_correction = {correct}
[correction]
method = "drill"
[correction.drill]
diameters_mm = [12.0]
"""


def generated_job(folder: Path, segments: int, correct: str, grade: float) -> Path:
    """Write a job on a generated crank, its pin in the file."""
    folder.mkdir(parents=True)
    design = preset(NAME)
    (folder / "crank.stl").write_bytes(encode(crank_solid(design, segments).mesh, "stl", 1.0))
    job = folder / "job.toml"
    text = JOB.format(density=design.density_kg_m3, grade=grade, correct=correct)
    job.write_text(text, encoding="utf-8")
    return job


def generated_report(folder: Path, segments: int, correct: str, grade: float = 40.0) -> dict[str, Any]:
    job = generated_job(folder / "in", segments, correct, grade)
    assert run("balance", job, "-o", folder / "out", "--no-report", "--quiet") == 0
    return report_of(folder / "out")


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, dict[str, Any]]]:
    found = {}
    for correct in ("false", "true"):
        folder = tmp_path_factory.mktemp(correct)
        found[correct] = folder / "out" / "report.json", generated_report(folder, 32, correct)
    return found


Reports = dict[str, tuple[Path, dict[str, Any]]]


def test_the_correction_puts_the_true_mass_inertia_and_unbalance_into_the_report(reports: Reports) -> None:
    truth = exact_moments(preset(NAME))
    raw, corrected = (reports[each][1]["crank"] for each in ("false", "true"))
    assert (raw["facet_error"]["correction"], raw["facet_error"]["added"]) == (None, None)
    assert corrected["facet_error"]["correction"] == "applied"
    for key, true in (("mass_g", truth.mass_g), ("polar_inertia_kg_mm2", truth.polar_inertia_g_mm2 / 1e3)):
        assert abs(corrected[key] - true) < abs(raw[key] - true) / 100.0
    assert corrected["volume_mm3"] == pytest.approx(truth.mass_g / preset(NAME).density_kg_m3 * 1e6, rel=1e-4)
    off = {}
    for each, crank in (("raw", raw), ("corrected", corrected)):
        x, y = (crank["mass_g"] * value for value in crank["centre_of_mass_mm"][:2])
        off[each] = abs(math.hypot(x, y) - math.hypot(*truth.first_g_mm[:2]))
    assert off["corrected"] < off["raw"] / 100.0


def test_the_verdict_is_on_what_is_corrected(reports: Reports) -> None:
    """The cut takes curved facets away too: what is added after it is less."""
    raw, corrected = (reports[each][1] for each in ("false", "true"))
    added = corrected["crank"]["facet_error"]["added"]
    before = np.subtract(corrected["initial"]["unbalance_g_mm"], raw["initial"]["unbalance_g_mm"])
    np.testing.assert_allclose(before, added["before"]["unbalance_g_mm"], rtol=1e-6)
    assert math.dist(added["before"]["unbalance_g_mm"], added["after"]["unbalance_g_mm"]) > 0.0
    assert corrected["residual"]["magnitude_g_mm"] < 0.02 * corrected["tolerance"]["permissible_g_mm"]
    shares = [each["residual"]["uncertainty_shares_g_mm"]["facets"] for each in (raw, corrected)]
    assert shares[1] < shares[0] / 3.0


def test_verify_checks_what_was_added(reports: Reports, tmp_path: Path) -> None:
    for path, _ in reports.values():
        assert run("verify", path) == 0


def test_a_mesh_too_coarse_for_the_grade_is_told_and_how_fine_it_would_have_to_be(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    coarse = generated_report(tmp_path / "coarse", 32, "false", 16.0)["crank"]["facet_error"]
    assert coarse["too_coarse"]["text"].startswith("the mesh is too coarse for G 16: its facets put ")
    assert coarse["too_coarse"]["text"].replace("; ", " ") in " ".join(capsys.readouterr().out.split())
    finer = math.ceil(32 * coarse["too_coarse"]["finer"]) + 2
    assert coarse["too_coarse"]["needed_sag_mm"] == pytest.approx(
        coarse["sag_mm"] / coarse["too_coarse"]["finer"] ** 2
    )
    fine = generated_report(tmp_path / "fine", finer, "false", 16.0)["crank"]["facet_error"]
    assert fine["too_coarse"] is None
    assert fine["sag_mm"] == pytest.approx(coarse["too_coarse"]["needed_sag_mm"], rel=0.2)


def error(mass_g: float, unbalance_g_mm: float, mass_bar_g: float, unbalance_bar_g_mm: float) -> ChordalError:
    missing = Moments(mass_g, np.array([unbalance_g_mm, 0.0, 0.0]), unbalance_g_mm * np.ones((3, 3)))
    return ChordalError(missing, mass_bar_g, unbalance_bar_g_mm, mass_g, unbalance_g_mm, 0.04, 1)


def test_what_is_not_sure_to_be_better_is_declined() -> None:
    whole, mass_only, nothing = (
        FacetCorrection.of(error(1.0, 20.0, *bars), True) for bars in ((0.5, 10.0), (0.5, 10.1), (0.51, 1.0))
    )
    assert [each.verdict for each in (whole, mass_only, nothing)] == ["applied", "mass_only", "declined"]
    assert whole.reason is None
    assert "leaves the unbalance as measured" in str(mass_only.reason)
    assert "is declined: the facets hide 1 g give or take 0.51 g" in str(nothing.reason)
    missing = error(1.0, 20.0, 0.0, 0.0).missing
    assert whole.part(missing) is missing
    assert nothing.part(missing).mass_g == 0.0
    part = mass_only.part(missing)
    assert (part.mass_g, part.polar_inertia_g_mm2) == (1.0, 40.0)
    assert not part.first_g_mm.any()
    assert not part.second_g_mm2[:2, 2].any()


def test_nothing_curved_needs_no_correction() -> None:
    assert FacetCorrection.of(ChordalError.known(Moments.zero()), True).verdict == "not_needed"
    assert FacetCorrection.of(error(1.0, 20.0, 0.0, 0.0), False).verdict is None


def test_what_is_needed_falls_as_the_square() -> None:
    tolerance = Tolerance.of(
        grade_mm_s=6.3,
        service_speed_rad_s=1000.0,
        rotor_mass_g=1000.0,
        z_centre_mm=0.0,
        planes_z_mm=(-10.0, 10.0),
        judge="dynamic",
    )
    found = error(1.0, 20.0, 0.0, 0.0)
    most = MAX_DOUBT * tolerance.permissible_g_mm
    assert needed(found, tolerance, Share(most, (0.0, 0.0))) is None
    resultant = needed(found, tolerance, Share(4.0 * most, (0.0, 0.0)))
    assert resultant is not None
    assert resultant.finer == pytest.approx(2.0)
    assert resultant.needed_sag_mm == pytest.approx(0.01)
    plane = needed(
        found, tolerance, Share(most, (0.0, 9.0 * MAX_DOUBT * tolerance.planes[1].permissible_g_mm))
    )
    assert plane is not None
    assert plane.finer == pytest.approx(3.0)
    assert "of plane B in doubt" in plane.text
    # rounded to the side where it is enough
    assert "a chord height of 0.0044 mm at most (now 0.04 mm), 3 times as many" in plane.text
    between = needed(found, tolerance, Share(1.43**2 * most, (0.0, 0.0)))
    assert between is not None
    assert "a chord height of 0.019 mm at most (now 0.04 mm), 1.5 times as many" in between.text
