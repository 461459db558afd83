"""What is read off the metal of a cut: flaps, thinner than rounding but wide, do not hide its planes."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import autobalance as ab
from autobalance.correction.faces.trace import BESIDE_DEG, FaceTrace
from autobalance.correction.rings import EQUAL_AREA, RING_SIDES, RingTrace
from autobalance.correction.trace import Before, Metal, Reading
from autobalance.crank.anatomy import Face
from autobalance.errors import SolidError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from autobalance.verification.cut_values import _separated, shared_out

NEAR_MM = 6e-5


def block(width_mm: float, low_mm: float, high_mm: float) -> Solid:
    half = 0.5 * width_mm
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return Solid.prism(Region.of([square]), low_mm, high_mm)


@pytest.mark.parametrize("up", [1.0, -1.0])
@pytest.mark.parametrize("flap_mm", [0.0, 1e-5, 5e-5])
def test_a_wide_flap_hides_neither_floor_nor_cheek(up: float, flap_mm: float) -> None:
    cut = block(10.0, 0.0, 4.0)
    if flap_mm:
        cut = union([cut, block(60.0, 0.0, flap_mm)])
    metal = Metal((cut,), 7.85e-3, cast(Any, None), None, 0.0, NEAR_MM)
    height, moments = metal.facing(np.array([0.0, 0.0, up]))
    assert height == pytest.approx(4.0 if up > 0.0 else 0.0, abs=1e-9)
    if up > 0.0:
        assert moments.mass_g == pytest.approx(100.0, rel=1e-9)


def test_a_flap_beside_a_floor_counts_on_neither_side() -> None:
    """Metal that is added up to the height of a face beside it, which rounding has covered in part."""
    pad = union([block(10.0, 0.0, 4.0), block(12.0, 4.0 - 1e-5, 4.0)])
    metal = Metal((pad,), 7.85e-3, cast(Any, None), None, 0.0, NEAR_MM)
    height, moments = metal.facing(np.array([0.0, 0.0, 1.0]))
    assert height == pytest.approx(4.0, abs=1e-9)
    assert moments.mass_g == pytest.approx(100.0, rel=1e-9)


def ring(inner_mm: float, outer_mm: float, start_deg: float, end_deg: float) -> Solid:
    """A part of a ring, 10 mm wide, of as many sides as a tool."""
    corners = [[inner_mm, 0.0], [outer_mm, 0.0], [outer_mm, 10.0], [inner_mm, 10.0]]
    outline = np.array(corners) * [EQUAL_AREA, 1.0]
    angles = np.radians(np.linspace(start_deg, end_deg, 40))
    wedge = np.concatenate(
        [np.zeros((1, 2)), 2.0 * outer_mm * np.column_stack([np.cos(angles), np.sin(angles)])]
    )
    return Solid.revolved(outline, RING_SIDES) & Solid.prism(Region.of([wedge]), -1.0, 11.0)


@pytest.mark.parametrize("flapped", [False, True])
def test_a_flap_beside_a_turned_rim_does_not_count_in_its_rate(flapped: bool) -> None:
    radius, density = 70.0, 7.85e-3
    rim = ring(radius, radius + 2.0, -20.0, 20.0)
    pieces = (rim, ring(radius + 0.03, radius + 0.03002, 120.0, 240.0)) if flapped else (rim,)
    metal = Metal(pieces, density, cast(Any, None), None, 0.0, NEAR_MM)
    told = RingTrace({"kind": "turn"}).rates(metal, radius)["unbalance_per_mm_g_mm"]
    value, within = (told.value, told.within) if isinstance(told, Reading) else (told, 0.0)
    half = np.radians(20.0)
    exact = -density * 10.0 * radius**2 * 2.0 * np.sin(half)
    assert within <= 0.05 * abs(exact)
    assert np.allclose(value, [exact, 0.0], rtol=0.0, atol=max(within, 1e-3 * abs(exact)))


@pytest.mark.parametrize("stands_out_mm", [0.033, 0.2])
def test_the_rate_of_a_faceted_rim_is_of_what_its_corners_leave(stands_out_mm: float) -> None:
    """Of the facets a strip at each corner alone is turned; a flap at the new radius hides their edges."""
    radius, density, sides = 70.0, 7.85e-3, 24
    corners = radius + stands_out_mm
    angles = 2.0 * np.pi / sides * np.arange(-3, 4)
    half = corners * np.column_stack([np.cos(angles), np.sin(angles)])
    rim = Solid.prism(Region.of([np.concatenate([np.zeros((1, 2)), half])]), 0.0, 10.0)
    strips = rim - Solid.revolved(np.array([[0, -1], [radius, -1], [radius, 11], [0, 11]]), 3600)
    flap = ring(radius + 0.01, radius + 0.01001, 120.0, 240.0)
    metal = Metal((strips, flap), density, cast(Any, None), None, 0.0, NEAR_MM)
    read = RingTrace({"kind": "turn"}).rates(metal, radius)["unbalance_per_mm_g_mm"]
    value, within = (read.value, read.within) if isinstance(read, Reading) else (read, 0.0)
    in_middle = corners * np.cos(np.pi / sides)  # of a facet; the turned circle comes out of it beside that
    bare = np.arccos(min(in_middle / radius, 1.0))
    ends = np.pi / sides - bare  # half of a strip
    strip = density * 10.0 * radius**2 * ends
    exact = -strip * sum(
        (1.0 if abs(k) == 3 else 2.0) * np.cos(k * 2.0 * np.pi / sides) for k in range(-3, 4)
    )
    assert within <= 0.3 * abs(exact)
    assert value[0] == pytest.approx(exact, abs=within)


class Losing(Solid):
    """A solid of which some is lost when it is built from its triangles: all where there is no such part."""

    left: Solid | None = None

    @classmethod
    def from_mesh(cls, mesh: Mesh) -> Solid:
        if cls.left is None:
            raise SolidError("the mesh is inside out: its volume is -3.88532e-08 mm³")
        return cls.left

    def pieces(self) -> list[Solid]:
        """With thousands of flakes this takes minutes: only what is around a thick piece is taken apart."""
        raise AssertionError("all of it was taken apart")


class LosingALayer(Losing):
    left = Solid.box(np.zeros(3), np.array([10.0, 10.0, 3.0]))


@pytest.mark.parametrize("losing", [Losing, LosingALayer])
def test_pieces_are_whole_where_making_them_anew_loses_metal(losing: type[Losing]) -> None:
    """manifold3d takes long slivers out of what it is given, at times with much that hangs there, or all."""
    flake = block(60.0, 20.0, 20.00001)
    both = losing(union([block(10.0, 0.0, 4.0), block(10.0, 6.0, 8.0), flake])._body)
    volumes = sorted(piece.volume_mm3 for piece in both.thicker_pieces(0.001))
    assert volumes == pytest.approx([200.0, 400.0], rel=1e-9)


def half_disc(start_deg: float) -> Solid:
    """Half of a disc, a hair more than that at both edges."""
    angles = np.radians(start_deg + np.linspace(-BESIDE_DEG, 180.0 + BESIDE_DEG, 90))
    return Solid.prism(Region.of([70.0 * np.column_stack([np.cos(angles), np.sin(angles)])]), 0.0, 3.0)


def test_equal_halves_that_meet_in_a_sectors_edge_are_both_found() -> None:
    """They share a hair and have one volume, yet neither is the other."""
    halves = [half_disc(0.0), half_disc(180.0)]
    parts = cast(Any, [SimpleNamespace(array=lambda *_, y=y: np.array([0.0, y, 1.5])) for y in (30.0, -30.0)])
    mine = [[half] for half in halves]
    assert _separated(parts, mine, 0, 1, 1e-6) == set()
    assert [len(pieces) for pieces in mine] == [1, 1]
    both = [[halves[0]], [halves[0]]]  # one piece, that lies in the rooms of both
    assert _separated(parts, both, 0, 1, 1e-6) == set()
    assert [len(pieces) for pieces in both] == [1, 0]
    shared = [[halves[0]], [block(60.0, 0.0, 3.0)]]
    assert _separated(parts, shared, 0, 1, 1e-6) == {0, 1}


def test_a_thin_cut_is_found_that_hangs_on_a_thick_one() -> None:
    """All but a twentieth of the piece is the thick one's, and yet all of the thin one is in it."""
    rooms = [half_disc(0.0), half_disc(180.0)]
    thin = rooms[1] - rooms[1].above(0.14)
    gone = union([rooms[0], thin])
    sizes = rooms[0].volume_mm3, thin.volume_mm3
    parts = cast(
        Any,
        [
            SimpleNamespace(
                get=lambda key, _, size=size: {"kind": "shoulder", "removed_volume_mm3": size}[key],
                array=lambda *_, y=y: np.array([0.0, y, 1.5]),
            )
            for size, y in zip(sizes, (30.0, -30.0), strict=True)
        ],
    )
    traces = cast(Any, [SimpleNamespace(room=lambda _, room=room: room) for room in rooms])
    every = shared_out((gone, Solid.nothing()), parts, traces, cast(Any, None), 1e-6)
    for found, size in zip(every, sizes, strict=True):
        assert not found.is_torn
        assert found.metal is not None
        assert sum(piece.volume_mm3 for piece in found.metal) == pytest.approx(size, rel=1e-3)


@pytest.mark.parametrize("lean", [0.5, 2.0, 6.0])
def test_the_room_of_a_lowered_face_holds_what_leans_far_outward(lean: float) -> None:
    """A square block whose sides lean outward by so much of the depth: all over the new face is its."""
    low, high = (
        half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) for half in (30.0, 10.0)
    )
    solid = Solid.lofted(low, high, 0.0, 20.0 / lean)
    top = 20.0 / lean
    mesh = solid.mesh
    flat = np.flatnonzero((mesh.corners[:, :, 2] > top - 1e-9).all(axis=1))
    up = np.array([0.0, 0.0, 1.0])
    face = Face("w1-a", "plane", 1, 400.0, up, top * up, flat, 0.0)
    crank = Before(mesh, cast(Any, SimpleNamespace(file_to_rotor=np.eye(4))), (face,), ())
    depth = 0.5 * top
    item = {
        "kind": "shoulder",
        "face": "w1-a",
        "normal": [0.0, 0.0, 1.0],
        "face_height_mm": top,
        "new_height_mm": top - depth,
    }
    gone = solid.above(top - depth)
    assert (gone - FaceTrace(item).room(crank)).volume_mm3 <= 1e-9 * gone.volume_mm3


def test_two_depths_that_meet_in_a_sectors_edge_are_told_apart(tmp_path: Path) -> None:
    drawn = ab.generate("single", file=tmp_path / "crank.stl", segments=64)
    drawn.write(tmp_path)
    crank = ab.read_crank(tmp_path / "crank.stl", unit="mm", density_kg_m3=7850.0)
    job = ab.Job.from_dict(
        {
            "crankshaft": {"density_kg_m3": 7850.0, "unit": "mm"},
            "engine": {"rotating_g": {"rod": 134.04}, "reciprocating_g": {"piston": 261.5}},
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
            "correction": {"method": "shoulder"},
        }
    )
    result = ab.balance(job, crank=crank)
    sectors = {tuple(cut.sector_deg) for cut in result.corrections}
    assert sectors == {(90.0, 180.0), (180.0, 270.0)}
    result.write(tmp_path / "out", only=("json",))
    assert ab.verify(tmp_path / "out" / "report.json", independent=True).holds
