"""Cranks whose counterweights are too light: by how much, and what put on them would do, each tried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from autobalance import correction
from autobalance.balancing import offers
from autobalance.balancing.comparison import compare
from autobalance.balancing.loop import Result, balance
from autobalance.balancing.offers import workpiece
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction.holes.drills import DrillLimits
from autobalance.planning.relaxation import Attempt
from autobalance.planning.too_light import too_light_g_mm, too_light_text
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from tests.cranks import Shape, planned_crank
from tests.geometry.test_plans import judge, rotor

DRILL = DrillLimits(diameters_mm=(8.0, 12.0))


def light(heavy_g_mm: float = 2000.0) -> Rotor:
    solid, anatomy = planned_crank(Shape(web_width=24.0, pin_width=50.0, segments=24))
    return rotor(solid, anatomy, [heavy_g_mm, 0.0])


@pytest.fixture(scope="module")
def refused() -> Result:
    made = light()
    return balance(made, judge(made), [DRILL])


def test_it_is_said_by_how_much_and_nothing_is_cut(refused: Result) -> None:
    assert refused.outcome == "above_tolerance"
    assert refused.corrections == ()
    assert refused.reason is not None
    assert "the counterweights are too light by 2 g·m, 1 g·m at each end" in refused.reason
    assert "none of the available cuts acts" not in refused.reason


def limits_of(result: Result, kind: str) -> tuple[str, list[correction.Limits]]:
    """The limits that a relaxation's keys make, and what it says."""
    for each in result.relaxations:
        keys = {change.key: change.proposed for change in each.changes}
        if kind in keys.get("correction.method", ()):
            table = f"correction.{kind}."
            own = {key.removeprefix(table): value for key, value in keys.items() if key.startswith(table)}
            others = [DRILL] if "drill" in keys["correction.method"] else []
            return each.text, [*others, correction.KINDS[kind].limits(**own)]
    raise AssertionError(kind)


@pytest.mark.parametrize("kind", ["add", "slug"])
def test_what_is_proposed_balances_the_crank(refused: Result, kind: str) -> None:
    text, limits = limits_of(refused, kind)
    made = light()
    from autobalance.crank.faces import find_faces

    with_faces = replace(made, faces=tuple(find_faces(made.solid.mesh, made.anatomy)))
    result = balance(with_faces, judge(made), limits, advise=False)
    assert result.outcome == "within_tolerance"
    assert text in str(refused.reason)
    if kind == "add":
        grams = sum(each.change.mass_g for each in result.corrections) / 2.0
        assert "on each of 2 counterweights" in text
        assert "mm thicker (method add)" in text
        assert float(text.split(" g ")[0].split(" to ")[0]) == pytest.approx(grams, rel=0.1)
    else:
        slugs = [each for each in result.corrections if each.kind == "slug"]
        assert text.startswith(f"{len(slugs)} slugs of ")


def test_only_a_crank_heavy_at_its_pins_is_too_light() -> None:
    for heavy, expected in ((2000.0, True), (-2000.0, False)):
        made = light(heavy)
        work = workpiece(made, judge(made), Unbalance.of(made.moments + made.loads))
        found = too_light_g_mm(work)
        assert (found is not None) == expected
        if found is not None:
            assert found == pytest.approx(2000.0, rel=1e-6)
    assert too_light_text(21000.0).startswith("the counterweights are too light by 21 g·m, 10.5 g·m at each")
    assert "210 g·mm" in too_light_text(210.0)


def test_nothing_is_cut_for_a_gain_of_a_few_per_cent() -> None:
    solid, anatomy = planned_crank(Shape(segments=32))
    made = rotor(solid, anatomy, [-20000.0, 0.0])
    small = DrillLimits(diameters_mm=(8.0,), max_depth_mm=6.0)
    cut = balance(made, judge(made), [small], advise=False)
    assert cut.corrections
    gain = 1.0 - cut.residual.magnitude_g_mm / 20000.0
    assert 0.01 < gain < 0.2
    left = balance(made, judge(made), [small], advise=False, min_gain=0.2)
    assert left.corrections == ()
    assert left.outcome == "above_tolerance"
    assert "nothing is cut (min_gain_percent = 20)" in str(left.reason)
    asked = balance(made, judge(made), [small], advise=False, min_gain=0.5 * gain)
    assert len(asked.corrections) == len(cut.corrections)


def test_compare_lists_no_mix_that_uses_one_of_its_kinds_only() -> None:
    solid, anatomy = planned_crank(Shape(segments=32))
    made = rotor(solid, anatomy, [-300.0, 0.0])
    limits = {"drill": DrillLimits(diameters_mm=(8.0,)), "mill": correction.KINDS["mill"].limits()}
    limits["turn"] = correction.KINDS["turn"].limits()
    rows = compare(made, judge(made), limits, mixes=[("drill",), ("drill", "mill")])
    assert [row.name for row in rows] == ["drill"]
    heavy_pin = rotor(solid, anatomy, [3000.0, 0.0])
    rows = compare(heavy_pin, judge(made), limits, mixes=[("drill",), ("turn",)])
    assert all("too light by 3 g·m" in str(row.reason) for row in rows)


def test_the_vector_of_what_is_missing_is_the_sum_of_both_ends() -> None:
    made = light(1500.0)
    ends = workpiece(made, judge(made), Unbalance.of(made.moments + made.loads)).heavy_at
    assert sum(float(np.linalg.norm(vector)) for _, vector in ends) == pytest.approx(1500.0, rel=1e-6)


PER_FACTOR_G_MM = 20_000.0


def with_factor(made: Rotor, factor: float) -> Rotor:
    """The crank with a piston that pulls along its throw, half of it at each end, at a balance factor."""
    ends = made.anatomy.webs[0].z_min_mm, made.anatomy.webs[-1].z_max_mm
    per = [Moments.point(0.5 * PER_FACTOR_G_MM, np.array([1.0, 0.0, z])) for z in ends]
    more = [Moments.point(0.5 * PER_FACTOR_G_MM * (factor - 0.5), np.array([1.0, 0.0, z])) for z in ends]
    loads, per_factor = sum(more, made.loads), sum(per[1:], per[0])
    return replace(made, loads=loads, loads_per_factor=per_factor, factor=factor)


@pytest.fixture
def factors_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out what else would suffice, which takes longer than all the rest."""
    for name in ("relaxations", "heavier"):
        monkeypatch.setattr(offers, name, lambda *_, **__: ())


@pytest.mark.usefixtures("factors_alone")
@pytest.mark.parametrize("heavy_g_mm", [2000.0, -9000.0])
def test_a_factor_is_tried_before_it_is_named(heavy_g_mm: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """2000: the crank as it is, at 0.4; -9000: with all that the drill may take, above 0.5."""
    made = with_factor(light(heavy_g_mm), 0.5)
    drill = replace(DRILL, max_holes=1)
    refused = balance(made, judge(made), [drill])
    (way,) = [each for each in refused.relaxations if each.changes[0].key == "balance.factor"]
    assert way.tried
    assert refused.reason is not None
    assert way.text in refused.reason
    if heavy_g_mm > 0.0:
        assert way.changes[0].proposed == pytest.approx(0.4, abs=1e-6)
        assert (way.metal_g, way.text) == (0.0, "a balance factor of 0.4000 can be reached as it is")
    at_that = with_factor(light(heavy_g_mm), float(way.changes[0].proposed))
    assert balance(at_that, judge(at_that), [drill]).outcome != "above_tolerance"
    if heavy_g_mm < 0.0:
        assert (way.metal_g or 0.0) > 1.0
        monkeypatch.setattr(Attempt, "offer_with", lambda *_, **__: None)  # a plan anew that fails
        again = balance(made, judge(made), [drill])
        assert not any(each.changes[0].key == "balance.factor" for each in again.relaxations)
        assert "balance factor of" not in str(again.reason)


@pytest.mark.usefixtures("factors_alone")
def test_a_factor_that_needs_further_holes_is_found() -> None:
    """At 0.4 the crank is heavy across the throw, where no hole may be; a little lower two do it."""
    drill = DrillLimits(diameters_mm=(8.0,), max_holes=2)
    made = with_factor(light(), 0.5)
    across = Moments.point(300.0, np.array([0.0, 1.0, 0.0]))
    made = replace(made, loads=made.loads + across)
    refused = balance(made, judge(made), [drill])
    (way,) = [each for each in refused.relaxations if each.changes[0].key == "balance.factor"]
    assert "with the available cuts" in way.text
    assert way.text in str(refused.reason)
    proposed = float(way.changes[0].proposed)
    assert 0.3 < proposed <= 0.4
    at_that = with_factor(light(), proposed)
    result = balance(replace(at_that, loads=at_that.loads + across), judge(at_that), [drill], advise=False)
    assert result.outcome == "within_tolerance"
    assert result.corrections
