"""The first view, and the unit of a file that has none: asked until it is answered."""

from pathlib import Path

from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, READY, at, chosen, load, nothing_wrong, put, text_of, until
from tests.web_app.serving import Served

pytestmark = BROWSER
ASKED = "return document.getElementById('unit-field').dataset.asked"
SEEN = """
const seen = what => [...document.querySelectorAll(what)].filter(each => each.getClientRects().length);
return ["button.main", ":disabled", ".ways section", "#model"].map(what => seen(what).length);
"""


def test_the_first_view_has_three_ways_in_and_a_unit_is_asked_for(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    page = load(window, app)
    with nothing_wrong(page, app):
        assert page.run(SEEN) == [1, 0, 3, 0]
        crank = small.crank(tmp_path)
        chosen(page, crank)
        until(page, READY)
        assert page.run(ASKED) == "true"
        assert "unit" not in app.ask("/api/project").json["job"]["crankshaft"]
        assert text_of(page, "state-line").startswith("Is the file in mm?")
        page.click_on(at("tab-correct"))
        assert page.run("return document.getElementById('balance').disabled")
        assert "1 question" in text_of(page, "state-line")
        page.click_on(at("tab-open"))
        put(page, unit="cm")
        page.run("document.getElementById('unit').dispatchEvent(new Event('change', { bubbles: true }))")
        until(page, "return document.querySelector('[data-testid=unit-strange]') !== null")
        assert page.run(ASKED) == "false"
        assert app.ask("/api/project").json["job"]["crankshaft"]["unit"] == "cm"
        other = tmp_path / "other.stl"
        other.write_bytes(crank.read_bytes())
        chosen(page, other)
        until(page, f"{ASKED} === 'true' && document.getElementById('unit').value === 'mm'")
        until(page, READY)
        assert page.run("return document.querySelector('[data-testid=unit-strange]')") is None
        assert "unit" not in app.ask("/api/project").json["job"]["crankshaft"]
        page.click_on(at("unit-yes"))
        until(page, f"{ASKED} === 'false'")
