"""Stress of fillets against sections cut by hand, closed forms and published numbers."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.command.main import main
from autobalance.crank_dynamics.strength import throw_stress
from autobalance.crank_dynamics.strength.fatigue import (
    Fatigue,
    FatigueMetal,
    FilletShape,
    fatigue_strength_MPa,
)
from autobalance.crank_dynamics.strength.verb import StrengthResult
from autobalance.crank_dynamics.torsion.from_job import sides_of_throws
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.errors import AutobalanceError, JobError, SolidError
from autobalance.solid.csg.region import Region
from tests.generated import preset_crank

STEEL = {"tensile_MPa": 800.0, "yield_MPa": 550.0}
BALANCE = {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000}
FILLETS = {"pin_fillet_mm": 2.0, "material": STEEL}


def job(speed: float = 6000.0, **tables: Any) -> ab.Job:
    return ab.Job.from_dict(
        {
            "engine": {
                "rod_length_mm": 104.0,
                "rotating_g": {"big_end": 134.0},
                "reciprocating_g": {"piston": 260.0},
            },
            "balance": {**BALANCE, "speed_rpm": speed},
            "correction": {"method": "drill"},
            "cycle": {"bore_mm": 76.8, "compression_ratio": 12.0, "heat_J": 600.0},
            "strength": FILLETS,
            **tables,
        }
    )


def single(name: str = "single") -> ab.Crank:
    return preset_crank(name, 48)


def test_bending_is_what_the_main_bearing_and_the_metal_do_below_the_web() -> None:
    """Reactions of `cycle`, and the centrifugal force of the metal summed section by section."""
    found = ab.strength(job(), crank=single())
    cycle, solid = found.analysis, single().measured.source.solid.moved(single().file_to_rotor)
    omega = 6000.0 * math.pi / 30.0
    main_z, web = float(single().main_journals[0].centre_mm[2]), single().webs[0]
    z_web = 0.5 * (web.z_min_mm + web.z_max_mm)
    low = float(solid.bounds[0, 2])
    nodes, weights = np.polynomial.legendre.leggauss(3)
    moment = 0.0
    for start, stop in pairwise(np.linspace(low, z_web, 81)):
        for node, weight in zip(nodes, weights, strict=True):
            z = float(0.5 * (start + stop) + 0.5 * (stop - start) * node)
            pull = 7.85e-3 * _first_moment_mm3(solid.section(z)) * omega**2 * 1e-6
            moment += 0.5 * (stop - start) * weight * pull * (z_web - z)
    turned = cycle.loads.main_in_crank_frame_n()[0][:, 0]
    wanted = moment - turned * (z_web - main_z)
    fillet = found.fillets[0]
    assert (fillet.throw, fillet.web, fillet.place) == (1, 1, "crankpin")
    assert fillet.bending_MPa * _modulus_mm3() == pytest.approx(wanted, abs=2e-3 * np.abs(wanted).max())
    assert found.report["fillets"][0]["nominal"]["bending_MPa"][1] == fillet.bending_MPa.max()


def _first_moment_mm3(region: Region) -> float:
    """Return ∫ x dA by the shoelace formula over the outlines."""
    total = 0.0
    for line in region.polygons:
        x, y = line.T
        after_x, after_y = np.roll(x, -1), np.roll(y, -1)
        total += float(((x + after_x) * (x * after_y - after_x * y)).sum()) / 6.0
    return total


def _modulus_mm3() -> float:
    side = sides_of_throws(single().measured)[0][0]
    return side.web_breadth_mm * side.web_thickness_mm**2 / 6.0


def test_torque_of_the_last_journal_is_the_engines() -> None:
    found = ab.strength(job(), crank=single())
    first, last = (each for each in found.fillets if each.place == "journal")
    diameter = single().main_journals[-1].diameter_mm
    polar = math.pi / 16.0 * diameter**3
    total = found.analysis.gas_n_m + found.analysis.inertia_n_m
    assert first.torsion_MPa == pytest.approx(0.0, abs=1e-9)
    assert last.torsion_MPa * polar * 1e-3 == pytest.approx(total, rel=1e-9, abs=1e-9 * np.abs(total).max())


def test_the_crankpin_is_twisted_by_the_first_main_on_the_lever_of_the_throw() -> None:
    """But for its oil hole, which pulls a little across."""
    found = ab.strength(job(), crank=single())
    pin = next(each for each in found.fillets if each.place == "crankpin")
    across = found.analysis.loads.main_in_crank_frame_n()[0][:, 1]  # of the crank on main 1
    throw = single().throws[0]
    polar = math.pi / 16.0 * throw.crankpin.diameter_mm**3
    wanted = throw.crank_radius_mm * across / polar
    assert pin.torsion_MPa == pytest.approx(wanted, rel=1e-6, abs=3e-3 * np.abs(wanted).max())


def test_torques_of_several_throws_add_up_towards_the_last_main() -> None:
    four = preset_crank("inline-4", 24)
    cycle = {"bore_mm": 84.0, "compression_ratio": 10.0, "heat_J": 1200.0, "firing_order": [1, 3, 4, 2]}
    engine = {"rod_length_mm": 140.0, "rotating_g": {"a": 400.0}, "reciprocating_g": {"b": 600.0}}
    found = ab.strength(job(cycle=cycle, engine=engine), crank=four)
    journals = [each for each in found.fillets if each.place == "journal"]
    total = found.analysis.gas_n_m + found.analysis.inertia_n_m
    polar = math.pi / 16.0 * four.main_journals[-1].diameter_mm ** 3 * 1e-3
    assert journals[-1].torsion_MPa * polar == pytest.approx(total, abs=1e-9 * np.abs(total).max())
    for before, after in zip(journals[1::2], journals[2::2], strict=False):  # both sides of a main
        assert before.torsion_MPa == pytest.approx(after.torsion_MPa, abs=1e-9)


def test_factors_of_a_crank_worked_out_by_hand() -> None:
    """IACS UR M53 Sec. 3 term by term: D = 200, DG = 200, E = 150, W = 80, B = 300, RH = RG = 12."""
    shape = FilletShape(200, 0, 200, 0, 150, 80, 300, 12, 12)
    s, w, b, r = 0.25, 0.4, 1.5, 0.06
    assert shape.ratios(12.0) == pytest.approx({"s": s, "w": w, "b": b, "r": r, "d_journal": 0, "d_pin": 0})
    overlap = -0.0634994 + 0.75 * 1.5574906 - 0.5625 * 0.5442667  # f(s, w), sums of powers of 0.4
    by_hand = 2.6914 * overlap * 2.1790 * 0.4**0.7171 * 1.003875 * 0.2081 * 0.06**-0.5231 * 0.9993 * 0.9978
    assert shape.crankpin.bending == pytest.approx(by_hand, rel=1e-6)
    torsion = 0.8 * 0.06 ** (-0.3220 + 0.1015 * 0.75) * 1.055575 * 0.4**-0.145
    assert shape.crankpin.torsion == pytest.approx(torsion, rel=1e-6)
    assert shape.journal.torsion == shape.crankpin.torsion  # of equal diameters and fillets


def test_no_factor_counts_less_than_half_a_diameter_apart() -> None:
    far, at_limit = (FilletShape(100, 0, 100, 0, radius, 50, 160, 6, 6) for radius in (190, 150))
    assert far.crankpin == at_limit.crankpin
    assert far.journal == at_limit.journal


def test_a_recess_never_makes_a_fillet_better() -> None:
    plain = FilletShape(100, 0, 100, 0, 160, 50, 160, 6, 6)  # s = −0.6: 1.8 + 3.2 s is below 0
    assert plain.s == pytest.approx(-0.6)
    within = FilletShape(100, 0, 100, 0, 90, 50, 160, 6, 6, 2.0, 2.0)
    flush = FilletShape(100, 0, 100, 0, 90, 50, 160, 6, 6)
    assert within.crankpin.bending / flush.crankpin.bending == pytest.approx(1 + 0.04 * (1.8 + 3.2 * 0.1))


def test_ranges_are_told() -> None:
    assert FilletShape(100, 0, 100, 0, 90, 50, 160, 6, 6).outside(6.0) == ()
    said = FilletShape(100, 0, 100, 0, 90, 10, 160, 1, 6).outside(1.0)
    assert [text.split(" is ")[0] for text in said] == [
        "web thickness over the crankpin",
        "fillet over the crankpin",
    ]


def test_fatigue_of_stress_in_step_and_out_of_step() -> None:
    """Bending and torsion of a sine each: in step they add up, a quarter apart the greater counts."""
    angle = np.linspace(0.0, 2.0 * math.pi, 721)
    metal = FatigueMetal(1000.0, 300.0, 700.0)
    bending = 40.0 + 90.0 * np.sin(angle)
    in_step = Fatigue.of(bending, 60.0 * np.sin(angle), metal).safety
    assert in_step.gough_pollard is not None
    assert in_step.gough_pollard == pytest.approx(300.0 / math.hypot(90.0, math.sqrt(3.0) * 60.0))
    assert in_step.goodman == pytest.approx(1.0 / (1.0 / in_step.gough_pollard + 40.0 / 1000.0))
    apart = Fatigue.of(bending, 60.0 * np.cos(angle), metal).safety
    assert apart.gough_pollard == pytest.approx(300.0 / (math.sqrt(3.0) * 60.0))
    assert apart.iacs == pytest.approx(in_step.iacs)  # of the equivalent of the half ranges
    pressed = Fatigue.of(
        bending - 200.0, 0.0 * angle, metal
    ).safety  # mean compression is no help and no harm
    assert pressed.goodman == pressed.gough_pollard == pytest.approx(300.0 / 90.0)
    assert pressed.yielding == pytest.approx(700.0 / 250.0)


def test_clockwise_engines_are_as_safe() -> None:
    mesh = crank_solid(PRESETS["single"], 48).mesh
    mirrored = ab.crank_from_mesh(
        np.array(mesh.vertices) * [1, -1, 1], np.array(mesh.triangles)[:, ::-1], density_kg_m3=7850
    )
    engine = {**job().raw["engine"], "turns": "cw"}
    here, there = ab.strength(job(), crank=single()), ab.strength(job(engine=engine), crank=mirrored)
    for one, other in zip(here.report["fillets"], there.report["fillets"], strict=True):
        assert one["safety"] == pytest.approx(other["safety"], rel=1e-6)
        assert one["nominal"]["torsion_MPa"] == pytest.approx(other["nominal"]["torsion_MPa"], rel=1e-6)


def test_given_factors_and_strength_are_taken() -> None:
    given = {
        **FILLETS,
        "factor": {"bending": 3.0, "torsion": 2.0},
        "material": {**STEEL, "fatigue_MPa": 250.0},
    }
    (row, *_) = ab.strength(job(strength=given), crank=single()).report["fillets"]
    assert row["factors"] == {"bending": 3.0, "shear": 0.0, "torsion": 2.0}
    assert row["fatigue_strength_MPa"] == 250.0
    low, high = row["nominal"]["bending_MPa"]
    assert row["stress"]["bending_alternating_MPa"] == pytest.approx(3.0 * 0.5 * (high - low))
    assert row["outside_of_range"] == []


def test_no_fatigue_strength_is_by_size_and_metal() -> None:
    said = ab.strength(
        job(strength={**FILLETS, "material": {**STEEL, "fatigue_MPa": "none"}}), crank=single()
    )
    (row, *_) = said.report["fillets"]
    pin = single().throws[0].crankpin.diameter_mm
    assert row["fatigue_strength_MPa"] == pytest.approx(fatigue_strength_MPa(800.0, pin, 2.0))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"pin_fillet_mm": 0.0}, "strength.pin_fillet_mm is 0; must be > 0"),
        ({"material": {}}, "strength.material.tensile_MPa is missing"),
        (
            {"material": {**STEEL, "yield_MPa": 900.0}},
            "strength.material.yield_MPa is 900, above tensile_MPa",
        ),
        ({"factor": "peterson"}, "strength.factor is 'peterson'"),
        ({"factor": {"bending": 0.5, "torsion": 1.5}}, "strength.factor.bending is 0.5; must be ≥ 1"),
        ({"fillet_mm": 2.0}, "strength.fillet_mm is an unknown key"),
    ],
)
def test_impossible_tables_are_refused(change: dict[str, Any], said: str) -> None:
    with pytest.raises(JobError) as caught:
        job(strength={**FILLETS, **change})
    assert said in caught.value.lines[0]


def test_a_fillet_larger_than_its_web_is_refused() -> None:
    with pytest.raises(JobError, match=r"strength.pin_fillet_mm is 40; web 1 is 14 mm thick"):
        ab.strength(job(strength={**FILLETS, "pin_fillet_mm": 40.0}), crank=single())


def test_what_cannot_be_meshed_is_said_beside_the_formulas(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> None:
        raise SolidError("the mesher did not end within 90 s")

    monkeypatch.setattr(throw_stress, "throw_by_elements", fails)
    report = ab.strength(job(), crank=single(), fem=True).report
    assert report["warnings"][-1].endswith("only by formulas: the mesher did not end within 90 s")
    assert report["fem"] is None
    assert report["fillets"] == ab.strength(job(), crank=single()).report["fillets"]


def test_a_job_without_the_table_is_refused() -> None:
    values = {key: table for key, table in job().raw.items() if key != "strength"}
    with pytest.raises(JobError, match=r"\[strength\] is missing; it needs pin_fillet_mm"):
        ab.strength(ab.Job.from_dict(values), crank=single())


def balanced(folder: Path) -> Path:

    single().write(folder / "crank.stl")
    text = json.loads(json.dumps(job().raw))
    text["crankshaft"] = {"file": str(folder / "crank.stl"), "unit": "mm", "density_kg_m3": 7850.0}
    made = ab.balance(ab.Job.from_dict(text))
    made.write(folder / "out", only=("json",))
    return folder / "out" / "report.json"


def test_a_report_is_told_before_and_after_its_cuts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before: as the crank's own job says; after: as the corrected solid's own moments say."""
    report = balanced(tmp_path)
    found = ab.strength(report)
    alone = ab.strength(job(), crank=single())
    for told, own in zip(found.report["before"]["fillets"], alone.report["fillets"], strict=True):
        assert told["safety"] == pytest.approx(own["safety"], rel=1e-4)
    rows = zip(found.report["before"]["fillets"], found.report["fillets"], strict=True)
    assert any(a["nominal"]["bending_MPa"] != pytest.approx(b["nominal"]["bending_MPa"]) for a, b in rows)
    assert main(["strength", str(report)]) == 0
    assert "Before the cuts" in capsys.readouterr().out
    with pytest.raises(AutobalanceError, match="neither --set nor another crank"):
        ab.strength(report, crank=single())


def test_plots_show_stress_and_safety() -> None:
    made: StrengthResult = ab.strength(job(), crank=single())
    assert set(made.plots()) == {"fillet-stress", "crankpin-safety", "journal-safety"}


# --- torsional vibration and the criterion of the rule ------------------------------------------------------


def test_torsional_vibration_comes_on_top_of_statics() -> None:
    """A single with a flywheel near the resonance of an order, against its own three-station chain.

    Torque of the throw as an even series, by fast Fourier transform, on hand-made matrices of the inertias
    and springs that `torsion` lists.
    """
    flywheel, zeta = 40000.0, 0.01
    cycle = {**job().raw["cycle"], "flywheel_kg_mm2": flywheel}
    model = ab.torsion(job(cycle=cycle), crank=single()).report
    first_hz = model["natural_frequencies_hz"][0]
    order = next(k for k in np.arange(0.5, 12.5, 0.5) if first_hz * 60.0 / k < 9000.0)
    speed = float(first_hz * 60.0 / order * 1.01)
    vibrating = job(speed=speed, cycle=cycle, torsion={"damping_ratio": zeta})
    found = ab.strength(vibrating, crank=single())
    grid = found.analysis.grid
    torque = grid.even(found.analysis.gas_n_m + found.analysis.inertia_n_m)
    inertia = np.array(model["model"]["inertias_kg_mm2"]) * 1e-6
    k1, k2 = model["model"]["stiffness_N_m_rad"]
    stiff = np.array([[k1, -k1, 0.0], [-k1, k1 + k2, -k2], [0.0, -k2, k2]])
    root = np.sqrt(inertia)
    square, vectors = np.linalg.eigh(stiff / np.outer(root, root))
    shapes = vectors / root[:, None]
    omega = np.sqrt(np.maximum(square, 0.0))
    omega[0] = 0.0
    spectrum = np.fft.rfft(torque) * 2.0 / len(torque)
    last, pin = np.zeros(len(torque)), np.zeros(len(torque))
    for n in range(1, 25):  # orders ½ to 12 of four strokes
        w = 0.5 * n * speed * math.pi / 30.0
        modal = shapes[1] * spectrum[n] / (omega**2 - w**2 + 2j * zeta * omega * w)
        angle = shapes @ modal
        turn = np.exp(1j * 0.5 * n * grid.even_rad)
        behind = k2 * (angle[1] - angle[2])
        before = k1 * (angle[0] - angle[1])
        last += ((behind - spectrum[n]) * turn).real
        pin += (0.5 * (before + behind - spectrum[n]) * turn).real
    still = ab.strength(job(speed=speed, cycle=cycle), crank=single())
    rows = {f"{each.place} {each.web}": each for each in found.fillets}
    rest = {f"{each.place} {each.web}": each for each in still.fillets}
    bore = sides_of_throws(single().measured)[0][0].pin_bore_mm
    for key, added, diameter, inner in (
        ("journal 2", last, single().main_journals[-1].diameter_mm, 0.0),
        ("crankpin 1", pin, single().throws[0].crankpin.diameter_mm, bore),
    ):
        stress = added / (math.pi / 16.0 * (diameter**4 - inner**4) / diameter) * 1e3
        told = grid.even(rows[key].torsion_MPa - rest[key].torsion_MPa)
        assert told == pytest.approx(stress, abs=5e-5 * np.abs(stress).max())  # the gas jumps
        assert np.abs(stress).max() > 2.0
    # the figures of docs/theory.md: nominal torsion of the journal's fillet, and the rule's Q
    figures = [
        (row["stress"]["torsion_alternating_MPa"], row["m53"]["factor"])
        for each in (still, found)
        for row in each.report["fillets"]
        if (row["place"], row["web"]) == ("journal", 2)
    ]
    assert figures == [pytest.approx((63.6, 1.31), rel=5e-3), pytest.approx((84.9, 1.24), rel=5e-3)]
    # nothing else changes, and both say what they count
    assert rows["journal 1"].bending_MPa == pytest.approx(rest["journal 1"].bending_MPa)
    counted, left_out = (each.report["torsional_vibration"] for each in (found, still))
    assert counted["counted"] is True
    assert counted["greatest_added_N_m"] == pytest.approx(np.abs(last).max(), rel=1e-3)
    assert left_out == {"counted": False, "greatest_added_N_m": None}
    assert "torsional vibration is left out" in still.report["warnings"][-1]
    assert "WITHOUT torsional vibration" in still.text()
    assert not any("torsional vibration" in text for text in found.report["warnings"])
    assert still.report["left_out"][0] == "torsional vibration"
    assert "torsional vibration" not in found.report["left_out"]


def test_a_rigid_crank_on_a_heavy_flywheel_has_statics_alone() -> None:
    """Limits G → ∞ and flywheel → ∞: nothing swings, each journal carries the sum of the throws before it."""
    cycle = {**job().raw["cycle"], "flywheel_kg_mm2": 1e9}
    added = [
        ab.strength(
            job(cycle=cycle, torsion={"damping_ratio": 0.01, "shear_modulus_gpa": modulus}), crank=single()
        ).report["torsional_vibration"]["greatest_added_N_m"]
        for modulus in (80.0, 8e5, 8e8)
    ]
    assert added[0] > 10.0
    assert added[1] < 1e-3 * added[0]
    assert added[2] < 1e-4 * added[0]  # what turns the flywheel itself is left


def test_over_the_speeds_the_least_safety_is_that_of_each_speed_alone() -> None:
    vibrating = job(cycle={**job().raw["cycle"], "flywheel_kg_mm2": 40000.0}, torsion={"damping_ratio": 0.01})
    swept = ab.strength(vibrating, crank=single(), sweep_rpm=[4000.0, 7000.0])
    assert "vibration adds" in swept.text()
    assert "safety-over-speed" in swept.plots()
    for row in swept.report["sweep"]:
        alone = ab.strength(vibrating, crank=single(), speed_rpm=row["speed_rpm"]).report
        assert row["least"] == alone["least"]
        assert row["torsional_vibration"] == alone["torsional_vibration"]
        assert row["m53_factor"] == min(each["m53"]["factor"] for each in alone["fillets"])


def test_the_rules_criterion_adds_ten_megapascals_of_bending() -> None:
    """IACS UR M53: Q = σ_DW/√((σ_B + 10)² + 3 τ²) ≥ 1.15 for trunk pistons."""
    for row in ab.strength(job(), crank=single()).report["fillets"]:
        bending, torsion = (row["stress"][f"{name}_alternating_MPa"] for name in ("bending", "torsion"))
        own = math.sqrt((bending + 10.0) ** 2 + 3.0 * torsion**2)
        assert row["m53"]["equivalent_MPa"] == pytest.approx(own)
        assert row["m53"]["factor"] == pytest.approx(row["fatigue_strength_MPa"] / own)
        assert row["m53"]["met"] is (row["m53"]["factor"] >= 1.15)
        assert row["m53"]["wanted"] == 1.15
    soft = {**FILLETS, "material": {**STEEL, "fatigue_MPa": 60.0}}
    report = ab.strength(job(strength=soft), crank=single())
    assert not all(row["m53"]["met"] for row in report.report["fillets"])
    assert "< 1.15" in report.text()


def test_vibration_without_damping_at_a_resonance_is_said() -> None:
    """Without damping an amplitude near a critical speed is any number: it is left out, and said."""
    report = ab.strength(job(torsion={"damping_ratio": 0.0}), crank=single()).report
    assert report["torsional_vibration"] == {"counted": False, "greatest_added_N_m": None}
    assert "has no limit without damping" in report["warnings"][-1]
    damped = ab.strength(job(torsion={}), crank=single()).report
    assert damped["torsional_vibration"]["counted"] is True
