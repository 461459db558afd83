"""Kinds of crank beside the usual one: places, diameters and widths of all journals, crankpins and webs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank.anatomy import Anatomy, Overrides, Pin, PinHint
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import AutobalanceError, RecognitionError
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from tests.cranks import Shape, make_crank
from tests.generated import random_placement
from tests.odd_kinds import KINDS, Bare, bored_arm, differences, disc, in_file, lone_web

ANY = Overrides(crankpin_in_file=None)
FRAMES = ("as drawn", "upside down", "along x", "anywhere", "mirrored", "inch", "no unit")


def frame(name: str) -> np.ndarray:
    """Return what makes a file's coordinates of the crank's own (4, 4)."""
    place = np.eye(4)
    if name == "upside down":
        place[:3, :3] = np.diag([1.0, -1.0, -1.0])
    elif name == "along x":
        place[:3, :3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        place[:3, 3] = (30.0, -200.0, 12.5)
    elif name == "anywhere":
        place = random_placement(np.random.default_rng(11), 300.0)
    elif name == "mirrored":
        place[0, 0] = -1.0
    elif name == "inch":
        place[:3, :3] *= 25.4
    elif name == "no unit":  # public models are drawn two units long
        place[:3, :3] /= 64.0
    return place


def placed(solid: Solid, place: np.ndarray) -> Solid:
    """Return a solid moved, rounded to single precision as in a file."""
    mesh = solid.mesh
    corners = mesh.vertices @ place[:3, :3].T + place[:3, 3]
    inside_out = np.linalg.det(place[:3, :3]) < 0.0
    triangles = mesh.triangles[:, ::-1] if inside_out else mesh.triangles
    return Solid.from_mesh(
        Mesh(corners.astype(np.float32).astype(np.float64), np.ascontiguousarray(triangles))
    )


@pytest.mark.parametrize("segments", [16, 48, 180])
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_what_it_is(kind: str, segments: int) -> None:
    crank = KINDS[kind](segments)
    assert differences(crank, recognise(crank.solid, ANY)) == []


@pytest.mark.parametrize("name", FRAMES)
@pytest.mark.parametrize("kind", KINDS)
def test_every_frame_shows_the_same_crank(kind: str, name: str) -> None:
    crank, place = KINDS[kind](48), frame(name)
    found = recognise(placed(crank.solid, place), ANY)
    assert differences(crank, found, place) == []


def assert_bare(found: Anatomy, journals: Sequence[Bare], pins: Sequence[Bare]) -> None:
    here = in_file(found)
    assert [len(bare) for bare in here] == [len(journals), len(pins)]
    assert np.abs(np.array(here[0]) - np.array(journals)).max() < 1e-6
    assert np.abs(np.array(here[1]) - np.array(pins)).max() < 1e-6


def test_an_arm_with_metal_beyond_its_crankpin_is_a_doubt() -> None:
    """The bore may be a crankpin's and the stub the shaft's, with a counterweight: nothing tells which."""
    crank = bored_arm(beyond_pin=25.0)
    found = recognise(crank.solid, ANY)
    assert differences(crank, found) == []
    (doubt,) = found.doubts
    assert (doubt.about, doubt.setting) == ("axis", "crankshaft.crankpin_in_file = false")
    stub = found.rotor_to_file @ [*doubt.other.centre_mm, 1.0]
    assert stub[:3] == pytest.approx(crank.pins[0][:3], abs=1e-6)
    other = recognise(crank.solid, Overrides(crankpin_in_file=False))
    assert_bare(other, crank.pins, crank.journals)
    assert [(each.about, each.setting) for each in other.doubts] == [
        ("axis", "crankshaft.crankpin_in_file = true")
    ]


def test_an_arm_with_a_counterweight_behind_its_bore_is_none() -> None:
    crank = bored_arm(beyond_pin=9.0)
    weight = Solid.box(np.array([-40.0, -10.0, 0.0]), np.array([-5.0, 10.0, 7.0]))
    turn = np.eye(4)
    angle = np.radians(40.0)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    found = recognise(crank.solid + weight.moved(turn), ANY)
    assert_bare(found, crank.journals, crank.pins)
    assert found.doubts == ()


def test_of_two_bores_alike_the_counterweight_tells_the_shafts() -> None:
    crank = lone_web(pin=9.5)
    found = recognise(crank.solid, ANY)
    assert differences(crank, found) == []
    assert found.doubts == ()


def test_the_axis_of_one_web_can_be_set() -> None:
    """Where signs do not agree the other bore is named, and the line that takes it does."""
    crank = lone_web(pin=11.0, shaft=8.0)  # wider than the shaft's, against the counterweight
    found = recognise(crank.solid, ANY)
    (doubt,) = found.doubts
    x, y, z = crank.pins[0][:3]
    assert found.rotor_to_file @ [*doubt.other.centre_mm, 1.0] == pytest.approx([x, y, z, 1.0], abs=1e-6)
    assert doubt.setting == f"crankshaft.axis_point_mm = [{x:.5f}, {y:.5f}, {z:g}]"
    other = recognise(crank.solid, Overrides(axis_point_mm=np.array([x, y, z]), crankpin_in_file=None))
    assert_bare(other, crank.pins, crank.journals)
    assert other.doubts == ()


@pytest.mark.parametrize("name", FRAMES)
def test_a_stated_crankpin_leaves_the_bore_to_the_shaft_in_every_frame(name: str) -> None:
    """With metal far beyond the crankpin, too; given whole, or its place alone."""
    crank, place = bored_arm(beyond_pin=25.0), frame(name)
    scale = float(np.cbrt(abs(np.linalg.det(place[:3, :3]))))
    x, y, z, diameter, width = crank.pins[0]
    centre = place[:3, :3] @ [x, y, z] + place[:3, 3]
    for hint in (PinHint(centre, scale * diameter, scale * width), PinHint(centre)):
        found = recognise(placed(crank.solid, place), Overrides(crankpins=(hint,)))
        assert differences(crank, found, place) == []


@pytest.mark.parametrize(
    "kind", ["shaft straight through", "shaft through one web", "eccentrics around a shaft"]
)
def test_stated_crankpins_beside_a_shaft_leave_no_journal_in_a_throw(kind: str) -> None:
    crank = KINDS[kind](48)
    hints = tuple(PinHint(np.array(pin[:3]), pin[3], pin[4]) for pin in crank.pins)
    assert differences(crank, recognise(crank.solid, Overrides(crankpins=hints))) == []
    journals = tuple(PinHint(np.array(one[:3]), one[3], one[4]) for one in crank.journals)
    assert (
        differences(crank, recognise(crank.solid, Overrides(crankpins=hints, main_journals=journals))) == []
    )


def test_what_no_crank_has_is_refused_where_a_job_states_it() -> None:
    """A journal in a web, a crankpin of no width to speak of, two crankpins on one stretch."""
    solid, true = make_crank([0, 180])
    back = true.rotor_to_file

    def hint(pin: Pin, along_mm: float = 0.0, width_mm: float | None = None) -> PinHint:
        centre = (back @ [*pin.centre_mm[:2], pin.centre_mm[2] + along_mm, 1.0])[:3]
        return PinHint(centre, pin.diameter_mm, pin.width_mm if width_mm is None else width_mm)

    first, *more = true.main_journals
    pins = [throw.crankpin for throw in true.throws]
    stated = tuple(hint(pin) for pin in pins)
    within = Overrides(crankpins=stated, main_journals=(hint(first, 20.0), *(hint(each) for each in more)))
    with pytest.raises(
        RecognitionError, match=r"main journal 1, ⌀40 × 30 mm at .* would be within a web over"
    ):
        recognise(solid, within)
    thin = Overrides(crankpins=(hint(pins[0], width_mm=0.3), stated[1]))
    with pytest.raises(
        RecognitionError, match=r"crankpin 1 would be ⌀36 × 0.3 mm at .* less than 0.5 mm wide"
    ):
        recognise(solid, thin)
    double = Overrides(crankpins=(*stated, hint(pins[1], along_mm=2.0)))
    with pytest.raises(RecognitionError, match=r"crankpin 2, .* and crankpin 3, .* would be on one stretch"):
        recognise(solid, double)


def test_a_crankpin_that_is_narrow_for_its_diameter_is_refused() -> None:
    solid, _ = make_crank([0], Shape(pin_width=6.0))
    found = recognise(solid, ANY)
    assert found.throws[0].crankpin.width_mm == pytest.approx(6.0, abs=1e-6)
    with pytest.raises(RecognitionError, match=r"⌀0\.56\d* × 0\.09375 mm at .* less than 0.5 mm wide"):
        recognise(placed(solid, frame("no unit")), ANY)


def test_a_refusal_counts_what_is_there_and_says_what_helps() -> None:
    """Two dowels beside a pilot: beside the axis, but no crankpins."""
    parts = [disc(10.0, 0.0, 60.0), disc(40.0, 60.0, 70.0), disc(6.0, 70.0, 90.0)]
    parts += [disc(5.0, 70.0, 78.0, (side, 0.0)) for side in (-25.0, 25.0)]
    with pytest.raises(RecognitionError) as refusal:
        recognise(union(parts), Overrides())
    text = str(refusal.value)
    assert "axis: 3 cylinders on the axis, 2 beside it: ⌀10 × 8 mm at [-25, 0, 74] mm" in text
    assert "⌀10 × 8 mm at [25, 0, 74] mm" in text
    with pytest.raises(RecognitionError) as refusal:
        recognise(lone_web().solid, Overrides())
    assert "the bores of one web: ⌀20 × 14 mm at [0, 0, 1] mm and ⌀12 × 14 mm" in str(refusal.value)
    assert str(refusal.value).endswith(". Set crankpin_in_file = false")
    assert recognise(lone_web().solid, Overrides(crankpin_in_file=False)).throws


def test_a_plate_without_a_bore_is_told_as_one() -> None:
    with pytest.raises(RecognitionError, match="has no bare cylinder and no round bore"):
        recognise(Solid.box(np.zeros(3), np.array([40.0, 50.0, 8.0])), Overrides())


@pytest.mark.parametrize("equal", [True, False])
def test_a_bracket_with_two_holes_is_no_web(equal: bool) -> None:
    """No hub, boss or rim is about either hole."""
    body = Solid.box(np.zeros(3), np.array([60.0, 70.0, 8.0])) + Solid.box(
        np.zeros(3), np.array([60.0, 8.0, 50.0])
    )
    body = body - disc(6.0, -1.0, 9.0, (20.0, 25.0)) - disc(6.0 if equal else 9.0, -1.0, 9.0, (38.0, 52.0))
    with pytest.raises(RecognitionError, match=r"has no bare cylinder but 2 bores: ⌀"):
        recognise(body, ANY)


def _drilled(name: str) -> Any:
    """Balance one of the kinds with drilled holes in the default zone."""
    mesh = KINDS[name](96).mesh
    crank = ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850.0)
    job = {
        "crankshaft": {"file": "crank.stl", "unit": "mm", "density_kg_m3": 7850.0},
        "engine": {"rotating_g": {"rod": 5.0}, "reciprocating_g": {"piston": 10.0}},
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 3000.0},
        "correction": {"method": "drill"},
    }
    return ab.balance(ab.Job.from_dict(job), crank=crank)


def test_eccentrics_without_webs_have_no_place_for_cuts_and_that_is_said() -> None:
    """There is no first web, which ended in a traceback."""
    with pytest.raises(AutobalanceError, match="no web has a counterweight"):
        _drilled("eccentrics around a shaft")


def test_webs_without_a_counterweight_are_judged_and_a_wider_zone_is_named() -> None:
    """Above tolerance is a result, with its numbers: the job was refused as if it were impossible."""
    report = _drilled("shaft straight through").report
    assert report["outcome"] == "above_tolerance"
    assert report["corrections"] == []
    assert report["residual"] == report["initial"]
    assert report["residual"]["magnitude_g_mm"] > report["tolerance"]["permissible_g_mm"]
    assert any('no web has a counterweight; zone = "anywhere"' in note for note in report["notes"])
