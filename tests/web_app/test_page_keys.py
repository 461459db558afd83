"""Keys of the page: steps, views, the main button; none of them while a field has the focus."""

import pytest

from tests.report.browser import Browser
from tests.web_app.page import BROWSER, at, until

pytestmark = BROWSER
PRESS = """
const [key, more] = arguments, target = document.activeElement || document.body;
target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
"""
TAB = "return document.body.dataset.tab"
AWAY = (
    "const view = document.getElementById('model').view;"
    "return view.camera.position.clone().sub(view.controls.target).normalize().toArray()"
)


def test_steps_and_views_are_at_a_key_but_not_while_one_types(page: Browser) -> None:
    page.run("document.activeElement.blur()")
    for key, tab in {
        "2": "parts",
        "3": "correct",
        "4": "see",
        "5": "machine",
        "a": "analyse",
        "1": "open",
    }.items():
        page.run(PRESS, key, {})
        assert page.run(TAB) == tab
    for key, (axis, sign) in {"e": (2, -1), "r": (2, 1), "s": (1, 1)}.items():
        page.run(PRESS, key, {})
        assert sign * page.run(AWAY)[axis] == pytest.approx(1.0, abs=1e-6)
    page.click_on(at("tab-parts"))
    page.run("document.getElementById('factor').focus()")
    for key in ("4", "a", "e", "b"):
        page.run(PRESS, key, {})
        assert page.run(TAB) == "parts"
        assert page.run(AWAY)[1] == pytest.approx(1.0, abs=1e-6)
    page.run(PRESS, "Enter", {"ctrlKey": True})  # the main button, from a field too
    until(page, "return document.body.dataset.tab === 'correct'")


def test_a_run_is_listed_with_its_crank(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    assert page.run("return document.querySelector('#run-list li b').textContent") == "small"
