"""Planar faces, on coarse and fine meshes, with float32 noise, anywhere."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.crank.anatomy import Face, Overrides
from autobalance.crank.faces import find_faces, find_rims, lowering_worth_g_mm_per_mm
from autobalance.crank.recognition.recognise import recognise
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from tests.cranks import Shape, make_crank, tilted


def square(faces: tuple[Face, ...]) -> list[Face]:
    return [face for face in faces if abs(face.normal[2]) > 0.99]


def refined(mesh: Mesh) -> Mesh:
    """Each triangle cut into four."""
    v, t = mesh.vertices, mesh.triangles
    edges = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
    ends, number = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (number.reshape(-1) + len(v)).reshape(3, -1)
    a, b, c = t.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return Mesh(
        np.concatenate([v, v[ends].mean(axis=1)]),
        np.concatenate([np.stack(part, axis=1) for part in parts]),
    )


@pytest.mark.parametrize("segments", [12, 64, 400])
def test_each_web_has_its_two_faces_and_two_flanks(segments: int) -> None:
    solid, true = make_crank([0, 90], Shape(segments=segments))
    faces = find_faces(solid.mesh, true)
    for web in true.webs:
        mine = [face for face in faces if face.web == web.number]
        heights = [float(face.centroid_mm[2]) for face in square(tuple(mine))]
        assert heights == pytest.approx([web.z_min_mm, web.z_max_mm], abs=1e-6)
        assert len(mine) == 4  # the fan's two straight flanks
        assert [face.id for face in mine] == [f"w{web.number}-{letter}" for letter in "abcd"]
    ends = [face for face in faces if face.web is None]
    assert [face.id for face in ends] == ["s-a", "s-b"]


def test_areas_are_those_of_the_sections() -> None:
    shape = Shape(segments=64)
    solid, true = make_crank([0], shape)
    web = true.webs[0]
    back = true.rotor_to_file[2, 3]
    at_web = solid.section(0.5 * (web.z_min_mm + web.z_max_mm) + back).area_mm2
    at_pin, at_journal = solid.section(back).area_mm2, solid.section(web.z_min_mm - 5.0 + back).area_mm2
    outer, inner = square(tuple(face for face in find_faces(solid.mesh, true) if face.web == 1))
    assert outer.area_mm2 == pytest.approx(at_web - at_journal, rel=1e-7)
    assert inner.area_mm2 == pytest.approx(at_web - at_pin, rel=1e-7)


def test_fine_meshes_float32_and_placement_change_nothing() -> None:
    solid, _ = make_crank([0], Shape(segments=48))
    plain = find_faces(solid.mesh, recognise(solid, Overrides()))
    moved = refined(refined(solid.mesh)).moved(tilted(0.9, (300.0, -200.0, 250.0)))
    rounded = Mesh(moved.vertices.astype(np.float32).astype(np.float64), moved.triangles)
    fine_solid = Solid.from_mesh(rounded)
    anatomy = recognise(fine_solid, Overrides())
    fine = find_faces(rounded, anatomy)
    flipped = anatomy.file_to_rotor[2, :3] @ tilted(0.9, (0.0, 0.0, 0.0))[:3, 2] < 0.0
    assert not flipped
    assert [face.id for face in fine] == [face.id for face in plain]
    for a, b in zip(fine, plain, strict=True):
        assert a.area_mm2 == pytest.approx(b.area_mm2, rel=1e-4)
        assert np.abs(a.centroid_mm - b.centroid_mm).max() < 1e-3


def test_ids_do_not_depend_on_the_order_of_triangles() -> None:
    solid, true = make_crank([0, 180], Shape(segments=32))
    mesh = solid.mesh
    order = np.random.default_rng(3).permutation(len(mesh.triangles))
    shuffled = find_faces(Mesh(mesh.vertices, mesh.triangles[order]), true)
    for a, b in zip(find_faces(mesh, true), shuffled, strict=True):
        assert a.id == b.id
        assert sorted(a.triangles) == sorted(order[b.triangles])


def test_lowering_a_face_takes_its_metal_from_where_it_is() -> None:
    solid, true = make_crank([0], Shape(segments=48))
    face = find_faces(solid.mesh, true)[0]
    thin = 1e-3
    density = 7.85e-3
    back = true.rotor_to_file[2, 3]
    corners = solid.mesh.vertices[solid.mesh.triangles[face.triangles]]
    area, first, _ = (
        solid.section(face.centroid_mm[2] + back + thin) - solid.section(face.centroid_mm[2] + back - thin)
    ).area_moments()
    assert area == pytest.approx(face.area_mm2, rel=1e-6)
    assert lowering_worth_g_mm_per_mm(face, density) == pytest.approx(-density * first, abs=1e-4)
    assert np.ptp(corners[:, :, 2]) < 1e-9


@pytest.mark.parametrize("segments", [24, 200])
def test_rims_are_listed_with_what_turning_them_is_worth(segments: int) -> None:
    shape = Shape(segments=segments)
    solid, _ = make_crank([0, 90], shape, tilted(0.7, (30.0, -40.0, 20.0)))
    anatomy = recognise(solid, Overrides())
    rims = find_rims(solid.mesh, anatomy)
    assert [(rim.id, rim.kind, rim.web) for rim in rims] == [
        (f"w{web.number}-rim", "cylinder", web.number) for web in anatomy.webs
    ]
    half, chord = shape.half_fan_rad, (shape.half_fan_rad / (segments - 1)) ** 2  # facets hide so much
    for rim, web in zip(rims, anatomy.webs, strict=True):
        area = 2.0 * half * shape.rim_radius * shape.web_width
        assert rim.area_mm2 == pytest.approx(area, rel=chord)
        away = anatomy.throws[0 if web.number <= 2 else 1].direction * -1.0
        assert rim.normal[:2] == pytest.approx(away, abs=1e-6)
        worth = 2.0 * shape.rim_radius**2 * np.sin(half) * shape.web_width
        assert lowering_worth_g_mm_per_mm(rim, 1.0) == pytest.approx(-worth * away, rel=2.0 * chord, abs=1e-3)
        assert rim.centroid_mm[2] == pytest.approx(0.5 * (web.z_min_mm + web.z_max_mm), abs=1e-6)
