import re
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from autobalance.balancing.comparison import ComparedRow, beaten_by, ranked, wall_left_mm, why_recommended
from autobalance.correction.contract import Correction, Prefer
from autobalance.crank.anatomy import Anatomy, Pin, Throw, Web
from autobalance.declare import encoded
from autobalance.quantities import mm, said
from autobalance.report.balance.comparison import comparison, comparison_html, comparison_text
from autobalance.report.balance.values import dumps
from autobalance.report.display_units import ON_SCREEN
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance


def row(name: str, metal_g: float, inertia: float, cuts: int, wall_mm: float | None = 5.0) -> ComparedRow:
    return ComparedRow(
        (name,),
        "within_tolerance",
        None,
        residual_share=0.01,
        residual_g_mm=0.1,
        mass_change_g=-metal_g,
        inertia_change_g_mm2=-inertia,
        metal_moved_g=metal_g,
        cuts=cuts,
        depths_mm=(2.0,) * cuts,
        wall_left_mm=wall_mm,
        capacity_is_plenty=True,
    )


ABOVE = ComparedRow(
    ("slug",),
    "above_tolerance",
    "too short",
    residual_share=3.0,
    residual_g_mm=30.0,
    mass_change_g=0.0,
    metal_moved_g=0.0,
    inertia_change_g_mm2=0.0,
    cuts=1,
    depths_mm=(4.0,),
    wall_left_mm=4.0,
    capacity=0.2,
)
NO_PLACE = ComparedRow(("add",), None, "no face")


def test_what_is_nowhere_worse_and_somewhere_better_beats() -> None:
    light, same, trade = row("a", 10.0, 500.0, 2), row("b", 10.0, 500.0, 3), row("c", 20.0, 300.0, 2)
    rows = [light, same, trade, ABOVE, NO_PLACE]
    beaten = {each.name: "".join(beaten_by(each, rows)) for each in rows}
    assert beaten == {"a": "", "b": "a", "c": "", "slug": "abc", "add": "abc"}
    assert not light.beats(light)
    assert not light.beats(row("d", 10.0 * (1.0 - 1e-4), 500.0, 2))  # equal but for rounding
    assert row("thick", 10.0, 500.0, 2, 9.0).beats(light)
    assert row("nothing cut", 10.0, 500.0, 2, None).beats(light)
    assert not ABOVE.beats(NO_PLACE)


def test_walls_are_the_least_of_what_each_kind_leaves() -> None:
    pin = Pin(np.array([30.0, 0.0, 0.0]), 36.0, 20.0)
    anatomy = Anatomy(np.eye(4), (), (Throw(1, 30.0, 0.0, pin),), (Web(1, 10.0, 28.0, True),), 0.0)

    def made(kind: str, depth_mm: float, **details: object) -> Correction:
        return Correction(kind, None, 1, np.zeros(3), depth_mm, Moments.zero(), 0.0, details)

    hole = made("drill", 9.0, wall_left_mm=4.5)
    front, back = (
        made("shoulder", 3.0, normal=[0.0, 0.0, 1.0]),
        made("shoulder", 2.0, normal=[0.0, 0.0, -1.0]),
    )
    rim = made("turn", 3.0, new_radius_mm=50.0)
    assert wall_left_mm([hole], anatomy) == 4.5
    assert wall_left_mm([front, back], anatomy) == pytest.approx(18.0 - 5.0)
    assert wall_left_mm([rim], anatomy) == pytest.approx(50.0 - 48.0)
    assert wall_left_mm([hole, front, rim], anatomy) == 2.0
    assert wall_left_mm([made("add", -3.0)], anatomy) is None


def off(size_g_mm: float) -> Unbalance:
    return Unbalance(np.array([size_g_mm, 0.0]), np.zeros(2))


def test_an_engine_whose_throws_cancel_is_judged_by_its_worst_plane() -> None:
    """A cross-plane V8: next to no resultant, a great couple."""
    tolerance = Tolerance.of(
        grade_mm_s=6.3,
        service_speed_rad_s=600.0,
        rotor_mass_g=20000.0,
        z_centre_mm=0.0,
        planes_z_mm=(-100.0, 100.0),
        judge="dynamic",
    )
    couple = Unbalance(np.array([1.0, 0.0]), np.array([2e6, 0.0]))
    compared = comparison("v8.toml", tolerance, couple, [row("drill", 12.0, 6e5, 3)])
    values = encoded(compared)
    worst = values["initial_worst"]
    assert (worst["place"], values["initial_g_mm"]) == ("plane B", 1.0)
    assert worst["g_mm"] == pytest.approx(10000.5)
    assert worst["permissible_g_mm"] == pytest.approx(105.0)
    text = comparison_text(compared, ON_SCREEN["metric"])
    assert "plane B has 10000.50 g·mm before, 105.00 g·mm permitted there (9\u202f524 %)" in text


def test_table_and_values_tell_the_same() -> None:
    tolerance = Tolerance.of(
        grade_mm_s=10.0,
        service_speed_rad_s=1.0,
        rotor_mass_g=1.0,
        z_centre_mm=0.0,
        planes_z_mm=None,
        judge="static",
    )
    rows = [row("turn", 10.0, 5e5, 2), row("drill", 12.0, 6e5, 3), ABOVE, NO_PLACE]
    compared = comparison("job.toml", tolerance, off(345.6), rows)
    values = encoded(compared)
    assert values["unbeaten"] == ["turn"]
    assert values["rows"][0]["inertia_change_kg_mm2"] == -500.0
    assert values["rows"][0]["capacity"] is None
    assert values["rows"][0]["capacity_is_plenty"]
    assert "NaN" not in dumps(values)
    text = comparison_text(compared, ON_SCREEN["metric"])
    assert values["recommended"] == ["turn"]
    assert values["ranking"] == ["turn", "drill"]
    assert [each["rank"] for each in values["rows"]] == [1, 2, None, None]
    assert "turn: 2 cuts" in values["why"]
    assert "next is drill: 3 cuts" in values["why"]
    assert text.splitlines()[:2] == [
        "WITHIN TOLERANCE with 2 of 4 methods",
        "Recommended: turn: 2 cuts, deepest 2 mm (10.00 g moved)",
    ]
    assert "Why turn: turn: 2 cuts" in text
    shown = comparison_html(compared, ON_SCREEN["metric"])
    assert shown.index("turn") < shown.index("<td>drill")
    light = [row("turn", 14.0, 5e5, 2), row("drill", 12.0, 6e5, 3)]
    assert encoded(comparison("job.toml", tolerance, off(1.0), light, "least_metal"))["recommended"] == [
        "drill"
    ]
    none = encoded(comparison("job.toml", tolerance, off(345.6), [ABOVE, NO_PLACE]))
    assert none["recommended"] is None
    assert "none is within tolerance" in none["why"]
    assert "345.60 g·mm before, 10.00 g·mm permitted" in text
    assert re.search(r"^2\. drill: within, .* of permitted, beaten by turn$", text, re.MULTILINE)
    assert "slug: ABOVE" in text
    assert "too short" in text
    assert "add: no place\n  - no face" in text
    assert text.endswith("Nothing beats: turn")
    assert "oz·in" in comparison_text(compared, ON_SCREEN["inch"])


def test_reasons_and_what_recommends_a_kind_are_in_the_units_of_the_table() -> None:
    tolerance = Tolerance.of(
        grade_mm_s=10.0,
        service_speed_rad_s=1.0,
        rotor_mass_g=1.0,
        z_centre_mm=0.0,
        planes_z_mm=None,
        judge="static",
    )
    above = replace(ABOVE, reason=said("limited by the wall of {} behind it", mm(4.5, "g")))
    found = comparison("job.toml", tolerance, off(345.6), [row("drill", 12.0, 6e5, 3), above])
    assert found.rows[1].reason == "limited by the wall of 4.5 mm behind it"
    inch = comparison_text(found, ON_SCREEN["inch"])
    assert "limited by the wall of 0.1772 in behind it" in inch
    assert "0.423 oz moved" in inch
    assert "in of wall left" in inch
    assert "lb·in²" in inch
    assert not re.search(r"\d mm\b|kg·mm²|\d g·mm", inch)
    assert "12.0 g moved" in comparison_text(found, ON_SCREEN["metric"])


def test_what_thins_a_web_ranks_behind_its_like_that_does_not() -> None:
    """After what was preferred, before metal: 0.89 of a web's metal is thin, 0.91 is not."""
    light_but_thin = replace(row("a", 8.0, 500.0, 2), web_metal_share=0.89)
    heavy = replace(row("b", 12.0, 500.0, 2), web_metal_share=0.91)
    light = replace(row("c", 10.0, 500.0, 2), web_metal_share=None)
    more_cuts = replace(row("d", 1.0, 500.0, 3), web_metal_share=1.0)
    rows = [light_but_thin, heavy, light, more_cuts, ABOVE, NO_PLACE]
    assert [each.name for each in ranked(rows, "simple")] == ["c", "b", "a", "d"]
    assert [each.name for each in ranked(rows, "fewest_holes")] == ["c", "b", "a", "d"]
    by_metal = [each.name for each in ranked(rows, "least_metal")]
    assert by_metal == ["d", "a", "c", "b"]  # metal was asked for first


def test_metal_is_taken_off_a_heavy_crank_before_any_is_built_up_on_it() -> None:
    added = replace(row("add", 9.0, 300.0, 2), adds_to_heavy=True)
    lowered = row("shoulder", 12.0, 500.0, 4)
    for prefer in get_args(Prefer):
        assert [each.name for each in ranked([added, lowered, ABOVE], prefer)] == ["shoulder", "add"]
    assert "metal taken off before metal added" in why_recommended([lowered, added], [], "simple")
    assert not added.beats(lowered)
    assert added.beats(ABOVE)
    as_light = replace(added, adds_to_heavy=False)  # the only thing that a light crank lacks
    assert ranked([lowered, as_light], "simple")[0] == as_light
