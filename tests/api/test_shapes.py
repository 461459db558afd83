"""Cranks in the memory of a CAD program: taken as shapes, balanced, and given back as shapes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.solid.cad.installed import has_kernel
from tests.coarse import ROUGH, coarse_facets
from tests.generated import single_step
from tests.jobs import without_advice
from tests.libraries import installed_instead

pytestmark = [
    pytest.mark.slow,
    pytest.mark.usefixtures("cranks_read_once"),
    pytest.mark.skipif(not has_kernel(), reason="the CAD kernel is not installed"),
]

JOB: dict[str, Any] = {
    "engine": {"rotating_g": {"big_end": 300.0}, "reciprocating_g": {"piston": 400.0}},
    "balance": {"factor": 0.4, "grade": 6.3, "speed_rpm": 6000},
    "correction": {"method": "shoulder"},
}


@pytest.fixture(scope="module", autouse=True)
def fewer_triangles() -> Iterator[None]:
    """Plan on fewer triangles: what is measured here are the true surfaces."""
    with coarse_facets(ROUGH):
        yield


@pytest.fixture(scope="module")
def step() -> bytes:
    return single_step()


@pytest.fixture(scope="module")
def shape(step: bytes) -> Any:
    from autobalance.solid.cad.files import read_step_file

    return read_step_file(step).bodies[0].body


@pytest.fixture(scope="module")
def of_file(step: bytes, tmp_path_factory: pytest.TempPathFactory) -> ab.Crank:
    path = tmp_path_factory.mktemp("step") / "crank.step"
    path.write_bytes(step)
    return ab.read_crank(path)


def test_a_shape_is_measured_as_its_step_file(shape: Any, of_file: ab.Crank) -> None:
    crank = ab.crank_from_shape(shape)
    assert crank.mass_g == pytest.approx(of_file.mass_g, rel=1e-9)
    np.testing.assert_allclose(crank.inertia_kg_mm2, of_file.inertia_kg_mm2, rtol=1e-9, atol=1e-9 * 1e4)
    np.testing.assert_allclose(crank.unbalance.resultant_g_mm, of_file.unbalance.resultant_g_mm, atol=1e-5)
    assert crank.throws[0].crank_radius_mm == pytest.approx(of_file.throws[0].crank_radius_mm, rel=1e-9)
    assert crank.file is None


@pytest.mark.parametrize("wrap", ["wrapped", "val"])
def test_objects_that_wrap_a_shape_stand_for_it(shape: Any, of_file: ab.Crank, wrap: str) -> None:
    wrapped = SimpleNamespace(wrapped=shape, label="Kurbelwelle")
    given = wrapped if wrap == "wrapped" else SimpleNamespace(val=lambda: wrapped)
    assert ab.crank_from_shape(given).mass_g == pytest.approx(of_file.mass_g, rel=1e-9)


def test_a_shape_in_inches_comes_and_goes_in_inches(shape: Any, of_file: ab.Crank) -> None:
    from autobalance.solid.cad.kernel import properties, scaled

    small = scaled(shape, 1.0 / 25.4)
    crank = ab.crank_from_shape(small, unit="inch")
    assert crank.mass_g == pytest.approx(of_file.mass_g, rel=1e-9)
    back = properties(crank.to_shape())
    assert back.mass_g == pytest.approx(properties(small).mass_g, rel=1e-9)
    np.testing.assert_allclose(back.centre_mm, properties(small).centre_mm, atol=1e-9)


def test_bytes_of_files_are_shapes_too(step: bytes, shape: Any, of_file: ab.Crank, tmp_path: Path) -> None:
    from OCP.BRepTools import BRepTools

    BRepTools.Write_s(shape, str(tmp_path / "crank.brep"))
    for data in (step, (tmp_path / "crank.brep").read_bytes()):
        assert ab.crank_from_shape(data).mass_g == pytest.approx(of_file.mass_g, rel=1e-9)


def test_the_corrected_crank_comes_back_as_a_shape_and_is_verified(shape: Any, tmp_path: Path) -> None:
    from autobalance.solid.cad.kernel import is_valid, properties

    crank = ab.crank_from_shape(shape)
    done = ab.balance(ab.Job.from_dict(JOB), crank)
    assert done.outcome == "within_tolerance"
    after = done.crank.to_shape()
    assert is_valid(after)
    found = properties(after)
    assert found.mass_g * 7.85e-3 == pytest.approx(done.report["outputs"]["solid"]["mass_g"], rel=1e-9)
    back = np.linalg.inv(crank.file_to_rotor)
    centre = back[:3, :3] @ done.report["outputs"]["solid"]["centre_of_mass_mm"] + back[:3, 3]
    np.testing.assert_allclose(found.centre_mm, centre, atol=1e-7)
    names = sorted(path.name for path in done.write(tmp_path, only=("json",)))
    assert names == ["balanced.step", "input.step", "report.json"]
    assert ab.verify(tmp_path / "report.json").within_tolerance


def test_what_is_no_shape_is_refused(step: bytes, of_file: ab.Crank, tmp_path: Path) -> None:
    from OCP.BRepTools import BRepTools
    from OCP.TopoDS import TopoDS_Shape

    from autobalance.solid.cad.kernel import compound

    with pytest.raises(ab.AutobalanceError, match="found an empty shape; expected an OCP TopoDS_Shape"):
        ab.crank_from_shape(TopoDS_Shape())
    nothing = compound([])
    with pytest.raises(ab.AutobalanceError, match=r"^the shape is empty; expected a crankshaft's solid"):
        ab.crank_from_shape(nothing)
    BRepTools.Write_s(nothing, str(tmp_path / "nothing.brep"))
    with pytest.raises(ab.AutobalanceError, match=r"nothing\.brep: the shape is empty"):
        ab.read_crank(tmp_path / "nothing.brep", unit="mm")
    with pytest.raises(ab.AutobalanceError, match="found int; expected an OCP TopoDS_Shape"):
        ab.crank_from_shape(3)
    with pytest.raises(ab.AutobalanceError, match="found bytes that are neither STEP nor BREP"):
        ab.crank_from_shape(b"solid crank")
    with pytest.raises(ab.AutobalanceError, match="the unit 'yard' is not known"):
        ab.crank_from_shape(step, unit="yard")
    mesh = ab.crank_from_mesh(of_file.vertices_mm, of_file.triangles)
    with pytest.raises(ab.AutobalanceError, match="found a crank of triangles; expected one of a STEP"):
        mesh.to_shape()


def test_a_kernel_of_another_generation_is_one_line(
    shape: Any, monkeypatch: pytest.MonkeyPatch, of_file: ab.Crank, tmp_path: Path
) -> None:
    installed_instead(monkeypatch, tmp_path, "OCP", packages=["cadquery_ocp-7.9.3"])
    with pytest.raises(ab.AutobalanceError, match=r"needs the CAD kernel OCP 8; found OCP 7\.9\.3"):
        ab.crank_from_shape(shape)
    mesh = ab.crank_from_mesh(of_file.vertices_mm, of_file.triangles)
    assert mesh.mass_g > 0.0  # meshes go on working


@pytest.fixture(scope="module")
def milled(of_file: ab.Crank) -> ab.BalanceResult:
    thin = {"method": "mill", "mill": {"min_wall_mm": 1.0}}  # as much as both webs can take
    with without_advice():
        return ab.balance(ab.Job.from_dict({**JOB, "correction": thin}), of_file)


def test_the_tools_make_the_corrected_crank_of_the_one_before(milled: ab.BalanceResult) -> None:
    from autobalance.solid.cad.kernel import cut, properties

    tools = milled.tools()
    entries = milled.report["corrections"]
    assert [(tool.correction, tool.kind, tool.label) for tool in tools] == [
        (number, entry["kind"], entry["label"]) for number, entry in enumerate(entries)
    ]
    assert not any(tool.adds_metal for tool in tools)
    left = properties(cut(milled.before.to_shape(), [tool.to_shape() for tool in tools]))
    after = properties(milled.crank.to_shape())
    gone = sum(entry["removed_volume_mm3"] for entry in entries)
    assert abs(left.mass_g - after.mass_g) < 1e-6 * gone
    for tool in tools:
        assert tool.triangles.max() < len(tool.vertices_mm)
        assert tool.volume_mm3 > entries[tool.correction]["removed_volume_mm3"]


@pytest.mark.parametrize("has_it", [True, False], ids=["step", "3mf"])
def test_tools_are_written_as_named_solids(
    milled: ab.BalanceResult, tmp_path: Path, has_it: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    from autobalance.report import output_kinds

    name = "tools.step" if has_it else "tools.3mf"
    kind = output_kinds.KINDS["tools"]._replace(files={"tools": name})
    monkeypatch.setitem(output_kinds._KINDS, "tools", kind)
    milled.write(tmp_path, only=("tools",))
    assert ab.verify(tmp_path / "report.json").holds
    labels = [entry["label"] for entry in milled.report["corrections"]]
    if has_it:
        from autobalance.solid.cad.files import read_step_file

        bodies = read_step_file((tmp_path / name).read_bytes()).bodies
        assert [one.name for one in bodies] == labels
        (tmp_path / name).write_bytes(b"ISO-10303-21")
    else:
        import zipfile

        with zipfile.ZipFile(tmp_path / name) as archive:
            model = archive.read("3D/3dmodel.model").decode()
        assert [model.count(f'name="{label}"') for label in labels] == [1] * len(labels)
        (tmp_path / name).write_bytes(b"PK")
    with pytest.raises(ab.AutobalanceError, match=r"outputs\.tools\.sha256"):
        ab.verify(tmp_path / "report.json")
