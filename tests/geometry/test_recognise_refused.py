"""What is no crank is refused in one line; what is doubtful too, and the key that settles it is named."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.alignment import misalignment_warning
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import RecognitionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from tests.cranks import Shape, make_crank, tilted
from tests.generated import differences
from tests.sweeps import SWEPT

SEGMENTS = 32


def disc(radius: float, low: float, high: float, x: float = 0.0, y: float = 0.0) -> Solid:
    return Solid.prism(Region.circle(radius, SEGMENTS, (x, y)), low, high)


def connecting_rod(small_end: float) -> Solid:
    shank = Solid.prism(Region.rectangle([0, -8], [120, 8]), -4.0, 4.0)
    body = shank + disc(30.0, -12.0, 12.0) + disc(16.0, -small_end, small_end, 120.0)
    return body - disc(20.0, -20.0, 20.0) - disc(8.0, -20.0, 20.0, 120.0)


def gear(hub: float) -> Solid:
    tooth = Solid.prism(Region.rectangle([38, -3], [46, 3]), 0.0, 20.0)
    teeth = []
    for step in range(24):
        c, s = math.cos(step * math.pi / 12), math.sin(step * math.pi / 12)
        turn = np.eye(4)
        turn[:2, :2] = [[c, -s], [s, c]]
        teeth.append(tooth.moved(turn))
    return union([disc(40.0, 0.0, 20.0), disc(18.0, 0.0, 20.0 + hub), *teeth]) - disc(10.0, -1.0, 60.0)


def camshaft() -> Solid:
    lobes = [
        Solid.prism(
            Region.circle(20.0, SEGMENTS)
            + Region.circle(10.0, SEGMENTS, (18.0 * math.cos(1.3 * k), 18.0 * math.sin(1.3 * k))),
            20.0 + 25.0 * k,
            32.0 + 25.0 * k,
        )
        for k in range(7)
    ]
    return union([disc(14.0, 0.0, 200.0), *lobes])


def plates() -> Solid:
    return union([disc(20.0, z, z + 5.0) - disc(5.0, -1.0, 50.0) for z in (0.0, 30.0)])


NO_CRANKS = {
    "cube": Solid.box(np.zeros(3), np.full(3, 50.0)),
    "connecting rod": connecting_rod(12.0),
    "connecting rod with a long small end": connecting_rod(16.0),
    "connecting rod with a flat small end": connecting_rod(4.0),
    "gear": gear(0.0),
    "gear with a hub": gear(15.0),
    "camshaft": camshaft(),
    "shaft": disc(10.0, 0.0, 100.0),
    "pipe": disc(10.0, 0.0, 100.0) - disc(8.0, -1.0, 101.0),
    "two plates": plates(),
    "flange with two dowels": disc(10.0, 0.0, 60.0)
    + disc(40.0, 60.0, 70.0)
    + disc(5.0, 70.0, 78.0, 25.0)
    + disc(5.0, 70.0, 78.0, -25.0),
}


HINTS = [
    (name, hint)
    for name in NO_CRANKS
    for hint in (None, False, True)
    if hint is not True or SWEPT or name == "two plates"
]
"""Without a hint a part is looked at with its crankpin and without; what is said is what is said of it with
its crankpin, except where there is a gap."""


@pytest.mark.parametrize(("name", "pin_in_file"), HINTS)
def test_what_is_no_crank_is_refused(name: str, pin_in_file: bool | None) -> None:
    solid = Solid.from_mesh(NO_CRANKS[name].mesh.moved(tilted(0.5, (10.0, 20.0, 30.0))))
    with pytest.raises(RecognitionError, match=r"\. (If .*, set|Set) [a-z_]+") as refusal:
        recognise(solid, Overrides(crankpin_in_file=pin_in_file))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("segments", [3, 4, 5, 6, 7])
def test_coarser_than_eight_facets_is_right_or_refused(segments: int) -> None:
    solid, true = make_crank([0, 180], Shape(segments=segments))
    try:
        found = recognise(solid, Overrides())
    except RecognitionError:
        return
    assert differences(found, true) == []
    assert np.abs(found.file_to_rotor - true.file_to_rotor).max() < 1e-6


def bent_crank(aside_mm: float) -> Solid:
    """Two throws, the middle main journal beside the axis of the other two."""
    return union(
        [
            disc(15.0, 0.0, 41.0),
            disc(40.0, 40.0, 55.0),
            disc(12.0, 54.0, 76.0, 25.0),
            disc(40.0, 75.0, 90.0),
            disc(15.0, 89.0, 121.0, aside_mm),
            disc(40.0, 120.0, 135.0),
            disc(12.0, 134.0, 156.0, -25.0),
            disc(40.0, 155.0, 170.0),
            disc(15.0, 169.0, 210.0),
        ]
    )


@pytest.mark.parametrize("aside_mm", [0.005, 0.05, 0.4, 1.0, 3.0])
def test_journals_out_of_line_are_reported(aside_mm: float) -> None:
    found = recognise(bent_crank(aside_mm), Overrides(crankpin_in_file=None))
    assert [j.diameter_mm for j in found.main_journals] == pytest.approx([30.0] * 3, rel=1e-3)
    assert [t.crankpin.diameter_mm for t in found.throws] == pytest.approx([24.0] * 2, rel=1e-3)
    assert np.diff([t.crankpin.centre_mm[2] for t in found.throws]) == pytest.approx([80.0], abs=0.1)
    assert np.diff([j.centre_mm[2] for j in found.main_journals]) == pytest.approx([85.0] * 2, abs=0.5)
    assert 0.5 * aside_mm < found.journal_misalignment_mm < aside_mm
    warning = misalignment_warning(found)
    assert warning is not None
    assert f"{found.journal_misalignment_mm:.3g} mm" in warning
    straight, _ = make_crank([0, 180], Shape(segments=24))
    aligned = recognise(straight, Overrides())
    assert aligned.journal_misalignment_mm < 1e-6
    assert misalignment_warning(aligned) is None


@pytest.mark.parametrize("aside_mm", [0.2, 1.0, 3.0, 8.0])
def test_round_webs_beside_the_axis_are_no_crankpins(aside_mm: float) -> None:
    webs = [disc(48.0, low, low + 16.0, -aside_mm) for low in (40.0, 72.0)]
    journals = [disc(14.0, 0.0, 41.0), disc(14.0, 87.0, 130.0)]
    with_pin = union([*webs, *journals, disc(14.0, 55.0, 73.0, 25.0)])
    bored = union([web - disc(14.0, 0.0, 100.0, 25.0) for web in webs] + journals)
    for solid in (with_pin, bored):
        found = recognise(solid, Overrides(crankpin_in_file=None))
        assert [t.crank_radius_mm for t in found.throws] == pytest.approx([25.0], abs=1e-6)
        assert [w.z_max_mm - w.z_min_mm for w in found.webs] == pytest.approx([16.0, 16.0], abs=1e-6)
        assert all(w.counterweight for w in found.webs)


def test_halves_apart_are_no_crank_with_its_crankpin() -> None:
    webs = [disc(48.0, low, low + 16.0, -3.0) for low in (40.0, 72.0)]
    halves = union([*webs, disc(14.0, 0.0, 41.0), disc(14.0, 87.0, 130.0)])
    with pytest.raises(RecognitionError, match=r"there is no metal .* crankpin_in_file = false"):
        recognise(halves, Overrides(crankpin_in_file=True))


def test_an_axis_given_beside_every_journal_is_refused() -> None:
    solid, _ = make_crank([0], Shape(segments=24))
    with pytest.raises(RecognitionError, match=r"no main journals on the axis given.* Set axis_point_mm"):
        recognise(solid, Overrides(axis_point_mm=np.array([0.0, 55.0, 0.0])))


def test_a_direction_without_length_is_refused() -> None:
    solid, _ = make_crank([0], Shape(segments=24))
    with pytest.raises(RecognitionError, match="axis_direction has no length"):
        recognise(solid, Overrides(axis_direction=np.zeros(3)))


def test_a_web_without_journal_beyond_it_is_a_web() -> None:
    blank_aside = 0.1
    solid = union(
        [
            disc(20.0, 0.0, 41.0),
            disc(60.0, 40.0, 55.0),
            disc(15.0, 54.0, 76.0, 30.0),
            disc(60.0, 75.0, 90.0),
            disc(15.0, 89.0, 111.0, -30.0),
            disc(60.0, 110.0, 160.0, blank_aside),
        ]
    )
    found = recognise(solid, Overrides())
    assert [t.crank_radius_mm for t in found.throws] == pytest.approx([30.0, 30.0], abs=1e-6)
    assert [j.diameter_mm for j in found.main_journals] == pytest.approx([40.0], abs=1e-6)
    widths = [web.z_max_mm - web.z_min_mm for web in found.webs]
    assert widths == pytest.approx([15.0, 15.0, 50.0], abs=1e-6)
