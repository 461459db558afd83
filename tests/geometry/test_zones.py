"""Where holes may go: the counterweight's own arc and radii, away from fillets and oil ways."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from autobalance.correction import drill, slug
from autobalance.correction.drill import DrillCut
from autobalance.correction.holes.cut import HoleCut
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.slugs import SlugLimits
from autobalance.correction.holes.surface import Zone, fillets_of, in_fillets, in_zone
from autobalance.correction.kind import Workpiece
from autobalance.correction.slug import SlugCut
from autobalance.crank.anatomy import Anatomy, CounterweightOutline, Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import preset
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from tests.cranks import Shape, make_crank
from tests.generated import GeneratedCrank, generated_crank

STEEL = 7.85e-3
TOWARDS = np.array([-1.0, 0.3])


def v8() -> tuple[GeneratedCrank, Anatomy]:
    made = generated_crank("v8-crossplane", segments=32)
    return made, recognise(made.solid, Overrides())


def away_deg(anatomy: Anatomy, web: int) -> float:
    """The direction away from the crankpin of a web, from the crankpins' true centres."""
    out = anatomy.webs[web - 1]
    pin = min(
        anatomy.throws,
        key=lambda each: abs(each.crankpin.centre_mm[2] - 0.5 * (out.z_min_mm + out.z_max_mm)),
    )
    x, y = pin.crankpin.centre_mm[:2]
    return math.degrees(math.atan2(-y, -x))


def from_away_deg(anatomy: Anatomy, cut: HoleCut) -> float:
    return math.remainder(math.degrees(cut.site.angle_rad) - away_deg(anatomy, cut.web), 360.0)


def drilled(made: GeneratedCrank, anatomy: Anatomy, **limits: object) -> list[DrillCut]:
    asked = replace(DrillLimits(diameters_mm=(10.0,), max_obliquity_deg=40.0), **limits)  # type: ignore[arg-type]
    return drill.cuts(made.solid, anatomy, STEEL, TOWARDS, asked, search_level=0)


def test_holes_keep_to_the_arc_that_the_counterweight_spans() -> None:
    """Half of a V8's web is a waist of 20 mm between main journal and crankpin, not counterweight."""
    made, anatomy = v8()
    fan = made.design.counterweight
    assert fan is not None
    by_zone: dict[Zone, list[DrillCut]] = {
        zone: drilled(made, anatomy, zone=zone) for zone in ("counterweights", "web", "anywhere")
    }
    journal = 0.5 * made.design.main_journal.diameter_mm + made.design.fillet_mm
    for cut in by_zone["counterweights"]:
        assert anatomy.webs[cut.web - 1].counterweight
        assert abs(from_away_deg(anatomy, cut)) <= 0.5 * fan.fan_angle_deg + 0.5
        point = cut.hole.radius_mm / math.tan(cut.hole.half_point_rad)
        end = math.hypot(*cut.hole.axis.entry_mm[:2]) - cut.max_depth_mm - point
        assert end >= journal - 0.1
    widest = max(abs(from_away_deg(anatomy, cut)) for cut in by_zone["counterweights"])
    assert widest >= 0.5 * fan.fan_angle_deg - 20.0  # all of it is used
    assert all(abs(from_away_deg(anatomy, cut)) <= 90.0 + 1e-6 for cut in by_zone["web"])
    assert any(abs(from_away_deg(anatomy, cut)) > 0.5 * fan.fan_angle_deg + 5.0 for cut in by_zone["web"])
    assert any(abs(from_away_deg(anatomy, cut)) > 95.0 for cut in by_zone["anywhere"])


def test_an_unsymmetrical_counterweight_is_used_where_it_is() -> None:
    _, anatomy = make_crank([0.0], Shape(segments=24))
    outline = CounterweightOutline(62.0, math.radians(60.0), 18.0, math.radians(20.0))
    web = replace(anatomy.webs[0], outline=outline)
    inside = [deg for deg in range(0, 360, 2) if in_zone(anatomy, web, math.radians(deg), "counterweights")]
    assert (inside[0], inside[-1], len(inside)) == (170, 230, 31)
    without = replace(web, counterweight=False)
    assert not any(in_zone(anatomy, without, angle, "counterweights") for angle in np.linspace(0.0, 6.2, 40))
    assert in_zone(anatomy, without, math.radians(95.0), "web")


def fillet_points(made: GeneratedCrank, anatomy: Anatomy) -> Array:
    """Vertices of the fillets at main journals and crankpins, from the true sizes."""
    fillet = made.design.fillet_mm
    vertices = made.mesh.moved(anatomy.file_to_rotor).vertices
    near = np.zeros(len(vertices), dtype=bool)
    for pin in (*anatomy.main_journals, *(throw.crankpin for throw in anatomy.throws)):
        away = np.hypot(*(vertices[:, :2] - pin.centre_mm[:2]).T)
        low, high = pin.z_range_mm
        beside = (vertices[:, 2] > low - fillet - 0.05) & (vertices[:, 2] < high + fillet + 0.05)
        near |= beside & (away < 0.5 * pin.diameter_mm + fillet + 0.05)
    return vertices[near]


@pytest.mark.parametrize("kind", ["drill", "slug"])
def test_axial_holes_keep_their_wall_to_fillets(kind: str) -> None:
    """A fillet leaves the face smoothly, and the first half of it faces the drill like the face itself."""
    twin = preset("parallel-twin-360")
    assert twin.counterweight is not None  # its faces run on to the hub
    made = generated_crank(
        replace(twin, counterweight=replace(twin.counterweight, radius_mm=46.0)), segments=64
    )
    anatomy = recognise(made.solid, Overrides())
    wall = 4.0
    cuts: list[DrillCut | SlugCut] = []
    if kind == "drill":
        limits = {
            "direction": "axial",
            "min_wall_mm": wall,
            "diameters_mm": (6.0, 12.0, 14.0),
            "zone": "anywhere",
        }
        cuts += drilled(made, anatomy, **limits)
    else:
        sizes = SlugLimits(diameters_mm=(6.0, 12.0, 14.0), lengths_mm=(5.0,), min_wall_mm=wall)
        heavy = ((-30.0, TOWARDS), (30.0, TOWARDS))
        work = Workpiece(made.solid, anatomy, (), STEEL, heavy)
        cuts += slug.cuts(work, TOWARDS, sizes, search_level=1)
    points = fillet_points(made, anatomy)
    assert cuts
    nearest = math.inf
    for cut in cuts:
        local = cut.hole.axis.local(points)
        beside = np.maximum(np.hypot(local[:, 0], local[:, 1]) - cut.hole.radius_mm, 0.0)
        above = np.maximum(np.maximum(-local[:, 2], local[:, 2] - cut.max_depth_mm), 0.0)
        same_side = np.abs(local[:, 2]) < made.design.fillet_mm + 0.1
        nearest = min(nearest, float(np.hypot(beside, above)[same_side].min(initial=math.inf)))
    assert wall - 0.05 <= nearest <= wall + 4.0


def test_fillets_are_recognised_whatever_their_radius_and_the_face_beyond_is_none() -> None:
    """A counterweight thicker than its hub hides from the recognised web where the fillet ends."""
    made = generated_crank("single", segments=64)
    anatomy = recognise(made.solid, Overrides())
    fillets = [each for web in anatomy.webs for each in fillets_of(anatomy, web)]
    assert len(fillets) == 2 * len(anatomy.webs)  # a journal's and a crankpin's at each
    corners = made.mesh.moved(anatomy.file_to_rotor).corners
    held = in_fillets(corners, tuple(fillets))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    slanted = (np.abs(normal[:, 2]) > 0.05) & (np.abs(normal[:, 2]) < 0.95)
    assert held.sum() >= 4 * 64
    assert slanted[held].mean() > 0.9
    assert not (np.abs(normal[held, 2]) > 0.999).any()


def test_holes_keep_their_wall_to_oil_ways_in_the_solid() -> None:
    """A bore from the crank axis out into the counterweight, plugged at the rim."""
    solid, anatomy = make_crank([0.0], Shape(segments=48))
    web, radius, wall = anatomy.webs[0], 3.0, 3.0
    middle = 0.5 * (web.z_min_mm + web.z_max_mm)
    bore = Solid.prism(Region.circle(radius, 48), 0.0, 50.0)  # along z from 0 to 50, then laid along -x
    lay = np.eye(4)
    lay[:3, :3] = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    lay[2, 3] = middle
    with_way = solid - bore.moved(lay)
    limits = DrillLimits(diameters_mm=(8.0,), min_wall_mm=wall, min_depth_mm=2.0)
    free = [cut for cut in drill.cuts(solid, anatomy, STEEL, TOWARDS, limits, 1) if cut.web == 1]
    kept = [cut for cut in drill.cuts(with_way, anatomy, STEEL, TOWARDS, limits, 1) if cut.web == 1]
    assert max(cut.max_depth_mm for cut in free) > 20.0
    for cut in kept:
        point = cut.hole.radius_mm / math.tan(cut.hole.half_point_rad)
        for depth in np.linspace(0.0, cut.max_depth_mm + point, 60):
            at = cut.hole.axis.entry_mm + depth * cut.hole.axis.inward
            beyond = max(-50.0 - float(at[0]), float(at[0]))
            aside = max(math.hypot(float(at[1]), float(at[2]) - middle) - radius, 0.0)
            own = cut.hole.radius_mm * min(1.0, (cut.max_depth_mm + point - depth) / point)
            assert math.hypot(aside, max(beyond, 0.0)) >= min(own + wall, wall) - 0.05
    towards_way = [cut for cut in kept if abs(math.pi - cut.site.angle_rad % math.tau) < 0.02]
    assert all(cut.max_depth_mm < 7.0 for cut in towards_way)
