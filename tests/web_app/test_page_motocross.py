"""The two commonest jobs on the bundled single, from the weights to the papers, on one page."""

from collections.abc import Iterator

import pytest

import autobalance as ab
from tests.report.browser import Browser
from tests.web_app.page import BROWSER, READY, at, load, nothing_wrong, text_of, until
from tests.web_app.serving import Served

pytestmark = BROWSER
MAKERS = "document.querySelector('[data-testid=factor-of-makers]')"
TYPED = """
const [name, grams] = arguments;
const row = [...document.querySelectorAll("[data-testid=weight-row]")]
  .find(each => each.querySelector("[data-testid=weight-name]").value === name);
const field = row.querySelector("[data-testid=weight-g]");
field.value = grams;
field.dispatchEvent(new Event("input", { bubbles: true }));
"""
FOLLOWED = """
const [now, done] = arguments, began = performance.now();
const says = () => document.querySelector("[data-testid=state-line]").textContent;
const field = [...document.querySelectorAll("[data-testid=weight-g]")].find(each => each.value === "27");
const wait = () => says().includes(now) ? done(performance.now() - began) : setTimeout(wait, 5);
field.value = "35";
field.dispatchEvent(new Event("input", { bubbles: true }));
wait();
"""
SEEN = """
return [...document.querySelectorAll(arguments[0])].map(each => each.getBoundingClientRect())
  .filter(box => box.width && box.top >= 0 && box.bottom <= innerHeight).length;
"""


@pytest.fixture(scope="module")
def motocross(app: Served, window: Browser) -> Iterator[Browser]:
    """The page with the bundled single opened."""
    window.resize(1400, 900)
    page = load(window, app)
    with nothing_wrong(page, app):
        page.click_on(at("bundled"))
        until(page, READY)
        yield page


def test_what_the_parts_weighed_and_weigh_stand_side_by_side(motocross: Browser, app: Served) -> None:
    page = motocross
    page.click_on(at("tab-parts"))
    until(page, "return document.querySelector('[data-testid=state-line]').textContent.includes('0.818')")
    says = text_of(page, "state-line")
    assert says.startswith("Counterweights too heavy")
    for words in ("0.280 wanted", "Bob-weight 321.91 g", "Clamp on 207.26 g", "Heavy side at 180.0°"):
        assert words in says
    assert page.run(SEEN, "#preview-polar svg") == 3
    assert page.run(SEEN, "#weights .changed") == 3
    took_ms = page.call("POST", "/execute/async", {"script": FOLLOWED, "args": ["Bob-weight 324.15 g"]})
    assert took_ms < 2000.0  # 200 ms on a machine that does nothing else
    page.run(TYPED, "wrist_pin", "27")
    until(page, "return document.querySelector('[data-testid=state-line]').textContent.includes('321.91')")


def test_the_makers_factor_is_kept_by_one_click_and_the_factors_are_those_of_the_command(
    motocross: Browser, app: Served
) -> None:
    page = motocross
    page.click_on(at("tab-parts"))
    until(
        page, "return document.querySelector('[data-testid=factor-of-makers]').textContent.includes('0.638')"
    )
    page.run("document.querySelector('[data-testid=compare-factors]').click()")
    rows = "return [...document.querySelectorAll('#factors tbody tr')].map(each => [each.dataset.name,"
    rows += " ...['factor', 'force'].map(key => Number(each.querySelector(`[data-${key}]`).dataset[key]))])"
    found = until(page, f"const all = (() => {{ {rows} }})(); return all.length && all")
    job = ab.Job.from_dict(app.ask("/api/project").json["job"], folder=app.project)
    own = ab.factor(job).report["candidates"]
    assert found == [[each["name"], each["factor"], each["greatest_N"]] for each in own]
    page.run("document.querySelector('[data-testid=factor-of-makers] input').click()")
    until(page, "return document.getElementById('factor-kept')?.textContent === '0.638'")
    until(page, "return document.getElementById('job-text').textContent.includes('factor = \"original\"')")
    page.run("document.querySelector('[data-name=given] button').click()")
    until(page, "return document.getElementById('factor')?.value === '0.28'")
    for grams, is_old in (("28", "true"), ("27", "false")):
        page.run(TYPED, "wrist_pin", grams)
        until(page, f"return document.getElementById('factors').dataset.old === '{is_old}'")
