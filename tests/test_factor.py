"""The balance factor that a crank has, and what other factors leave and cost."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.errors import UsageError
from tests import jobs

WEIGHTS: dict[str, Any] = {"rotating_g": 134.04, "reciprocating_g": 261.5, "crankpin_g": 114.65}
SPEED = 15200.0 * np.pi / 30.0
RADIUS_MM, ROD_MM = 26.9, 104.0


def candidates(report: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {each["name"]: each for each in report["candidates"]}


def greatest_force_n(factor: float) -> float:
    """Return the greatest shaking force of the single with two masses, from the piston's exact motion."""
    angle = np.linspace(0.0, 2.0 * np.pi, 7201)
    ratio = RADIUS_MM / ROD_MM
    c, s = np.cos(angle), np.sin(angle)
    root = np.sqrt(1.0 - (ratio * s) ** 2)
    second = ratio * (np.cos(2.0 * angle) / root + ratio**2 * (s * c) ** 2 / root**3)
    along = c + second - factor * c
    across = -factor * s
    size = WEIGHTS["reciprocating_g"] * RADIUS_MM * 1e-6 * SPEED**2
    return float(size * np.hypot(along, across).max())


@pytest.fixture
def crank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    jobs.bundled_job(tmp_path).rename(tmp_path / "by-hand.toml")
    return Path("crank.stl")


def test_candidates_of_a_crank_have_forces_of_the_exact_motion(crank: Path) -> None:
    more: dict[str, Any] = {"unit": "mm", "material": "steel", "speed_rpm": 15200, "rod_length_mm": ROD_MM}
    report = ab.factor(crank, **WEIGHTS, **more, factors=[0.28]).report
    found = candidates(report)
    assert list(found) == ["present", "half", "least_peak", "given"]
    assert report["present"] == pytest.approx(0.818, abs=2e-3)
    assert (report["layout"], report["motion"], report["reason"]) == ("single", "exact", None)
    for name in ("half", "least_peak", "given"):
        each = found[name]
        assert each["greatest_N"] == pytest.approx(greatest_force_n(each["factor"]), rel=1e-4)
        assert each["mains_N"] == pytest.approx([0.5 * each["greatest_N"]] * 2, rel=1e-3)
        bob = 134.04 + 114.65 + each["factor"] * 261.5
        assert each["bob_weights_g"] == pytest.approx([bob])
        assert each["reach"] is None
    best = found["least_peak"]["factor"]
    assert all(greatest_force_n(best) <= greatest_force_n(best + step) + 0.5 for step in (-0.01, 0.01))


def test_reach_is_what_balance_then_takes(crank: Path) -> None:
    result = ab.factor("by-hand.toml", factors=[0.5])
    given = [each for each in result.report["candidates"] if each["name"] == "given"]
    assert [each["factor"] for each in given] == [0.28, 0.5]
    done = ab.balance("by-hand.toml")
    reach = given[0]["reach"]
    assert reach["outcome"] == done.outcome
    assert reach["cuts"] == len(done.corrections)
    assert reach["metal_g"] == pytest.approx(sum(cut.removed_mass_g for cut in done.corrections), rel=1e-3)
    assert reach["deepest_mm"] == pytest.approx(max(cut.depth_mm for cut in done.corrections), rel=1e-3)
    present = candidates(result.report)["present"]["reach"]
    assert (present["outcome"], present["cuts"], present["metal_g"]) == ("already_within_tolerance", 0, 0.0)
    assert all(len(line) <= 80 for line in result.text().splitlines())
    assert result.text().splitlines()[0].startswith("crank.stl: balance factor 0.8")


def test_a_job_without_factor_grade_and_speed_is_enough(crank: Path) -> None:
    text = Path("by-hand.toml").read_text("utf-8").partition("[balance]")[0]
    old = "[original.rotating_g]\na = 134.04\n[original.reciprocating_g]\np = 242.7\n"
    Path("open.toml").write_text(f"{text}\n{old}[original.crankpin_g]\ncrankpin = 114.65\n", "utf-8")
    assert jobs.run("factor", "open.toml", "--json", "f.json") == 0
    report = json.loads(Path("f.json").read_text("utf-8"))
    found = candidates(report)
    assert found["maker's"]["factor"] == pytest.approx(0.8816, abs=2e-3)
    assert report["speed_rpm"] == pytest.approx(1000.0)
    assert report["motion"] == "first_order"
    assert any("rod_length_mm" in text for text in report["warnings"])


def test_throws_that_cancel_have_none_and_say_why() -> None:
    crank = ab.generate("inline-4", segments=24).crank
    engine = {"layout": {"bank_deg": [0.0]}, "rotating_g": {"a": 300.0}, "reciprocating_g": {"b": 400.0}}
    found = ab.factor({"engine": {**engine, "rod_length_mm": 140.0}}, crank)
    assert found.present is None
    assert found.report["reason"].startswith("the throws cancel each other's force")
    assert found.report["layout"] == "in-line 4"
    assert "no balance factor" in found.text()
    assert found.exit_code == 0


def test_impossible_factors_are_wrong_use(crank: Path) -> None:
    with pytest.raises(UsageError, match=r"--factors is '1.5'; each must be 0 to 1"):
        ab.factor("by-hand.toml", factors=[1.5])
