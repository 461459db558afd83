"""STEP: exact mass properties, triangles on the true surface, and clear errors."""

import math
from pathlib import Path

import numpy as np
import pytest

from autobalance.crank.design import preset
from autobalance.crank.generate import crank_shape
from autobalance.errors import FormatError
from autobalance.solid import step
from autobalance.solid.brep import ExactSolid, has_kernel
from autobalance.solid.csg import Solid
from autobalance.solid.facets import facet_error
from autobalance.solid.formats import written_ending
from autobalance.solid.measure import mesh_moments
from autobalance.solid.read import read
from autobalance.solid.shape import Prism, circle
from autobalance.solid.step import read_step
from autobalance.solid.write import encode

kernel = pytest.mark.skipif(not has_kernel(), reason="the CAD kernel is not installed")


@pytest.fixture
def cylinder(tmp_path: Path) -> Path:
    path = tmp_path / "cylinder.stp"
    path.write_bytes(ExactSolid(Prism(circle(10.0, (30.0, 0.0)), 0.0, 20.0)).step())
    return path


@kernel
def test_a_cylinder_is_exact(cylinder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    source = read(cylinder, None)
    assert (source.read_as, source.format, source.mm_per_unit, source.bodies) == ("step", "stl", 1.0, 1)
    assert source.exact is not None
    assert source.exact.mass_g == pytest.approx(2000.0 * math.pi, rel=1e-12)
    np.testing.assert_allclose(source.exact.centre_mm, [30.0, 0.0, 10.0], atol=1e-9)
    assert source.solid.volume_mm3 == pytest.approx(2000.0 * math.pi, rel=2e-3)
    corner = source.solid.mesh.vertices
    assert np.hypot(corner[:, 0] - 30.0, corner[:, 1]).max() == pytest.approx(10.0, rel=1e-12)
    assert capfd.readouterr().out == ""  # the kernel prints on standard output unless told not to


@kernel
def test_mesh_and_exact_surface_agree_within_the_facet_error(tmp_path: Path) -> None:
    path = tmp_path / "crank.step"
    path.write_bytes(ExactSolid(crank_shape(preset("pressed-up-single"))).step())
    source = read(path, "mm")
    assert source.exact is not None
    missing = source.exact - mesh_moments(source.solid.mesh, 1.0)
    error = facet_error(source.solid.mesh, 1.0)
    assert abs(missing.mass_g - error.missing.mass_g) < min(error.mass_bar_g, abs(missing.mass_g) / 10.0)


@kernel
def test_a_step_file_is_in_mm(cylinder: Path) -> None:
    with pytest.raises(FormatError, match="the file is in mm, the unit given is inch"):
        read(cylinder, "inch")


@kernel
@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"solid", "does not begin with ISO-10303-21"),
        (b"ISO-10303-21;\nrubbish", r"cannot be read|holds no solid"),
        (
            b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n",
            r"cannot be read|holds no solid",
        ),
    ],
)
def test_wrong_step_files(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_step(data)


def test_without_the_kernel_one_line_names_the_install_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step, "has_kernel", lambda: False)
    with pytest.raises(FormatError, match=r"pip install 'autobalance\[step\]'"):
        read_step(b"ISO-10303-21;")


def test_the_corrected_solid_of_a_step_file_is_a_mesh() -> None:
    assert written_ending(Path("crank.STP")) == ".stl"
    assert written_ending(Path("crank.OBJ")) == ".obj"
    assert written_ending(Path("crank.unknown")) == ".unknown"
    with pytest.raises(FormatError, match="a mesh cannot be written as STEP"):
        encode(Solid.box(np.zeros(3), np.ones(3)).mesh, "step", 1.0)
