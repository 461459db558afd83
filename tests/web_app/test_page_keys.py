"""Keys of the page: steps, views, the main button; none of them while a field has the focus."""

import tomllib
from pathlib import Path

import pytest

from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, at, job_text, load, until
from tests.web_app.serving import Served

pytestmark = BROWSER
ROOT = Path(__file__).parents[2]
PRESS = """
const [key, more] = arguments, target = document.activeElement || document.body;
target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
"""
TAB = "return document.body.dataset.tab"
AWAY = (
    "const view = document.getElementById('model').view;"
    "return view.camera.position.clone().sub(view.controls.target).normalize().toArray()"
)


STEPS = {
    "2": "parts",
    "3": "correct",
    "4": "see",
    "5": "machine",
    "a": "analyse",
    "h": "history",
    "1": "open",
}
VIEWS = {"e": (2, -1), "r": (2, 1), "s": (1, 1)}
FOCUSED = "return document.activeElement.dataset.cut || ''"
SAVED = """
window.saved = [];
document.addEventListener("click", (event) => {
  if (event.target.dataset?.file) { window.saved.push(event.target.dataset.file); event.preventDefault(); }
}, { capture: true });
"""


@pytest.mark.looks
def test_every_key_of_the_list_works_but_not_while_one_types(page: Browser) -> None:
    page.run("document.activeElement.blur()")
    for key, tab in STEPS.items():
        page.run(PRESS, key, {})
        assert page.run(TAB) == tab
    for key, (axis, sign) in VIEWS.items():
        page.run(PRESS, key, {})
        assert sign * page.run(AWAY)[axis] == pytest.approx(1.0, abs=1e-6)
    page.run("document.getElementById('model').view.camera.zoom = 9")
    page.run(PRESS, "f", {})
    assert 0.5 < page.run("return document.getElementById('model').view.camera.zoom") <= 1.0  # fitted
    page.click_on(at("tab-parts"))
    page.run("document.getElementById('factor').focus()")
    for key in (*STEPS, *VIEWS, "b", "f", "w", "m", "p", "?"):
        page.run(PRESS, key, {})
        assert page.run(TAB) == "parts"
        assert page.run(AWAY)[1] != pytest.approx(1.0, abs=1e-6)
        assert not page.run("return document.querySelector('dialog[open]')")
    page.run(PRESS, "Enter", {"ctrlKey": True})  # the main button, from a field too
    until(page, "return document.body.dataset.tab === 'correct'")


def test_keys_of_a_result_lead_to_its_webs_its_cuts_its_sheet_and_the_big_digits(page: Browser) -> None:
    page.run(SAVED)
    page.click_on(at("tab-see"))
    until(
        page,
        "return document.querySelectorAll('.handle').length > 1 && document.querySelector('#downloads a')",
    )
    page.run("document.activeElement.blur()")
    until(page, "return document.querySelector('[data-testid=view-webs]')")
    for hidden in (False, True):
        page.run(PRESS, "w", {})
        until(page, f"return document.getElementById('webs').hidden === {str(hidden).lower()}")
    page.run("document.querySelectorAll('#cuts tr.turns')[1].click()")
    page.run(PRESS, "m", {})
    until(page, "return document.activeElement.dataset.cut === '2'")
    page.run(PRESS, "ArrowDown", {})
    until(page, "return document.querySelector('#dragged')")
    page.run(PRESS, "Escape", {})
    page.run("document.activeElement.blur()")
    page.run(PRESS, "p", {})
    assert page.run("return window.saved") == ["sheet.pdf"]
    page.run(PRESS, "b", {})
    until(page, "return document.getElementById('big-digits')")
    page.run("[...document.querySelectorAll('#big-digits button')].pop().click()")


@pytest.mark.looks
def test_arrows_and_signs_turn_and_zoom_the_model_and_tab_goes_through_its_cuts(page: Browser) -> None:
    page.click_on(at("tab-see"))
    until(page, "return document.querySelectorAll('.handle').length > 1")
    page.run("document.getElementById('model').focus()")
    before, zoom = page.run(AWAY), "return document.getElementById('model').view.camera.zoom"
    for key in ("ArrowLeft", "ArrowUp"):
        page.run(PRESS, key, {})
        assert page.run(AWAY) != before
        before = page.run(AWAY)
    was = page.run(zoom)
    page.run(PRESS, "+", {})
    assert page.run(zoom) == pytest.approx(1.15 * was)
    page.run(PRESS, "-", {})
    assert page.run(zoom) == pytest.approx(was)
    page.run("document.querySelector('.handle[data-cut=\"1\"]').focus()")
    page.press(".handle[data-cut='1']", "\ue004")
    assert page.run(FOCUSED) == "2"


@pytest.mark.looks
def test_the_list_of_keys_names_each_and_leads_to_the_documentation(page: Browser) -> None:
    page.run("document.activeElement.blur()")
    page.run("document.querySelector('meta[name=autobalance-docs]').content = 'https://docs.test/app.md'")
    sections = [f"## {each}" for each in ("1. Crank", "2. Engine", "5. Machine", "Analyses")]
    for tab, title in zip(("open", "parts", "machine", "analyse"), sections, strict=True):
        page.click_on(at(f"tab-{tab}"))
        page.run("document.activeElement.blur()")
        page.run(PRESS, "?", {})
        until(page, "return document.getElementById('help').open")
        link = page.run("return document.getElementById('help-docs').href")
        anchor = title.removeprefix("## ").lower().replace(". ", "-")
        assert link == f"https://docs.test/app.md#{anchor}"
        keys = page.run("return [...document.querySelectorAll('#help kbd')].map(each => each.textContent)")
        assert {"1 – 5", "A", "H", "B", "M", "P", "W", "?"} <= set(keys)
        page.click_on(at("help-close"))
        until(page, "return !document.getElementById('help').open")
    for section in sections:
        assert section in (ROOT / "docs" / "app.md").read_text(encoding="utf-8")


PASTE = """
const field = document.querySelector("[data-group=rotating_g] [data-testid=weight-g]");
const clipboardData = new DataTransfer();
clipboardData.setData("text", arguments[0]);
field.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
"""


def test_in_a_table_enter_goes_down_and_pasted_numbers_fill_down(unopened: Browser, project: Served) -> None:
    rods = {"rod": 400.0, "bearing": 20.0, "shells": 11.0}
    engine = {**small.DRILLED["engine"], "rotating_g": rods}
    project.ask("/api/job", {**small.DRILLED, "engine": engine}, "PUT")
    page = load(unopened, project)
    page.click_on(at("tab-parts"))
    fields = "[...document.querySelectorAll('[data-group=rotating_g] [data-testid=weight-g]')]"
    page.run(f"{fields}[0].focus()")
    page.run(PRESS, "Enter", {})
    assert page.run(f"return {fields}.indexOf(document.activeElement)") == 1
    page.run(PASTE, "401,5\n21 g\n")
    text = job_text(page, "401.5")
    assert tomllib.loads(text)["engine"]["rotating_g"] == {"rod": 401.5, "bearing": 21, "shells": 11}
    assert page.run(f"return {fields}.map(each => each.value)") == ["401.5", "21", "11"]


@pytest.mark.looks
def test_a_run_is_listed_with_its_crank(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    page.run(
        "[...document.querySelectorAll('#run-list button')].find(b => /^All/.test(b.textContent))?.click()"
    )
    shown = page.run(
        "return [...document.querySelectorAll('#run-list li span:first-child')].map(each => each.textContent)"
    )
    name = page.run("return document.getElementById('crank-name').textContent")
    assert any(each.startswith(f"{name} balance: done") for each in shown)
