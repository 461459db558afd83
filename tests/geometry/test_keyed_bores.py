"""Bores with keyways, splines and slots: they are bores, and a key tells the shaft's from the crankpin's."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides, PinHint
from autobalance.crank.recognition.circles import hole_circles
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import RecognitionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from tests.odd_kinds import OddCrank, arm, bored_arm, differences, disc, lone_web

ANY = Overrides(crankpin_in_file=None)
REACH_MM = 60.0


def slot(
    radius: float, width: float, depth: float, angle_deg: float, centre: Sequence[float] = (0.0, 0.0)
) -> Solid:
    """Return the metal of a slot from a line along z to ``depth`` beyond a radius."""
    box = Solid.box(
        np.array([0.0, -0.5 * width, -REACH_MM]), np.array([radius + depth, 0.5 * width, REACH_MM])
    )
    turn, angle = np.eye(4), math.radians(angle_deg)
    turn[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    turn[:2, 3] = centre
    return box.moved(turn)


def keyed(
    crank: OddCrank, radius: float, centre: Sequence[float] = (0.0, 0.0), deep: float = 0.12
) -> OddCrank:
    """Return a crank with a hub's keyway in a bore, 0.3 of its diameter wide and 0.12 deep (DIN 6885)."""
    cut = slot(radius, 0.6 * radius, 2.0 * deep * radius, 17.0, centre)
    return OddCrank(crank.solid - cut, crank.journals, crank.pins, crank.webs)


@pytest.mark.parametrize("segments", [16, 48, 180])
def test_a_keyway_makes_a_bore_the_shafts(segments: int) -> None:
    """Without it nothing tells the arm's shaft; of the web, size and counterweight contradict each other."""
    plain_arm, plain_web = bored_arm(segments, beyond_pin=25.0), lone_web(segments, pin=11.0, shaft=8.0)
    for plain, radius in ((plain_arm, 2.4), (plain_web, 8.0)):
        assert [doubt.about for doubt in recognise(plain.solid, ANY).doubts] == ["axis"]
        crank = keyed(plain, radius)
        found = recognise(crank.solid, ANY)
        assert differences(crank, found) == []
        assert found.doubts == ()
        (bore,) = [each for each in found.cylinders if each.role == "main_journal"]
        assert bore.kind == "bore"
        assert bore.diameter_mm == pytest.approx(2.0 * radius, abs=1e-4)


def test_a_key_that_the_counterweight_contradicts_is_a_doubt() -> None:
    plain = lone_web(pin=11.0, shaft=8.0)
    crank = keyed(plain, 11.0, plain.pins[0][:2], deep=0.05)
    found = recognise(crank.solid, ANY)
    assert differences(OddCrank(crank.solid, plain.pins, plain.journals, plain.webs), found) == []
    (doubt,) = found.doubts
    x, y, z = plain.journals[0][:3]
    assert found.rotor_to_file @ [*doubt.other.centre_mm, 1.0] == pytest.approx([x, y, z, 1.0], abs=1e-6)


def test_a_keyway_in_the_stub_makes_it_the_shaft() -> None:
    """The arm's bore is the crankpin's then; without the keyway it is the shaft's."""
    plain = bored_arm()
    assert differences(plain, recognise(plain.solid, ANY)) == []
    x, y = plain.pins[0][:2]
    ring = disc(6.0, 9.0, 20.0, (x, y)) - disc(2.9, 8.0, 21.0, (x, y))
    key = ring & slot(3.5, 2.0, 3.0, 100.0, (x, y))
    found = recognise(plain.solid - key, ANY)
    swapped = OddCrank(plain.solid, plain.pins, plain.journals, plain.webs)
    assert differences(swapped, found) == []


@pytest.mark.parametrize("segments", [24, 96])
def test_a_splined_bore_is_the_shafts(segments: int) -> None:
    """Six slots as of DIN ISO 14, 6 × 23 × 26, leave 47 % of the bore's circle."""
    web = arm((40.0, 0.0), 28.0, 16.0, 0.0, 14.0, segments, 50.0)
    tools = [disc(8.0, -5.0, 20.0, (40.0, 0.0), segments), disc(11.5, -5.0, 20.0, n=segments)]
    solid = web - union([*tools, *(slot(11.5, 6.0, 1.5, 60.0 * k + 5.0) for k in range(6))])
    found = recognise(solid, ANY)
    crank = OddCrank(solid, [(0.0, 0.0, 7.0, 23.0, 14.0)], [(40.0, 0.0, 7.0, 16.0, 14.0)], [(0.0, 14.0)])
    assert differences(crank, found) == []
    assert found.doubts == ()


def test_a_keyway_tells_an_overhung_cranks_shaft_from_its_pin() -> None:
    """A bar with a stub at either end, one up, one down, alike but for a keyway."""
    bar = Solid.box(np.array([-12.0, -10.0, 0.0]), np.array([42.0, 10.0, 8.0]))
    plain = union([bar, disc(7.0, -20.0, 1.0), disc(7.0, 7.0, 28.0, (30.0, 0.0))])
    with pytest.raises(RecognitionError, match="ambiguous, with 2 lines of cylinders"):
        recognise(plain, ANY)
    ends: dict[float, tuple[float, ...]] = {0.0: (-20.0, -6.0), 30.0: (14.0, 28.0)}
    for x, (low, high) in ends.items():
        box = Solid.box(np.array([x - 2.0, 4.5, low]), np.array([x + 2.0, 9.0, high]))
        found = recognise(plain - box, ANY)
        (journal,) = found.main_journals
        place = found.rotor_to_file @ [*journal.centre_mm, 1.0]
        assert place[:2] == pytest.approx([x, 0.0], abs=1e-6)
        assert found.throws[0].crank_radius_mm == pytest.approx(30.0, abs=1e-6)


# --- two bores in one hole ----------------------------------------------------------------------------------


def clamped_web() -> OddCrank:
    """A bar with two bores that a slot joins, and a bolt's bore across it."""
    body = Solid.box(np.array([-8.0, -7.0, 0.0]), np.array([22.0, 7.0, 10.0]))
    joined = Solid.box(np.array([0.0, -1.0, -1.0]), np.array([14.0, 1.0, 11.0]))
    lying = np.eye(4)
    lying[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    lying[:3, 3] = (7.0, 0.0, 5.0)
    bolt = disc(2.5, -20.0, 20.0).moved(lying)
    tools = union([disc(4.0, -1.0, 11.0), disc(4.0, -1.0, 11.0, (14.0, 0.0)), joined, bolt])
    return OddCrank(body - tools, [(14.0, 0.0, 5.0, 8.0, 10.0)], [(0.0, 0.0, 5.0, 8.0, 10.0)], [(0.0, 10.0)])


def test_two_bores_that_a_slot_joins_are_named_and_can_be_chosen() -> None:
    """Nothing tells such a web from a clamp: it is recognised once a job states which bore is what."""
    crank = clamped_web()
    with pytest.raises(RecognitionError) as refusal:
        recognise(crank.solid, ANY)
    text = str(refusal.value)
    assert "no bare cylinder but 2 bores: " in text
    assert all(f"⌀8 × 10 mm at [{x}, 0, 5] mm" in text for x in (0, 14))
    assert text.endswith("Set axis_point_mm (--axis-point) in the shaft's bore, and crankpin_in_file = false")
    shaft, pin = np.array([14.0, 0.0, 5.0]), np.array([0.0, 0.0, 5.0])
    for stated in (
        Overrides(axis_point_mm=shaft, crankpin_in_file=False),
        Overrides(crankpins=(PinHint(pin),), crankpin_in_file=False),
        Overrides(main_journals=(PinHint(shaft),), crankpin_in_file=False),
        Overrides(main_journals=(PinHint(shaft),), crankpins=(PinHint(pin),), crankpin_in_file=False),
        Overrides(
            axis_direction=np.array([0.0, 0.0, 1.0]),
            main_journals=(PinHint(shaft, 8.0, 10.0),),
            crankpins=(PinHint(pin, 8.0, 10.0),),
            crankpin_in_file=False,
        ),
    ):
        found = recognise(crank.solid, stated)
        assert differences(crank, found) == []
        assert found.doubts == ()


def outline_of(region: Region) -> np.ndarray:
    (outline,) = region.polygons
    return np.asarray(outline, dtype=np.float64)


def test_windows_and_long_holes_hold_no_pin() -> None:
    long = Region.circle(4.0, 64) + Region.circle(4.0, 64, (9.0, 0.0)) + Region.rectangle([0, -4], [9, 4])
    window = Region.rectangle([-5.0, -5.0], [5.0, 5.0])
    for region in (long, window):
        assert hole_circles(outline_of(region), 1e-9) == ()
    keyhole = Region.circle(4.0, 64) + Region.rectangle([0.0, -1.0], [9.0, 1.0])
    (circle,) = hole_circles(outline_of(keyhole), 1e-9)
    assert [*circle.centre, circle.radius] == pytest.approx([0.0, 0.0, 4.0], abs=1e-9)
