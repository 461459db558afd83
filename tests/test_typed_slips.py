"""Slips of typing that a program could believe: each is said, and what is right is not."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.errors import JobError
from tests import jobs
from tests.generated import generated_crank, preset_crank

pytestmark = pytest.mark.usefixtures("cranks_read_once")

GAS = {"bore_mm": 80.0, "compression_ratio": 10.0, "heat_J": 900.0}


def preset(name: str) -> ab.Crank:
    return preset_crank(name)


def job(**tables: Any) -> dict[str, Any]:
    engine = {
        "rod_length_mm": 140.0,
        "rods_per_throw": 1,
        "rotating_g": {"big_end": 251.0},
        "reciprocating_g": {"piston": 221.0, "wrist_pin": 60.0, "rings_clips_oil": 19.0},
        **tables.pop("engine", {}),
    }
    balance = {"factor": 0.3, "grade": 6.3, "speed_rpm": 11000, **tables.pop("balance", {})}
    return {
        "engine": {key: value for key, value in engine.items() if value is not None},
        "balance": balance,
        "correction": {"method": "drill"},
        **tables,
    }


def warned(name: str, **tables: Any) -> list[str]:
    return list(ab.shafts(job(**tables), preset(name)).report["warnings"])


def test_a_job_without_slips_is_not_doubted() -> None:
    assert warned("single") == []
    assert warned("v8-crossplane", engine={"rods_per_throw": 2, "layout": {"bank_deg": [-45.0, 45.0]}}) == []
    assert warned("inline-4", engine={"rods_per_throw": None}) == []


def test_a_speed_in_thousands_is_asked_about() -> None:
    """11.000 is eleven in TOML, and eleven thousand in half of Europe."""
    slow, wide = warned("single", balance={"speed_rpm": 11.000})
    assert "balance.speed_rpm is 11; an engine with connecting rods turns at 300 or more" in slow
    assert "is it in thousands (11000)?" in slow
    # G 6.3 of 1849 g at 11 rpm, over the reciprocating mass on its radius, twice
    crank = preset("single")
    permissible = crank.mass_g * 6.3 / (11.0 * 3.14159265358979 / 30.0)
    spans = 2.0 * permissible / (300.0 * crank.throws[0].crank_radius_mm)
    assert f"the permissible unbalance spans {spans:.2g} of balance factor" in wide
    assert warned("single", balance={"speed_rpm": 299})[0].endswith("grows as the speed falls")
    assert not any("speed_rpm" in text for text in warned("single", balance={"speed_rpm": 301, "grade": 0.4}))


@pytest.mark.parametrize(("grade", "is_wide"), [(30.0, False), (80.0, True)])
def test_a_wide_tolerance_says_how_many_factors_it_spans(grade: float, is_wide: bool) -> None:
    crank = preset("single")
    permissible = crank.mass_g * grade / (11000.0 * 3.14159265358979 / 30.0)
    spans = 2.0 * permissible / (300.0 * crank.throws[0].crank_radius_mm)
    assert (spans > 0.02) is is_wide
    told = warned("single", balance={"grade": grade})
    assert told == [] if not is_wide else f"spans {spans:.2g} of balance factor" in told[0]


def test_one_part_in_kilograms_is_asked_about() -> None:
    parts = {"piston": 0.221, "wrist_pin": 60.0, "rings_clips_oil": 19.0}
    (told,) = warned("single", engine={"reciprocating_g": parts})
    assert (
        "engine.reciprocating_g.piston is 0.221 g beside parts of 19 to 251 g; is it in kg (221 g)?" in told
    )
    light = {"piston": 221.0, "wrist_pin": 60.0, "circlips": 0.4}
    assert warned("single", engine={"reciprocating_g": light}) == []
    by_unit = {"piston": {"kg": 0.221}, "wrist_pin": 60.0, "rings_clips_oil": 19.0}
    assert warned("single", engine={"reciprocating_g": by_unit}) == []


@pytest.mark.parametrize("name", ["v8-crossplane", "v12-60", "v-twin-45"])
def test_pins_for_two_rods_ask_for_their_number(name: str) -> None:
    pin = preset(name).throws[0].crankpin
    told = [text for text in warned(name, engine={"rods_per_throw": None}) if "rods_per_throw" in text]
    assert len(told) == 1
    assert f"{pin.width_mm:.4g} mm wide and {pin.diameter_mm:.4g} mm thick, wide enough for two" in told[0]
    assert not any("rods_per_throw" in text for text in warned(name, engine={"rods_per_throw": 1}))


@pytest.mark.parametrize(
    ("name", "hint", "rods"),
    [
        ("v8-crossplane", "0.5 for vee engines", True),
        ("v-twin-45", "0.5 for vee engines", True),
        ("v8-flatplane", "0: its throws cancel", True),
        ("inline-4", "0: its throws cancel", False),
        ("inline-3", "0.5: its throws leave a force or a couple", False),
        ("v6-60", "0.5: its throws leave a force or a couple", False),
        ("single", "0.2, say: it has 0.26 to 0.56 with usual parts", False),
    ],
)
def test_init_hints_follow_the_crank(tmp_path: Path, name: str, hint: str, rods: bool) -> None:
    path = tmp_path / "c.stl"
    jobs.write_stl(path, generated_crank(name, segments=None if name == "single" else 32).soup)
    made = ab.init(path, unit="mm", density_kg_m3=7850.0, file=tmp_path / "job.toml")
    text = made.data.decode()
    line = next(each for each in text.splitlines() if "factor" in each and "FILL IN" in each)
    assert hint in text[text.index(line) :].replace("\n#", "")
    assert ("engine.rods_per_throw" in made.report["fill_in"]) is rods


def test_the_hint_of_a_single_does_not_lead_above_its_tolerance(tmp_path: Path) -> None:
    """The factor named, with ordinary parts of a stroke of 58 mm, is met by taking metal off."""
    parts = {"rotating_g": {"big_end": 251.0}, "reciprocating_g": {"piston": 384.0}}
    values = job(engine=parts, balance={"factor": 0.2})
    values["correction"] = {"method": "drill", "drill": {"diameters_mm": [4.0, 6.0, 8.0]}}
    low = ab.balance(values, crank=preset("single")).report
    assert low["balance_factor"]["initial"] == pytest.approx(0.25, abs=0.01)
    assert low["outcome"] in ("within_tolerance", "already_within_tolerance")


# --- firing -------------------------------------------------------------------------------------------------


def cycle(name: str, order: list[int], **engine: Any) -> dict[str, Any]:
    values = job(engine=engine, cycle={**GAS, "firing_order": order})
    return ab.cycle(values, crank=preset(name)).report


def test_two_cylinders_that_fire_at_once_are_named() -> None:
    """An in-line four whose second cylinder stands where the first's partner should."""
    report = cycle("inline-4", [1, 4, 3, 2])
    (told,) = [text for text in report["warnings"] if "firing_order" in text]
    assert "cycle.firing_order [1, 4, 3, 2]" in told
    assert told.endswith("fires evenly")
    assert not any("firing_order" in text for text in cycle("inline-4", [1, 3, 4, 2])["warnings"])
    at_once = ab.cycle(
        job(cycle={**GAS, "firing_order": [1, 2]}, engine={}), crank=preset("parallel-twin-360")
    ).report
    assert at_once["firing_deg"] == [0.0, 360.0]


def test_a_pair_at_once_and_no_minus_zero() -> None:
    """A split-pin V6 with the order counted along the crank: 1 and 2 come together."""
    banks = [{"number": n, "bank_deg": [-30.0 if n % 2 else 30.0]} for n in range(1, 7)]
    report = cycle("v6-60", [1, 2, 3, 4, 5, 6], rods_per_throw=1, throw=banks)
    angles = report["firing_deg"]
    assert not any(str(each).startswith("-") for each in angles)
    spread = sorted(angles)
    pairs = [(a, b) for a in range(1, 7) for b in range(a + 1, 7) if abs(angles[a - 1] - angles[b - 1]) < 1.0]
    told = [text for text in report["warnings"] if "firing_order" in text]
    if pairs:
        assert f"cylinders {pairs[0][0]} and {pairs[0][1]}" in told[0]
    even = all(abs(b - a - 120.0) < 1.0 for a, b in pairwise(spread))
    assert bool(told) is not even


@pytest.mark.parametrize(("turns", "order"), [("ccw", [1, 2, 3]), ("cw", [1, 3, 2])])
def test_an_order_that_is_even_only_in_the_other_sense_is_refused(turns: str, order: list[int]) -> None:
    """An in-line three fires at 0, 120, 600° against 0, 240, 480°: both orders that fit are named."""
    other = "cw" if turns == "ccw" else "ccw"
    with pytest.raises(JobError) as refused:
        cycle("inline-3", order, turns=turns)
    said = str(refused.value)
    assert f"cycle.firing_order is {order}, whose intervals are " in said
    gaps = said.partition("whose intervals are ")[2].partition("°")[0].split(", ")
    assert sorted(map(float, gaps)) == [120.0, 120.0, 480.0]
    assert f'evenly with engine.turns = "{other}"' in said
    backwards = [order[0], *reversed(order[1:])]
    assert f'and {backwards} with "{turns}"' in said
    report = cycle("inline-3", backwards, turns=turns)
    assert sorted(report["firing_deg"]) == pytest.approx([0.0, 240.0, 480.0], abs=1e-4)
    assert sorted(cycle("inline-3", order, turns=other)["firing_deg"]) == pytest.approx(
        [0, 240, 480], abs=1e-4
    )


def test_an_uneven_order_that_is_meant_is_given_by_angles() -> None:
    even = cycle("inline-3", [1, 3, 2])["firing_deg"]
    meant = [even[0], even[1] - 360.0 if even[1] >= 360.0 else even[1] + 360.0, even[2]]
    values = job(cycle={**GAS, "firing_deg": meant})
    assert ab.cycle(values, crank=preset("inline-3")).report["firing_deg"] == pytest.approx(meant)


def test_the_command_line_says_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    preset("single").write(tmp_path / "crank.stl")
    text = {
        "crankshaft.file": "crank.stl", "crankshaft.unit": "mm", "crankshaft.density_kg_m3": 7850.0,
        "engine.rotating_g.big_end": 251.0, "engine.reciprocating_g.piston": 384.0,
        "balance.factor": 0.55, "balance.grade": 6.3, "balance.speed_rpm": 11,
        "correction.method": "drill",
    }  # fmt: skip
    lines = [f"{key} = {value!r}".replace("'", '"') for key, value in text.items()]
    (tmp_path / "job.toml").write_text("\n".join(lines), "utf-8")
    assert jobs.run("balance", tmp_path / "job.toml", "-o", tmp_path / "out", "--no-report") == 0
    error = capsys.readouterr()
    assert "is it in thousands (11000)?" in error.err + error.out
