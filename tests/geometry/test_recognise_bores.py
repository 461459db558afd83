"""Full-disc webs without their pin: the throw is where their bores are, whatever else is beside them."""

from __future__ import annotations

import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import RecognitionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from tests.cranks import tilted
from tests.sweeps import SWEPT

SEGMENTS = 24
ROUNDING_MM = 1e-6
AIDS = [(20.0, 20.0, 7.0), (20.0, -20.0, 7.0)]
"""Lightening holes beside the pin, as x, y and radius [mm]."""
LARGER = [(-10.0, 25.0, 12.0), (-10.0, -25.0, 12.0)]
EQUAL = [(20.0, -25.0, 10.0), (20.0, 25.0, 10.0)]


def disc(radius: float, low: float, high: float, x: float = 0.0, y: float = 0.0) -> Solid:
    return Solid.prism(Region.circle(radius, SEGMENTS, (x, y)), min(low, high), max(low, high))


def shoulder(kind: str, side: float) -> list[Solid]:
    """What stands 2 mm out of the inner cheek of a web."""
    low, high = 6.0 * side, 8.0 * side
    return {
        "none": [],
        "about the axis": [disc(20.0, low, high)],
        "about the bore": [disc(16.0, low, high, 25.0)],
        "a ring near the rim": [disc(40.0, low, high) - disc(36.0, -60.0, 60.0)],
    }[kind]


def crank(kind: str, holes: list[tuple[float, float, float]], blind: bool = False) -> Solid:
    halves = []
    for side in (-1.0, 1.0):
        parts = [disc(45.0, 8.0 * side, 28.0 * side), disc(12.5, 28.0 * side, 70.0 * side)]
        half = union([*parts, *shoulder(kind, side)])
        half = half - (disc(10.0, 0.0, 22.0 * side, 25.0) if blind else disc(10.0, -40.0, 40.0, 25.0))
        for x, y, radius in holes:
            half = half - disc(radius, -40.0, 40.0, x, y)
        halves.append(half)
    return Solid.from_mesh(union(halves).mesh.moved(tilted(0.9, (40.0, 0.0, -20.0))))


KINDS = ("none", "about the axis", "about the bore", "a ring near the rim")
BESIDE = [(kind, [*AIDS, *LARGER]) for kind in KINDS] + [(kind, []) for kind in KINDS[: None if SWEPT else 1]]


@pytest.mark.parametrize(("kind", "holes"), BESIDE)
def test_the_throw_is_at_the_bores(kind: str, holes: list[tuple[float, float, float]]) -> None:
    found = recognise(crank(kind, holes), Overrides(crankpin_in_file=None))
    (throw,) = found.throws
    assert throw.crank_radius_mm == pytest.approx(25.0, abs=ROUNDING_MM)
    assert throw.crankpin.diameter_mm == pytest.approx(20.0, abs=ROUNDING_MM)
    assert throw.crankpin.width_mm == pytest.approx(16.0 if kind == "none" else 12.0, abs=ROUNDING_MM)
    assert [j.diameter_mm for j in found.main_journals] == pytest.approx([25.0] * 2, abs=ROUNDING_MM)
    assert [j.width_mm for j in found.main_journals] == pytest.approx([42.0] * 2, abs=ROUNDING_MM)
    assert [j.centre_mm[2] for j in found.main_journals] == pytest.approx([-49.0, 49.0], abs=ROUNDING_MM)
    assert len(found.webs) == 2


def test_blind_bores_serve_as_well() -> None:
    found = recognise(crank("about the axis", EQUAL, blind=True), Overrides(crankpin_in_file=False))
    assert found.throws[0].crank_radius_mm == pytest.approx(25.0, abs=ROUNDING_MM)


def test_halves_without_bores_are_refused_for_their_bores_not_their_gap() -> None:
    plain = union(
        [disc(45.0, side * 8.0, side * 28.0) + disc(12.5, side * 28.0, side * 70.0) for side in (-1, 1)]
    )
    with pytest.raises(
        RecognitionError, match=r"a side of the gap between webs, .* has no bore for the crankpin"
    ):
        recognise(plain, Overrides(crankpin_in_file=None))
