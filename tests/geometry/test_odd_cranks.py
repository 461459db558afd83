"""Odd cranks, built with a known anatomy: recognised with every place and size, doubted, or refused."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank.anatomy import Anatomy, Overrides, Pin, PinHint
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import AutobalanceError
from autobalance.solid.formats.read import source_of
from tests.generated import random_placement
from tests.odd_cranks import KINDS, OddCrank, faults, odd_crank, outcome
from tests.sweeps import seeds

ROUNDING_MM = 2e-4
"""Coordinates of a file in single precision, some metres from its origin."""
FRAMES_MM = 5e-3
"""The same crank in another frame: cylinders are fitted to vertices that are rounded elsewhere."""


@pytest.mark.parametrize("seed", seeds(len(KINDS) + 12, 500))
def test_an_odd_crank_is_right_doubted_or_refused(seed: int) -> None:
    odd = odd_crank(seed)
    ending, what = outcome(odd)
    assert ending in ("right", "doubted", "refused"), f"{odd.kind}, {odd.what}: {what}"


@pytest.mark.parametrize("kind", KINDS)
def test_the_truth_is_the_constructions(kind: str) -> None:
    """The mesh has vertices on each true cylinder, all round at both its ends, and at each web's faces."""
    number = KINDS.index(kind)
    while odd_crank(number).step:
        number += len(KINDS)
    odd = odd_crank(number)
    solid, true = odd.source().solid, odd.truth()
    turn, shift = true.file_to_rotor[:3, :3], true.file_to_rotor[:3, 3]
    assert np.linalg.det(turn) == pytest.approx(1.0)
    vertices = solid.mesh.vertices @ turn.T + shift
    cylinders = [*true.main_journals, *(throw.crankpin for throw in true.throws)]
    for each in cylinders:
        away = np.hypot(*(vertices[:, :2] - each.centre_mm[:2]).T)
        on = np.abs(away - 0.5 * each.diameter_mm) < ROUNDING_MM
        for height in each.z_range_mm:
            ring = vertices[on & (np.abs(vertices[:, 2] - height) < ROUNDING_MM)] - each.centre_mm
            assert len(ring) >= 8, (each, height)
    heights = [z for web in true.webs for z in (web.z_min_mm, web.z_max_mm)]
    assert all(np.abs(vertices[:, 2] - z).min() < ROUNDING_MM for z in heights)
    assert true.throws[0].angle_rad == pytest.approx(0.0, abs=1e-9)
    assert all(0.0 <= throw.angle_rad < 2.0 * math.pi for throw in true.throws)


def _in_own_axes(odd: OddCrank, found: Anatomy, pin: Pin) -> tuple[float, ...]:
    """Return place and size of a cylinder in the axes of the construction."""
    back = np.linalg.inv(odd.placement) @ found.rotor_to_file
    return *(back[:3, :3] @ pin.centre_mm + back[:3, 3]), pin.diameter_mm, pin.width_mm


def _sorted(rows: Iterable[tuple[float, ...]]) -> list[tuple[float, ...]]:
    return sorted(rows, key=lambda row: row[2])


def _seen(odd: OddCrank) -> dict[str, list[tuple[float, ...]]] | str:
    """Return all that is recognised of a crank, in the axes of its construction; "refused" without any."""
    source = odd.source()
    own = source.surfaces.cylinders if source.surfaces is not None else ()
    try:
        found = recognise(source.solid, Overrides(crankpin_in_file=None), own)
    except AutobalanceError:
        return "refused"
    back = np.linalg.inv(odd.placement) @ found.rotor_to_file
    faces = [float(back[2, 2] * z + back[2, 3]) for web in found.webs for z in (web.z_min_mm, web.z_max_mm)]
    return {
        "mains": _sorted(_in_own_axes(odd, found, each) for each in found.main_journals),
        "pins": _sorted(_in_own_axes(odd, found, throw.crankpin) for throw in found.throws),
        "webs": [(0.0, 0.0, z) for z in sorted(faces)],
        "doubts": _sorted(
            (*_in_own_axes(odd, found, doubt.chosen), *_in_own_axes(odd, found, doubt.other))
            for doubt in found.doubts
        ),
    }


@pytest.mark.parametrize("kind", KINDS)
def test_the_frame_of_the_file_changes_nothing(kind: str) -> None:
    """Turned, moved, mirrored, and in inches a crank is the same, and so is what is doubted of it."""
    first = odd_crank(KINDS.index(kind))
    wanted = None
    for number, (unit, mirror) in enumerate((("mm", 1.0), ("inch", 1.0), ("mm", -1.0))):
        placement = random_placement(np.random.default_rng(100 + number), 150.0)
        here = first.presented(placement @ np.diag([mirror, 1.0, 1.0, 1.0]), unit)
        seen = _seen(here)
        wanted = seen if wanted is None else wanted
        if isinstance(wanted, str) or isinstance(seen, str):
            assert seen == wanted
            continue
        assert set(seen) == set(wanted)
        for name, rows in seen.items():
            assert len(rows) == len(wanted[name]), (name, number)
            for row, other in zip(rows, wanted[name], strict=True):
                assert row == pytest.approx(other, abs=FRAMES_MM), (name, number)


@pytest.mark.parametrize("segments", [12, 24])
@pytest.mark.parametrize("typed", [False, True])
def test_journals_whose_corners_are_mostly_their_neighbours_are_found(segments: int, typed: bool) -> None:
    """Eccentrics cross the ends of a coarse shaft's middle journals: three corners or fewer are left of each.

    The journals are the construction's, each at its place, whether crankpins are recognised or typed.
    """
    odd = replace(odd_crank(164, "eccentrics beside the shaft"), segments=segments, step=False)
    true = odd.truth()
    back = np.linalg.inv(true.file_to_rotor)
    pins = [throw.crankpin for throw in true.throws]
    places = [back[:3, :3] @ pin.centre_mm + back[:3, 3] for pin in pins]
    hints = tuple(PinHint(at, pin.diameter_mm, pin.width_mm) for at, pin in zip(places, pins, strict=True))
    found = recognise(odd.source().solid, Overrides(crankpins=hints if typed else None))
    assert len(found.main_journals) == 4
    assert faults(odd, found) == []
    assert found.doubts == ()


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_coordinates_written_with_two_decimals_change_nothing(seed: int) -> None:
    """A file's digits are no waves: collars stay apart from their webs, and no surface is missing."""
    odd = odd_crank(seed).presented(odd_crank(seed).placement, "mm")
    written = np.round(odd.source().solid.mesh.corners, 2)
    found = recognise(source_of(written, "mm").solid, Overrides(crankpin_in_file=None))
    assert faults(odd, found) == []


@pytest.mark.parametrize("seed", [4, 10, 31])
def test_coordinates_written_with_one_decimal_are_told(seed: int) -> None:
    """Surfaces are off by 0.07 mm: journals were missing, or all was found without a word on the file."""
    odd = odd_crank(seed).presented(odd_crank(seed).placement, "mm")
    mesh = odd.source().solid.mesh
    crank = ab.crank_from_mesh(np.round(mesh.vertices, 1), mesh.triangles, 7850.0)
    found, true = crank.measured.anatomy, odd.truth()
    assert len(found.main_journals) == len(true.main_journals)
    assert len(found.throws) == len(true.throws)
    pairs = [
        *zip(found.main_journals, true.main_journals, strict=True),
        *((own.crankpin, meant.crankpin) for own, meant in zip(found.throws, true.throws, strict=True)),
    ]
    for own, meant in pairs:
        assert own.centre_mm == pytest.approx(meant.centre_mm, abs=0.1)
        assert own.diameter_mm == pytest.approx(meant.diameter_mm, abs=0.1)
        assert own.width_mm == pytest.approx(meant.width_mm, abs=0.2)
    assert any("multiple of 0.1 mm: the file was rounded" in text for text in crank.warnings)
    written = ab.crank_from_mesh(np.round(mesh.vertices, 2), mesh.triangles, 7850.0)
    assert not any("multiple of" in text for text in written.warnings)
