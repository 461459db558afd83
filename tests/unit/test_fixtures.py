"""The bundled cranks: committed files equal a rebuild, and are what they claim to be."""

import json
import math
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import mesh_of_soup
from fixtures import make

REBUILD = 1e-9  # other versions of the dependencies may round differently
FACETS_G_MM = 1.0  # what 512 segments may cost in unbalance
RHO = make.DENSITY_G_MM3

built = pytest.fixture(scope="module")(make.build)


def read(name: str) -> Solid:
    records = np.fromfile(make.HERE / name, dtype=np.uint8)[84:].reshape(-1, 50)
    soup = np.ascontiguousarray(records[:, 12:48]).view("<f4").reshape(-1, 3, 3)
    return Solid.from_mesh(mesh_of_soup(soup))


def moments_of_bytes(content: bytes) -> Moments:
    records = np.frombuffer(content, dtype=np.uint8)[84:].reshape(-1, 50)
    soup = np.ascontiguousarray(records[:, 12:48]).view("<f4").reshape(-1, 3, 3)
    return Solid.from_mesh(mesh_of_soup(soup)).moments(RHO)


def test_committed_files_equal_a_rebuild(built: tuple[dict[str, bytes], dict[str, object]]) -> None:
    recorded = json.loads((make.HERE / "built.json").read_text(encoding="utf-8"))
    same = recorded["versions"] == {name: version(name) for name in make.DEPENDENCIES}
    for name, content in built[0].items():
        committed = (make.HERE / name).read_bytes()
        if same:
            assert content == committed
        here, there = moments_of_bytes(content), moments_of_bytes(committed)
        assert here.mass_g == pytest.approx(there.mass_g, rel=REBUILD)
        size = math.sqrt(there.polar_inertia_g_mm2 / there.mass_g)
        np.testing.assert_allclose(here.first_g_mm, there.first_g_mm, atol=REBUILD * size * there.mass_g)
        np.testing.assert_allclose(
            here.second_g_mm2, there.second_g_mm2, atol=REBUILD * there.polar_inertia_g_mm2
        )
    if same:
        assert json.loads(json.dumps(built[1])) == recorded


@pytest.mark.parametrize("variant", ["straight", "drafted"])
def test_dimensions_give_the_published_mass_properties(variant: str) -> None:
    dimensions, webs = make.VARIANTS[variant]
    size = dimensions()
    mass, product, polar = make.whole(size, webs(size))
    assert mass == pytest.approx(2020.40, rel=1e-12)
    assert product / mass == pytest.approx(6.16, rel=1e-12)
    assert polar == pytest.approx(2847.335e3, rel=1e-12)


def test_straight_dimensions_are_those_derived_from_the_source() -> None:
    size = make.straight()
    assert size.counterweight_radius == pytest.approx(51.3812184, abs=1e-7)
    assert size.web_radius == pytest.approx(49.3555157, abs=1e-7)
    assert size.web_thickness == pytest.approx(15.3319494, abs=1e-7)
    assert size.shoulder_height == pytest.approx(4.44237129, abs=1e-8)
    assert size.shoulder_inner_radius == pytest.approx(19.0817693, abs=1e-7)
    assert (size.pin_length, size.pin_bore) == pytest.approx((46.6638988, 19.634033), abs=1e-6)
    assert size.journal_length == pytest.approx(58.4392208, abs=1e-7)


def test_drafted_shoulder_has_the_first_moment_and_its_growth() -> None:
    size = make.drafted()
    face = make.segment(size.counterweight_radius, make.SHOULDER_EDGE_MM)
    assert face[1] == pytest.approx(make.SHOULDER_Q_MM3, rel=1e-12)
    step = 0.01
    full, lower, lowest = (make.drafted_shoulder(size, depth)[1] for depth in (0.0, step, 2.0 * step))
    assert (full - lower) / step == pytest.approx(make.SHOULDER_Q_MM3, rel=1e-4)
    assert 490.0 < (2.0 * lower - full - lowest) / step**2 < 550.0


@pytest.mark.parametrize("variant", ["straight", "drafted"])
@pytest.mark.parametrize(("file", "bodies"), [("crank.stl", 2), ("crank-with-pin.stl", 1)])
def test_files_measure_what_the_dimensions_say(variant: str, file: str, bodies: int) -> None:
    path = f"{variant}/{file}"
    pin = make.FILES[file]
    assert (make.HERE / path).stat().st_size < 1_000_000
    solid = read(path)
    assert len(solid.pieces()) == bodies
    moments = solid.moments(RHO)
    mass = 2700.0 - (0.0 if pin else 114.65)
    unbalance = 2020.40 * 6.16 - (114.65 * 26.9 if pin else 0.0)
    assert moments.mass_g == pytest.approx(mass, rel=1e-4)
    assert moments.mass_g < mass
    assert -moments.first_g_mm[1] == pytest.approx(unbalance, abs=FACETS_G_MM)
    np.testing.assert_allclose(moments.first_g_mm[[0, 2]], 0.0, atol=0.01)
    if pin:
        assert moments.polar_inertia_g_mm2 == pytest.approx(2847.335e3, rel=1e-4)


@pytest.mark.parametrize("variant", ["straight", "drafted"])
def test_facet_error_falls_with_the_square_of_the_segments(variant: str) -> None:
    dimensions, webs = make.VARIANTS[variant]
    size = dimensions()
    _, product, _ = make.whole(size, webs(size))
    errors = []
    for segments in (128, 256):
        drawn = make.crank(replace(size, segments=segments), pin=False)
        errors.append(-drawn.moments(RHO).first_g_mm[1] - product)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def test_written_normals_point_out_of_the_metal() -> None:
    for path in Path(make.HERE).rglob("*.stl"):
        records = np.fromfile(path, dtype=np.uint8)[84:].reshape(-1, 50)
        numbers = np.ascontiguousarray(records[:, :48]).view("<f4").astype(np.float64).reshape(-1, 4, 3)
        normal, a, b, c = numbers.transpose(1, 0, 2)
        cross = np.cross(b - a, c - a)
        np.testing.assert_allclose(normal * np.linalg.norm(cross, axis=1)[:, None], cross, atol=1e-5)
