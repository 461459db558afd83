"""Milled pockets: closed forms, walls measured anew, reach of the cutter, and a whole run."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.command.main import main
from autobalance.correction import mill
from autobalance.correction.kind import Workpiece
from autobalance.correction.mill import MillCut
from autobalance.correction.pockets import MillLimits, Pocket
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.crank.faces import find_faces
from autobalance.errors import CorrectionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from tests.coarse import bundled_corners
from tests.cranks import Shape, make_crank, tilted
from tests.geometry.test_drill import assert_same, difference
from tests.geometry.test_layouts import web_faces
from tests.jobs import bundled_job, write_stl

STEEL = 7.85e-3
HEAVY = np.array([-1000.0, 0.0])
ARCS = 1e-4
"""Share of a pocket that the tool's chords miss."""


def work(solid: Solid, anatomy: Anatomy) -> Workpiece:
    heavy = (-50.0, HEAVY), (50.0, HEAVY)
    return Workpiece(solid, anatomy, web_faces(solid, anatomy), STEEL, heavy)


def offered(solid: Solid, anatomy: Anatomy, limits: MillLimits) -> list[MillCut]:
    cuts = mill.KIND.offer(work(solid, anatomy), limits, 0).cuts
    return [cut for cut in cuts if isinstance(cut, MillCut)]


def corner_loss_mm2(pocket: Pocket, radius: float, sign: float) -> float:
    """What a fillet takes of the corner between a ray and a circle, by the circles' own geometry."""
    c = pocket.corner_mm
    centre = radius - sign * c
    lean = math.asin(c / centre)
    foot = centre * math.cos(lean)
    swept = 0.5 * math.pi + sign * lean
    sector = 0.5 * radius**2 * lean  # between the ray and the line to the fillet's centre
    kite = 0.5 * foot * c
    return sign * (sector - kite) - 0.5 * c**2 * swept


def test_the_area_of_a_pocket_is_that_of_its_sector_without_its_corners() -> None:
    pocket = Pocket(25.0, 45.0, 0.3, 1.4, 5.0)
    sector = 0.5 * 1.1 * (45.0**2 - 25.0**2)
    loss = 2.0 * corner_loss_mm2(pocket, 45.0, 1.0) + 2.0 * corner_loss_mm2(pocket, 25.0, -1.0)
    assert pocket.region.area_mm2 == pytest.approx(sector - loss, rel=ARCS)
    assert pocket.has_room
    assert not Pocket(25.0, 34.0, 0.3, 1.4, 5.0).has_room
    assert not Pocket(25.0, 45.0, 0.3, 0.6, 5.0).has_room


@pytest.mark.slow
def test_a_pocket_in_a_disc_is_a_prism() -> None:
    R, t, wall = 60.0, 20.0, 4.0
    solid = Solid.prism(Region.circle(R, 360), 0.0, t)
    anatomy = Anatomy(np.eye(4), (), (), (Web(1, 0.0, t, True),), 0.0)
    faces = find_faces(solid.mesh, anatomy)
    piece = Workpiece(solid, anatomy, faces, STEEL, ((0.0, HEAVY), (t, HEAVY)))
    limits = MillLimits(min_wall_mm=wall, sectors_deg=((179.0, 181.0),), depth_step_mm=0.0)
    cuts = mill.KIND.offer(piece, limits, 0).cuts
    up = [cut for cut in cuts if isinstance(cut, MillCut) and cut.cheek.up > 0.0]
    assert len(up) == len(cuts) / 2
    for cut in up:
        assert cut.pocket.outer_mm == pytest.approx(R - wall, abs=0.06)  # the edge's chords between rays
        assert cut.max_depth_mm == pytest.approx(15.0)
        assert cut.limit == "max_depth_mm = 15"
        change, area = cut.effect(6.0), cut.pocket.region.area_mm2
        assert -change.mass_g == pytest.approx(STEEL * area * 6.0, rel=1e-12)
        assert change.centre_mm[2] == pytest.approx(t - 3.0)
        assert change.centre_mm[1] == pytest.approx(0.0, abs=1e-6)
        half = 0.5 * (cut.pocket.end_rad - cut.pocket.start_rad)
        ring = (cut.pocket.outer_mm**3 - cut.pocket.inner_mm**3) / (
            cut.pocket.outer_mm**2 - cut.pocket.inner_mm**2
        )
        assert change.centre_mm[0] == pytest.approx(-2.0 / 3.0 * math.sin(half) / half * ring, rel=5e-3)
        details = cut.correction(6.0).details
        assert details["angle_deg"] == pytest.approx(180.0)
        assert details["wall_left_mm"] == pytest.approx(wall, abs=0.07)
    thin = MillLimits(min_wall_mm=wall, max_depth_mm=30.0)
    assert mill.KIND.offer(piece, thin, 0).cuts[0].max_depth_mm == pytest.approx(16.0)
    assert mill.KIND.offer(piece, thin, 0).cuts[0].limit == "min_wall_mm = 4"


@pytest.mark.parametrize("placement", [np.eye(4), tilted(0.7, [200.0, -300.0, 150.0])])
def test_planned_effect_is_what_the_cut_solid_loses_and_the_walls_are_left(placement: Array) -> None:
    solid, anatomy = make_crank([0.0, 180.0], Shape(web_width=24.0, segments=48), placement)
    limits = MillLimits(cutter_mm=8.0)
    cuts = offered(solid, anatomy, limits)
    assert {cut.cheek.web for cut in cuts} >= {1, 4}
    for cut in cuts[:: max(1, len(cuts) // 8)]:
        depth = 0.7 * cut.max_depth_mm
        after = solid - cut.tool(depth).moved(anatomy.rotor_to_file)
        assert_same(cut.effect(depth), difference(solid, after, anatomy), 1e-6)
        slope = (cut.effect(depth + 1e-3) - cut.effect(depth - 1e-3)).scaled(500.0)
        assert_same(cut.rate(depth), slope, 1e-7)
        deepest, wall = cut.max_depth_mm, limits.min_wall_mm - 0.01
        low, high = cut.cheek.heights(deepest + wall)
        below = (low, high - 0.01) if cut.cheek.up > 0.0 else (low + 0.01, high)
        inflated = Solid.prism(cut.pocket.region.grown(wall), *below).moved(anatomy.rotor_to_file)
        assert (inflated - solid).volume_mm3 < 1e-6 * inflated.volume_mm3


def test_a_cutter_comes_along_the_axis_only_where_nothing_stands() -> None:
    """Between webs that cover each other there is no way in; beyond the first and the last there is."""
    solid, anatomy = make_crank([0.0], Shape(web_width=24.0, segments=48))
    for cut in offered(solid, anatomy, MillLimits(cutter_mm=8.0)):
        assert (cut.cheek.web, cut.cheek.up) in ((1, -1.0), (2, 1.0))
        z, far = cut.cheek.z_mm + 0.01 * cut.cheek.up, cut.cheek.z_mm + 1e3 * cut.cheek.up
        way = Solid.prism(cut.pocket.region, min(z, far), max(z, far)).moved(anatomy.rotor_to_file)
        assert (way & solid).is_empty


def test_pockets_keep_to_their_sectors_and_apart() -> None:
    solid, anatomy = make_crank([0.0], Shape(web_width=24.0, segments=48))
    limits = MillLimits(cutter_mm=8.0, sectors_deg=((120.0, 200.0),))
    candidates = mill.KIND.offer(work(solid, anatomy), limits, 0)
    angles = [cut.correction(1.0).details["angle_deg"] for cut in candidates.cuts]
    assert 120.0 <= min(angles) <= max(angles) <= 200.0
    never = {(pair.first, pair.second) for pair in candidates.apart}
    free = [(i, j) for j in range(len(candidates.cuts)) for i in range(j) if (i, j) not in never]
    assert never
    for i, j in free[:: max(1, len(free) // 40)]:
        one, two = (cut.tool(cut.max_depth_mm) for cut in (candidates.cuts[i], candidates.cuts[j]))
        assert one.gap_mm(two, 5.0) >= limits.min_wall_mm


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"cutter_mm": 0.0}, "mill.cutter_mm is 0"),
        ({"min_wall_mm": -1.0}, "mill.min_wall_mm is -1"),
        ({"depth_step_mm": math.inf}, "mill.depth_step_mm is inf"),
        ({"min_depth_mm": 20.0}, "at most max_depth_mm = 15"),
        ({"sectors_deg": ()}, "mill.sectors_deg is empty"),
        ({"cutter_mm": 60.0}, "no pocket for a cutter of 60 mm"),
        ({"sectors_deg": ((0.0, 1.0),), "cutter_mm": 30.0}, "within sectors_deg"),
        ({"min_wall_mm": 30.0}, "min_wall_mm = 30"),
    ],
)
def test_impossible_limits_are_refused(limits: dict[str, Any], message: str) -> None:
    solid, anatomy = make_crank([0.0], Shape(segments=48))
    with pytest.raises(CorrectionError, match=re.escape(message)):
        mill.KIND.offer(work(solid, anatomy), MillLimits(**limits), 0)


@pytest.mark.slow
def test_a_crank_is_milled_and_verified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = bundled_job(tmp_path, method='["mill", "drill"]')
    write_stl(tmp_path / "crank.stl", bundled_corners(segments=64))
    table = (
        "\n[correction.mill]\ncutter_mm = 6.0\nmin_wall_mm = 2.5\n[correction.drill]\nmax_depth_mm = 8.0\n"
    )
    job.write_text(job.read_text(encoding="utf-8") + table, encoding="utf-8")
    out = tmp_path / "out"
    assert main(["balance", str(job), "-o", str(out), "--no-report"]) == 0
    assert "mill web" in capsys.readouterr().out
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    milled = [made for made in report["corrections"] if made["kind"] == "mill"]
    assert 0 < len(milled) < len(report["corrections"])
    for made in milled:
        assert made["wall_left_mm"] >= 2.5 - 0.01
        assert made["corner_radius_mm"] == 3.0
    assert main(["verify", "--independent", str(out / "report.json")]) == 0
