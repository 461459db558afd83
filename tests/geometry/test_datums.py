"""Keyways, flanges and faces: found where they are, and nowhere else."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.datums import DatumAngle, Datums
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import PRESETS
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from tests.cranks import make_crank, tilted
from tests.generated import generated_crank

R = 20.0
"""Radius of the main journals of ``make_crank`` [mm]; the first is 30 mm wide, its end at z = -61."""
END_MM = -61.0
ANGLE_DEG = 37.0


def datums_of(solid: Solid) -> Datums:
    found = recognise(solid, Overrides()).datums
    assert found is not None
    return found


def test_keyway_and_flange_of_a_drawn_crank_that_lies_anywhere() -> None:
    crank = generated_crank("inline-3", seed=3)
    found, design = datums_of(crank.solid), crank.design
    assert design.nose is not None
    assert design.nose.keyway is not None
    assert design.flange is not None
    (key,), (flange,) = found.keyways, found.flanges
    assert key.width_mm == pytest.approx(design.nose.keyway.width_mm, abs=1e-3)
    assert key.z_max_mm - key.z_min_mm == pytest.approx(design.nose.keyway.length_mm, abs=1e-3)
    assert key.angle_deg == pytest.approx(90.0, abs=1e-3)
    assert (key.end, flange.end) == ("-z", "+z")
    assert flange.diameter_mm == pytest.approx(design.flange.diameter_mm, abs=1e-3)
    assert [hole.diameter_mm for hole in flange.holes] == pytest.approx([design.flange.bolt_diameter_mm] * 6)
    step = np.array([hole.angle_deg for hole in flange.holes]) % 60.0
    assert np.abs((step + 30.0) % 60.0 - 30.0).max() < 1e-3
    top = crank.mesh.moved(recognise(crank.solid, Overrides()).file_to_rotor).bounds[1, 2]
    assert found.faces[0].of == "flange"
    assert found.faces[0].z_mm == pytest.approx(top, abs=1e-3)
    assert found.angle == DatumAngle("keyway", key.angle_deg)


def test_without_a_keyway_the_odd_hole_of_the_flange_is_told() -> None:
    design = PRESETS["parallel-twin-360"]
    assert design.flange is not None
    crank = generated_crank(design, segments=48)
    (flange,) = datums_of(crank.solid).flanges
    assert flange.marker_hole is not None
    assert flange.marker_hole.angle_deg % 360.0 == pytest.approx(0.0, abs=1e-3) or (
        flange.marker_hole.angle_deg == pytest.approx(360.0, abs=1e-3)
    )
    wider = Solid.prism(Region.circle(6.0, 48, (-29.0, 0.0)), -500.0, 500.0)
    back = crank.mesh.bounds[1, 2] - 6.0
    found = datums_of(crank.solid - wider.above(float(back) - 6.0))
    assert found.angle is not None
    assert found.angle.of == "flange_hole"
    assert found.angle.angle_deg == pytest.approx(180.0, abs=1e-3)
    assert len(found.flanges[0].holes) == 6


@pytest.mark.parametrize("name", ["single", "parallel-twin-360"])
def test_no_datum_of_angle_where_nothing_is_drawn(name: str) -> None:
    design = replace(PRESETS[name], nose=None, flange=None)
    found = datums_of(generated_crank(design, segments=37).solid)
    assert found.keyways == () == found.flanges
    assert found.angle is None
    assert [face.name for face in found.faces[:2]] == [
        "-z face of web 1",
        f"+z face of web {2 if name == 'single' else 4}",
    ]


# --- slots that are keyways, and what only looks like one ---------------------------------------------------


def box(wide: float, low: float, high: float, length: float, *, begin: float = END_MM) -> Solid:
    """Return a bar along the axis from ``begin``, ``low`` to ``high`` from the axis, at ``ANGLE_DEG``."""
    return turned(
        Solid.box(np.array([low, -0.5 * wide, begin]), np.array([high, 0.5 * wide, begin + length]))
    )


def turned(body: Solid, by_deg: float = ANGLE_DEG) -> Solid:
    c, s = math.cos(math.radians(by_deg)), math.sin(math.radians(by_deg))
    return body.moved(np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]))


def crank_less(*tools: Solid, placement: Array | None = None) -> Solid:
    solid, _ = make_crank([0.0])
    solid = solid.moved(np.eye(4))
    for tool in tools:
        solid = solid - tool
    return solid if placement is None else solid.moved(placement)


def milled_by_disc() -> Solid:
    """A Woodruff key's slot: a disc of 25 mm across the axis, 8 mm wide."""
    disc = Solid.prism(Region.circle(12.5, 64), -4.0, 4.0)
    stand = np.array([[1.0, 0, 0, R + 6.0], [0, 0, -1.0, 0], [0, 1.0, 0, END_MM + 16.0], [0, 0, 0, 1]])
    return turned(disc.moved(stand))


def drilled(flat: bool) -> Solid:
    """A radial hole of 12 mm, 5 mm deep."""
    hole = Solid.prism(Region.circle(6.0, 24), 0.0, 20.0)
    stand = np.array([[0, 0, 1.0, R - 5.0], [0, 1.0, 0, 0], [-1.0, 0, 0, END_MM + 15.0], [0, 0, 0, 1]])
    return turned(hole.moved(stand)) if flat else turned(hole.moved(stand)) + box(1.0, 10.0, 15.0, 1.0)


def vee() -> Solid:
    corners = np.array([[R - 6.0, -1.0], [R + 4.0, -9.0], [R + 4.0, 9.0], [R - 6.0, 1.0]])
    return turned(Solid.prism(Region.of([corners]), END_MM - 1.0, END_MM + 20.0))


@pytest.mark.parametrize(
    ("tool", "length"),
    [
        (lambda: box(10.0, R - 5.0, R + 5.0, 24.0, begin=END_MM - 1.0), 23.0),
        (lambda: box(10.0, R - 5.0, R + 5.0, 14.0, begin=END_MM + 6.0), 14.0),
        (milled_by_disc, None),
    ],
    ids=["open", "closed", "woodruff"],
)
def test_a_slot_in_the_journal_is_a_keyway(tool: Callable[[], Solid], length: float | None) -> None:
    found = datums_of(crank_less(tool(), placement=tilted(1.1, (30.0, -200.0, 90.0))))
    (key,) = found.keyways
    away = math.remainder(key.angle_deg - ANGLE_DEG, 360.0)
    upside_down = math.remainder(key.angle_deg + ANGLE_DEG, 360.0)  # the file's axis may point the other way
    assert min(abs(away), abs(upside_down)) < 0.01
    assert key.shaft_diameter_mm == pytest.approx(2.0 * R, rel=2e-3)
    if length is not None:
        assert key.width_mm == pytest.approx(10.0, abs=1e-3)
        assert key.depth_mm == pytest.approx(5.0, abs=0.02)
        assert key.z_max_mm - key.z_min_mm == pytest.approx(length, abs=0.01)


@pytest.mark.parametrize(
    "tools",
    [
        (lambda: box(60.0, R - 4.0, R + 5.0, 20.0, begin=END_MM - 1.0),),
        (lambda: drilled(flat=True),),
        (lambda: turned(Solid.prism(Region.circle(5.0, 48, (R, 0.0)), END_MM - 1.0, END_MM + 20.0)),),
        (vee,),
        tuple(lambda k=k: turned(box(4.0, R - 3.0, R + 5.0, 20.0), 45.0 * k) for k in range(8)),
        (lambda: box(10.0, R - 5.0, R + 5.0, 5.0, begin=END_MM + 6.0),),
        (lambda: box(1.0, R - 0.2, R + 5.0, 20.0),),
    ],
    ids=["flat", "radial hole", "round groove", "vee", "spline", "shorter than wide", "scratch"],
)
def test_what_is_no_keyway_gives_none(tools: tuple[Callable[[], Solid], ...]) -> None:
    assert datums_of(crank_less(*(tool() for tool in tools))).keyways == ()
