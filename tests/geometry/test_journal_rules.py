"""Which of several cylinders is the main journal: places, diameters and widths of all, and the doubts."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.command.main import main
from autobalance.crank.anatomy import Anatomy, Overrides, Pin, PinHint
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import encode
from autobalance.types import Array
from tests.coarse import coarse_facets
from tests.generated import random_placement
from tests.stepped import Step, pin, stepped

PIN, BACK = pin(30, 20, 0.0), pin(30, 20, 180.0)
FLAT = [pin(48, 22, angle) for angle in (0.0, 180.0, 180.0, 0.0)]
SEAT, STUB, MAIN, DRIVE = Step(28, 15), Step(24, 42), Step(30, 20), Step(40, 24)
CLOSE_MM = 2e-3


@dataclass(frozen=True)
class Case:
    """Steps of a crank along its axis, the places among them of the mains, and what else may be meant."""

    steps: Sequence[Step]
    mains: Sequence[int]
    others: Sequence[int | None] = ()
    crank_radius: float = 27.0


SHOULDER, SHORT = Step(54, 12), Step(35, 19)
CASES = {
    "a seat before a longer stub": Case([STUB, SEAT, PIN, SEAT, STUB], [1, 3]),
    "a seat before a stub with a keyway": Case(
        [replace(STUB, key=(6.0, 3.0)), SEAT, PIN, SEAT, STUB], [1, 3]
    ),
    "a thrust collar of 0.14": Case([SHORT, Step(54, 7.5), PIN, Step(54, 7.5), SHORT], [0, 4]),
    "a shoulder of 0.22": Case([SHORT, SHOULDER, PIN, SHOULDER, SHORT], [0, 4], [1, 3]),
    "a short journal of 0.27": Case([SHORT, Step(54, 14.6), PIN, Step(54, 14.6), SHORT], [1, 3], [0, 4]),
    "a shoulder at one end only": Case([MAIN, PIN, SHOULDER, Step(30, 19)], [0, 3]),
    "a short journal like the others": Case([STUB, Step(30, 8), PIN, MAIN, BACK, MAIN], [1, 3, 5]),
    "a shoulder beside a keyed shaft": Case(
        [replace(SHORT, key=(8.0, 4.0)), SHOULDER, PIN, SHOULDER, replace(SHORT, key=(8.0, 4.0))], [1, 3]
    ),
    "a drive seat between throws": Case([MAIN, PIN, MAIN, DRIVE, BACK, MAIN], [0, 2, 5]),
    "a drive seat before the journal": Case([MAIN, PIN, DRIVE, MAIN, BACK, MAIN], [0, 3, 5]),
    "a keyed drive seat, no main alike": Case(
        [MAIN, PIN, Step(34, 20), replace(DRIVE, key=(10.0, 5.0)), BACK, MAIN], [0, 2, 5]
    ),
    "two seats between throws, both ends settled by the web": Case(
        [STUB, MAIN, PIN, MAIN, DRIVE, BACK, MAIN, STUB], [1, 3, 6]
    ),
    "two seats between throws, no main alike": Case(
        [MAIN, PIN, Step(34, 20), DRIVE, BACK, MAIN], [0, 3, 5], [None, 2, None]
    ),
    "thrust rings between throws": Case(
        [MAIN, PIN, Step(44, 4), Step(36, 20), Step(44, 4), BACK, MAIN], [0, 3, 6]
    ),
    "a fifth main before a flange's end": Case(
        [
            Step(38, 50), Step(54, 25), FLAT[0], Step(54, 22), FLAT[1], Step(54, 22), FLAT[2], Step(54, 22),
            FLAT[3], Step(72, 32), Step(32, 74),
        ],
        [1, 3, 5, 7, 9],
        crank_radius=43.0,
    ),
}  # fmt: skip


Row = tuple[float, float, float]
"""Middle along z, diameter and width of a cylinder."""


def row_of(each: Pin) -> Row:
    return float(each.centre_mm[2]), each.diameter_mm, each.width_mm


def recognised(case: Case, placement: Array | None = None) -> tuple[Anatomy, list[Row]]:
    """Return a crank as recognised, and the true cylinders in its rotor frame, in the order of the case."""
    solid, placed = stepped(case.steps, case.crank_radius, placement=placement)
    found = recognise(solid, Overrides(crankpin_in_file=None))
    along = np.array([0.0, 0.0, 1.0]) if placement is None else placement[:3, 2]
    sense = float(np.sign(found.file_to_rotor[2, :3] @ along))
    pins = [each.z for each in placed if each.step.pin_deg is not None]
    zero = pins[0] if sense > 0.0 else pins[-1]
    return found, [(sense * (each.z - zero), each.step.diameter, each.step.width) for each in placed]


def assert_cylinders(found: Anatomy, case: Case, rows: Sequence[Row]) -> None:
    """Compare place, diameter and width of every cylinder, its role, and journals' and crankpins' numbers."""
    mains = sorted(rows[place] for place in case.mains)
    assert np.array([row_of(each) for each in found.main_journals]) == near(mains)
    outside = [each for each in found.cylinders if each.kind == "outside"]
    assert np.array([row_of(each) for each in outside]) == near(sorted(rows))
    numbered = [each for each in outside if each.role == "main_journal"]
    assert np.array([row_of(each) for each in numbered]) == near(mains)
    assert [each.number for each in numbered] == list(range(1, len(mains) + 1))
    pins = [each for each in outside if each.role == "crankpin"]
    assert [each.number for each in pins] == list(range(1, len(found.throws) + 1))
    assert [each.offset_mm for each in pins] == pytest.approx([case.crank_radius] * len(pins), abs=CLOSE_MM)
    rest = [each for each in outside if each.number is None]
    assert {each.role for each in rest} <= {"collar", "shaft"}
    assert max((each.offset_mm for each in rest), default=0.0) < CLOSE_MM


def near(rows: Sequence[Row]) -> Any:
    return pytest.approx(np.array(rows), abs=CLOSE_MM)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_the_journal_of_every_stretch(name: str, turned: bool) -> None:
    case = CASES[name]
    placement = random_placement(np.random.default_rng(len(name))) if turned else None
    found, rows = recognised(case, placement)
    assert_cylinders(found, case, rows)
    wanted = sorted(
        (rows[main], rows[other])
        for main, other in zip(case.mains, case.others or [None] * len(case.mains), strict=True)
        if other is not None
    )
    doubts = [(row_of(doubt.chosen), row_of(doubt.other)) for doubt in found.doubts]
    assert np.array(doubts) == pytest.approx(np.array(wanted), abs=CLOSE_MM)
    for doubt in found.doubts:
        assert row_of(doubt.chosen) == row_of(found.main_journals[doubt.number - 1])


def test_a_setting_takes_the_other_cylinder_wherever_the_crank_lies() -> None:
    case = CASES["a shoulder of 0.22"]
    placement = random_placement(np.random.default_rng(5))
    solid, _ = stepped(case.steps, placement=placement)
    found, rows = recognised(case, placement)
    (line,) = {doubt.setting for doubt in found.doubts}
    key, value = line.split(" = ", 1)
    assert key == "crankshaft.main_journals"
    hints = tuple(
        PinHint(np.array(each["centre_mm"]), each["diameter_mm"], each["width_mm"])
        for each in tomllib.loads(f"it = {value}")["it"]
    )
    again = recognise(solid, Overrides(main_journals=hints))
    assert np.array([row_of(each) for each in again.main_journals]) == near(
        sorted(rows[place] for place in (1, 3))
    )
    assert again.doubts == ()
    assert again.file_to_rotor == pytest.approx(found.file_to_rotor, abs=1e-4)


@pytest.mark.parametrize("length_mm", [48.0, 50.0, 90.0])
def test_a_nose_is_no_main_journal_however_long_it_is(length_mm: float) -> None:
    v8 = PRESETS["v8-crossplane"]
    assert v8.nose is not None
    nose = replace(v8.nose, diameter_mm=32.0, end_diameter_mm=None, length_mm=length_mm, keyway=None)
    found = recognise(crank_solid(replace(v8, nose=nose), 64), Overrides())
    first = found.main_journals[0]
    assert row_of(first) == pytest.approx((-58.25, 62.0, 24.5), abs=CLOSE_MM)
    assert [each.centre_mm[2] for each in found.main_journals] == pytest.approx(
        [-58.25, 57.0, 171.0, 285.0, 400.25], abs=CLOSE_MM
    )
    shaft = found.cylinders[0]
    assert row_of(shaft) == pytest.approx((-70.5 - 0.5 * length_mm, 32.0, length_mm), abs=CLOSE_MM)
    assert (shaft.role, shaft.number) == ("shaft", None)
    assert found.doubts == ()


@pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")
def test_the_snout_of_a_step_file_is_no_main_journal(tmp_path: Path) -> None:
    """A cross-plane V8: its mains and its snout are told with the file's own numbers."""
    sizes = {"nose.length_mm": 60, "nose.diameter_mm": 38, "nose.end_diameter_mm": None}
    crank = ab.generate("v8-crossplane", file="crank.step", settings={k: v for k, v in sizes.items() if v})
    (tmp_path / "crank.step").write_bytes(crank.data)
    with coarse_facets():
        report = ab.inspect(tmp_path / "crank.step").report["crank"]
    mains = [
        (each["centre_mm"][2], each["diameter_mm"], each["width_mm"]) for each in report["main_journals"]
    ]
    middle = [(57.0 + 114.0 * number, 62.0, 22.0) for number in range(3)]
    wanted = [(-58.25, 62.0, 24.5), *middle, (400.25, 62.0, 24.5)]
    assert np.array(mains) == pytest.approx(np.array(wanted), abs=1e-6)
    assert report["doubts"] == []


# --- what is told of every cylinder -------------------------------------------------------------------------


def test_bores_are_told_with_the_cylinders() -> None:
    """The bores through crankpins and webs of a V8, and the bolt holes of its flange."""
    v8 = PRESETS["v8-crossplane"]
    found = recognise(crank_solid(v8, 64), Overrides())
    bores = [each for each in found.cylinders if each.kind == "bore"]
    through = [each for each in bores if each.diameter_mm > 15.0]
    wanted = [(114.0 * number, 20.0, 87.0) for number in range(4)]
    assert np.array([row_of(each) for each in through]) == pytest.approx(np.array(wanted), abs=0.01)
    assert [each.offset_mm for each in through] == pytest.approx([44.2] * 4, abs=CLOSE_MM)
    angles = [math.remainder(each.angle_deg, 360.0) for each in through]
    assert angles == pytest.approx([0.0, 90.0, -90.0, 180.0], abs=0.01) or angles[3] == pytest.approx(-180.0)
    bolts = [each for each in bores if each.diameter_mm < 15.0]
    assert np.array([row_of(each) for each in bolts]) == pytest.approx(
        np.array([(419.5, 10.5, 14.0)] * 8), abs=CLOSE_MM
    )
    assert {each.role for each in bores} == {"none"}


def test_the_bores_of_a_pressed_up_crank_are_its_crankpins() -> None:
    pressed = PRESETS["pressed-up-single-no-pin"]
    found = recognise(crank_solid(pressed, 64), Overrides(crankpin_in_file=False))
    bores = [each for each in found.cylinders if each.kind == "bore"]
    assert [(each.role, each.number) for each in bores] == [("crankpin", 1)] * 2
    assert np.array([row_of(each) for each in bores]) == pytest.approx(
        np.array([(-15.5, 28.0, 15.0), (15.5, 28.0, 15.0)]), abs=CLOSE_MM
    )
    assert [each.offset_mm for each in bores] == pytest.approx([26.9] * 2, abs=CLOSE_MM)


def test_a_thin_disc_and_a_narrow_ring_are_told() -> None:
    """A flywheel's disc of 150 mm by 2.5 mm is listed as the rest, a chamfer's ring of 1 mm is not."""
    steps = [Step(150, 2.5), MAIN, PIN, MAIN, Step(34, 1.0), STUB]
    found, rows = recognised(Case(steps, [1, 3]))
    outside = [row_of(each) for each in found.cylinders if each.kind == "outside"]
    assert np.array(outside) == near([row for row in rows if row[2] > 1.0])
    assert found.cylinders[0].role == "collar"


def test_a_cylinder_beside_the_axis_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An eccentric for a pump is neither journal nor crankpin; the table has what else is on the axis."""
    solid, _ = stepped([STUB, SEAT, PIN, SEAT, STUB], segments=64)
    eccentric = Solid.prism(Region.circle(24.0, 64, (3.0, 0.0)), 15.0, 27.0)
    path = tmp_path / "crank.stl"
    path.write_bytes(encode((solid + eccentric).mesh, "stl", 1.0))
    report = ab.inspect(path, unit="mm").report
    (warning,) = [each for each in report["warnings"] if "is not a crankpin" in each]
    assert "⌀48 × 12 mm at z -61 mm, is 3 mm beside the axis at 0.0°" in warning
    assert main(["inspect", str(path), "--unit", "mm"]) == 0
    shown = capsys.readouterr().out
    table = shown[shown.index("Also on the axis") :].split("\n\n")[0].splitlines()
    assert [line.split() for line in table[1:]] == [
        ["shaft", "-74.500", "mm", "24.000", "mm", "15.000", "mm"],
        ["shaft", "-47.500", "mm", "24.000", "mm", "15.000", "mm"],
        ["shaft", "61.000", "mm", "24.000", "mm", "42.000", "mm"],
    ]


@pytest.mark.parametrize("weights", [True, False])
@pytest.mark.parametrize("name", PRESETS)
def test_the_cylinders_of_a_generated_crank_are_those_recognised(name: str, weights: bool) -> None:
    """Straight noses, so that they are listed; with and without counterweights: a disc is round then."""
    design = PRESETS[name] if weights else replace(PRESETS[name], counterweight=None)
    if design.nose is not None:
        design = replace(design, nose=replace(design.nose, end_diameter_mm=None, keyway=None))
    true = crank_anatomy(design).cylinders
    found = recognise(crank_solid(design, 32), Overrides(crankpin_in_file=None)).cylinders
    rows, wanted = ([(*row_of(each), each.offset_mm) for each in some] for some in (found, true))
    assert np.array(sorted(rows)) == pytest.approx(np.array(sorted(wanted)), abs=0.01)
    told, roles = (
        sorted((round(float(each.centre_mm[2])), each.kind, each.role, each.number or 0) for each in some)
        for some in (found, true)
    )
    assert told == roles


def test_a_crank_with_hollow_journals_on_both_sides_of_its_pin_is_no_arm() -> None:
    """Bores at both ends, as a public crank has them, are no bore of an arm for its shaft."""
    solid, placed = stepped([Step(36, 40), PIN, Step(36, 40)])
    low, high = float(solid.bounds[0, 2]), float(solid.bounds[1, 2])
    for radius, depth in ((13.0, 12.0), (10.0, 30.0)):
        disc = Region.circle(radius, 96)
        solid = (
            solid - Solid.prism(disc, low - 1.0, low + depth) - Solid.prism(disc, high - depth, high + 1.0)
        )
    found = recognise(solid, Overrides(crankpin_in_file=None))
    wanted = [(placed[place].z, 36.0, 40.0) for place in (0, 2)]
    assert np.array([row_of(each) for each in found.main_journals]) == near(wanted)
    assert found.doubts == ()
    bores = [each for each in found.cylinders if each.kind == "bore"]
    assert sorted((each.diameter_mm, each.width_mm) for each in bores) == [
        pytest.approx(each, abs=CLOSE_MM) for each in ((20.0, 18.0), (20.0, 18.0), (26.0, 12.0), (26.0, 12.0))
    ]
