"""Torsional chains against closed forms and a published crankshaft; cranks against their own sums."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank_dynamics.torsion.chain import (
    ThrowShape,
    TorsionChain,
    holzer_table,
    throw_stiffness_n_m_rad,
    torsion_modes,
)
from autobalance.crank_dynamics.torsion.model import CrankTorsion
from autobalance.drawn_cranks.design import PRESETS
from autobalance.engines.cycle.analysis import throw_torques
from autobalance.errors import JobError
from tests.generated import preset_crank

Values = dict[str, Any]


def chain(inertias: list[float], springs: list[float], **file: Any) -> Values:
    """Return the report of a chain; kg·mm² and N·m/rad."""
    return ab.torsion(
        {
            "inertia": [{"kg_mm2": each} for each in inertias],
            "spring": [{"N_m_rad": each} for each in springs],
            **file,
        }
    ).report


# --- closed forms -------------------------------------------------------------------------------------------


def test_two_discs() -> None:
    first, second, spring = 2e4, 5e3, 3e4
    report = chain([first, second], [spring])
    square = spring * (1e6 / first + 1e6 / second)
    assert report["natural_frequencies_hz"] == pytest.approx([math.sqrt(square) / (2 * math.pi)], rel=1e-12)
    mode = report["modes"][0]
    assert mode["nodes"] == 1
    assert mode["shape"] == pytest.approx([-second / first, 1.0], rel=1e-12)
    assert mode["holzer"][-1]["torque_N_m"] == pytest.approx(0.0, abs=1e-9 * spring)
    assert report["model"]["ker_wilson_N_m_rad"] is None


def test_the_six_mass_chain_of_a_motorcycle_four() -> None:
    """P. Biedenkopf's crank, measured and checked by finite elements: J [1e-6 kg·m²], k [N·m/°]."""
    inertias = [19.9, 1695.8, 2159.5, 1815.7, 1260.2, 15.4]
    springs = [each * 180.0 / math.pi for each in (3014, 2562, 2430, 2636, 2562)]
    report = chain(inertias, springs)
    assert report["natural_frequencies_hz"][:3] == pytest.approx([1168.91, 2084.57, 2618.70], abs=0.005)
    assert [mode["nodes"] for mode in report["modes"]] == [1, 2, 3, 4, 5]


def test_holzers_remainder_is_the_characteristic_polynomial() -> None:
    """The remainder at any frequency is det(K − ω²J)/Πk up to sign."""
    rng = np.random.default_rng(7)
    inertias, springs = rng.uniform(0.01, 0.1, 5), rng.uniform(1e3, 1e4, 4)
    model = TorsionChain(inertias, springs, np.zeros(5), np.zeros(4))
    for frequency in (50.0, 200.0, 700.0):
        left = holzer_table(model, frequency)[-1].torque_n_m
        whole = np.linalg.det(model.stiffness() - frequency**2 * np.diag(inertias))
        assert left == pytest.approx(-whole / np.prod(springs), rel=1e-9)
    for mode in torsion_modes(model):
        rows = holzer_table(model, mode.frequency_rad_s)
        angles = np.array([row.angle_rad for row in rows], dtype=float)
        assert angles / angles[np.argmax(np.abs(angles))] == pytest.approx(mode.shape, abs=1e-9)


def test_a_uniform_shaft_is_the_limit_of_many_discs() -> None:
    count = 200
    report = chain([1.0 / count * 1e6] * count, [1e4 * count] * (count - 1))
    exact = [0.5 * n * math.sqrt(1e4) for n in (1, 2, 3)]  # free ends: n/2L √(GJ/I), L = 1
    assert report["natural_frequencies_hz"][:3] == pytest.approx(exact, rel=2e-4)


def test_a_spring_of_zero_parts_the_chain() -> None:
    report = chain([1e4, 1e4, 2e4, 2e4], [1e4, 0.0, 1e4])
    assert len(report["natural_frequencies_hz"]) == 2
    assert report["modes"][0]["holzer"] is None


def test_response_of_a_damped_two_disc_chain() -> None:
    first, second, spring, ground, across = 0.02, 0.005, 3e4, 0.7, 0.3
    report = ab.torsion(
        {
            "speed_rpm": 3000,
            "inertia": [{"kg_mm2": 1e6 * first, "damping_N_m_s_rad": ground}, {"kg_mm2": 1e6 * second}],
            "spring": [{"N_m_rad": spring, "damping_N_m_s_rad": across, "diameter_mm": 30}],
            "excitation": [
                {"station": 1, "order": 2, "N_m": 50},
                {"station": 2, "order": 2, "N_m": 20, "phase_deg": 60},
                {"station": 2, "order": 3.5, "N_m": 5},
            ],
        }
    ).report
    assert [each["order"] for each in report["response"]] == [2.0, 3.5]
    w = 2.0 * 100.0 * math.pi
    link = spring + 1j * w * across
    dynamic = np.array([[link + 1j * w * ground - w**2 * first, -link], [-link, link - w**2 * second]])
    angle = np.linalg.solve(dynamic, [50.0, 20.0 * np.exp(1j * math.pi / 3)])
    point = report["response"][0]["points"][0]
    assert point["angle_mrad"] == pytest.approx(1e3 * np.abs(angle), rel=1e-9)
    torque = abs(link * (angle[1] - angle[0]))
    assert point["torque_N_m"] == pytest.approx([torque], rel=1e-9)
    assert point["twist_mrad"] == pytest.approx([1e3 * abs(angle[1] - angle[0])], rel=1e-9)
    assert point["stress_MPa"] == pytest.approx([16.0 * torque / (math.pi * 0.03**3) / 1e6], rel=1e-9)


def test_criticals_are_where_an_order_meets_a_frequency() -> None:
    report = chain(
        [2e4, 5e3],
        [3e4],
        speed_rpm=[500, 6000],
        excitation=[{"station": 1, "order": o, "N_m": 1} for o in (2, 4)],
    )
    frequency = report["natural_frequencies_hz"][0]
    found = {each["order"]: each["speed_rpm"] for each in report["critical"]}
    expected = {o: 60.0 * frequency / o for o in (2.0, 4.0) if 500.0 <= 60.0 * frequency / o <= 6000.0}
    assert found == pytest.approx(expected)


def test_a_tuned_pendulum_stops_its_station() -> None:
    pendulum = {"order": 2, "distance_mm": 60, "mass_g": 400, "station": 2}
    excitation = [{"station": 1, "order": o, "N_m": 30} for o in (2, 3)]
    file: Values = {"excitation": excitation, "speed_rpm": [1000, 1500], "points": 3}
    with_it = chain([2e4, 5e3], [3e4], pendulum=pendulum, **file)
    assert with_it["pendulum"] == {
        "length_mm": pytest.approx(15.0),
        "inertia_kg_mm2": pytest.approx(0.4 * 75.0**2),
    }
    assert all(point["angle_mrad"][1] == 0.0 for point in with_it["response"][0]["points"])
    # at another order it is an inertia, here less than nothing
    third = 0.4 * 75.0**2 / (1.0 - 3.0**2 * 15.0 / 60.0)
    stiff = chain([2e4, 5e3 + third], [3e4], **file)
    assert with_it["response"][1]["points"][2]["angle_mrad"] == pytest.approx(
        stiff["response"][1]["points"][2]["angle_mrad"], rel=1e-9
    )


# --- cranks -------------------------------------------------------------------------------------------------


def test_both_formulas_on_one_throw() -> None:
    throw = ThrowShape(60, 20, 40, 50, 10, 30, 45, 22, 90)
    journal, pin, web = 60**4 - 20**4, 50**4 - 10**4, 22 * 90**3
    ker_wilson = (40 + 24) / journal + (30 + 20) / pin + (45 - 0.2 * 110) / web
    carter = (40 + 0.8 * 22) / journal + 0.75 * 30 / pin + 1.5 * 45 / web
    for length, found in ((ker_wilson, throw.ker_wilson_per_mm3()), (carter, throw.carter_per_mm3())):
        assert found == pytest.approx(length, rel=1e-12)
        k = math.pi * 80e3 / (32.0 * length) / 1e3
        assert throw_stiffness_n_m_rad(found, 80e3) == pytest.approx(k, rel=1e-12)


def test_a_throw_without_flexibility_is_refused() -> None:
    with pytest.raises(ValueError, match="without torsional flexibility"):
        throw_stiffness_n_m_rad(-1e-9, 80e3)


def crank_job(**tables: Any) -> ab.Job:
    return ab.Job.from_dict(
        {
            "engine": {
                "rods_per_throw": 1,
                "rod_length_mm": 140,
                "rotating_g": {"big_end": 300.0},
                "reciprocating_g": {"piston": 400.0},
                "crankpin_g": {"oil": 5.0},
            },
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000},
            "correction": {"method": "drill"},
            **tables,
        }
    )


@pytest.fixture(scope="module")
def inline_four() -> ab.Crank:
    return preset_crank("inline-4", 48)


def test_inertias_of_a_crank_sum_to_what_turns(inline_four: ab.Crank) -> None:
    job = crank_job(torsion={"flywheel_kg_mm2": 5e4, "damper_kg_mm2": 3e3})
    report = ab.torsion(job, crank=inline_four).report
    model = report["model"]
    assert model["stations"] == ["main 1", "throw 1", "throw 2", "throw 3", "throw 4", "main 5"]
    rods = sum((300.0 + 200.0 + 5.0) * throw.crank_radius_mm**2 * 1e-3 for throw in inline_four.throws)
    whole = inline_four.polar_inertia_kg_mm2 + 5e4 + 3e3 + rods
    assert sum(model["inertias_kg_mm2"]) == pytest.approx(whole, rel=1e-9)
    assert model["inertias_kg_mm2"][1] == pytest.approx(model["inertias_kg_mm2"][4], rel=1e-3)
    assert model["inertias_kg_mm2"][-1] > 5e4


def test_a_ring_in_front_and_a_train_behind_lengthen_the_chain(inline_four: ab.Crank) -> None:
    ring = {"name": "ring", "kg_mm2": 2e3, "N_m_rad": 3e4, "shaft_damping_N_m_s_rad": 2.0}
    wheel = {"name": "wheel", "kg_mm2": 1e6, "N_m_rad": 1e4}
    train = [{"kg_mm2": 8e4, "N_m_rad": 5e4, "diameter_mm": 30}, wheel]
    alone = ab.torsion(crank_job(), crank=inline_four).report["model"]
    report = ab.torsion(crank_job(torsion={"front": [ring], "train": train}), crank=inline_four).report
    model = report["model"]
    assert model["stations"] == ["ring", *alone["stations"], "train 1", "wheel"]
    assert model["inertias_kg_mm2"] == pytest.approx([2e3, *alone["inertias_kg_mm2"], 8e4, 1e6])
    for key in ("stiffness_N_m_rad", "ker_wilson_N_m_rad", "carter_N_m_rad"):
        assert model[key] == pytest.approx([3e4, *alone[key], 5e4, 1e4])
    same = chain(model["inertias_kg_mm2"], model["stiffness_N_m_rad"])
    assert report["natural_frequencies_hz"] == pytest.approx(same["natural_frequencies_hz"], rel=1e-9)


def test_stiffness_of_a_crank_is_its_dimensions(inline_four: ab.Crank) -> None:
    design = PRESETS["inline-4"]
    reports = {
        name: ab.torsion(crank_job(torsion={"stiffness": name}), crank=inline_four).report
        for name in ("ker_wilson", "carter")
    }
    throw = reports["ker_wilson"]["throws"][1]
    assert throw["journal_mm"] == pytest.approx(design.main_journal.diameter_mm, rel=1e-3)
    assert throw["journal_length_mm"] == pytest.approx(design.main_journal.width_mm, rel=1e-3)
    assert throw["crankpin_mm"] == pytest.approx(design.crankpin.diameter_mm, rel=1e-3)
    assert throw["crankpin_length_mm"] == pytest.approx(design.crankpin.width_mm, rel=1e-3)
    assert throw["web_thickness_mm"] == pytest.approx(design.web.thickness_mm, rel=1e-3)
    assert throw["crank_radius_mm"] == pytest.approx(0.5 * design.stroke_mm, rel=1e-3)
    assert 62.0 < throw["web_breadth_mm"] < 70.0  # a pear of radii 31 mm and 35 mm
    for name, report in reports.items():
        assert report["model"]["stiffness_N_m_rad"] == report["model"][f"{name}_N_m_rad"]
        assert len(report["model"]["stiffness_N_m_rad"]) == 5
    shape = ThrowShape(
        *[
            throw[key]
            for key in (
                "journal_mm",
                "journal_bore_mm",
                "journal_length_mm",
                "crankpin_mm",
                "crankpin_bore_mm",
                "crankpin_length_mm",
                "crank_radius_mm",
                "web_thickness_mm",
                "web_breadth_mm",
            )
        ]
    )
    one = throw_stiffness_n_m_rad(shape.ker_wilson_per_mm3(), 80e3)
    assert reports["ker_wilson"]["model"]["stiffness_N_m_rad"][2] == pytest.approx(one, rel=5e-3)
    twice = reports["ker_wilson"]["model"]["stiffness_N_m_rad"]
    assert twice[0] == pytest.approx(2.0 * twice[1], rel=0.01)  # half a throw against two halves


def test_the_cycles_torque_orders_excite_the_crank(inline_four: ab.Crank) -> None:
    gas = {
        "bore_mm": 86,
        "compression_ratio": 10,
        "heat_J": 1200,
        "gas": "ideal",
        "firing_order": [1, 3, 4, 2],
    }
    job = crank_job(cycle=gas, speed_rpm=[3000, 6000], points=4, torsion={"flywheel_kg_mm2": 1e6})
    report = ab.torsion(job, crank=inline_four).report
    assert [each["order"] for each in report["response"]] == [0.5 * n for n in range(1, 25)]
    assert all(each["speed_rpm"] <= 6000.0 for each in report["critical"])
    speeds = [each["speed_rpm"] for each in report["critical"]]
    assert all(a <= b for a, b in pairwise(speeds))
    torques = throw_torques(job, inline_four.measured)
    whole = ab.cycle(job, speed_rpm=3000, crank=inline_four).report["torque"]["orders"]
    square = (3000 * math.pi / 30) ** 2
    gas_sum, inertia_sum = (np.abs(each.sum(axis=1)) for each in (torques.gas_n_m, torques.inertia_n_m_s2))
    assert gas_sum == pytest.approx([each["gas_N_m"] for each in whole], abs=1e-6)
    assert square * inertia_sum == pytest.approx([each["inertia_N_m"] for each in whole], abs=1e-6)


def test_other_verbs_pass_over_the_tables_of_torsion() -> None:
    job = crank_job(torsion={"flywheel_kg_mm2": 10}, pendulum={"order": 2, "distance_mm": 5, "mass_g": 3})
    assert job.table(CrankTorsion) is not None
    assert crank_job().table(CrankTorsion) is None


# --- what is refused ----------------------------------------------------------------------------------------

TWO: Values = {"inertia": [{"kg_mm2": 1}, {"kg_mm2": 2}], "spring": [{"N_m_rad": 5}]}


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ({"spring": []}, r"there are 0 \[\[spring\]\] tables; 2 inertias need 1"),
        ({"inertia": [{"kg_mm2": 0}, {"kg_mm2": 1}]}, r"inertia\[1\].kg_mm2 is 0; must be > 0"),
        ({"spring": [{"N_m_rad": -1}]}, "N_m_rad is -1; must be ≥ 0"),
        ({"excitation": [{"station": 3, "order": 1, "N_m": 1}]}, "station is 3; there are 2 stations"),
        ({"excitation": [{"station": 1, "order": 0, "N_m": 1}]}, "order is 0; must be > 0"),
        ({"pendulum": {"order": 2, "distance_mm": 5, "mass_g": 1, "station": 9}}, "pendulum.station is 9"),
        ({"speed_rpm": [6000, 500]}, "the first must be the lower one"),
        ({"speed_rpm": 0}, "speed_rpm is 0; must be > 0"),
        ({"dampers": 1}, "unknown key"),
    ],
)
def test_bad_input_is_one_line(file: Values, words: str) -> None:
    with pytest.raises(JobError, match=words) as refused:
        ab.torsion({**TWO, **file})
    assert "\n" not in str(refused.value)


def test_a_job_with_a_wrong_key_names_it() -> None:
    words = r"torsion\.stiffness is 'bicera'; must be one of 'ker_wilson', 'carter'"
    with pytest.raises(JobError, match=words):
        crank_job(torsion={"stiffness": "bicera"})
