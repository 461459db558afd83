"""Finite elements against the theory of beams, of torsion, and of a plate with a hole."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from autobalance.command import main
from autobalance.errors import FileError, JobError, SolidError
from autobalance.finite_elements.verb import FemResult, fem
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import encode
from tests.libraries import uninstalled

E_PA, NU, DENSITY = 210e9, 0.3, 7850.0
G_PA = E_PA / (2.0 * (1.0 + NU))
LENGTH_M, RADIUS_M = 0.24, 0.02
FACETED = 2e-3
"""Share by which 96 facets lower the moments of area of a circle, and more."""


def written(solid: Solid, path: Path) -> Path:
    path.write_bytes(encode(solid.mesh, "stl", 1.0))
    return path


def free_timoshenko_hz() -> float:
    """Return the first bending frequency of the free cylinder, from Timoshenko's frequency equation."""
    area, inertia = math.pi * RADIUS_M**2, math.pi * RADIUS_M**4 / 4.0
    shear = 6.0 * (1.0 + NU) / (7.0 + 6.0 * NU)  # Cowper 1966, circle

    def determinant(hz: float) -> float:
        omega = math.tau * hz
        b2 = DENSITY * area * LENGTH_M**4 * omega**2 / (E_PA * inertia)
        r2 = inertia / (area * LENGTH_M**2)
        s2 = E_PA * inertia / (shear * area * G_PA * LENGTH_M**2)
        root = math.sqrt((r2 - s2) ** 2 + 4.0 / b2)
        alpha, beta = (math.sqrt(b2 * 0.5 * (sign * (r2 + s2) + root)) for sign in (-1.0, 1.0))
        mixed = (b2 * r2 * (r2 - s2) ** 2 + (3.0 * r2 - s2)) * math.sqrt(b2) / math.sqrt(1.0 - b2 * r2 * s2)
        return 2.0 - 2.0 * math.cosh(alpha) * math.cos(beta) + mixed * math.sinh(alpha) * math.sin(beta)

    return float(brentq(determinant, 2200.0, 3400.0))


@pytest.fixture(scope="module")
def cylinder(tmp_path_factory: pytest.TempPathFactory) -> FemResult:
    solid = Solid.prism(Region.circle(1e3 * RADIUS_M, 96), 0.0, 1e3 * LENGTH_M)
    file = written(solid, tmp_path_factory.mktemp("fem") / "cylinder.stl")
    return fem(file, unit="mm", modes=5, size_mm=18.0)


def test_a_cylinder_bends_as_timoshenko_says(cylinder: FemResult) -> None:
    first, second = cylinder.report["modes"][:2]
    assert first["kind"] == second["kind"] == "bending"
    assert first["frequency_hz"] == pytest.approx(second["frequency_hz"], rel=1e-3)  # any plane
    assert first["frequency_hz"] == pytest.approx(free_timoshenko_hz(), rel=FACETED)


def test_a_cylinder_twists_as_a_bar(cylinder: FemResult) -> None:
    twisting = [mode for mode in cylinder.report["modes"] if mode["kind"] == "torsion"]
    exact = math.sqrt(G_PA / DENSITY) / (2.0 * LENGTH_M)
    assert exact == pytest.approx(6682.7, abs=0.1)
    assert [mode["frequency_hz"] for mode in twisting] == [pytest.approx(exact, rel=1e-3)]
    assert abs(twisting[0]["frequency_hz"] - exact) < twisting[0]["error_hz"] < 1e-3 * exact


def test_frequencies_settle_from_mesh_to_mesh(cylinder: FemResult) -> None:
    levels = cylinder.report["convergence"]
    assert len(levels) == 3
    assert [level["nodes"] for level in levels] == sorted(level["nodes"] for level in levels)
    first, second, last = (np.array(level["frequencies_hz"]) for level in levels)
    assert (np.abs(last - second) < np.abs(second - first)).all()
    assert levels[-1]["frequencies_hz"] == [mode["frequency_hz"] for mode in cylinder.report["modes"]]
    assert cylinder.report["mesh"]["volume_error"] < 1e-3


def plate_with_hole(folder: Path, radius_mm: float = 10.0, size_mm: float = 16.0) -> dict[str, Any]:
    """Return an eighth of a plate 200 × 200 × 4 mm with a hole, of 20 mm by default, under 100 MPa."""
    quarter = np.linspace(0.5 * math.pi, 0.0, 25 if radius_mm == 10.0 else 49)
    arc = radius_mm * np.stack([np.cos(quarter), np.sin(quarter)], axis=1)
    length = 10.0 * radius_mm
    outline = Region.of([np.concatenate([arc, [[length, 0.0], [length, 100.0], [0.0, 100.0]]])])
    file = written(Solid.prism(outline, 0.0, 2.0), folder / "plate.stl")
    far = 500.0

    def face(axis: int, at: float) -> list[list[float]]:
        box = [[-far] * 3, [far] * 3]
        box[0][axis], box[1][axis] = at - 0.01, at + 0.01
        return box

    return {
        "solid": {"file": str(file), "unit": "mm"},
        "analysis": {"kind": "static", "size_mm": size_mm},
        "fix": [{"box_mm": face(axis, 0.0), "axes": "xyz"[axis]} for axis in range(3)],
        "load": [{"box_mm": face(0, length), "traction_MPa": [100.0, 0.0, 0.0]}],
    }


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return plate_with_hole(tmp_path_factory.mktemp("fem"))


def test_a_hole_in_a_plate_triples_the_stress(plate: dict[str, Any]) -> None:
    report = fem(plate).report
    howland = 3.03  # d/W = 0.1, of the gross stress (Peterson, chart 4.1)
    assert report["stress"]["greatest_principal_MPa"] == pytest.approx(100.0 * howland, rel=0.035)
    assert report["stress"]["greatest_von_mises_MPa"] == pytest.approx(100.0 * howland, rel=0.035)
    x, y, _ = report["stress"]["at_mm"]
    assert (x, y) == (pytest.approx(0.0, abs=1.0), pytest.approx(10.0, abs=0.1))
    assert report["reactions_N"][0] == pytest.approx(-100.0 * 100.0 * 2.0, rel=1e-9)
    assert report["modes"] is None


@pytest.mark.parametrize("size_mm", [16.0, 6.0])
def test_the_bar_of_a_wide_hole_covers_the_truth(size_mm: float, tmp_path: Path) -> None:
    """d/W = 0.2, plane stress: 3.14 of the gross stress (Howland 1930; Peterson, chart 4.1)."""
    stress = fem(plate_with_hole(tmp_path, 20.0, size_mm)).report["stress"]
    for value in (stress["greatest_principal_MPa"], stress["greatest_von_mises_MPa"]):
        assert abs(value - 314.0) <= stress["error_MPa"] < 0.03 * 314.0


@pytest.fixture(scope="module")
def brick(plate: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return the same on a body of a few elements; its faces at 0 are those fixed."""
    solid = Solid.box(np.zeros(3), np.array([100.0, 60.0, 60.0]))
    file = written(solid, tmp_path_factory.mktemp("fem") / "brick.stl")
    analysis = {"kind": "static", "size_mm": 50.0}
    return {**plate, "solid": {"file": str(file), "unit": "mm"}, "analysis": analysis}


def test_a_box_without_surface_is_refused(brick: dict[str, Any]) -> None:
    nowhere = {"box_mm": [[300.0, 0.0, 0.0], [301.0, 1.0, 1.0]], "traction_MPa": [1.0, 0.0, 0.0]}
    with pytest.raises(JobError, match=r"load\[1\].box_mm holds no surface; the solid reaches from"):
        fem({**brick, "load": [nowhere]})


def test_a_body_that_can_still_move_is_refused(brick: dict[str, Any]) -> None:
    with pytest.raises(JobError, match="can still move along y and move along z"):
        fem({**brick, "fix": brick["fix"][:1]})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"fix": []}, "fix is missing"),
        ({"load": []}, "load is missing"),
        ({"fix": [{"box_mm": [[0, 0, 0], [1, 1, 1]], "axes": "xw"}]}, r"fix\[1\].axes is 'xw'"),
        ({"fix": [{"box_mm": [[2, 0, 0], [1, 1, 1]]}]}, "its first corner must be the smaller one"),
        ({"load": [{"box_mm": [[0, 0, 0], [1, 1, 1]]}]}, "needs one of traction_MPa and force_N"),
        ({"analysis": {"kind": "modes"}}, "load is given with"),
        ({"analysis": {"kind": "static", "sise_mm": 1.0}}, "unknown key"),
        ({"material": {"nu": 0.5}}, "nu is 0.5; must be 0 ≤ nu < 0.5"),
    ],
)
def test_an_impossible_analysis_is_refused(plate: dict[str, Any], change: dict[str, Any], said: str) -> None:
    with pytest.raises(JobError, match=said):
        fem({**plate, **change})


def test_without_a_wheel_of_the_mesher_one_line_says_so(
    monkeypatch: pytest.MonkeyPatch, plate: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    uninstalled(monkeypatch, "netgen")
    with pytest.raises(FileError, match="wheels"):
        fem(plate)
    assert main(["fem", plate["solid"]["file"], "--unit", "mm"]) == 3
    assert "pip install 'autobalance[fem]'" in capsys.readouterr().err


def test_a_bar_pulled_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(Solid.prism(Region.rectangle([0, 0], [10, 8]), 0.0, 60.0), tmp_path / "bar.stl")
    (tmp_path / "fem.toml").write_text(
        """
        fix = [{ box_mm = [[-1, -1, -0.01], [11, 9, 0.01]], axes = "z" },
               { box_mm = [[-0.01, -1, -1], [0.01, 9, 61]], axes = "x" },
               { box_mm = [[-1, -0.01, -1], [11, 0.01, 61]], axes = "y" }]
        load = [{ box_mm = [[-1, -1, 59.99], [11, 9, 60.01]], force_N = [0, 0, 4000] }]
        solid = { file = "bar.stl", unit = "mm" }
        material = { e_gpa = 70.0, nu = 0.33 }
        analysis = { kind = "static", size_mm = 20.0 }
        """,
        "utf-8",
    )
    assert main(["fem", str(tmp_path / "fem.toml"), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["stress"]["greatest_von_mises_MPa"] == pytest.approx(50.0, rel=1e-6)  # F/A, exactly linear
    stretch, squeeze = 50.0 / 70e3 * 60.0, 0.33 * 50.0 / 70e3
    exact = math.hypot(stretch, squeeze * 10.0, squeeze * 8.0)
    assert report["displacement"]["greatest_mm"] == pytest.approx(exact, rel=1e-6)
    assert report["reactions_N"] == pytest.approx([0.0, 0.0, -4000.0], abs=1e-6)


def test_two_solids_are_refused(tmp_path: Path) -> None:
    square = Region.rectangle([0, 0], [10, 10])
    both = Solid.prism(square, 0.0, 10.0) + Solid.prism(square, 20.0, 30.0)
    with pytest.raises(SolidError, match="the file holds 2 bodies"):
        fem(written(both, tmp_path / "two.stl"), unit="mm")
