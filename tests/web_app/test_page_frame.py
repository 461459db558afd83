"""The frame about every step: one state line with one main button, and nothing cut off at any width."""

from typing import Any

import pytest

from tests.report.browser import Browser
from tests.web_app.page import BROWSER, at, put, text_of, until
from tests.web_app.serving import Served

pytestmark = BROWSER
STEPS = ("open", "parts", "correct", "see", "machine", "analyse", "history")
SEEN = "[...document.querySelectorAll(arguments[0])].filter(each => each.getClientRects().length)"
CUT_OFF = """
const seen = (what) => [...document.querySelectorAll(what)].filter(each => each.getClientRects().length);
const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
const box = each => each.getBoundingClientRect();
const out = seen(".line > *, .steps button, .strip .polar, .panel, .help-line")
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


@pytest.mark.parametrize("width", [1440, 1024, 390])
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


def test_targets_are_as_large_as_a_finger_on_a_phone(page: Browser) -> None:
    page.resize(390, 844)
    try:
        for step in STEPS[:5]:
            page.click_on(at(f"tab-{step}"))
            small: list[Any] = page.run(
                f"return {SEEN}.filter(each => each.getBoundingClientRect().height < 43.5)"
                ".map(each => each.outerHTML.slice(0, 90))",
                "[role=tab], .line button, .tools button, #settings select",
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


def test_journals_and_crankpins_have_their_colours_at_first_sight(page: Browser) -> None:
    assert {"journal", "pin"} <= set(page.run(COLOURS))


def test_a_bar_is_there_only_while_something_runs(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    assert page.run("return document.getElementById('progress').hidden")
