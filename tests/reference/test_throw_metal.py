"""The stiffness of a throw's own metal: a round shaft in closed form, a throw beside both formulas."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import autobalance as ab
from autobalance.balancing.engine_from_job import with_crankpins
from autobalance.bundled import bundled_folder
from autobalance.crank_dynamics.torsion.from_job import throw_shapes
from autobalance.crank_dynamics.torsion.throw_twist import throw_ends_mm, throw_twists
from autobalance.drawn_cranks.design import PRESETS, DesignBay
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.errors import UsageError
from autobalance.finite_elements.analysis import COARSENING
from autobalance.finite_elements.elasticity import STEEL
from autobalance.finite_elements.throws import TwistStiffness, bodies_of_solid, twist_stiffness
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.verbs.crank import read_crank

WORTH = 0.2
"""The formulas are fits to measured crankshafts: 10 to 20 % of stiffness."""


def test_a_round_shaft_is_as_stiff_as_its_polygon() -> None:
    shaft = Solid.prism(Region.circle(15.0, 48), 0.0, 20.0)
    found = twist_stiffness(bodies_of_solid(shaft, 12.0, COARSENING), shaft.volume_mm3, STEEL)
    shear = STEEL.young_MPa / (2.0 * (1.0 + STEEL.poisson))
    exact = shear * math.pi * 15.0**4 / (2.0 * 20.0) * 1e-3
    flats = (math.sin(2.0 * math.pi / 48) / (2.0 * math.pi / 48)) ** 2  # J of nearly round goes as its area²
    assert found.n_m_rad == pytest.approx(flats * exact, rel=2e-3)
    assert abs(found.n_m_rad - flats * exact) < found.error_n_m_rad < 0.01 * exact
    assert len(found.levels_n_m_rad) == 3


def test_a_throw_is_as_stiff_as_the_formulas_say_within_what_they_are_worth() -> None:
    throws = (DesignBay((0.0,)), DesignBay((180.0,)))
    plain = replace(
        PRESETS["inline-4"],
        bays=throws,
        oil_hole_mm=0.0,
        fillet_mm=0.0,
        nose=None,
        flange=None,
        counterweight=None,
    )
    mesh = crank_solid(plain, 32).mesh
    crank = ab.crank_from_mesh(mesh.vertices, mesh.triangles, 7850.0)
    job = {
        "crankshaft": {},
        "engine": {"rotating_g": {"rod": 400.0}, "reciprocating_g": {"piston": 500.0}},
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000.0},
        "correction": {"method": "drill"},
    }
    report = ab.torsion(job, crank=crank, fem=True).report
    first, second = report["throws"]
    metal = first["fem_N_m_rad"]
    assert second["fem_N_m_rad"] == metal  # alike: solved once
    assert 0.0 < first["fem_error_N_m_rad"] < 0.05 * metal
    assert len(first["fem_levels_N_m_rad"]) == 3
    for formula in ("ker_wilson_N_m_rad", "carter_N_m_rad"):
        assert first[formula] == pytest.approx(metal, rel=WORTH)
    assert report["model"]["fem_N_m_rad"] == pytest.approx([2.0 * metal, metal, 2.0 * metal])
    ratio = report["fem_natural_frequencies_hz"][0] / report["natural_frequencies_hz"][0]
    assert ratio == pytest.approx(math.sqrt(metal / first["ker_wilson_N_m_rad"]), rel=1e-6)


def test_throws_alike_but_for_the_side_of_their_drillings_are_solved_once() -> None:
    """The end throws have longer outer journals; what volumes differ by counts as error of the others."""
    seen: list[float] = []

    def twisted(piece: Solid, *_: object) -> TwistStiffness:
        seen.append(piece.volume_mm3)
        return TwistStiffness(float(len(seen)), 0.0, 1, (1.0,))

    design = PRESETS["inline-4"]
    mesh = crank_solid(design, 32).mesh
    crank = ab.crank_from_mesh(mesh.vertices, mesh.triangles, 7850.0).measured
    found = [
        each.stiffness
        for each in throw_twists(crank, 210e3, 80e3, None, stiffness_of_bay=twisted)
        if each.stiffness
    ]
    assert len(seen) == 1
    assert [each.n_m_rad for each in found] == [1.0] * 4
    first, *others = (each.error_n_m_rad for each in found)
    assert first == 0.0
    ends = [throw_ends_mm(crank.anatomy, throw) for throw in crank.anatomy.throws[:2]]
    longer_mm = abs(float(np.diff(ends[0])[0] - np.diff(ends[1])[0]))
    softer = longer_mm / design.main_journal.diameter_mm**4 / throw_shapes(crank)[1].ker_wilson_per_mm3()
    assert 0.0059 < softer < 0.01  # more than the volumes differ by
    assert others == pytest.approx([softer, softer, 0.0], abs=2e-4)


def test_throws_of_one_bay_are_twisted_together_and_in_series_as_stiff() -> None:
    """Bays that are turned about the axis are alike; both throws have their share of the twist."""
    pieces: list[Solid] = []

    def twisted(piece: Solid, *_: object) -> TwistStiffness:
        pieces.append(piece)
        return TwistStiffness(3e5, 3e3, 1, (2.8e5, 2.9e5, 3e5))

    mesh = crank_solid(replace(PRESETS["v6-60"], oil_hole_mm=0.0), 24).mesh
    crank = ab.crank_from_mesh(mesh.vertices, mesh.triangles, 7850.0).measured
    found = [
        each.stiffness
        for each in throw_twists(crank, 210e3, 80e3, None, stiffness_of_bay=twisted)
        if each.stiffness
    ]
    mains = [float(main.centre_mm[2]) for main in crank.anatomy.main_journals]
    assert [tuple(piece.bounds[:, 2]) for piece in pieces] == [
        pytest.approx(each) for each in pairwise(mains[: len(pieces) + 1])
    ]
    assert len(pieces) < len(mains) - 1 == 3
    for one, other in zip(found[::2], found[1::2], strict=True):
        assert 1.0 / one.n_m_rad + 1.0 / other.n_m_rad == pytest.approx(1.0 / 3e5, rel=1e-12)
        assert 0.01 * (1.0 - 1e-9) <= one.error_n_m_rad / one.n_m_rad < 0.02
        assert one.n_m_rad == pytest.approx(other.n_m_rad, rel=0.05)  # throws of one drawing


def test_crankpins_are_put_into_a_crank_without_them() -> None:
    design = PRESETS["pressed-up-single-no-pin"]
    mesh = crank_solid(design, 64).mesh
    crank = ab.crank_from_mesh(mesh.vertices, mesh.triangles, 7850.0, crankpin_in_file=False).measured
    apart = crank.source.solid.moved(crank.anatomy.file_to_rotor)
    joined = with_crankpins(apart, crank)
    assert (len(apart.pieces()), len(joined.pieces())) == (2, 1)
    length = design.crankpin.width_mm + 2.0 * design.web.thickness_mm
    pin = 0.25 * math.pi * design.crankpin.diameter_mm**2 * length
    assert joined.volume_mm3 - apart.volume_mm3 == pytest.approx(pin, rel=3e-3)  # flats of both


def test_a_crankpin_that_is_put_in_leaves_no_slivers() -> None:
    """Its ends lay in the planes of the webs but for rounding: the mesher crashed on what that left."""
    file = bundled_folder() / "crf250r" / "straight" / "crank.stl"
    measured = read_crank(file, "mm", crankpin_in_file=False).measured
    joined = with_crankpins(measured.source.solid.moved(measured.anatomy.file_to_rotor), measured)
    mesh = joined.simplified(1e-2).mesh
    corners = mesh.vertices[mesh.triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    assert (mesh.doubled_areas / longest).min() > 1e-3


def test_a_chain_has_no_metal() -> None:
    chain = {"inertia": [{"kg_mm2": 1.0}, {"kg_mm2": 1.0}], "spring": [{"N_m_rad": 1.0}]}
    with pytest.raises(UsageError, match="a chain has no metal"):
        ab.torsion(chain, fem=True)


def test_a_throw_that_is_not_meshed_in_time_has_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("autobalance.crank_dynamics.torsion.throw_twist.LONGEST_S", 0.0)
    crank = ab.generate("single", segments=24).crank
    job = {
        "engine": {"rotating_g": {"rod": 400.0}, "reciprocating_g": {"piston": 500.0}},
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000.0},
        "correction": {"method": "drill"},
    }
    result = ab.torsion(job, crank=crank, fem=True)
    throw = result.report["throws"][0]
    assert throw["fem_N_m_rad"] is None
    assert "the mesher did not end within 0 s" in throw["fem_note"]
    assert throw["fem_note"] in result.text()
    assert result.report["fem_natural_frequencies_hz"] is None
    assert len(result.report["natural_frequencies_hz"]) == 2
