"""Readings of a balancing machine as judged, their uncertainty, and the mistakes that numbers give away."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from autobalance.balancing.machine_reading import (
    JudgedReading,
    MachineAccuracy,
    PlaneReading,
    ReadingComparison,
    bob_weight_fit,
    judged_reading,
    machine_cannot_show,
    needs_no_cut,
    suspects,
)
from autobalance.errors import JobError
from autobalance.job.reading import READING_KEYS, read_reading
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.toml_files.keys import json_schema
from autobalance.units import G_MM_PER_OZ_IN

NOTHING = Unbalance(np.zeros(2), np.zeros(2))
PLACES = (-40.0, 60.0)
FINE = MachineAccuracy(0.99, 0.2)
READING: dict[str, Any] = {
    "urr_percent": 95.0,
    "umar_g_mm": 2.0,
    "plane": [{"at": "A", "g_mm": 35.0, "angle_deg": 191.0}, {"z_mm": 50.0, "g_mm": 20.0, "angle_deg": 10.0}],
}


def tolerance(judge: Any = "dynamic") -> Tolerance:
    return Tolerance.of(
        grade_mm_s=6.3,
        service_speed_rad_s=1000.0,
        rotor_mass_g=4000.0,
        z_centre_mm=10.0,
        planes_z_mm=PLACES,
        judge=judge,
    )


def read(
    *planes: tuple[float | None, complex], off: Unbalance = NOTHING, zero_rad: float = 0.0
) -> JudgedReading:
    found = [PlaneReading(z, u) for z, u in planes]
    return judged_reading(found, FINE, off, NOTHING, PLACES, zero_rad)


def complex_of(vector: Any) -> complex:
    return complex(vector[0], vector[1])


def test_two_planes_give_resultant_and_moment() -> None:
    found = read((-30.0, 5 + 2j), (50.0, -3j))
    assert complex_of(found.unbalance.resultant_g_mm) == pytest.approx(5 - 1j)
    assert complex_of(found.unbalance.moment_g_mm2) == pytest.approx(-30.0 * (5 + 2j) - 150j)


def test_uncertainty_is_carried_by_the_levers() -> None:
    accuracy = MachineAccuracy(0.95, 2.0)
    found = judged_reading(
        [PlaneReading(-40.0, 30 + 0j), PlaneReading(60.0, 40j)], accuracy, NOTHING, NOTHING, PLACES
    )
    first, second = math.hypot(2.0, 1.5), math.hypot(2.0, 2.0)
    assert found.share.resultant_g_mm == pytest.approx(math.hypot(first, second))
    assert found.share.planes_g_mm == pytest.approx(
        (first, second)
    )  # read in the tolerance planes themselves
    inside = judged_reading(
        [PlaneReading(0.0, 30 + 0j), PlaneReading(20.0, 40j)], accuracy, NOTHING, NOTHING, PLACES
    )
    assert inside.share.planes_g_mm[0] == pytest.approx(math.hypot(0.6 * first, 0.4 * second))
    assert inside.share.planes_g_mm[1] == pytest.approx(math.hypot(0.4 * first, 0.6 * second))


def test_static_reading_takes_the_moment_of_the_model() -> None:
    model = Unbalance(np.array([1.0, 2.0]), np.array([300.0, -40.0]))
    off = Unbalance(np.array([0.5, 0.0]), np.array([7.0, 0.0]))
    found = judged_reading([PlaneReading(None, 10 + 1j)], FINE, off, model, PLACES)
    assert found.static
    assert found.unbalance.resultant_g_mm.tolist() == [10.5, 1.0]
    assert found.unbalance.moment_g_mm2 == pytest.approx(model.moment_g_mm2)


def test_no_further_cut_only_well_inside() -> None:
    # Permitted 25.2 g·mm, 12.6 in each plane.
    fine = read((-40.0, 12.0 + 0j), (60.0, 12.0j))
    assert needs_no_cut(fine, tolerance())
    assert not needs_no_cut(read((-40.0, 12.5 + 0j), (60.0, 0j)), tolerance())  # 12.6 − 0.24
    assert needs_no_cut(read((-40.0, 12.5 + 0j), (60.0, 0j)), tolerance("static"))


@pytest.mark.parametrize(
    ("umar", "judge", "shows"),
    [(12.5, "dynamic", True), (12.6, "dynamic", False), (12.7, "static", True), (25.2, "static", False)],
)
def test_machine_that_cannot_show_it(umar: float, judge: str, shows: bool) -> None:
    said = machine_cannot_show(MachineAccuracy(0.9, umar), tolerance(judge))
    assert (said is None) == shows
    if said is not None:
        assert "this machine cannot show it" in said


# --- mistakes -----------------------------------------------------------------------------------------------

ZERO = math.radians(25.0)
TRUE_BEFORE = ((-40.0, cmath.rect(90.0, 2.1)), (60.0, cmath.rect(55.0, -0.7)))
TRUE_NOW = ((-40.0, cmath.rect(9.0, 0.4)), (60.0, cmath.rect(14.0, 1.9)))
PER_GRAM = Unbalance(np.array([27.0, 0.0]), np.array([27.0 * 8.0, 0.0]))

Spoil = Callable[[complex], complex]
SPOILT: dict[str, Spoil] = {
    "mirrored": lambda u: cmath.exp(2j * ZERO) * u.conjugate(),
    "opposite": lambda u: -u,
    "turned": lambda u: u * cmath.exp(1j * 2.0),
    "scaled": lambda u: u * 25.4,
}


def compared(now: JudgedReading, before: JudgedReading) -> ReadingComparison:
    cuts = read(*TRUE_NOW).unbalance - read(*TRUE_BEFORE).unbalance
    return ReadingComparison(now, before, cuts, PER_GRAM, PLACES)


def spoilt(planes: Any, spoil: Spoil) -> JudgedReading:
    return read(*((z, spoil(u)) for z, u in planes), zero_rad=ZERO)


def test_right_readings_leave_no_doubt() -> None:
    assert suspects(compared(read(*TRUE_NOW), read(*TRUE_BEFORE))) == []


@pytest.mark.parametrize("cause", SPOILT)
def test_mistake_in_both_readings_is_the_first_suspect(cause: str) -> None:
    spoil = SPOILT[cause]
    found = suspects(compared(spoilt(TRUE_NOW, spoil), spoilt(TRUE_BEFORE, spoil)))
    assert found[0].cause == cause
    assert found[0].left_g_mm == pytest.approx(0.0, abs=1e-9)


def test_mistake_in_the_new_reading_alone_is_found() -> None:
    now = ((-40.0, cmath.rect(70.0, 0.4)), (60.0, cmath.rect(64.0, 1.9)))
    cuts = read(*now).unbalance - read(*TRUE_BEFORE).unbalance
    wrong = ReadingComparison(spoilt(now, SPOILT["opposite"]), read(*TRUE_BEFORE), cuts, PER_GRAM, PLACES)
    (first, *_) = suspects(wrong)
    assert (first.cause, first.key) == ("opposite", "reads")


def test_exchanged_planes_are_found() -> None:
    def exchange(planes: Any) -> JudgedReading:
        (za, a), (zb, b) = planes
        return read((za, b), (zb, a))

    found = suspects(compared(exchange(TRUE_NOW), exchange(TRUE_BEFORE)))
    assert (found[0].cause, found[0].key) == ("exchanged", "at")


def test_bob_weights_are_found_with_their_grams() -> None:
    more = PER_GRAM.scaled(4.0).in_planes(*PLACES)
    heavy = [(z, u + complex_of(each)) for (z, u), each in zip(TRUE_NOW, more, strict=True)]
    found = suspects(compared(read(*heavy), read(*TRUE_BEFORE)))
    assert found[0].cause == "bob_weights"
    assert "+4.00 g" in found[0].says


def test_what_no_mistake_explains_has_no_suspect() -> None:
    odd = read((-40.0, TRUE_NOW[0][1] + 60.0), (60.0, TRUE_NOW[1][1] - 75.0j))
    task = compared(odd, read(*TRUE_BEFORE))
    assert not task.agrees
    assert suspects(task) == []


def test_bob_weights_alike_on_throws_that_cancel_explain_nothing() -> None:
    assert bob_weight_fit(np.ones((1, 2)), np.zeros((1, 2))) is None


# --- the file -----------------------------------------------------------------------------------------------


def test_reading_in_other_units_and_senses() -> None:
    planes = [
        {"at": "B", "oz_in": 0.5, "angle_deg": 50.0},
        {"z_mm": "1 in", "g": 0.7, "radius_mm": 50.0, "angle_deg": 0.0},
    ]
    senses = {"rotation": "cw", "zero_deg": 20.0, "reads": "light"}
    found = read_reading({**READING, **senses, "plane": planes})
    first, second = found.planes
    turned = math.radians(20.0 - 50.0 + 180.0)
    assert first.unbalance_g_mm == pytest.approx(cmath.rect(0.5 * G_MM_PER_OZ_IN, turned))
    assert second.unbalance_g_mm == pytest.approx(cmath.rect(35.0, math.radians(200.0)))
    assert second.z_mm == pytest.approx(25.4)
    assert found.urr == pytest.approx(0.95)


def plane(**keys: Any) -> dict[str, Any]:
    return {"plane": [{"angle_deg": 0.0, **keys}]}


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"urr_percent": 0.0}, "urr_percent is 0; must be > 0 and"),
        ({"plane": []}, "[[plane]] is missing"),
        ({"plane": READING["plane"] * 2}, "plane has 4 entries; expected one (static) or two"),
        (plane(), "plane[1].g_mm is missing; expected exactly one of g_mm, oz_in, g"),
        (plane(g_mm=1.0, oz_in=1.0), "plane[1].g_mm is given with oz_in"),
        (plane(g=1.0), "plane[1].radius_mm is missing"),
        (plane(g_mm=1.0, radius_mm=3.0), "plane[1].radius_mm is given with g_mm"),
        (plane(g_mm=1.0, at="A", z_mm=3.0), "plane[1].at is given with z_mm"),
        (plane(g_mm=1.0, at="C"), "plane[1].at"),
        ({"plane": [READING["plane"][0], {"g_mm": 1.0, "angle_deg": 0.0}]}, "plane[2].at is missing"),
        ({"before": [READING["plane"][0]]}, "before has 1 planes, plane 2"),
        ({"readings": 1}, "readings is an unknown key; did you mean"),
    ],
)
def test_bad_readings_are_named(more: dict[str, Any], message: str) -> None:
    with pytest.raises(JobError) as refused:
        read_reading({**READING, **more})
    assert message in str(refused.value)


def test_schema_allows_what_is_read() -> None:
    import jsonschema

    schema = json_schema("reading", READING_KEYS)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate({**READING, "correction": {"method": "drill"}}, schema)
