"""Nothing wrong is shown: a result under its own job and crank, one zero, readings that are whole."""

import time
import tomllib
from collections.abc import Iterator

import pytest

from autobalance.report.balance.zero import with_design_radii
from autobalance.report.records.balanced import BalancedReport
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import (
    BROWSER,
    READY,
    at,
    job_text,
    latest,
    load,
    nothing_wrong,
    other_crank,
    put,
    text_of,
    until,
)
from tests.web_app.serving import Served

pytestmark = BROWSER
TONE = "return document.querySelector('[data-testid=verdict]').dataset.tone || ''"
IS = "return document.querySelector('[data-testid=verdict]').dataset.tone === arguments[0]"
PLACES = """
return [...document.querySelectorAll("#panel-parts :is(input, select, button)")]
  .filter(each => each.offsetParent).map(each => Math.round(each.getBoundingClientRect().y + scrollY));
"""
CONTRAST = """
const parts = text => text.match(/[\\d.]+/g).map(Number);
const linear = v => v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4;
const light = text => parts(text).map(linear).slice(0, 3)
  .reduce((sum, v, k) => sum + [0.2126, 0.7152, 0.0722][k] * v, 0);
const box = document.getElementById("big-digits"), ground = light(getComputedStyle(box).backgroundColor);
const texts = [...box.querySelectorAll("text, dt, dd, p, button, label")];
return texts.filter(each => each.textContent.trim() && !each.disabled).map(each => {
  const style = getComputedStyle(each), own = parts(style.backgroundColor);
  const behind = own.length === 4 && own[3] === 0 ? ground : light(style.backgroundColor);
  const ink = light(each instanceof SVGElement ? style.fill : style.color);
  return [each.textContent.slice(0, 30), (Math.max(ink, behind) + 0.05) / (Math.min(ink, behind) + 0.05)];
});
"""


def reloaded(page: Browser) -> None:
    page.call("POST", "/refresh", {})
    until(page, "return document.body.dataset.ready === 'true'")


def grams(page: Browser, text: str) -> None:
    page.run(
        "const field = document.querySelector('[data-group=reciprocating_g] [data-testid=weight-g]');"
        "field.value = arguments[0]; field.dispatchEvent(new Event('input', { bubbles: true }));",
        text,
    )


def test_a_result_is_grey_while_the_job_says_otherwise(page: Browser) -> None:
    assert page.run(TONE) == "warn"
    page.click_on(at("tab-parts"))
    put(page, key_job_customer="Ann")  # stands on papers alone
    job_text(page, "Ann")
    assert page.run(TONE) == "warn"
    put(page, key_engine_rod_length_mm="120")  # changes loads and no cut
    job_text(page, "rod_length_mm = 120")
    assert page.run(TONE) == "warn"
    grams(page, "460,5")
    until(page, IS, "stale")
    assert text_of(page, "job-changed") == "Piston: 500 → 460.50"
    reloaded(page)
    assert page.run(TONE) == "stale"
    grams(page, "500")
    until(page, IS, "warn")
    reloaded(page)
    assert page.run(TONE) == "warn"


def test_the_job_of_a_result_is_taken_back(page: Browser, project: Served) -> None:
    grams(page, "460")
    until(page, IS, "stale")
    page.click_on(at("tab-see"))
    page.click_on(at("job-of"))
    until(page, IS, "warn")
    assert project.ask("/api/project").json["job"]["engine"]["reciprocating_g"] == {"piston": 500}
    text = project.ask(f"/api/runs/{latest(project, 'balance')['id']}/job").body.decode()
    assert tomllib.loads(text) == small.DRILLED


@pytest.fixture
def two(window: Browser, app: Served, project: Served) -> Iterator[Browser]:
    """A project with the small crank, balanced."""
    app.ask(f"/api/files?name={small.NAME}", (project.project / small.NAME).read_bytes())
    for verb in ("inspect", "balance"):
        small.ran(app, verb, small.DRILLED)
    app.ask("/api/job", small.DRILLED, "PUT")
    load(window, app)
    with nothing_wrong(window, app):
        yield window


def test_no_result_of_one_crank_stands_under_another(two: Browser, app: Served) -> None:
    other_crank(two)
    put(two, preset="single")
    two.click_on(at("draw-preset"))
    until(two, READY)
    for _ in range(2):
        assert two.run(TONE) == ""
        assert two.run("return document.querySelectorAll('#panel-see [data-key]').length") == 0
        assert two.run("return document.getElementById('machine-none') !== null")
        reloaded(two)
    two.click_on(at("tab-correct"))
    two.run(
        "[...document.querySelectorAll('#run-list button')].find(b => b.ariaLabel.startsWith('Show')).click()"
    )
    until(two, IS, "warn")
    assert app.ask("/api/project").json["job"] == small.DRILLED
    assert "small, " in two.run("return document.getElementById('result-of').textContent")


def test_two_tabs_keep_what_both_typed(page: Browser, project: Served) -> None:
    page.click_on(at("tab-parts"))
    elsewhere = {**small.DRILLED, "engine": {**small.DRILLED["engine"], "rotating_g": {"rod": 111.0}}}
    project.ask("/api/job", elsewhere, "PUT")
    put(page, factor="0.43")
    until(page, "return document.getElementById('clash')?.open")
    assert "111" in text_of(page, "clash")
    page.click_on(at("keep-both"))
    job_text(page, "0.43")
    until(page, "return !document.getElementById('clash').open")
    end = time.monotonic() + 10
    while (job := project.ask("/api/project").json["job"])["balance"]["factor"] != 0.43:
        assert time.monotonic() < end
    assert job["engine"]["rotating_g"] == {"rod": 111}
    fields = "return [...document.querySelectorAll('[data-testid=weight-g]')].map(each => each.value)"
    assert "111" in page.run(fields)
    assert all("409" in each["message"] for each in page.log("browser"))


@pytest.mark.looks
def test_nothing_moves_when_a_field_has_the_focus(page: Browser) -> None:
    page.click_on(at("tab-parts"))
    page.run("for (const each of document.querySelectorAll('#panel-parts details')) each.open = true")
    before = page.run(PLACES)
    said = set()
    for place in range(0, len(before), 9):
        page.run(
            "[...document.querySelectorAll('#panel-parts :is(input, select, button)')]"
            ".filter(each => each.offsetParent)[arguments[0]].focus({ preventScroll: true })",
            place,
        )
        assert page.run(PLACES) == before
        said.add(text_of(page, "help"))
    assert len(said) > 3


def test_a_reading_waits_for_its_numbers_and_is_there_again(page: Browser, project: Served) -> None:
    page.run("localStorage.clear()")
    reloaded(page)
    page.click_on(at("tab-machine"))
    runs = len(project.ask("/api/runs").json["runs"])
    assert page.run("return document.querySelectorAll('#read-polars .tip').length") == 0
    assert "read 0" not in page.run("return document.getElementById('read-polars').textContent")
    assert page.run("return document.getElementById('recut').disabled")
    put(page, g_mm_1=150, angle_1=180, g_mm_2="15o", angle_2=180)
    until(page, "return document.getElementById('g-mm-2').getAttribute('aria-invalid') === 'true'")
    assert "15o" in page.run("return document.getElementById('g-mm-2-note').textContent")
    put(page, g_mm_2=150, umar="")
    until(page, "return document.getElementById('umar-note').textContent !== ''")
    assert page.run("return document.getElementById('recut').disabled")
    assert "residual" in text_of(page, "recut-needs")
    put(page, umar=0.5)
    until(page, "return !document.getElementById('recut').disabled")
    reloaded(page)
    assert page.run("return document.getElementById('g-mm-2').value") == "150"
    assert len(project.ask("/api/runs").json["runs"]) == runs
    page.click_on(at("big"))
    until(page, "return document.querySelector('#big-digits text')")
    for _ in range(2):
        found = page.run(CONTRAST)
        assert [each for each in found if each[1] < 4.5] == []
        page.run("[...document.querySelectorAll('#big-digits button')][1].click()")
        until(page, "return document.querySelector('.big-cut dd')")
        high, key, foot = page.run(
            "const keys = [...document.querySelectorAll('#big-digits button')].pop().getBoundingClientRect();"
            "const dd = getComputedStyle(document.querySelector('.big-cut dd'));"
            "return [parseFloat(dd.fontSize) / innerHeight, keys.height, innerHeight - keys.bottom]"
        )
        assert high >= 0.125
        assert key >= 88.0
        assert foot > 0.0


@pytest.mark.looks
def test_a_hole_has_one_angle_and_its_entry_radius(page: Browser, project: Served) -> None:
    page.click_on(at("tab-see"))
    report = latest(project, "balance")["report"]
    zero = (report["crank"]["datums"]["angle"] or {"angle_deg": 0.0})["angle_deg"]
    rows = page.run(
        "return [...document.querySelectorAll('#cuts tr.turns')]"
        ".map(row => [...row.cells].map(each => each.textContent))"
    )
    listed = project.ask(f"/api/runs/{latest(project, 'balance')['id']}/papers/holes.csv").body.decode()
    for cut, row in zip(with_design_radii(BalancedReport.read(report)).corrections, rows, strict=True):
        assert row[2] == f"{(cut.angle_deg - zero) % 360:.1f}° P1↺"
        assert float(row[3]) == pytest.approx(cut.shown_radius_mm, abs=0.00501)
        assert f"{float(row[3]):.2f}" in listed
    assert "crankpin 1" in text_of(page, "zero")


def test_forces_are_one_line_once_the_rod_length_is_known(page: Browser, project: Served) -> None:
    line = "document.getElementById('forces-line')"
    page.click_on(at("tab-parts"))
    words = until(page, f"return !{line}.hidden && {line}.textContent")
    greatest = latest(project, "balance")["report"]["forces"]["before"]["greatest_n"]
    assert words.startswith(f"Forces today: up to {greatest:.0f} N at 6000 rpm.")
    put(page, key_engine_rod_length_mm="20")  # shorter than the crank radius
    until(page, f"return {line}.textContent.includes('must be more than')")
    put(page, key_engine_rod_length_mm="")
    until(page, f"return {line}.hidden")


def test_a_verdict_that_is_not_met_tells_of_the_place_that_misses_it(window: Browser, app: Served) -> None:
    def of(size: float) -> dict[str, float]:
        return {"magnitude_g_mm": size, "uncertainty_g_mm": 1.0}

    planes = [{"name": "A", **of(30275.4)}, {"name": "B", **of(80.0)}]
    permitted = {"permissible_g_mm": 227.36, "planes": [{"permissible_g_mm": 111.5}] * 2}
    report = {
        "outcome": "above_tolerance",
        "residual": {**of(87.4), "planes": planes},
        "tolerance": {"grade_mm_s": 6.3, "speed_rpm": 6500, **permitted},
    }
    page = load(window, app)
    ask = "import('/static/verdict.js').then(all => { window.told = all.judgement(report, null).says; })"
    page.run(f"const report = arguments[0]; {ask}", report)
    says = until(page, "return window.told")
    assert says == "Plane A: Residual 30275.40 ± 1.00 g·mm; G 6.3 permits 111.50 g·mm at 6500 rpm."


ADDED = """
const table = document.getElementById("cuts-added");
return [table.caption.textContent, [...table.tHead.rows[0].cells].map(each => each.innerText),
  [...table.querySelectorAll("tr.turns")].map(row => [...row.cells].map(each => each.innerText))];
"""


def test_a_pad_is_added_with_a_height_under_its_own_heading(window: Browser, app: Served) -> None:
    name, page = "pads.stl", window
    if not (app.project / name).exists():
        app.ask(f"/api/files?name={name}", small.crank(app.project.parent).read_bytes())
    table = {**small.DRILLED["crankshaft"], "file": name}
    balance = {"factor": 0.9, "grade": 16.0, "speed_rpm": 6000.0}
    job = small.job(crankshaft=table, balance=balance, correction={"method": "add"})
    for verb in ("inspect", "balance"):
        small.ran(app, verb, job)
    app.ask("/api/job", job, "PUT")
    load(page, app)
    with nothing_wrong(page, app):
        page.click_on(at("tab-see"))
        until(page, "return document.getElementById('cuts-added')")
        assert page.run("return document.getElementById('cuts')") is None
        pads = latest(app, "balance")["report"]["corrections"]
        caption, heads, rows = page.run(ADDED)
        assert caption == "Metal to add"
        assert [each.split("\n")[0] for each in heads] == ["No.", "pad", "angle", "radius", "height"]
        for pad, row in zip(pads, rows, strict=True):
            assert pad["depth_mm"] < 0.0 > pad["removed_mass_g"]
            assert row[1].startswith("Pad")
            height, mass = row[4].split("\n")
            assert height == f"{-pad['depth_mm']:.3f}"
            assert mass == f"{-pad['removed_mass_g']:.2f} g on"
        page.click_on(at("tab-machine"))
        page.click_on(at("big"))
        page.run("[...document.querySelectorAll('#big-digits .buttons button')][1].click()")
        words = until(page, "return document.querySelector('.big-cut')?.innerText")
        assert f"height\n{-pads[0]['depth_mm']:.2f} mm" in words
        page.run("[...document.querySelectorAll('#big-digits button')].pop().click()")
        # read and found within: the crank was corrected, so that it is not within already
        for place, angle in ((1, 10), (2, 10)):
            put(page, **{f"g_mm_{place}": 20, f"angle_{place}": angle})
        page.click_on(at("recut"))
        until(page, "return document.querySelectorAll('#stages tbody tr').length === 2", most_s=60.0)
        page.click_on(at("tab-see"))
        assert page.run("return document.querySelector('#verdict h2').textContent") == "Within tolerance"
