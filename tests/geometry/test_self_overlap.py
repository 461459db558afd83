"""Metal that one connected mesh holds twice is found wherever it lies, refused, or united when asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from autobalance.errors import OverlapError
from autobalance.solid.csg.difference import self_overlap, united
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.measure import Doubled, doubled_metal, frame_along
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.soundness.validate import (
    _measured,
    check_solid,
    refuse_overlap,
    refuse_overlap_exactly,
)
from autobalance.types import Array
from tests import jobs
from tests.cranks import make_crank
from tests.generated import random_placement
from tests.overlaps import DEEP_MM, HEAD_THICKNESS, with_hidden_head

THIN_STEM = 5e-3
"""Of the volume; no ray need meet it."""
RAYS_ROUNDING = 0.02
"""Of a volume of some hundred rays."""


def plate() -> Solid:
    return Solid.box(np.array([-30.0, -20.0, 0.0]), np.array([30.0, 20.0, 20.0]))


@pytest.mark.parametrize("seed", range(4))
def test_a_head_inside_a_web_is_found_however_it_is_turned(seed: int) -> None:
    """Half a millimetre thick: 24 sections across the part would miss it in most places."""
    mesh, twice = with_hidden_head(plate(), -10.0, -5.0, 0.0)
    placement = random_placement(np.random.default_rng(seed)) if seed else np.eye(4)
    solid = Solid.from_mesh(mesh.moved(placement))
    with pytest.raises(OverlapError, match="overlaps itself") as caught:
        check_solid(solid, doubtful=False)
    assert caught.value.volume_mm3 == pytest.approx(twice, rel=THIN_STEM)
    place = placement[:3, :3] @ [-10.0, 7.0, DEEP_MM - 0.5 * HEAD_THICKNESS] + placement[:3, 3]
    shown = str(caught.value).partition("around (")[2].partition(")")[0]
    assert np.array([float(each) for each in shown.split(",")]) == pytest.approx(place, abs=0.1)
    with pytest.raises(OverlapError, match="overlaps itself"):
        refuse_overlap_exactly(solid)


def test_doubled_metal_is_measured_whole_of_which_rays_saw_a_corner() -> None:
    mesh, twice = with_hidden_head(plate(), -10.0, -5.0, 0.0)
    solid = Solid.from_mesh(mesh)
    corner = np.array([-10.0, 7.0, DEEP_MM - 0.5 * HEAD_THICKNESS])
    share, _ = _measured(solid, [Doubled(0.1, corner, corner + 0.2, 1, 0.1)])
    assert share * solid.volume_mm3 == pytest.approx(twice, rel=THIN_STEM)


def test_the_head_lies_between_the_heights_that_were_looked_at() -> None:
    mesh, twice = with_hidden_head(plate(), -10.0, -5.0, 0.0)
    low, high = mesh.bounds[:, 2]
    heights = low + (np.arange(24) + 0.5) / 24 * (high - low)
    head = (DEEP_MM - HEAD_THICKNESS, DEEP_MM)
    assert not ((heights > head[0]) & (heights < head[1])).any()
    assert twice / Solid.from_mesh(mesh).volume_mm3 > 4e-4


def together(one: Mesh, other: Mesh) -> Solid:
    """Return one solid of two shells, as they are."""
    triangles = np.concatenate([one.triangles, other.triangles + len(one.vertices)])
    return Solid.from_mesh(Mesh(np.concatenate([one.vertices, other.vertices]), triangles))


def directions() -> list[Array]:
    rng = np.random.default_rng(5)
    return [frame_along(*rng.normal(size=(2, 3))) for _ in range(3)]


@pytest.mark.parametrize("axes", directions())
def test_rays_measure_what_they_find_and_find_nothing_in_a_sound_solid(axes: Array) -> None:
    mesh, twice = with_hidden_head(plate(), -10.0, -5.0, 0.0)
    for seen in doubled_metal(mesh, 40_000, axes):
        assert seen.volume_mm3 == pytest.approx(twice, rel=RAYS_ROUNDING)
    for sound in doubled_metal(make_crank([0.0, 180.0])[0].mesh, 10_000, axes):
        assert sound.stretches == 0
        assert sound.volume_mm3 < 1e-6


def test_rays_see_metal_that_counts_as_negative() -> None:
    box = Solid.box(np.zeros(3), np.ones(3)).mesh
    for seen in doubled_metal(box.flipped(), 1000, directions()[0]):
        assert seen.volume_mm3 == pytest.approx(1.0, rel=RAYS_ROUNDING)


def test_rays_stand_as_dense_as_asked_for_in_both_directions() -> None:
    """Also through a part of unequal sides, where the fields fill rectangles of unequal size."""
    axes = directions()[1]
    mesh = Solid.box(np.zeros(3), np.array([60.0, 20.0, 5.0])).mesh
    size = np.ptp(mesh.vertices @ axes.T, axis=0)
    for seen, area in zip(doubled_metal(mesh, 1000, axes), size[1] * size[[0, 2]], strict=True):
        assert area / seen.pitch_mm**2 >= 999.9


@pytest.mark.parametrize("fine", [1, 12])
def test_small_metal_is_found_in_a_fine_mesh_where_rays_stand_denser(fine: int) -> None:
    """A ten-thousandth of the mass, in one lump; many triangles are measured by rays alone."""
    size = (1.0e-4 * 48_000.0) ** (1.0 / 3.0)
    knob = Solid.box(np.full(3, 8.0), np.full(3, 8.0 + 1.1 * size)).mesh
    body = Solid(plate()._body.refine(fine * 10)).mesh
    with pytest.raises(OverlapError, match=r"overlaps itself: 0\.01"):
        refuse_overlap(together(body, knob))


def test_united_metal_counts_once_and_moves_nothing_else() -> None:
    mesh, twice = with_hidden_head(plate(), -10.0, -5.0, 0.0)
    solid = Solid.from_mesh(mesh)
    once = united(solid)
    assert once.volume_mm3 == pytest.approx(solid.volume_mm3 - twice, rel=1e-9)
    assert self_overlap(once) is None
    assert once.bounds == pytest.approx(solid.bounds)


def test_what_is_inside_out_cannot_be_united() -> None:
    """A lump of negative metal in a plate: no union makes sense of it."""
    hole = Solid.box(np.full(3, 15.0), np.full(3, 25.0)).mesh.flipped()
    with pytest.raises(OverlapError, match="could not be united"):
        united(together(plate().mesh, hole))


def test_a_file_is_refused_with_place_and_volume_or_united_on_request(tmp_path: Path) -> None:
    mesh, twice = with_hidden_head(plate(), -10.0, -5.0, 0.0)
    path = tmp_path / "plate.stl"
    path.write_bytes(encode(mesh, "stl", 1.0))
    with pytest.raises(
        OverlapError, match=r'plate\.stl: the solid overlaps itself.* mm³ in doubt.*body = "all"'
    ):
        read(path, "mm")
    source = read(path, "mm", "all")
    assert source.volume_mm3 == pytest.approx(Solid.from_mesh(mesh).volume_mm3 - twice, rel=1e-6)
    assert any("united" in note for note in source.repairs)


@pytest.fixture(scope="module")
def crank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A crank with a hidden head in the counterweight of its first web."""
    solid, anatomy = make_crank([0.0])
    mesh, _ = with_hidden_head(solid, -45.0, -6.0, anatomy.webs[0].z_min_mm)
    path = tmp_path_factory.mktemp("overlap") / "crank.stl"
    path.write_bytes(encode(mesh, "stl", 1.0))
    return path


def test_the_command_line_says_the_mass_in_doubt(crank: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", crank, "--unit", "mm") == 3
    printed = capsys.readouterr().err
    assert "overlaps itself" in printed
    assert "g of its mass are in doubt" in printed
    assert jobs.run("inspect", crank, "--unit", "mm", "--body", "all") == 0
    assert "united" in capsys.readouterr().err


def test_verify_refuses_a_written_solid_that_overlaps_itself(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    jobs.balanced(jobs.bundled_job(tmp_path, "straight"), out, 0, "--no-report")
    good = read(out / "balanced.stl", "mm", "all").solid
    low, high = good.bounds
    lump = Solid.box(0.5 * (low + high) - 1.0, 0.5 * (low + high) + 1.0)
    inside = max(good.pieces(), key=lambda piece: piece.volume_mm3)
    corner = inside.section(float(inside.bounds[:, 2].mean())).inner_point()
    shift = np.eye(4)
    shift[:3, 3] = [*corner, inside.bounds[:, 2].mean()] - 0.5 * (low + high)
    path = out / "balanced.stl"
    path.write_bytes(encode(together(good.mesh, lump.mesh.moved(shift)).mesh, "stl", 1.0))
    for options in ([], ["--independent"]):
        assert jobs.run("verify", out / "report.json", *options) == 3
        assert "overlaps itself" in capsys.readouterr().err
