"""Metal is read off what went, though rounding leaves wide flaps on it."""

import numpy as np
import pytest

from autobalance.correction.rings import RingTrace
from autobalance.correction.trace import Before, Metal
from autobalance.errors import SolidError
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.soundness.validate import without_flakes
from autobalance.verification.claims import Claims
from autobalance.verification.correction_claims import _is_skin
from autobalance.verification.cut_values import shared_out
from tests.cranks import make_crank

NEAR_MM = 1e-5
FLAP_MM = 2e-6


def test_a_pockets_depth_is_read_under_a_flap_wider_than_the_pocket() -> None:
    solid, anatomy = make_crank([0.0])
    pocket = Solid.box(np.array([10.0, 0.0, -5.0]), np.array([20.0, 8.0, 0.0]))
    flap = Solid.box(np.array([-30.0, -30.0, -FLAP_MM]), np.array([30.0, 30.0, 0.0]))
    crank = Before(solid.mesh, anatomy, (), ())
    metal = Metal((pocket + flap,), 7.85e-3, crank, None, 100.0, NEAR_MM)
    up = np.array([0.0, 0.0, 1.0])
    floor, cut = metal.facing(-up)
    assert floor == pytest.approx(5.0)
    assert cut.mass_g == pytest.approx(80.0)
    assert metal.facing(up)[0] == pytest.approx(0.0)


def test_slivers_on_a_flap_are_found_in_their_room() -> None:
    """A rim turned by less than its corners stick out: the flap between them makes all of it thin."""
    solid, anatomy = make_crank([0.0])
    web = anatomy.webs[0]
    low, high = web.z_min_mm, web.z_max_mm
    tips = [Solid.box(np.array([x, 60.0, low]), np.array([x + 0.5, 60.1, high])) for x in (-5.0, 5.0)]
    flap = Solid.box(np.array([-58.0, -58.0, low]), np.array([58.0, 60.1, low + FLAP_MM]))
    gone = union([*tips, flap]), Solid.nothing()
    item = {"kind": "turn", "webs": [web.number], "new_radius_mm": 60.0, "position_mm": [0.0, 60.0, low]}
    crank = Before(solid.mesh, anatomy, (), ())
    parts = [Claims("report.json", item)]
    (found,) = shared_out(gone, parts, [RingTrace(item)], crank, NEAR_MM)
    assert found.is_torn
    assert found.metal is not None
    assert sum(each.volume_mm3 for each in found.metal) == pytest.approx(
        sum(t.volume_mm3 for t in tips), rel=0.01
    )


@pytest.mark.parametrize(("share", "is_skin"), [(1.0, True), (1.1, False), (0.0, False)])
def test_a_film_is_told_by_its_volume(share: float, is_skin: bool) -> None:
    """A rim turned by little more than its facets stand back."""
    solid, anatomy = make_crank([0.0])
    web = anatomy.webs[0]
    low, high, thick = web.z_min_mm, web.z_max_mm, 8.0 * NEAR_MM
    film = Solid.box(np.array([-5.0, 60.0, low]), np.array([5.0, 60.0 + thick, high]))
    volume = share * film.volume_mm3
    item = {"kind": "turn", "webs": [web.number], "new_radius_mm": 60.0, "position_mm": [0.0, 60.0, low]}
    part = Claims("report.json", {**item, "depth_mm": 0.03, "removed_volume_mm3": volume})
    crank = Before(solid.mesh, anatomy, (), ())
    (found,) = shared_out((film, Solid.nothing()), [part], [RingTrace(part.values)], crank, NEAR_MM)
    assert found.metal == ()
    assert _is_skin(part, found.skin, 0.01 * NEAR_MM) == is_skin


def test_flakes_beside_a_cut_solid_are_dropped_and_loose_pieces_refused() -> None:
    before = Solid.box(np.zeros(3), np.full(3, 10.0))
    cut = before - Solid.box(np.array([4.0, -1.0, 5.0]), np.array([6.0, 11.0, 11.0]))
    flake = Solid.box(np.full(3, 20.0), np.full(3, 20.01))
    inside_out = flake.mesh.flipped()
    offset = len(cut.mesh.vertices)
    both = Mesh(
        np.concatenate([cut.mesh.vertices, inside_out.vertices]),
        np.concatenate([cut.mesh.triangles, inside_out.triangles + offset]),
    )
    assert without_flakes(cut, before) is cut
    left = without_flakes(Solid.from_mesh(both), before)
    assert left.triangle_count == cut.triangle_count
    assert left.volume_mm3 == pytest.approx(cut.volume_mm3, rel=1e-12)
    halves = before - Solid.box(np.array([4.0, -1.0, -1.0]), np.array([6.0, 11.0, 11.0]))
    with pytest.raises(SolidError, match=r"a loose piece of 400 mm³ around \((2|8), 5, 5\) mm"):
        without_flakes(halves, before)
