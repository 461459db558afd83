"""The frame about every step: one state line with one main button, and nothing cut off at any width."""

import math
import re
from typing import Any

import pytest

from tests.report.browser import Browser
from tests.web_app.page import BROWSER, at, latest, load, put, text_of, until
from tests.web_app.serving import Served

pytestmark = BROWSER
PRESSED = (
    "[role=tab], button:not(table button), select, summary,"
    "input:not([type=range], [type=checkbox], [type=radio], [type=file], [type=hidden]), .seg label"
)
"""What is pressed or typed into; a row of a table is itself a target."""
STEPS = ("open", "parts", "correct", "see", "machine", "analyse", "history")
SEEN = "[...document.querySelectorAll(arguments[0])].filter(each => each.getClientRects().length)"
CUT_OFF = """
const seen = (what) => [...document.querySelectorAll(what)].filter(each => each.getClientRects().length);
const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
const box = each => each.getBoundingClientRect();
const out = seen(".head > *, .menu > *, .line > *, .steps button, .strip .polar, .panel, .help-line")
  .filter(each => box(each).width && (box(each).left < -1 || box(each).right > innerWidth + 1))
  .map(each => each.className || each.id);
const over = (a, b) =>
  a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
const apart = [...seen(".line > *"), ...seen(".steps button")].map(box)
  .filter(each => each.width && each.height);
const touching = apart.filter((each, k) => apart.slice(k + 1).some(other => over(each, other))).length;
const cut = seen(".line button, .steps b, .polar dd, .polar figcaption")
  .filter(each => each.clientWidth && each.scrollWidth > each.clientWidth + 1).map(each => each.textContent);
return [wide, out, touching, cut];
"""
COLOURS = """
const { group } = document.getElementById("model").view.sets.crank;
return group.children.map(each => each.userData.ink);
"""


WEIGHTS = """
const { sets: { crank } } = document.getElementById("model").view;
const made = crank.group.children.find(each => each.userData.ink === "weight");
return [...made.geometry.attributes.position.array].filter((_, k) => k % 3 === 0).map(x => -x);
"""
AXIS = """
const view = document.getElementById("model").view, box = view.box.getBoundingClientRect();
const [x, y] = view.placed([0, 0, 0]);
return [box.x + x, box.y + y];
"""
PIN = """
const { view } = document.getElementById("model");
return view.whereIs(view.parts.findIndex(each => each.kind === "main_journal") + 1);
"""
WHEEL = """
const view = document.getElementById("model").view, box = view.box.getBoundingClientRect();
const [x, y] = view.placed([0, 0, 0]).map((value, axis) => value + [box.x, box.y, 0][axis]);
return [...document.getElementById("wheel-names").children].map(each => {
  const at = each.getBoundingClientRect();
  return [each.textContent, at.x + at.width / 2 - x, at.y + at.height / 2 - y];
});
"""
MEASURED = (
    "Object.fromEntries([...document.querySelectorAll('[data-measured]')]"
    ".map(each => [each.dataset.measured, Number(each.dataset.value)]))"
)


@pytest.mark.parametrize("width", [1440, 1280, 1024, 390])
@pytest.mark.looks
def test_each_step_has_a_state_line_with_one_main_button(page: Browser, width: int) -> None:
    page.resize(width, 900)
    try:
        for step in STEPS:
            page.click_on(at(f"tab-{step}"))
            until(page, f"return document.body.dataset.tab === '{step}'")
            assert text_of(page, "state-line").strip()
            assert page.run(f"return {SEEN}.length", "button.main") == 1, step
            assert page.run(CUT_OFF) == [0, [], 0, []], step
    finally:
        page.resize(1400, 900)


HEAD = """
const box = what => document.querySelector(what).getBoundingClientRect();
const [name, help, step] = [".crank-name", ".help-button", ".steps button"].map(box);
return [name.width, step.left - name.right, help.width, help.height, innerWidth - help.right];
"""


FORMATS = {
    "en": "",
    "de": r"Kurbelwellen: stl, .*, step.*\. Aufträge: toml, xlsx\. Ergebnisse: ihr Ordner\.",
    "es": r"Cigüeñales: stl, .*, step.*\. Trabajos: toml, xlsx\. Resultados: su carpeta\.",
}


def test_in_every_language_the_head_has_room_for_the_cranks_name_and_formats_are_said(
    page: Browser, project: Served
) -> None:
    page.resize(1024, 900)
    try:
        for language, says in FORMATS.items():
            page.run("localStorage.setItem('autobalance-language', arguments[0])", language)
            load(page, project)
            assert page.run("return document.documentElement.lang") == language
            assert page.run(CUT_OFF) == [0, [], 0, []]
            name, apart, width, height, edge = page.run(HEAD)
            assert name >= 96.0
            assert apart >= 0.0
            assert min(width, height) >= 28.0
            assert edge >= 0.0
            words = page.run("return document.getElementById('formats').textContent")
            assert re.fullmatch(says or ".+", words), words
    finally:
        page.run("localStorage.removeItem('autobalance-language')")
        page.resize(1400, 900)


UNITS = """
const field = document.getElementById("units"), style = getComputedStyle(field);
const pen = document.createElement("canvas").getContext("2d");
pen.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
const wide = pen.measureText(field.selectedOptions[0].textContent).width;
return [wide, field.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight)];
"""
ARROW_PX = 16.0
"""Width of a choice's arrow."""


@pytest.mark.looks
def test_units_and_both_planes_are_whole_on_a_small_laptop(page: Browser) -> None:
    page.resize(1024, 900)
    try:
        page.click_on(at("tab-see"))
        until(page, "return document.querySelectorAll('#strip .polar').length === 3")
        wide, room = page.run(UNITS)
        assert wide + ARROW_PX <= room
        seen = page.run(f"return {SEEN}.map(each => each.querySelector('figcaption').textContent)", ".polar")
        assert seen == ["Resultant", "Plane A", "Plane B"]
        assert page.run(CUT_OFF) == [0, [], 0, []]
    finally:
        page.resize(1400, 900)


@pytest.mark.looks
def test_instruments_and_help_are_in_sight_on_a_phone(page: Browser) -> None:
    page.resize(390, 844)
    try:
        page.click_on(at("tab-see"))
        until(page, "return document.querySelector('[data-testid=view-webs]') !== null")
        for name in ("tool-degrees", "tool-section", "tool-measure", "view-webs", "help-open"):
            left, right, width = page.run(
                "const { left, right, width } = document.querySelector(arguments[0]).getBoundingClientRect();"
                "return [left, right, width];",
                at(name),
            )
            assert left >= 0.0, name
            assert right <= 390.0, name
            assert width >= 40.0, name
        covered = (
            "const a = document.querySelector('.toolbar').getBoundingClientRect(),"
            "b = document.getElementById('model').getBoundingClientRect(); return a.bottom - b.top"
        )
        assert page.run(covered) <= 0.5  # they stand above the model, not over it
        page.click_on(at("tool-measure"))
        until(page, "return document.querySelector('.measure') !== null")
        page.click_on(at("tool-measure"))
        page.click_on(at("help-open"))
        until(page, "return document.getElementById('help').open")
        page.click_on(at("help-close"))
    finally:
        page.resize(1400, 900)


@pytest.mark.looks
def test_targets_are_as_large_as_a_finger_on_a_phone(page: Browser) -> None:
    page.resize(390, 844)
    try:
        for step in STEPS:
            page.click_on(at(f"tab-{step}"))
            small: list[Any] = page.run(
                f"return {SEEN}.filter(each => each.getBoundingClientRect().height < 43.5)"
                ".map(each => each.outerHTML.slice(0, 90))",
                PRESSED,
            )
            assert small == [], step
    finally:
        page.resize(1400, 900)


def test_the_steps_say_how_far_each_is(page: Browser, project: Served) -> None:
    assert text_of(page, "tab-open").endswith("throws: 1, webs: 2")
    assert text_of(page, "tab-see").endswith("not proven")
    assert page.run("return document.getElementById('tab-see').dataset.is") == "ask"
    page.click_on(at("tab-see"))
    assert page.run("return document.querySelector('[data-testid=state-line]').dataset.tone") == "warn"
    put(page, factor="0.3")
    until(page, "return document.querySelector('[data-testid=state-line]').dataset.tone === 'stale'")
    assert page.run("return document.getElementById('tab-see').dataset.is") == "stale"
    assert page.run("return document.querySelector('.line button.main').textContent") == "Cut again"


@pytest.mark.looks
def test_journals_and_crankpins_have_their_colours_at_first_sight(page: Browser) -> None:
    assert {"journal", "pin", "weight"} <= set(page.run(COLOURS))
    found = page.run(WEIGHTS)
    assert min(found) >= -1e-4  # a counterweight is what is beyond the axis, away from its crankpin
    assert max(found) > 50.0


@pytest.mark.looks
def test_a_wheel_has_its_zero_and_a_measure_the_places_that_were_clicked(
    page: Browser, project: Served
) -> None:
    page.click_on(at("tab-open"))
    page.click_on("#views button:nth-child(3)")  # Rear: from +z, angles go counter-clockwise
    page.click_on(at("tool-degrees"))
    names = until(page, WHEEL)
    for text, x, y in names:
        wanted = float(text.partition("°")[0])
        angle = math.degrees(math.atan2(-x, -y)) % 360.0  # the camera's up is the direction of the crankpin
        assert abs((angle - wanted + 180.0) % 360.0 - 180.0) < 0.5, text
    assert names[0][0] == "0° P1↺"
    page.click_on(at("tool-measure"))
    middle = page.run(AXIS)
    page.click(middle[0] + 20.0, middle[1] + 90.0)
    page.click(middle[0] - 35.0, middle[1] + 70.0)
    shown = until(page, f"const all = {MEASURED}; return all.distance !== undefined && all")
    per = page.run(
        "const { camera, box } = document.getElementById('model').view;"
        "return (camera.right - camera.left) / camera.zoom / box.clientWidth"
    )
    assert shown["distance"] == pytest.approx(per * math.hypot(55.0, 20.0), rel=0.02)  # on one face
    assert shown["radius-1"] == pytest.approx(per * math.hypot(20.0, 90.0), rel=0.02)
    assert shown["angle-1"] == pytest.approx(math.degrees(math.atan2(-20.0, -90.0)) % 360.0, abs=1.0)
    assert shown["between"] == pytest.approx(
        math.degrees(math.atan2(20.0, 90.0) + math.atan2(35.0, 70.0)), abs=1.0
    )
    page.click_on("#views button:nth-child(4)")  # Side: a journal is seen along its length
    page.click(*until(page, PIN))
    diameter = until(page, f"return {MEASURED}['diameter-1']")
    report = latest(project, "inspect")["report"]
    assert diameter == report["crank"]["main_journals"][0]["diameter_mm"]
    page.click_on(at("tool-measure"))
    page.click_on(at("tool-degrees"))


@pytest.mark.looks
def test_a_bar_is_there_only_while_something_runs(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    assert page.run("return document.getElementById('progress').hidden")
