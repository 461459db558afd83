"""Influence coefficients, weights under limits, on places and from stock, and what is refused."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from autobalance.errors import JobError
from autobalance.test_stands.influence.fitted_weights import (
    Fitting,
    fitted_weights,
    places_with_sum,
    weights_with_sum,
)
from autobalance.test_stands.influence.input import TRIALS_KEYS
from autobalance.test_stands.influence.limited_weights import (
    Goal,
    Trial,
    influence_coefficients,
    limited_weights,
)
from autobalance.test_stands.influence.verb import influence
from autobalance.toml_files.keys import json_schema
from autobalance.types import Array, Complex


def plant(seed: int, readings: int, planes: int) -> tuple[Complex, Complex, Array]:
    """Return random coefficients (M, N), initial readings and reading weights (M,)."""
    rng = np.random.default_rng(seed)
    alpha: Complex = rng.normal(size=(readings, planes)) + 1j * rng.normal(size=(readings, planes))
    initial: Complex = 5.0 * rng.normal(size=readings) + 5.0j * rng.normal(size=readings)
    return alpha, initial, rng.uniform(0.5, 2.0, readings)


def written(alpha: Complex, initial: Complex, **more: Any) -> dict[str, Any]:
    """Return a trials file of a plant, with one trial of its own size and angle in each plane."""

    def shown(readings: Complex) -> list[list[float]]:
        return [[float(abs(each)), float(np.degrees(np.angle(each)))] for each in readings]

    trials = [
        {
            "plane": plane + 1,
            "g_mm": 3.0 + plane,
            "angle_deg": 40.0 * plane,
            "readings": shown(initial + column * (3.0 + plane) * np.exp(1j * np.radians(40.0 * plane))),
        }
        for plane, column in enumerate(alpha.T)
    ]
    return {"initial": shown(initial), "trial": trials, **more}


def sums(report: dict[str, Any]) -> Complex:
    return np.array(
        [each["g_mm"] * np.exp(1j * np.radians(each["angle_deg"])) for each in report["corrections"]]
    )


def test_linear_plant_leaves_nothing() -> None:
    alpha, initial, _ = plant(1, 4, 4)
    report = influence(written(alpha, initial)).report
    assert report["residual"]["worst"] < 1e-12 * np.abs(initial).max()
    assert np.allclose(alpha @ sums(report), -initial)


def test_trials_left_on_count_for_the_runs_after_them() -> None:
    alpha, initial, _ = plant(2, 3, 2)
    weights = np.array([2.0 * np.exp(0.3j), 3.0 * np.exp(2.0j)])
    after = initial + alpha[:, 0] * weights[0]
    trials = [
        Trial(0, weights[0], after, left_on=True),
        Trial(1, weights[1], after + alpha[:, 1] * weights[1]),
        Trial(0, -weights[0], after - alpha[:, 0] * weights[0]),
    ]
    assert np.allclose(influence_coefficients(initial, trials, 2), alpha)


def test_what_is_left_on_is_taken_from_what_to_add() -> None:
    alpha, initial, _ = plant(3, 2, 2)
    task = written(alpha, initial)
    task["trial"][1]["left_on"] = True
    report = influence(task).report
    more = [each["g_mm"] * np.exp(1j * np.radians(each["angle_deg"])) for each in report["add_to_left"]]
    assert np.allclose(sums(report) - more, [0.0, 4.0 * np.exp(1j * np.radians(40.0))])
    assert influence(written(alpha, initial)).report["add_to_left"] is None


@pytest.mark.parametrize("goal", ["least_squares", "least_worst"])
@pytest.mark.parametrize("seed", range(6))
def test_no_small_change_within_the_limits_is_better(goal: Goal, seed: int) -> None:
    alpha, initial, v = plant(seed, 5, 3)
    limits = np.array([0.4, np.inf, 2.0])
    found = limited_weights(alpha, initial, v, limits, goal)

    def cost(weights: Complex) -> float:
        sizes = v * np.abs(initial + alpha @ weights)
        return float(sizes.max() if goal == "least_worst" else np.sqrt((sizes**2).sum()))

    assert (np.abs(found) <= limits).all()
    rng = np.random.default_rng(seed)
    for step in (1e-3, 1e-2, 1e-1, 1.0):
        for change in rng.normal(size=(200, 3)) + 1j * rng.normal(size=(200, 3)):
            moved = found + step * change
            moved *= np.minimum(1.0, limits / np.abs(moved))
            assert cost(moved) >= cost(found) - 1e-6 * np.abs(initial).max()


def test_single_reading_goes_down_by_all_that_the_limit_allows() -> None:
    # |8 + 2 w| with |w| ≤ 3 is least at w = −3, whatever the goal.
    for goal in ("least_squares", "least_worst"):
        task = written(
            np.array([[2.0 + 0j]]), np.array([8.0 + 0j]), goal=goal, plane=[{"plane": 1, "max_g_mm": 3.0}]
        )
        report = influence(task).report
        assert report["residual"]["worst"] == pytest.approx(2.0, abs=8e-5)
        assert report["corrections"][0]["angle_deg"] == pytest.approx(180.0, abs=1e-3)


def all_sums(fitting: Fitting) -> Complex:
    """Return every sum that a fitting of places and stock allows."""
    assert fitting.angles_rad is not None
    assert fitting.weights_g_mm is not None
    most = fitting.max_weights or len(fitting.angles_rad)
    found = [0j] + [
        complex(sum(w * np.exp(1j * a) for w, a in zip(weights, places, strict=True)))
        for count in range(1, most + 1)
        for places in itertools.combinations(fitting.angles_rad, count)
        for weights in itertools.product(fitting.weights_g_mm, repeat=count)
    ]
    return np.array([each for each in found if abs(each) <= fitting.limit_g_mm * (1.0 + 1e-9)])


@pytest.mark.parametrize("seed", range(5))
def test_places_and_stock_are_as_good_as_trying_all_sets(seed: int) -> None:
    alpha, initial, v = plant(seed, 3, 2)
    places = np.radians(np.random.default_rng(seed).choice(np.arange(0, 360, 15), 5, replace=False))
    stock = np.array([1.0, 2.0, 5.0])
    fittings = (Fitting(places, stock, 2, 4.0), Fitting(places + 0.1, stock[:2], 3))
    found = fitted_weights(alpha, initial, v, fittings)
    one, two = (all_sums(each) for each in fittings)
    every = v[:, None, None] * np.abs(
        initial[:, None, None]
        + alpha[:, 0, None, None] * one[:, None]
        + alpha[:, 1, None, None] * two[None, :]
    )
    assert found.worst <= 1.01 * every.max(axis=0).min()
    assert found.proven
    assert found.bound <= every.max(axis=0).min()


def test_one_weight_at_any_angle_is_put_where_it_does_most() -> None:
    alpha, initial, v = plant(11, 3, 1)
    found = fitted_weights(alpha, initial, v, (Fitting(None, np.array([1.0, 2.5]), 1),))
    turns = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 7200))
    tried = [
        (v[:, None] * np.abs(initial[:, None] + weight * alpha[:, 0, None] * turns)).max(axis=0).min()
        for weight in (0.0, 1.0, 2.5)
    ]
    assert found.worst <= 1.01 * min(tried)


@pytest.mark.parametrize("most", [None, 1, 2])
def test_any_weight_at_some_places(most: int | None) -> None:
    alpha, initial, v = plant(12, 3, 1)
    places = np.radians(np.arange(0.0, 360.0, 30.0))
    found = fitted_weights(alpha, initial, v, (Fitting(places, None, most),))
    free = v * np.abs(initial + alpha @ limited_weights(alpha, initial, v, np.array([np.inf]), "least_worst"))
    if most != 1:  # two neighbours make any sum
        assert found.worst <= 1.01 * free.max()
    fitted = found.split[0]
    assert fitted is not None
    assert len(fitted) <= (most or 2)
    assert all(np.isclose(angle, places).any() for angle, _ in fitted)


@pytest.mark.parametrize("size", [0.0, 1.0, 1.7, 2.0, 3.0, 4.0, 9.3, 20.0])
def test_weights_from_stock_make_a_sum(size: float) -> None:
    stock = np.array([1.0, 2.0])
    total = size * np.exp(2.2j)
    fitted = weights_with_sum(complex(total), stock)
    assert all(weight in stock for _, weight in fitted)
    assert sum(weight * np.exp(1j * angle) for angle, weight in fitted) == pytest.approx(total)


def test_places_beside_a_sum_carry_it() -> None:
    fitted = places_with_sum(3.0 * np.exp(1j * np.radians(20.0)), np.radians([0.0, 30.0, 120.0]))
    assert [round(float(np.degrees(angle))) for angle, _ in fitted] == [0, 30]
    assert places_with_sum(1.0 + 0j, np.radians([90.0, 100.0])) == ()


def test_target_decides_the_outcome() -> None:
    alpha, initial, _ = plant(4, 4, 2)
    worst = np.max([each[0] for each in influence(written(alpha, initial)).report["residual"]["readings"]])
    reached = influence(written(alpha, initial, target=1.01 * worst))
    missed = influence(written(alpha, initial, target=0.99 * worst))
    assert (reached.report["outcome"], reached.exit_code) == ("within_tolerance", 0)
    assert (missed.report["outcome"], missed.exit_code) == ("above_tolerance", 4)
    assert "more planes" in missed.report["reason"]


def test_condition_of_planes_that_act_alike_is_warned_of() -> None:
    alpha = np.array([[1.0, 1.0], [1.0, 1.05]], dtype=complex)
    report = influence(written(alpha, np.array([1.0 + 0j, 2.0 + 0j]))).report
    scaled = alpha / np.linalg.norm(alpha, axis=0)
    assert report["condition"] == pytest.approx(np.linalg.cond(scaled))
    assert "1, 2" in report["warnings"][0]


def changed(**more: Any) -> dict[str, Any]:
    alpha, initial, _ = plant(5, 2, 2)
    return {**written(alpha, initial), **more}


def spoilt(number: int, **keys: Any) -> dict[str, Any]:
    task = changed()
    task["trial"][number] |= keys
    return task


@pytest.mark.parametrize(
    ("task", "message"),
    [
        (changed(goal="least"), "goal"),
        (changed(tria=1), "tria is an unknown key"),
        ({"initial": [[1.0, 0.0]]}, "[[trial]] is missing"),
        (changed(initial=[[1.0, 0.0]]), "trial has 2 planes, initial 1 reading;"),
        (changed(reading_weights=[1.0]), "reading_weights has 1 entries"),
        (changed(reading_weights=[0.0, 0.0]), "reading_weights are all 0"),
        (changed(initial=[[-1.0, 0.0], [1.0, 0.0]]), "initial[1] has an amplitude of -1"),
        (spoilt(0, readings=[[1.0, 0.0]]), "trial[1].readings has 1 entries"),
        (spoilt(0, g_mm=0.0), "trial[1].g_mm is 0; must be > 0"),
        (spoilt(0, g=1.0), "trial[1].g is given with g_mm"),
        (spoilt(1, readings=changed()["initial"]), "trial[2]: changes nothing"),
        (changed(plane=[{"plane": 3}]), "plane[1].plane is 3; no trial is in that plane: 1, 2"),
        (changed(plane=[{"plane": 1}, {"plane": 1}]), "plane[2].plane is 1 twice"),
        (changed(plane=[{"plane": 1, "angles_deg": []}]), "plane[1].angles_deg is an empty list"),
        (
            written(np.array([[1.0, 1.0], [1.0, 1.0 + 1e-5]], dtype=complex), np.array([1.0 + 0j, 1.0 + 0j])),
            "planes 1, 2 apart",
        ),
    ],
)
def test_bad_trials_are_named(task: dict[str, Any], message: str) -> None:
    with pytest.raises(JobError) as refused:
        influence(task)
    assert message in str(refused.value)


def test_weight_needs_its_radius() -> None:
    task = changed()
    del task["trial"][0]["g_mm"]
    with pytest.raises(JobError, match=r"trial\[1\].g_mm is missing; or g with radius_mm"):
        influence(task)
    task["trial"][0]["g"] = 0.3
    with pytest.raises(JobError, match=r"trial\[1\].radius_mm is missing"):
        influence(task)
    task["trial"][0]["radius_mm"] = 10.0
    correction = influence(task).report["corrections"][0]
    assert correction["g"] * 10.0 == pytest.approx(correction["g_mm"])


def test_schema_allows_what_is_read() -> None:
    import jsonschema

    schema = json_schema("trials", TRIALS_KEYS)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(changed(target=2.0), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(changed(goal="least"), schema)
