"""Geared and branched trains against transfer matrices, hand-made matrices and closed forms."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import autobalance as ab
from autobalance.crank_dynamics.torsion.chain import TorsionChain, torsion_response
from autobalance.crank_dynamics.torsion.train import TorsionTrain, train_response
from autobalance.errors import JobError
from tests.generated import preset_crank

Values = dict[str, Any]


def train(inertias: list[float], springs: list[float], **file: Any) -> Values:
    """Return the report of a chain; kg·mm² and N·m/rad."""
    return ab.torsion(
        {
            "inertia": [{"kg_mm2": each} for each in inertias],
            "spring": [{"N_m_rad": each} for each in springs],
            **file,
        }
    ).report


def left_over(square: float, inertias: list[float], shafts: list[float | tuple[str, float]]) -> float:
    """Return the torque left behind the last inertia, by Holzer's table with gears between the shafts."""
    angle, torque = 1.0, 0.0
    for at, inertia in enumerate(inertias):
        torque += inertia * 1e-6 * square * angle
        if at == len(shafts):
            break
        shaft = shafts[at]
        if isinstance(shaft, tuple):  # a pair of gears: power is kept
            angle, torque = angle * shaft[1], torque / shaft[1]
        else:
            angle -= torque / shaft
    return torque


@pytest.mark.parametrize("ratio", [0.4, -2.5])
def test_a_geared_chain_against_a_transfer_matrix(ratio: float) -> None:
    inertias, shafts = [2e4, 3e3, 6e3, 5e4], [3e4, ("gear", ratio), 2e4]
    report = train(inertias, [3e4, 0.0, 2e4], gear=[{"stations": [2, 3], "ratio": ratio}])
    found = report["natural_frequencies_hz"]
    assert len(found) == 2
    for hertz in found:
        square = (2.0 * math.pi * hertz) ** 2
        root = brentq(left_over, 0.98 * square, 1.02 * square, args=(inertias, shafts), rtol=1e-14)
        assert math.sqrt(root) / (2.0 * math.pi) == pytest.approx(hertz, rel=1e-10)
    shape = report["modes"][0]["shape"]
    assert shape[2] == pytest.approx(ratio * shape[1], rel=1e-12)
    assert report["model"]["ratios"] == pytest.approx([1.0, 1.0, ratio, ratio])
    assert report["model"]["referred_inertias_kg_mm2"] == pytest.approx(
        [2e4, 3e3, 6e3 * ratio**2, 5e4 * ratio**2]
    )
    assert report["model"]["referred_stiffness_N_m_rad"] == pytest.approx([3e4, 0.0, 2e4 * ratio**2])
    assert report["modes"][0]["holzer"] is None


def test_stiff_teeth_are_rigid_ones() -> None:
    file = {"inertias": [2e4, 3e3, 6e3, 5e4], "springs": [3e4, 0.0, 2e4]}
    gear = {"stations": [2, 3], "ratio": -0.4}
    rigid = train(**file, gear=[gear])
    teeth = train(**file, gear=[{**gear, "mesh_N_m_rad": 1e11}])
    assert teeth["natural_frequencies_hz"][:2] == pytest.approx(rigid["natural_frequencies_hz"], rel=1e-6)
    assert len(teeth["natural_frequencies_hz"]) == 3
    # two inertias and their teeth alone: k (1/J1 + 1/(ρ² J2)), the stiffness as seen from the first
    alone = train([2e4, 8e3], [0.0], gear=[{"stations": [1, 2], "ratio": -0.4, "mesh_N_m_rad": 5e4}])
    square = 5e4 * (1e6 / 2e4 + 1e6 / (8e3 * 0.16))
    assert alone["natural_frequencies_hz"] == pytest.approx([math.sqrt(square) / (2 * math.pi)], rel=1e-12)


def test_a_geared_branch_against_lagranges_equations() -> None:
    """Crank with a flywheel at 3; a branch at 2 drives camshaft and blower through gears of ½ and −2."""
    report = train(
        [1e4, 2e4, 9e4],
        [5e4, 8e4],
        gear=[{"stations": [2, 4], "ratio": 0.5}, {"stations": [5, 6], "ratio": -2.0}],
        branch=[
            {"from": 2, "inertia": [{"kg_mm2": 4e3}, {"kg_mm2": 7e3}], "spring": [{"N_m_rad": 1e4}]},
            {"from": 5, "inertia": [{"kg_mm2": 1e3, "name": "blower"}], "spring": []},
        ],
        speed_rpm=1800,
        excitation=[{"station": 1, "order": 2, "N_m": 40}],
        torsion={"damping_ratio": 0.02},
    )
    assert report["model"]["stations"][3:] == ["branch 1.1", "branch 1.2", "blower"]
    # angles of 1, 2, 3 and 5 are free; 4 turns ½ of 2, 6 turns −2 of 5
    t = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0.5, 0, 0], [0, 0, 0, 1], [0, 0, 0, -2.0]])
    mass = t.T @ np.diag([1e-2, 2e-2, 9e-2, 4e-3, 7e-3, 1e-3]) @ t
    strain = np.array([[1, -1, 0, 0, 0, 0], [0, 1, -1, 0, 0, 0], [0, 0, 0, 1, -1, 0]]) @ t
    stiffness = strain.T @ np.diag([5e4, 8e4, 1e4]) @ strain
    square, vectors = eigh(stiffness, mass)
    assert report["natural_frequencies_hz"] == pytest.approx(np.sqrt(square[1:]) / (2 * math.pi), rel=1e-10)
    # every mode an oscillator of 2 % by itself
    w = 2.0 * 1800.0 * math.pi / 30.0
    force = vectors.T @ np.array([40.0, 0, 0, 0])
    own = np.sqrt(np.maximum(square, 0.0))
    own[0] = 0.0
    angle = t @ vectors @ (force / (own**2 - w**2 + 2j * 0.02 * own * w))
    point = report["response"][0]["points"][0]
    assert point["angle_mrad"] == pytest.approx(1e3 * np.abs(angle), rel=1e-9)
    assert point["twist_mrad"][2] == pytest.approx(1e3 * abs(angle[4] - angle[3]), rel=1e-9)


def test_a_chain_is_a_train_without_branches() -> None:
    rng = np.random.default_rng(3)
    chain = TorsionChain(
        rng.uniform(0.01, 0.1, 5), rng.uniform(1e3, 1e4, 4), rng.uniform(0, 1, 5), np.ones(4)
    )
    torque = rng.normal(size=(3, 5)) + 1j * rng.normal(size=(3, 5))
    speeds = np.array([50.0, 200.0, 700.0])
    one, other = (
        torsion_response(chain, speeds, torque),
        train_response(TorsionTrain.of_chain(chain), speeds, torque),
    )
    assert other.angles_rad == pytest.approx(one.angles_rad, rel=1e-10)
    assert other.torques_n_m == pytest.approx(one.torques_n_m, rel=1e-9)


def test_one_percent_of_critical_unless_something_is_said() -> None:
    """At resonance the twist of two discs is T/(k) · J2/(J1 + J2) · 1/(2ζ), times √(1 + 0) at ω = ω_n."""
    first, second, spring = 2e4, 5e3, 3e4
    hertz = math.sqrt(spring * (1e6 / first + 1e6 / second)) / (2 * math.pi)
    file: Values = {"excitation": [{"station": 1, "order": 2, "N_m": 10}], "speed_rpm": 30.0 * hertz}
    report = train([first, second], [spring], **file)
    assert report["damping"] == {"ratio": 0.01, "dampers": False}
    assert report["input"]["torsion"]["damping_ratio"] == 0.01
    reduced = 1.0 / (1e6 / first + 1e6 / second)
    static = 10.0 / (first * 1e-6) * reduced / spring
    assert report["response"][0]["points"][0]["twist_mrad"][0] == pytest.approx(1e3 * static / 0.02, rel=1e-9)
    critical = report["critical"][0]
    assert critical["torque_N_m"] == pytest.approx(static * spring / 0.02, rel=1e-9)
    assert critical["phase_sum"] is None
    none = train([first, second], [spring], torsion={"damping_ratio": 0.0}, **file)
    assert none["critical"][0]["torque_N_m"] is None
    bare = {"inertia": [{"kg_mm2": first}, {"kg_mm2": second}], "spring": [{"N_m_rad": spring}]}
    text = ab.torsion({**bare, **file, "torsion": {"damping_ratio": 0.0}}).text()
    assert "Damping: none; peaks of the response have no limit" in text
    damped = {"kg_mm2": second, "damping_N_m_s_rad": 0.1}
    given = ab.torsion(
        {"inertia": [{"kg_mm2": first}, damped], "spring": [{"N_m_rad": spring}], **file}
    ).report
    assert given["damping"] == {"ratio": 0.0, "dampers": True}


def test_the_greatest_twist_is_along_the_chain_not_its_rolling() -> None:
    file: Values = {"excitation": [{"station": 1, "order": 0.5, "N_m": 500}], "speed_rpm": 300}
    result = ab.torsion({"inertia": [{"kg_mm2": 2e4}, {"kg_mm2": 2e4}], "spring": [{"N_m_rad": 1e5}], **file})
    point = result.report["response"][0]["points"][0]
    assert min(point["angle_mrad"]) > 20.0 * max(point["twist_mrad"])
    assert f"{max(point['twist_mrad']):.4g} mrad" in result.text()
    assert f"{max(point['angle_mrad']):.4g} mrad" not in result.text()


def test_a_coupling_has_the_stiffness_of_the_torque_it_carries() -> None:
    coupling = {"station": 1, "torque_N_m": [0, 50, 250], "twist_rad": [0, 0.05, 0.1]}
    for mean, stiffness in ((0.0, 1e3), (-20.0, 1e3), (100.0, 4e3)):
        report = train([1e4, 2e4], [7.0], coupling=[{**coupling, "mean_N_m": mean}])
        assert report["model"]["couplings"] == [{"station": 1, "mean_N_m": mean, "N_m_rad": stiffness}]
        square = stiffness * (1e6 / 1e4 + 1e6 / 2e4)
        assert report["natural_frequencies_hz"][0] == pytest.approx(math.sqrt(square) / (2 * math.pi))


# --- cranks -------------------------------------------------------------------------------------------------

GAS = {"bore_mm": 86, "compression_ratio": 10, "heat_J": 1200, "firing_order": [1, 3, 4, 2]}


def crank_job(**tables: Any) -> ab.Job:
    return ab.Job.from_dict(
        {
            "engine": {
                "rods_per_throw": 1,
                "rod_length_mm": 140,
                "rotating_g": {"big_end": 300.0},
                "reciprocating_g": {"piston": 400.0},
            },
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000},
            "correction": {"method": "drill"},
            **tables,
        }
    )


@pytest.fixture(scope="module")
def inline_four() -> ab.Crank:
    return preset_crank("inline-4", 48)


def test_there_is_one_flywheel(inline_four: ab.Crank) -> None:
    own = ab.torsion(crank_job(torsion={"flywheel_kg_mm2": 9e4}, cycle=GAS), crank=inline_four).report
    cycles = ab.torsion(crank_job(cycle={**GAS, "flywheel_kg_mm2": 9e4}), crank=inline_four).report
    bare = ab.torsion(crank_job(cycle=GAS), crank=inline_four).report
    assert cycles["natural_frequencies_hz"] == own["natural_frequencies_hz"]
    assert cycles["natural_frequencies_hz"][0] < 0.8 * bare["natural_frequencies_hz"][0]
    assert cycles["input"]["torsion"]["flywheel_kg_mm2"] == 9e4
    crank_job(torsion={"flywheel_kg_mm2": 9e4}, cycle={**GAS, "flywheel_kg_mm2": 9e4})
    with pytest.raises(
        JobError, match=r"flywheel_kg_mm2 is 1 and cycle\.flywheel_kg_mm2 90000; expected one"
    ):
        crank_job(torsion={"flywheel_kg_mm2": 1}, cycle={**GAS, "flywheel_kg_mm2": 9e4})


def test_phase_sums_of_a_four(inline_four: ab.Crank) -> None:
    job = crank_job(cycle=GAS, torsion={"flywheel_kg_mm2": 9e4}, speed_rpm=[1000, 12000], points=2)
    report = ab.torsion(job, crank=inline_four).report
    sums = {each["order"]: each["phase_sum"] for each in report["critical"] if each["mode"] == 1}
    one, two, three, four = report["modes"][0]["shape"][1:5]
    assert sums[4.0] == pytest.approx(abs(one + two + three + four), rel=1e-9)
    assert sums[5.0] == pytest.approx(abs(one - two - three + four), rel=1e-9)
    # ½ orders: 1 fires at 0°, 3 at 180°, 4 at 360°, 2 at 540°
    half = abs(one - four + 1j * (three - two))
    assert sums[4.5] == pytest.approx(half, rel=1e-9)
    strongest = max(report["critical"], key=lambda each: each["torque_N_m"])
    assert strongest["stress_MPa"] > 0.0


def test_a_coupling_behind_a_crank_carries_the_cycles_mean_torque(inline_four: ab.Crank) -> None:
    tables: Values = {
        "cycle": GAS,
        "torsion": {"train": [{"kg_mm2": 1e4, "N_m_rad": 1}, {"kg_mm2": 1e5, "N_m_rad": 1e4}]},
        "coupling": [{"station": 6, "torque_N_m": [0, 100, 1000], "twist_rad": [0, 0.1, 0.2]}],
        "gear": [],
    }
    report = ab.torsion(crank_job(**tables), crank=inline_four).report
    torque = ab.cycle(crank_job(cycle=GAS), crank=inline_four).report["torque"]
    mean = torque["gas_mean_N_m"] - torque["friction_mean_N_m"]
    assert report["model"]["couplings"][0]["mean_N_m"] == pytest.approx(mean, rel=1e-9)
    assert report["model"]["stiffness_N_m_rad"][5] == pytest.approx(9000.0)


@pytest.mark.parametrize("ratio", [0.5, -2.0])
def test_a_coupling_on_a_geared_branch_carries_the_torque_over_the_ratio(
    inline_four: ab.Crank, ratio: float
) -> None:
    """Power is kept across the gear; the stiffness is that of the torque there, and so is the first mode."""
    load, wheel, flywheel = 3e5, 2e4, 9e4
    torques, twists = [0, 100, 200, 400, 800], [0, 0.05, 0.08, 0.1, 0.12]
    tables: Values = {
        "cycle": {**GAS, "flywheel_kg_mm2": flywheel},
        "branch": [
            {"from": 6, "inertia": [{"kg_mm2": wheel}, {"kg_mm2": load}], "spring": [{"N_m_rad": 1.0}]}
        ],
        "gear": [{"stations": [6, 7], "ratio": ratio}],
        "coupling": [{"station": 7, "torque_N_m": torques, "twist_rad": twists}],
    }
    result = ab.torsion(crank_job(**tables), crank=inline_four).report
    torque = ab.cycle(crank_job(cycle=tables["cycle"]), crank=inline_four).report["torque"]
    mean = (torque["gas_mean_N_m"] - torque["friction_mean_N_m"]) / abs(ratio)
    (coupling,) = result["model"]["couplings"]
    assert coupling["mean_N_m"] == pytest.approx(mean, rel=1e-9)
    step = next(n for n in range(4) if mean < torques[n + 1])
    slope = (torques[step + 1] - torques[step]) / (twists[step + 1] - twists[step])
    assert coupling["N_m_rad"] == pytest.approx(slope, rel=1e-12)
    # crank, flywheel and wheel as one rigid body against the load, referred to the branch
    crank = sum(result["model"]["inertias_kg_mm2"][:6]) / ratio**2 + wheel
    root = math.sqrt(slope * (1e6 / crank + 1e6 / load)) / (2.0 * math.pi)
    assert result["natural_frequencies_hz"][0] == pytest.approx(root, rel=5e-3)
    assert result["warnings"] == []


def test_where_a_train_divides_the_mean_torque_is_doubted(inline_four: ab.Crank) -> None:
    tables: Values = {
        "cycle": GAS,
        "torsion": {"train": [{"kg_mm2": 1e4, "N_m_rad": 1e4}]},
        "branch": [
            {"from": 6, "inertia": [{"kg_mm2": 2e4}, {"kg_mm2": 3e4}], "spring": [{"N_m_rad": 1.0}]},
            {"from": 1, "inertia": [{"kg_mm2": 2e4}, {"kg_mm2": 3e4}], "spring": [{"N_m_rad": 1.0}]},
        ],
        "gear": [{"stations": [6, 8], "ratio": 0.5}, {"stations": [1, 10], "ratio": 0.5}],
        "coupling": [
            {"station": 8, "torque_N_m": [0, 100], "twist_rad": [0, 0.05]},
            {"station": 10, "torque_N_m": [0, 100], "twist_rad": [0, 0.05]},
        ],
    }
    report = ab.torsion(crank_job(**tables), crank=inline_four).report
    behind, front = report["model"]["couplings"]
    assert behind["mean_N_m"] > 0.0
    assert front["mean_N_m"] == 0.0  # the engine's torque leaves at the other end
    assert [text for text in report["warnings"] if "coupling" in text] == [
        "coupling[1] is taken to carry all of the engine's mean torque, but the train divides at station 6;"
        " give coupling[1].mean_N_m"
    ]


def test_the_inertia_of_a_radial_is_that_of_its_mean_kinetic_energy() -> None:
    """By finite differences of the places of all pins; links are more than m_rot r² + ½ m_rec r²."""
    crank = ab.generate("single", segments=32).crank
    r, length, rho, link = crank.throws[0].crank_radius_mm, 140.0, 32.0, 108.0
    links = [
        {
            "cylinder": n + 2,
            "bank_deg": bank,
            "rod_length_mm": link,
            "knuckle_radius_mm": rho,
            "knuckle_angle_deg": bank,
        }
        for n, bank in enumerate((72.0, 144.0, 216.0, 288.0))
    ]
    base: Values = {
        "engine": {
            "rod_length_mm": length,
            "rotating_g": {"rod_share": 210.0},
            "reciprocating_g": {"piston": 260.0},
        },
        "balance": {"factor": 0.5, "grade": 16, "speed_rpm": 3600},
        "correction": {"method": "drill"},
    }
    layout = {"kind": "articulated", "bank_deg": 0.0}
    radial = {**base, "engine": {**base["engine"], "layout": layout, "throw": [{"number": 1, "link": links}]}}
    with_rods = sum(ab.torsion(radial, crank=crank).report["model"]["inertias_kg_mm2"])
    one = sum(ab.torsion(base, crank=crank).report["model"]["inertias_kg_mm2"])
    plain = (210.0 + 0.5 * 260.0) * r**2 / 1e3

    def places(angle: float) -> list[complex]:
        pin = r * complex(math.cos(angle), math.sin(angle))
        lean = math.asin(-pin.imag / length)
        found = [pin, complex(pin.real + length * math.cos(lean), 0.0)]
        for each in (72.0, 144.0, 216.0, 288.0):
            bank = math.radians(each)
            knuckle = pin + rho * complex(math.cos(lean + bank), math.sin(lean + bank))
            own = knuckle * complex(math.cos(bank), -math.sin(bank))
            wrist = own.real + math.sqrt(link**2 - own.imag**2)
            found += [knuckle, wrist * complex(math.cos(bank), math.sin(bank))]
        return found

    step, count = 1e-4, 360
    energy = 0.0
    for n in range(count):
        at = 2.0 * math.pi * n / count
        speeds = [(b - a) / (2.0 * step) for a, b in zip(places(at - step), places(at + step), strict=True)]
        energy += sum(mass * abs(speed) ** 2 for mass, speed in zip([210.0, 260.0] * 5, speeds, strict=True))
    assert with_rods - one + plain == pytest.approx(energy / count / 1e3, rel=1e-6)
    assert energy / count / 1e3 > 1.04 * 5 * plain


# --- what is refused ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ({"gear": [{"stations": [1, 1], "ratio": 2}]}, r"gear\[1\].stations is \[1, 1\]"),
        ({"gear": [{"stations": [1, 5], "ratio": 2}]}, r"gear\[1\].stations has 5; there are 2"),
        ({"gear": [{"stations": [1, 2], "ratio": 0}]}, r"gear\[1\].ratio is 0; must not be 0"),
        ({"gear": [{"stations": [1, 2], "ratio": 2}]}, "gear: station 2 turns 1 and 2 times as fast"),
        (
            {"branch": [{"from": 3, "inertia": [{"kg_mm2": 1}], "spring": [{"N_m_rad": 1}]}]},
            "from is 3; there",
        ),
        ({"branch": [{"from": 1, "inertia": [{"kg_mm2": 1}]}]}, r"and no \[\[gear\]\] drives its station 3"),
        (
            {"branch": [{"from": 1, "inertia": [{"kg_mm2": 1}], "spring": [{"N_m_rad": 1}] * 2}]},
            r"branch\[1\] has 2 spring tables; 1 inertias need 1, or 0",
        ),
        ({"coupling": [{"station": 2, "torque_N_m": [0, 1], "twist_rad": [0, 1]}]}, "no shaft leads from it"),
        ({"coupling": [{"station": 1, "torque_N_m": [0], "twist_rad": [0]}]}, "1 torques and 1 twists"),
        ({"coupling": [{"station": 1, "torque_N_m": [0, 1], "twist_rad": [1, 0]}]}, "expected increasing"),
        (
            {"damper": [{"station": 3, "kind": "ring", "inertia_kg_mm2": 1, "tune": True}]},
            "station is 3; there",
        ),
        (
            {"damper": [{"station": 1, "kind": "ring", "inertia_kg_mm2": 1}]},
            "N_m_s_rad is missing; give it, or",
        ),
        ({"torsion": {"damping_ratio": 1}}, "damping_ratio is 1; must be 0 or more and below 1"),
    ],
)
def test_bad_input_is_one_line(file: Values, words: str) -> None:
    with pytest.raises(JobError, match=words) as refused:
        train([1, 2], [5], **file)
    assert "\n" not in str(refused.value)


def test_mode_shapes_end_their_lines_at_gears() -> None:
    """Stations of a branch are no neighbours of the shaft that it is driven from; all have their names."""
    values = {
        "inertia": [{"name": name, "kg_mm2": 1000.0} for name in ("crank", "pinion")],
        "spring": [{"N_m_rad": 1e4}],
        "gear": [{"stations": [2, 3], "ratio": -0.5}],
        "branch": [
            {
                "from": 2,
                "inertia": [{"name": name, "kg_mm2": 2000.0} for name in ("wheel", "screw")],
                "spring": [{"N_m_rad": 2e4}],
            }
        ],
        "speed_rpm": 3000,
    }
    drawn = ab.torsion(values).plots()["torsion-modes"]["svg"].decode()
    for name in ("crank", "pinion", "wheel", "screw"):
        assert f">{name}<" in drawn
    moves = [path for path in re.findall(r'd="(M[^"]+)"', drawn) if path.count("M") == 2]
    assert moves  # one curve of two pieces
