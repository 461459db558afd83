"""Every preset of the generator, anywhere, of any size and fineness, is recognised as it was drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import PRESETS, DesignBay
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.input import with_settings
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import RecognitionError
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from tests.generated import AT_OTHER_ANGLES, SEGMENTS, differences, drawn, generated_crank, solid_of
from tests.sweeps import SWEPT

AXIS_DEG = 0.02
"""What the axis' direction may be off."""
SHARE_OF_RADIUS = 1e-3
"""What the axis' position, and everything else, may be off, as a share of the crank radius."""
INCH_MM = 25.4
COARSE = (5, 6, 7, 8, 9, 10, 11)


def spread(segments: Sequence[int], turns: Sequence[int] = (0,)) -> list[tuple[str, int]]:
    """Return every preset with one of the finenesses a turn, so that each comes up; in a sweep with all."""
    if SWEPT:
        return [*product(PRESETS, segments)]
    return [(name, segments[(k + turn) % len(segments)]) for k, name in enumerate(PRESETS) for turn in turns]


VERY_FINE = [("pressed-up-single-no-pin", 360)]
EACH_FINENESS = spread(SEGMENTS) if SWEPT else [*spread(SEGMENTS[:6]), *VERY_FINE]
EACH_COARSENESS = [
    (name, segments) for name, segments in spread(COARSE) if SWEPT or name not in AT_OTHER_ANGLES
]
FEW_OR_MANY = spread((12, 29))


def placement(seed: int) -> Array:
    """A rigid motion drawn at random, up to 300 mm away."""
    random = np.random.default_rng(seed)
    turn, upper = np.linalg.qr(random.normal(size=(3, 3)))
    turn = turn * np.sign(np.diag(upper))
    if np.linalg.det(turn) < 0.0:
        turn[:, 0] *= -1.0
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turn, random.uniform(-300.0, 300.0, 3)
    return place


def assert_recognised(found: Anatomy, true: Anatomy, scale: float = 1.0) -> None:
    radius = scale * true.throws[0].crank_radius_mm
    slack = SHARE_OF_RADIUS * radius
    z = np.cross(found.file_to_rotor[2, :3], true.file_to_rotor[2, :3])
    assert math.degrees(float(np.linalg.norm(z))) < AXIS_DEG
    assert found.file_to_rotor[2, :3] @ true.file_to_rotor[2, :3] > 0.0
    origin = true.file_to_rotor @ np.append(found.rotor_to_file[:3, 3] / scale, 1.0)
    assert np.linalg.norm(origin[:2]) * scale < slack
    assert found.journal_misalignment_mm < slack
    pins = [t.crankpin for t in found.throws], [t.crankpin for t in true.throws]
    for mine, theirs in (pins, (found.main_journals, true.main_journals)):
        assert len(mine) == len(theirs)
        for a, b in zip(mine, theirs, strict=True):
            assert np.abs(a.centre_mm - scale * b.centre_mm).max() < slack
            assert abs(a.diameter_mm - scale * b.diameter_mm) < slack
            assert abs(a.width_mm - scale * b.width_mm) < slack
    for t, u in zip(found.throws, true.throws, strict=True):
        assert abs(t.crank_radius_mm - scale * u.crank_radius_mm) < slack
        assert abs(math.remainder(t.angle_rad - u.angle_rad, 2.0 * math.pi)) < SHARE_OF_RADIUS
    assert len(found.webs) == len(true.webs)
    for w, v in zip(found.webs, true.webs, strict=True):
        assert abs(w.z_min_mm - scale * v.z_min_mm) < slack
        assert abs(w.z_max_mm - scale * v.z_max_mm) < slack
        assert w.counterweight == v.counterweight


def check(name: str, segments: int, scale: float = 1.0) -> None:
    design = PRESETS[name]
    place = placement(segments)
    mesh = drawn(design, segments).mesh.moved(place)
    rounded = (scale * mesh.vertices).astype(np.float32).astype(np.float64)  # as a binary STL keeps them
    solid = solid_of(Mesh(rounded, mesh.triangles))
    found = recognise(solid, Overrides(crankpin_in_file=design.crankpin_in_file))
    assert_recognised(found, crank_anatomy(design, place), scale)


@pytest.mark.parametrize(("name", "segments"), FEW_OR_MANY)
def test_presets_are_recognised_as_drawn(name: str, segments: int) -> None:
    check(name, segments)


@pytest.mark.parametrize("scale", [1.0 / INCH_MM, INCH_MM])
@pytest.mark.parametrize("name", ["single", "v-twin-45", "inline-3"])
def test_the_unit_does_not_matter(name: str, scale: float) -> None:
    check(name, 24, scale)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "segments"), EACH_FINENESS)
def test_presets_in_files_are_recognised_as_drawn(name: str, segments: int) -> None:
    """Anywhere, in mm or inch, and without being told whether crankpins are in the file."""
    crank = generated_crank(name, seed=segments, segments=segments, unit=("mm", "inch")[segments % 3 % 2])
    assert differences(recognise(crank.solid, Overrides(crankpin_in_file=None)), crank.truth) == []


@pytest.mark.slow
@pytest.mark.parametrize(("name", "segments"), EACH_COARSENESS)
def test_coarse_presets_are_right_or_refused(name: str, segments: int) -> None:
    place = placement(segments)
    solid = solid_of(drawn(PRESETS[name], segments).mesh.moved(place))
    try:
        found = recognise(solid, Overrides(crankpin_in_file=None))
    except RecognitionError:
        return
    assert differences(found, crank_anatomy(PRESETS[name], place)) == []


@pytest.mark.parametrize("name", ["single", "v-twin-45", "inline-3"])
def test_an_overhung_cranks_journal_is_told_from_its_crankpin(name: str) -> None:
    design = replace(PRESETS[name], journals="first", oil_hole_mm=0.0, flange=None)
    place = placement(5)
    solid = solid_of(crank_solid(design, 32).mesh.moved(place))
    assert_recognised(recognise(solid, Overrides()), crank_anatomy(design, place))


@pytest.mark.parametrize("segments", [12, 40])
def test_a_half_without_its_pin_has_its_throw_at_the_bore(segments: int) -> None:
    """Of the crankpin the file has the bore that it is pressed into: as wide as that is deep, in the web."""
    design = replace(PRESETS["pressed-up-single-no-pin"], journals="first")
    half = generated_crank(design, seed=segments, segments=segments)
    found = recognise(half.solid, Overrides(crankpin_in_file=None))
    assert differences(found, half.truth) == []
    pin, (web,) = found.throws[0].crankpin, found.webs
    assert pin.width_mm == pytest.approx(design.web.thickness_mm, abs=1e-4)
    assert pin.z_range_mm == pytest.approx((-0.5 * pin.width_mm, 0.5 * pin.width_mm), abs=1e-9)
    assert web.z_min_mm < pin.z_range_mm[0] + 1e-4
    assert web.z_max_mm > pin.z_range_mm[1] - 1e-4
    assert pin.diameter_mm == pytest.approx(design.crankpin.diameter_mm, abs=1e-4)
    (bore,) = [each for each in found.cylinders if each.role == "crankpin"]
    assert (bore.kind, bore.number) == ("bore", 1)
    assert bore.width_mm == pytest.approx(pin.width_mm, abs=1e-4)


@pytest.mark.parametrize("name", ["single", "pressed-up-single", "v-twin-45", "inline-4", "v6-60"])
def test_overhung_cranks_are_recognised_as_drawn(name: str) -> None:
    """The last crankpin ends in the air, without a fillet."""
    design = replace(PRESETS[name], journals="first", flange=None)
    crank = generated_crank(design, seed=1, segments=16)
    assert differences(recognise(crank.solid, Overrides(crankpin_in_file=None)), crank.truth) == []


def test_webs_without_counterweight_are_told_apart() -> None:
    design = replace(
        PRESETS["inline-3"],
        bays=(DesignBay((0.0,), (True, False)), DesignBay((240.0,)), DesignBay((120.0,), (False, False))),
    )
    found = recognise(crank_solid(design, 24), Overrides())
    assert [web.counterweight for web in found.webs] == [True, False, True, True, False, False]


def test_the_counterweights_outline_is_measured() -> None:
    design = PRESETS["inline-4"]
    size = design.counterweight
    assert size is not None
    for web in recognise(crank_solid(design, 48), Overrides()).webs:
        assert web.outline is not None
        assert web.outline.rim_radius_mm == pytest.approx(size.radius_mm, rel=1e-6)
        assert math.degrees(web.outline.fan_angle_rad) == pytest.approx(size.fan_angle_deg, abs=1e-4)
        assert web.outline.thickness_mm == pytest.approx(design.web.thickness_mm, rel=1e-9)


@pytest.mark.slow
def test_twelve_throws_are_counted_and_placed() -> None:
    angles = [0.0, 120.0, 240.0, 240.0, 120.0, 0.0]
    design = replace(PRESETS["inline-4"], bays=tuple(DesignBay((angle,)) for angle in 2 * angles))
    place = placement(12)
    solid = solid_of(crank_solid(design, 24).mesh.moved(place))
    found = recognise(solid, Overrides())
    assert_recognised(found, crank_anatomy(design, place))


NEARLY_ROUND = [(49.0, 50.0, 60.0), (49.0, 51.0, 170.0), (48.0, 50.0, 170.0), (49.9, 50.0, 180.0)]
"""Radii of disc and rim, and fan angle, of webs that are one circle but for less than a coarse facet."""


@pytest.mark.parametrize(("disc", "rim", "fan"), NEARLY_ROUND)
@pytest.mark.parametrize("name", ["pressed-up-single", "pressed-up-single-no-pin"])
def test_nearly_round_webs_are_no_crankpins(name: str, disc: float, rim: float, fan: float) -> None:
    design = with_settings(
        PRESETS[name],
        {
            "web.disc_radius_mm": disc,
            "counterweight.radius_mm": rim,
            "counterweight.fan_angle_deg": fan,
        },
    )
    for segments in (7, 9, 11, 12, 13, 16, 24) if SWEPT else (11, 12):
        place = placement(segments)
        solid = solid_of(crank_solid(design, segments).mesh.moved(place))
        try:
            found = recognise(solid, Overrides(crankpin_in_file=None))
        except RecognitionError:
            assert segments < 12
        else:
            assert_recognised(found, crank_anatomy(design, place))


DRILLED = {
    "a slight fillet": (
        "inline-3",
        40,
        {
            "fillet_mm": 0.205,
            "main_journal.diameter_mm": 41.807,
            "crankpin.diameter_mm": 52.01,
            "counterweight.radius_mm": 83.75,
            "web.thickness_mm": 23.325,
        },
    ),
    "short main journals": (
        "inline-3",
        12,
        {
            "main_journal.bore_mm": 5.6,
            "main_journal.diameter_mm": 47.141,
            "main_journal.width_mm": 14.768,
            "stroke_mm": 78.614,
            "web.thickness_mm": 15.321,
        },
    ),
    "a drilling at the middle": (
        "single",
        16,
        {
            "crankpin.diameter_mm": 24.13,
            "stroke_mm": 56.184,
            "counterweight.radius_mm": 58.082,
            "web.thickness_mm": 17.39,
        },
    ),
}
"""Cranks whose oil drillings hide most of a journal from its sections."""


@pytest.mark.parametrize("name", DRILLED)
def test_cylinders_are_whole_beside_fillets_and_drillings(name: str) -> None:
    preset, segments, settings = DRILLED[name]
    design = with_settings(PRESETS[preset], settings)
    crank = generated_crank(replace(design, segments=segments), seed=1, segments=segments)
    assert differences(recognise(crank.solid, Overrides(crankpin_in_file=None)), crank.truth) == []
