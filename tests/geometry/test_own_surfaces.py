"""Axis, journals, crankpins and faces of cranks with true surfaces are the file's own, wherever it lies."""

from pathlib import Path

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.faces import find_faces
from autobalance.crank.recognition.cylinders import own_direction
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_shape
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.tessellation import CylinderFace
from autobalance.solid.csg.shape import Placed
from autobalance.solid.formats.read import Source, read
from tests.coarse import coarse_facets
from tests.generated import random_placement

needs_kernel = pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")

EXACT_MM = 1e-9
"""Rounding of the numbers in a STEP file for a part some 100 mm off its origin."""


def step_crank(folder: Path, preset: str, placement: np.ndarray) -> Source:
    path = folder / "crank.step"
    path.write_bytes(ExactSolid(Placed(crank_shape(PRESETS[preset]), placement)).step())
    return read(path, None)


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Source:
    with coarse_facets():
        return step_crank(tmp_path_factory.mktemp("single"), "single", np.eye(4))


def hints(preset: str) -> Overrides:
    return Overrides(crankpin_in_file="no-pin" not in preset)


@needs_kernel
@pytest.mark.parametrize(
    ("preset", "seed"),
    [("single", 1), *(pytest.param(p, 2, marks=pytest.mark.slow) for p in ("inline-4", "v-twin-45"))],
)
def test_nothing_is_fitted(tmp_path: Path, preset: str, seed: int) -> None:
    placement = random_placement(np.random.default_rng(seed), 100.0)
    with coarse_facets():
        source = step_crank(tmp_path, preset, placement)
    assert source.surfaces is not None
    found = recognise(source.solid, hints(preset), source.surfaces.cylinders)
    true = crank_anatomy(PRESETS[preset], placement)
    np.testing.assert_allclose(found.file_to_rotor[2], true.file_to_rotor[2], atol=EXACT_MM)
    np.testing.assert_allclose(found.file_to_rotor[:2], true.file_to_rotor[:2], atol=3.0 * EXACT_MM)
    assert found.journal_misalignment_mm < EXACT_MM
    for one, other in zip(found.throws, true.throws, strict=True):
        assert one.crank_radius_mm == pytest.approx(other.crank_radius_mm, abs=EXACT_MM)
        assert one.crankpin.diameter_mm == pytest.approx(other.crankpin.diameter_mm, abs=EXACT_MM)
        assert one.crankpin.width_mm == pytest.approx(other.crankpin.width_mm, abs=1e-6)
    for here, there in zip(found.main_journals, true.main_journals, strict=True):
        assert here.diameter_mm == pytest.approx(there.diameter_mm, abs=EXACT_MM)


@pytest.mark.slow
@needs_kernel
def test_faces_have_the_ids_they_have_in_triangles_and_planes_of_their_own(single: Source) -> None:
    source = single
    assert source.surfaces is not None
    anatomy = recognise(source.solid, hints("single"), source.surfaces.cylinders)
    fitted = {face.id: face for face in find_faces(source.solid.mesh, anatomy)}
    own = {face.id: face for face in find_faces(source.solid.mesh, anatomy, source.surfaces)}
    assert own.keys() == fitted.keys()
    planes = {plane.number: plane for plane in source.surfaces.planes}
    for name, face in own.items():
        assert face.spread_mm < 1e-12
        assert face.web == fitted[name].web
        assert face.area_mm2 == pytest.approx(sum(planes[number].area_mm2 for number in face.surfaces))
        assert face.area_mm2 == pytest.approx(fitted[name].area_mm2, rel=1e-2)
        np.testing.assert_allclose(face.normal, fitted[name].normal, atol=1e-6)
        np.testing.assert_allclose(face.centroid_mm, fitted[name].centroid_mm, atol=0.05)
        assert set(face.triangles.tolist()) == set(fitted[name].triangles.tolist())


@pytest.mark.slow
@needs_kernel
def test_what_the_job_gives_is_taken_from_the_job(single: Source) -> None:
    source = single
    assert source.surfaces is not None
    tilted = np.array([1e-5, 0.0, 1.0])
    given = Overrides(axis_direction=tilted, axis_point_mm=np.zeros(3))
    found = recognise(source.solid, given, source.surfaces.cylinders)
    np.testing.assert_allclose(found.file_to_rotor[2, :3], tilted / np.linalg.norm(tilted), atol=1e-12)


def test_the_direction_is_that_of_most_cylindrical_surface() -> None:
    def bar(axis: tuple[float, float, float], area: float) -> CylinderFace:
        unit = np.array(axis) / np.linalg.norm(axis)
        return CylinderFace(0, np.zeros(3), unit, 1.0, 0.0, 1.0, False, area, 6.0)

    faces = [bar((0.0, 0.0, -1.0), 4.0), bar((0.0, 1e-4, 1.0), 5.0), bar((0.0, 0.0, 1.0), 3.0)]
    found = own_direction(np.array([1e-3, 0.0, 1.0]), faces)
    assert found is not None
    np.testing.assert_array_equal(found, [0.0, 0.0, 1.0])
    assert own_direction(np.array([1.0, 0.0, 0.0]), faces) is None
