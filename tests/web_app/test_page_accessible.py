"""The page is for people who do not see it or cannot point, too: axe-core finds nothing serious."""

from importlib.resources import files
from typing import Any

import pytest

from tests.report.browser import Browser
from tests.web_app.page import BROWSER, at, until

pytestmark = BROWSER
RUN = """
window.axe_found = null;
axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "best-practice"] }).then(({ violations }) => {
  window.axe_found = violations.filter(each => ["serious", "critical"].includes(each.impact))
    .map(each => [each.id, each.nodes.map(node => node.html.slice(0, 160))]);
});
"""


@pytest.mark.parametrize("size", [(1280, 860), (390, 844)], ids=["wide", "narrow"])
def test_axe_finds_nothing_serious_on_any_tab(page: Browser, size: tuple[int, int]) -> None:
    page.resize(*size)
    page.run(files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    wrong: dict[str, Any] = {}
    for tab in ("open", "parts", "correct", "see", "analyse", "machine", "history"):
        page.click_on(at(f"tab-{tab}"))
        page.run("for (const each of document.querySelectorAll('details')) each.open = true;" + RUN)
        until(page, "return window.axe_found !== null")
        found = page.run("return window.axe_found")
        if found:
            wrong[tab] = found
    assert wrong == {}
