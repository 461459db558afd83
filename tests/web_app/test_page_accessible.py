"""The page is for people who do not see it or cannot point, too: axe-core finds nothing, light or dark."""

from importlib.resources import files
from typing import Any

import pytest

from tests.report.browser import Browser
from tests.web_app.page import BROWSER, at, until

pytestmark = BROWSER
RULES = {"light": ["wcag2a", "wcag2aa", "best-practice"], "dark": ["color-contrast", "link-in-text-block"]}
"""What stands on the page is the same in both schemes: in the dark one only its colours are left to hold."""
RUN = """
window.axe_found = null;
const options = { runOnly: arguments[0], resultTypes: ["violations"], selectors: false };
axe.run(document, options).then(({ violations }) => {
  window.axe_found = violations.map(each => [each.id, each.nodes.map(node => node.html.slice(0, 160))]);
});
"""


TEXTS_IN_DRAWINGS = """
const parts = text => text.match(/[\\d.]+/g).map(Number);
const linear = v => v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4;
const light = text => parts(text).map(linear).slice(0, 3)
  .reduce((sum, v, k) => sum + [0.2126, 0.7152, 0.0722][k] * v, 0);
const covers = (shape, each) => { // a number on its badge
  const a = shape.getBoundingClientRect(), b = each.getBoundingClientRect();
  return a.left <= b.left && b.right <= a.right && getComputedStyle(shape).fill.startsWith("rgb");
};
const ground = (each) => {
  const before = each.previousElementSibling;
  const isBadge = before && /rect|circle/.test(before.tagName) && covers(before, each);
  if (isBadge) return light(getComputedStyle(before).fill);
  for (let box = each; box; box = box.parentElement) {
    const own = getComputedStyle(box).backgroundColor, all = parts(own);
    if (!(box instanceof SVGElement) && (all.length === 3 || all[3] === 1)) return light(own);
  }
  return 1;
};
const found = [...document.querySelectorAll("svg text")];
return found.filter(each => each.getClientRects().length && each.textContent.trim()).map(each => {
  const ink = light(getComputedStyle(each).fill), behind = ground(each);
  return [each.textContent, (Math.max(ink, behind) + 0.05) / (Math.min(ink, behind) + 0.05)];
}).filter(each => each[1] < 4.5);
"""


def colours(page: Browser, scheme: str) -> None:
    features = [{"name": "prefers-color-scheme", "value": scheme}] if scheme else []
    asked = {"cmd": "Emulation.setEmulatedMedia", "params": {"features": features}}
    page.call("POST", "/goog/cdp/execute", asked)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 860), (390, 844)], ids=["wide", "narrow"])
@pytest.mark.looks
def test_axe_finds_nothing_on_any_tab(page: Browser, size: tuple[int, int], scheme: str) -> None:
    page.resize(*size)
    colours(page, scheme)
    try:
        assert found_on_tabs(page, RULES[scheme]) == {}
    finally:
        colours(page, "")
        page.resize(1400, 900)


def found_on_tabs(page: Browser, rules: list[str]) -> dict[str, Any]:
    """Return what axe finds on each tab, and texts of drawings without contrast, which axe leaves out."""
    page.run(files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    wrong: dict[str, Any] = {}
    steps = ("tab-open", "tab-parts", "tab-correct", "tab-see", "view-webs", "tab-analyse", "tab-machine")
    for tab in (*steps, "tab-history", "to-start"):
        page.click_on(at(tab))
        page.run("for (const each of document.querySelectorAll('details')) each.open = true;" + RUN, rules)
        until(page, "return window.axe_found !== null")
        found = page.run("return window.axe_found") + page.run(TEXTS_IN_DRAWINGS)
        if found:
            wrong[tab] = found
    return wrong
