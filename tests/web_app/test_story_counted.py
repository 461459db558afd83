"""Both stories of the design with a real pointer and real keys: every click and keystroke is counted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import (
    BROWSER,
    READY,
    at,
    chosen,
    latest,
    load,
    nothing_wrong,
    outcome,
    shows_the_report,
    text_of,
    until,
)
from tests.web_app.serving import Served, served

pytestmark = BROWSER
TAB, ENTER = "\ue004", "\ue007"
PLACE = """
const found = document.querySelector(arguments[0]), body = document.querySelector(".panel > .body");
if (!found) return null;
let box = found.getBoundingClientRect();
const frame = body.contains(found) ? body.getBoundingClientRect() : { top: 0, bottom: innerHeight };
const isSeen = box.top >= frame.top - 1 && box.bottom <= frame.bottom + 1;
if (!isSeen) { found.scrollIntoView({ block: "center" }); box = found.getBoundingClientRect(); }
const x = box.x + box.width / 2, y = box.y + box.height / 2, top = document.elementFromPoint(x, y);
return { x, y, isSeen, isFree: found.contains(top), isOff: Boolean(found.disabled) };
"""
SHEET = "#downloads [data-file='sheet.pdf']"
CERTIFICATE = "#downloads [data-file='certificate.pdf']"
SAYS = "document.querySelector('[data-testid=state-line]').textContent"
FIRST_WEIGHT = "#weights [data-group=rotating_g] [data-testid=weight-{}]"
IS_RESULT = (
    "return document.body.dataset.tab === 'see' && Boolean(document.getElementById('verdict').dataset.tone)"
)


class Person:
    """Somebody with a mouse and a keyboard: what is done is counted, what had to be sought is listed."""

    def __init__(self, page: Browser) -> None:
        self.page, self.clicks, self.keys = page, 0, 0
        self.sought: list[str] = []

    def click(self, what: str) -> None:
        place: dict[str, Any] = until(self.page, PLACE, what)
        assert not place["isOff"], f"{what} cannot be pressed: {text_of(self.page, 'state-line')}"
        assert place["isFree"], f"something lies over {what}"
        if not place["isSeen"]:
            self.sought.append(what)
        self.page.click(place["x"], place["y"])
        self.clicks += 1

    def type(self, text: str) -> None:
        """Press keys where the focus is."""
        acts = [{"type": kind, "value": key} for key in text for kind in ("keyDown", "keyUp")]
        self.page.call("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": acts}]})
        self.keys += len(text)


def given(page: Browser, app: Served, link: str) -> bytes:
    """Return what a link of the papers gives."""
    url = page.run("return document.querySelector(arguments[0]).href", link)
    return app.ask(url.removeprefix(app.base)).body


def test_the_example_becomes_a_shop_sheet_in_6_clicks_and_4_keys(window: Browser, app: Served) -> None:
    window.resize(1440, 1043)
    page = load(window, app)
    person = Person(page)
    with nothing_wrong(page, app):
        person.click(at("bundled"))
        until(page, READY)
        person.click(at("next"))
        until(page, f"return {SAYS}.includes('0.818')")
        person.click(at("factor"))
        person.type("0.25")
        until(page, "return document.getElementById('job-text').textContent.includes('factor = 0.25')")
        person.click(at("next"))
        person.click(at("balance"))
        until(page, IS_RESULT)
        person.click(SHEET)
        assert given(page, app, SHEET).startswith(b"%PDF")
        assert page.run("return document.getElementById('verdict').dataset.tone") == "good"
        assert outcome(page) == "within_tolerance"
        shows_the_report(page, app)
        groups = "return [...document.querySelectorAll('#downloads p > small')].length"
        assert page.run(groups) == 4
        names = page.run(
            "return [...document.querySelectorAll('#downloads a[download]')].map(each => each.download)"
        )
        assert all(name.startswith("crank-") for name in names)
    assert (person.clicks, person.keys, person.sought) == (6, 4, [])


def test_an_own_file_with_three_new_weights_takes_9_clicks_and_40_keys(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    window.resize(1440, 1043)
    page = load(window, app)
    person = Person(page)
    with nothing_wrong(page, app):
        chosen(page, small.crank(tmp_path))  # dropped on the page
        until(page, READY)
        person.click(at("unit-yes"))
        person.click(at("next"))
        person.click(at("columns-both"))
        for column, grams in (("was", ("430", "200", "350")), ("g", ("400", "180", "320"))):
            person.click(FIRST_WEIGHT.format(column))
            person.type(f"{grams[0]}{2 * ENTER}{grams[1]}{ENTER}{grams[2]}")
        person.click(at("factor-of-makers"))
        person.type(f"{TAB}6000{TAB}16")
        until(page, f"return {SAYS}.includes('wanted')")
        person.click(at("next"))
        person.click(at("balance"))
        until(page, IS_RESULT)
        person.click(SHEET)
        assert given(page, app, SHEET).startswith(b"%PDF")
        report = latest(app, "balance")["report"]
        assert report["job"]["balance"]["factor"] == "original"
        assert report["balance_factor"]["target"] < report["balance_factor"]["initial"]  # lighter parts
    assert person.clicks == 9
    assert person.keys == 32  # at most 40
    assert person.sought == []


def test_a_drawn_v8_has_its_certificate_after_two_readings_in_22_clicks_and_90_keys(
    window: Browser, tmp_path: Path
) -> None:
    window.resize(1440, 1043)
    with served(tmp_path / "project") as app:
        person = of_a_drawn_v8(load(window, app), app)
    assert person.clicks == 14  # at most 22
    assert person.keys == 61  # at most 90
    assert person.sought == []


def of_a_drawn_v8(page: Browser, app: Served) -> Person:
    person = Person(page)
    with nothing_wrong(page, app):
        person.click(at("preset"))
        person.type(f"v8{ENTER}")
        person.click(at("draw-preset"))
        until(page, READY)
        person.click(at("next"))
        person.click(FIRST_WEIGHT.format("g"))
        person.type(f"480{ENTER}45{ENTER}150{ENTER}450{ENTER}100")
        person.click(at("factor"))
        person.type(f"0.5{TAB}6500{TAB}6.3")
        until(page, f"return {SAYS}.includes('wanted')")
        person.click(at("next"))
        person.click(at("balance"))
        until(page, IS_RESULT)
        person.click(at("next"))
        for stage, reading in ((2, ("400", "200", "300", "20")), (3, ("90", "45", "80", "310"))):
            person.click(at("g-mm-1"))
            person.type(f"{reading[0]}{TAB}{reading[1]}{TAB}{TAB}{reading[2]}{TAB}{reading[3]}")
            person.click(at("recut"))
            until(page, "return document.querySelectorAll('#stages tbody tr').length === arguments[0]", stage)
        person.click(at("tab-see"))
        person.click(CERTIFICATE)
        assert given(page, app, CERTIFICATE).startswith(b"%PDF")
        assert [each["stage"] for each in latest(app, "recut")["report"]["stages"]] == [1, 2, 3]

    return person
