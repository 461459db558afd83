"""Ends of journals and crankpins of odd kinds in scans: where a bore or another cylinder crosses them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.recognition.scan_cylinders import _ends
from autobalance.crank.recognition.section_stack import lengthwise
from tests.generated import solid_of
from tests.odd_kinds import KINDS, Bare, OddCrank, bored_arm, eccentrics, in_file, lone_web
from tests.split_scans import split_mesh

SIGMA_MM = 0.01


@cache
def made(kind: str, segments: int) -> OddCrank:
    """Return a kind of crank, whose facets are split once."""
    return KINDS[kind](segments)


def scanned(odd: OddCrank, sigma_mm: float, pin_in_file: bool | None = None, edge_mm: float = 1.2) -> Anatomy:
    mesh = split_mesh(odd.mesh, sigma_mm, edge_mm=edge_mm, seed=0)
    return recognise(solid_of(mesh), Overrides(crankpin_in_file=pin_in_file))


def places_and_sizes(pins: Sequence[Bare]) -> list[float]:
    return [value for pin in pins for value in pin]


@pytest.mark.parametrize(
    ("kind", "edge_mm", "sigma_mm"),
    [
        ("eccentrics beside a shaft", 1.8, SIGMA_MM),
        ("hollow journals and crankpins", 1.5, SIGMA_MM),
        ("hollow journals and crankpins", 1.5, 0.05),
    ],
)
def test_ends_are_where_the_faces_are(kind: str, edge_mm: float, sigma_mm: float) -> None:
    """A shaft goes on past an eccentric's face, and a few points of a bore are as far from a journal's axis
    as its surface is: ends were up to 1.5 mm off, several standard errors. The bottom of a journal's bore was
    taken for its web's face, and the journal was 2 mm too wide."""
    odd = made(kind, 72)
    found = recognise(solid_of(split_mesh(odd.mesh, sigma_mm, edge_mm=edge_mm, seed=1)), Overrides())
    assert found.scan is not None
    upward = found.rotor_to_file[2, 2] > 0.0
    told = [list(each)[:: 1 if upward else -1] for each in (found.scan.journals, found.scan.crankpins)]
    for here, there, fits in zip(in_file(found), (odd.journals, odd.pins), told, strict=True):
        for own, true, fit in zip(here, there, fits, strict=True):
            ends, meant = (np.array([z - 0.5 * w, z + 0.5 * w]) for *_, z, _, w in (own, true))
            assert ends == pytest.approx(meant, abs=2.0 * sigma_mm)
            assert own[4] == pytest.approx(true[4], abs=3.0 * fit.width_pm_mm)


def test_an_end_that_no_face_tells_is_as_uncertain_as_its_points_are_apart() -> None:
    """Whole sections to 20 mm, the surface left after the row at 17 mm: by 23 mm most stands off."""
    z = np.repeat(np.arange(-1.0, 27.0, 3.0), 60)
    off = np.where(z > 17.5, 0.5, 0.0)
    areas = np.full(len(z), 3.0 * 2.0 * np.pi * 10.0 / 60.0)
    _, high = _ends(z, off, areas, CylinderRun(np.zeros(2), 10.0, 0.0, 20.0), 0.03, 3.0)
    assert high.first_mm == pytest.approx(17.0)
    assert high.last_mm == pytest.approx(20.0, abs=0.5)
    middle, pm = high.between
    assert abs(middle - 18.5) < 0.3
    assert 0.8 < pm < 1.0


@pytest.mark.parametrize(("sigma_mm", "boss_mm"), [(0.02, 0.0), (0.05, 2.0)])
def test_a_scanned_arm_turns_about_its_bore(sigma_mm: float, boss_mm: float) -> None:
    """Its stub was the main journal, and the bore, or the boss around it, the crankpin."""
    odd = bored_arm(96, boss=boss_mm)
    found = scanned(odd, sigma_mm, edge_mm=1.4)
    assert found.scan is not None
    (journal,), (pin,) = in_file(found)
    (fit,), (own,) = found.scan.journals, found.scan.crankpins
    assert journal[:2] == pytest.approx(odd.journals[0][:2], abs=0.02 + sigma_mm)
    assert pin[:2] == pytest.approx(odd.pins[0][:2], abs=0.02 + sigma_mm)
    assert journal[3:] == pytest.approx(
        odd.journals[0][3:], abs=3.0 * max(fit.diameter_pm_mm, fit.width_pm_mm)
    )
    assert pin[3:] == pytest.approx(odd.pins[0][3:], abs=3.0 * max(own.diameter_pm_mm, own.width_pm_mm))
    for doubt in found.doubts:
        assert doubt.about == "axis"
        assert doubt.other.diameter_mm == pytest.approx(pin[3])


def test_the_line_of_a_scanned_arms_doubt_takes_the_stub_for_the_shaft() -> None:
    odd = bored_arm(96, beyond_pin=25.0)
    (doubt,) = scanned(odd, 0.02).doubts
    assert doubt.setting == "crankshaft.crankpin_in_file = false"
    other = scanned(odd, 0.02, pin_in_file=False)
    (stub,), (bore,) = in_file(other)
    assert (stub[3], stub[4], bore[3], bore[4]) == pytest.approx((7.0, 10.0, 4.8, 7.0), abs=0.15)
    (back,) = other.doubts
    assert back.setting == "crankshaft.crankpin_in_file = true"


@pytest.mark.parametrize("sigma_mm", [0.005, 0.05])
def test_a_scanned_webs_bores_end_at_its_faces(sigma_mm: float) -> None:
    """They were up to 1.2 mm short, told to 0.01 mm: rough rows at the rim stood off the bore."""
    odd = made("one web drawn alone", 160)
    found = scanned(odd, sigma_mm)
    assert found.scan is not None
    for told, true, fit in zip(
        (pin for pins in in_file(found) for pin in pins),
        (odd.journals[0], odd.pins[0]),
        (*found.scan.journals, *found.scan.crankpins),
        strict=True,
    ):
        assert told[:2] == pytest.approx(true[:2], abs=0.005 + 0.3 * sigma_mm)
        assert abs(told[4] - true[4]) < 3.0 * fit.width_pm_mm
        assert fit.width_pm_mm < 0.05
        assert told[3] == pytest.approx(true[3], abs=3.0 * fit.diameter_pm_mm)
    ((low, high),) = [(web.z_min_mm, web.z_max_mm) for web in found.webs]
    assert high - low == pytest.approx(14.0, abs=0.005 + 0.5 * sigma_mm)


def test_eccentrics_whose_waves_reach_beyond_their_circles_are_found() -> None:
    """Of sections through waves of 0.05 mm hardly one was round: refused, or one eccentric was two."""
    odd = eccentrics(96, offset=11.0, radius=9.0)
    found = scanned(odd, 0.05)
    journals, pins = in_file(found)
    assert found.webs == ()
    assert places_and_sizes(journals) == pytest.approx(places_and_sizes(odd.journals), abs=0.15)
    assert places_and_sizes(pins) == pytest.approx(places_and_sizes(odd.pins), abs=0.15)


def test_sections_of_a_rough_mesh_keep_clear_of_its_waves() -> None:
    """Each rough face was a hundred levels: 1 700 sections along each direction tried, half a minute."""
    mesh = split_mesh(lone_web(96).mesh, 0.05, edge_mm=1.2, seed=0)
    assert len(lengthwise(mesh, np.array([0.0, 0.0, 1.0]), 0.15, 0.15).sections) < 100
