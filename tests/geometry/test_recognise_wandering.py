"""Main journals that wander, as on a bent or badly drawn crank: all are found, or what is odd is said."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.alignment import misalignment_warning, run_outs_mm
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.given import refuse_incomplete
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import RecognitionError
from autobalance.report.records.crank import Journal
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union

SEGMENTS = 32
PHASES_DEG = (0.0, 120.0, 240.0, 240.0, 120.0, 0.0)
MAIN_MM, PIN_MM, THROW_MM = 25.0, 22.0, 38.0


def bent_six(share: float, seed: int) -> Solid:
    """An inline-six whose main journals stand aside by a share of their radius, each its own way."""
    random = np.random.default_rng(seed)
    parts, z = [], 0.0
    for number in range(7):
        way = random.uniform(0.0, 2.0 * math.pi)
        aside = share * MAIN_MM * np.array([math.cos(way), math.sin(way)])
        parts.append(Solid.prism(Region.circle(MAIN_MM, SEGMENTS, tuple(aside)), z, z + 26.0))
        z += 25.0
        if number < len(PHASES_DEG):
            angle = math.radians(PHASES_DEG[number])
            pin = THROW_MM * math.cos(angle), THROW_MM * math.sin(angle)
            web = Region.circle(33.0, SEGMENTS) + Region.circle(30.0, SEGMENTS, pin)
            parts.append(Solid.prism(web, z, z + 14.0))
            parts.append(Solid.prism(Region.circle(PIN_MM, SEGMENTS, pin), z + 13.0, z + 40.0))
            parts.append(Solid.prism(web, z + 39.0, z + 53.0))
            z += 52.0
    return union(parts)


def assert_all_there(found: Anatomy) -> None:
    """Seven journals and six throws, each in its place and of its size; twelve webs of 13 mm."""
    assert [j.diameter_mm for j in found.main_journals] == pytest.approx([2.0 * MAIN_MM] * 7, rel=1e-3)
    assert [t.crankpin.diameter_mm for t in found.throws] == pytest.approx([2.0 * PIN_MM] * 6, rel=1e-3)
    pitch = np.diff([j.centre_mm[2] for j in found.main_journals])
    assert pitch[1:-1] == pytest.approx([77.0] * 4, abs=0.5)
    assert np.diff([t.crankpin.centre_mm[2] for t in found.throws]) == pytest.approx([77.0] * 5, abs=0.5)
    assert [web.z_max_mm - web.z_min_mm for web in found.webs] == pytest.approx([14.0] * 12, abs=0.2)


@pytest.mark.parametrize("share", [0.02, 0.04])
def test_every_journal_and_throw_is_found_and_the_misalignment_said(share: float) -> None:
    found = recognise(bent_six(share, 1), Overrides(crankpin_in_file=None))
    assert_all_there(found)
    assert [t.crank_radius_mm for t in found.throws] == pytest.approx(
        [THROW_MM] * 6, abs=2.0 * share * MAIN_MM
    )
    assert 0.5 * share * MAIN_MM < found.journal_misalignment_mm < 2.0 * share * MAIN_MM
    assert misalignment_warning(found) is not None
    run_outs = run_outs_mm(found)
    assert max(run_outs) == pytest.approx(2.0 * found.journal_misalignment_mm)
    assert [Journal.of(each, found).journal_run_out_mm for each in found.main_journals] == list(run_outs)


@pytest.mark.parametrize("seed", range(1, 5))
@pytest.mark.parametrize("share", [0.08, 0.15])
def test_what_wanders_too_far_is_refused_or_found_whole(share: float, seed: int) -> None:
    """Never some of the throws as if they were all: the rest would be webs 100 mm thick."""
    try:
        found = recognise(bent_six(share, seed), Overrides(crankpin_in_file=None))
    except RecognitionError:
        return
    assert_all_there(found)


def test_a_throw_without_its_web_is_refused() -> None:
    journal, pin = (
        CylinderRun(np.zeros(2), 10.0, 0.0, 20.0),
        CylinderRun(np.array([30.0, 0.0]), 9.0, 40.0, 60.0),
    )
    with pytest.raises(RecognitionError, match="throw 1 has no web on one side"):
        refuse_incomplete(JournalLayout(np.zeros(2), (journal,), (pin,)), [], 50.0)


def test_lines_that_may_be_the_axis_are_listed_with_the_option_that_settles_it() -> None:
    """An overhung shaft of two equal ends: either could be the crank axis, until one is named."""
    web = Solid.prism(Region.circle(30.0, SEGMENTS) + Region.circle(30.0, SEGMENTS, (40.0, 0.0)), 0.0, 12.0)
    ends = [
        Solid.prism(Region.circle(12.0, SEGMENTS), -40.0, 1.0),
        Solid.prism(Region.circle(12.0, SEGMENTS, (40.0, 0.0)), 11.0, 52.0),
    ]
    solid = union([web, *ends])
    with pytest.raises(RecognitionError, match="--axis-point") as refused:
        recognise(solid, Overrides(crankpin_in_file=True))
    points = re.findall(r"through \(([^)]*)\)", str(refused.value))
    assert len(points) == 2
    for text in points:
        point = np.array([float(value) for value in text.split(",")])
        found = recognise(solid, Overrides(axis_point_mm=point, crankpin_in_file=True))
        assert found.throws[0].crank_radius_mm == pytest.approx(40.0, abs=1e-6)
        assert found.rotor_to_file[:2, 3] == pytest.approx(point[:2], abs=1e-6)
