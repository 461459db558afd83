"""Moments from slices against moments from tetrahedra."""

from pathlib import Path

import numpy as np
import pytest

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad import tessellation
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.slicing.independent import agreement, slice_moments, trimesh_moments
from autobalance.verification import solids
from tests import jobs
from tests.coarse import COARSE
from tests.cranks import make_crank, tilted
from tests.generated import single_step

ROUNDING = 1e-12


def test_a_box_in_closed_form() -> None:
    box = Solid.box(np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 6.0]))
    found = slice_moments(box.mesh, 0.5)
    assert found.mass_g == pytest.approx(3.0, rel=ROUNDING)
    np.testing.assert_allclose(found.centre_mm, [1.5, 3.0, 4.5], rtol=ROUNDING)
    np.testing.assert_allclose(
        np.diag(found.second_g_mm2), 3.0 * np.array([7 / 3, 28 / 3, 21.0]), rtol=ROUNDING
    )


def test_a_crank_anywhere_agrees_with_its_tetrahedra() -> None:
    solid, anatomy = make_crank([0.0, 120.0], placement=tilted(0.7, [100.0, 50.0, 30.0]))
    for frame in (None, anatomy.file_to_rotor):
        one, other = mesh_moments(solid.mesh, 0.00785, frame), slice_moments(solid.mesh, 0.00785, frame)
        assert agreement(one, other) < ROUNDING
        assert agreement(one, trimesh_moments(solid.mesh, 0.00785, frame)) < ROUNDING


def test_disagreement_is_seen() -> None:
    solid, _ = make_crank([0.0])
    one = mesh_moments(solid.mesh, 1.0)
    for other in (
        one.scaled(1.001),
        Moments(one.mass_g, one.first_g_mm + 1e-3 * one.mass_g, one.second_g_mm2),
        Moments(one.mass_g, one.first_g_mm, 1.001 * one.second_g_mm2),
    ):
        assert agreement(one, other) > 1e-6


def test_verify_measures_a_second_way(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs.computed(jobs.bundled_job(tmp_path), tmp_path / "out")
    report = tmp_path / "out" / "report.json"
    assert jobs.run("verify", report, "--independent") == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "from slices: volume, first and second moments agree to" in said
    monkeypatch.setattr(solids, "slice_moments", lambda *_: Moments.zero())
    assert jobs.run("verify", report, "--independent") == 3
    assert "from tetrahedra and from slices differ by" in capsys.readouterr().err
    monkeypatch.undo()
    monkeypatch.setattr(solids, "trimesh_moments", lambda *_: Moments.zero())
    assert jobs.run("verify", report, "--independent") == 3
    assert "from tetrahedra and by trimesh differ by" in capsys.readouterr().err


@pytest.mark.slow
def test_true_surfaces_are_measured_a_second_way_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("OCP")
    for name, value in COARSE.items():
        monkeypatch.setattr(tessellation, name, value)
    job = jobs.pin_job(tmp_path, file='"crank.step"', unit="", grade="40")
    (tmp_path / "crank.step").write_bytes(single_step())
    jobs.computed(job, tmp_path / "out")
    report = tmp_path / "out" / "report.json"
    capsys.readouterr()
    assert jobs.run("verify", report, "--independent") == 0
    said = " ".join(capsys.readouterr().out.split())
    assert float(said.rpartition("agree to ")[2].split()[0]) < 1e-5
    moved = slice_moments
    monkeypatch.setattr(solids, "slice_moments", lambda *a: moved(*a).scaled(1.001))
    assert jobs.run("verify", report, "--independent") == 3
    assert "from true surfaces and from slices differ by" in capsys.readouterr().err
