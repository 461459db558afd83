"""The machine on the page: stages with what was read, expected and left; the polar's path; the big screen."""

from __future__ import annotations

import io
import json
import re
from datetime import UTC, datetime
from typing import Any

import pytest
from pypdf import PdfReader

import autobalance as ab
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, at, latest, load, nothing_wrong, put, text_of, until
from tests.web_app.serving import Served

pytestmark = BROWSER
TWO_STAGES = "return document.querySelectorAll('#stages tbody tr').length === 2"
STAGES = (
    "return [...document.querySelectorAll('#stages tbody tr')].map(row => Object.fromEntries("
    "[...row.querySelectorAll('[data-key]')]"
    ".map(each => [each.dataset.key.split('.')[2], Number(each.dataset.value)])))"
)
BIG = """
const keys = [...document.querySelectorAll("#big-digits .buttons button")]
  .map(each => each.getBoundingClientRect());
const digits = getComputedStyle(document.querySelector("#big-digits .big-cut dd"));
return [parseFloat(digits.fontSize) / innerHeight, Math.min(...keys.map(each => each.height)),
  Math.min(...keys.map(each => innerHeight - each.bottom)),
  document.getElementById("big-digits").textContent];
"""


def test_a_reading_makes_a_stage_with_what_was_read_expected_and_left(window: Browser, app: Served) -> None:
    page = window
    page.resize(1400, 900)
    app.ask(f"/api/files?name={small.NAME}", small.crank(app.project.parent).read_bytes())
    for verb in ("inspect", "balance"):
        small.ran(app, verb, small.DRILLED)
    app.ask("/api/job", small.DRILLED, "PUT")
    load(page, app)
    with nothing_wrong(page, app):
        page.click_on(at("tab-machine"))
        permitted = latest(app, "balance")["report"]["tolerance"]["planes"][0]["permissible_g_mm"]
        first = 1.5 * permitted
        put(page, g_mm_1=first, angle_1=180, g_mm_2=first, angle_2=180)
        expected = latest(app, "balance")["report"]["residual"]["planes"][0]["unbalance_g_mm"]
        drawn = until(
            page,
            "const d = document.querySelector('[data-testid=read-polar-1]');"
            "const path = d.querySelector('.p-path'), ring = d.querySelector('.p-expected');"
            "return path && [d.dataset.expected, path.getAttribute('d'),"
            "...['cx', 'cy'].map(name => ring.getAttribute(name))]",
        )
        assert json.loads(drawn[0]) == expected
        assert drawn[1].startswith(f"M{drawn[2]} {drawn[3]}L")  # from what was expected
        assert drawn[1].endswith("L100.00 166.00")  # to what is read: straight down, at the rim
        page.click_on(at("recut"))
        until(page, TWO_STAGES)
        report: dict[str, Any] = latest(app, "recut")["report"]
        rows = page.run(STAGES)
        for row, stage in zip(rows, report["stages"], strict=True):
            for key in ("reading", "expected", "predicted"):
                if stage[key] is not None:
                    assert row[key] == stage[key]["magnitude_g_mm"]
        assert rows[1]["reading"] == pytest.approx(2.0 * first)
        assert page.run("return document.querySelectorAll('#next-cuts tr.turns').length") == len(
            report["corrections"]
        )
        said = page.run("return document.querySelector('[data-testid=state-line]').textContent")
        assert said.startswith(f"Next cuts: {len(report['corrections'])}")
        places = (
            "return ['next-cuts', 'plane-1'].map(id => document.getElementById(id).getBoundingClientRect().y)"
        )
        cuts, fields = page.run(places)
        assert 0.0 < cuts < fields  # what to cut now, before the next reading
        page.click_on(at("big"))
        until(page, "return document.querySelector('#big-digits').open")
        page.run("[...document.querySelectorAll('#big-digits .buttons button')][1].click()")
        until(page, "return document.querySelector('.big-cut dd')")
        share, key, foot, words = page.run(BIG)
        assert share >= 1.0 / 8.0
        assert key >= 88.0
        assert foot > 0.0
        assert "0° at crankpin 1, counter-clockwise seen from +z" in words
        try:
            page.resize(390, 844)
            assert page.run(BIG)[1] >= 88.0
            cut_off = (
                "const box = document.querySelector('.big-cut'); return box.scrollWidth - box.clientWidth"
            )
            assert page.run(cut_off) <= 0
        finally:
            page.resize(1400, 900)
        page.run("document.getElementById('big-digits').close()")
        moves_no_verdict(page)


def moves_no_verdict(page: Browser) -> None:
    """A cut that is moved after a reading is a prediction: the line at the foot says so and takes it back."""
    page.click_on(at("tab-see"))
    says = "document.querySelector('[data-testid=state-line]').textContent"
    verdict = page.run(f"return {says}")
    page.press(".handle", 5 * "\ue013")
    until(page, f"return {says}.startsWith('Moved by hand, not cut yet')")
    page.click_on("#line-as-it-was")
    until(page, f"return {says} === arguments[0]", verdict)


CUT = "return document.querySelector('#big-digits .big-cut')?.dataset.cut"
TICKS = (
    "return Object.fromEntries([...document.querySelectorAll('#cuts [data-testid=tick]')].map(each =>"
    "[each.closest('tr').querySelector('[data-cut]').dataset.cut, each.dataset.at]))"
)


def sheet_rows(app: Served, run: str) -> list[str]:
    return rows_of(app.ask(f"/api/runs/{run}/files/sheet.pdf").body)


def rows_of(sheet: bytes) -> list[str]:
    """Return the rows of the cuts in the table of a shop sheet."""
    text = PdfReader(io.BytesIO(sheet)).pages[0].extract_text()
    rows = [line.strip() for line in text.splitlines() if re.match(r"\s*\d+ +Drilled hole", line)]
    assert len(rows) == 2
    return rows


def test_a_cut_that_is_done_is_ticked_with_its_time_and_another_screen_follows(
    page: Browser, project: Served
) -> None:
    run = latest(project, "balance")["id"]
    page.click_on(at("tab-machine"))
    page.click_on(at("big"))
    page.run("[...document.querySelectorAll('#big-digits .buttons button')][1].click()")
    until(page, f"{CUT} === '1'")
    desk = page.call("GET", "/window")
    page.run("window.open('/#big')")
    (screen,) = {*page.call("GET", "/window/handles")} - {desk}
    try:
        page.call("POST", "/window", {"handle": screen})
        until(page, f"{CUT} === '1'")
        keys = page.run(
            "return [...document.querySelectorAll('#big-digits button:not([hidden])')]"
            ".map(each => Math.min(each.getBoundingClientRect().height, each.getBoundingClientRect().width))"
        )
        assert len(keys) == 3
        assert min(keys) >= 88.0
        page.call("POST", "/window", {"handle": desk})
        before = datetime.now(UTC).replace(microsecond=0)
        page.click_on(at("cut-done"))
        until(page, f"{CUT} === '2'")
        page.call("POST", "/window", {"handle": screen})
        until(page, f"{CUT} === '2'", most_s=20.0)
        page.click_on(at("cut-done"))  # this screen ticks too
        page.call("POST", "/window", {"handle": desk})
        ticks = until(page, f"const found = (() => {{ {TICKS} }})(); return found[2] && found", most_s=20.0)
        assert set(ticks) == {"1", "2"}
        assert before <= datetime.fromisoformat(ticks["1"]) <= datetime.now(UTC)
        assert project.ask(f"/api/runs/{run}/ticks").json == {"ticks": ticks, "latest": run}
        assert text_of(page, "cuts-done") == "Cuts done: 2 of 2"
        page.call("POST", "/refresh", {})
        until(page, "return document.body.dataset.ready === 'true'")
        assert page.run(TICKS) == ticks  # kept with the result
        done = [datetime.fromisoformat(each).astimezone().strftime("%m-%d %H:%M") for each in ticks.values()]
        assert [row[-len("mm-dd hh:mm") :] for row in sheet_rows(project, run)] == done
        drawn_again = ab.sheet(project.project / "runs" / run / "report.json").files()["sheet.pdf"]
        assert [row[-len("mm-dd hh:mm") :] for row in rows_of(drawn_again)] == done
        assert "done.json" not in project.ask(f"/api/runs/{run}").json["files"]
    finally:
        page.call("POST", "/window", {"handle": screen})
        page.call("DELETE", "/window")
        page.call("POST", "/window", {"handle": desk})
        for number in (1, 2):
            project.ask(f"/api/runs/{run}/ticks", {"number": number, "done": False}, "PUT")
    assert project.ask(f"/api/runs/{run}/ticks").json["ticks"] == {}
    assert not any(re.search(r"\d\d:\d\d$", row) for row in sheet_rows(project, run))
    assert project.ask(f"/api/runs/{run}/ticks", {"number": 3, "done": True}, "PUT").status == 400
    assert project.ask(f"/api/runs/{run}/ticks", {"number": True, "done": True}, "PUT").status == 400
