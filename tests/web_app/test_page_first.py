"""The first view, and the unit of a file that has none: asked until it is answered."""

import base64
import re
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from tests import jobs
from tests.cranks import Shape, make_crank
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
    numbers,
    put,
    text_of,
    until,
)
from tests.web_app.serving import Served, served

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
        turns = "return getComputedStyle(document.querySelector('.first .turning')).animationName"
        for wanted, name in (("reduce", "none"), ("no-preference", "turn"), ("", "none")):
            emulated = {"features": [{"name": "prefers-reduced-motion", "value": wanted}]}
            page.call("POST", "/goog/cdp/execute", {"cmd": "Emulation.setEmulatedMedia", "params": emulated})
            assert page.run(turns) == name
        picture = tmp_path / "picture.stl"
        picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(200))
        chosen(page, picture)
        until(page, "return document.getElementById('error').textContent.includes('PNG picture')")
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


def test_a_stroke_that_is_known_says_the_unit(window: Browser, app: Served, tmp_path: Path) -> None:
    page = load(window, app)
    with nothing_wrong(page, app):
        chosen(page, small.crank(tmp_path))
        until(page, READY)
        until(page, f"{ASKED} === 'true'")
        runs = app.ask("/api/runs").json["runs"]
        report = app.ask(f"/api/runs/{runs[-1]['id']}/report").json
        stroke = 2.0 * report["crank"]["throws"][0]["crank_radius_mm"]
        put(page, stroke=f"{25.4 * stroke:.2f}")
        page.click_on(at("by-stroke"))
        until(page, f"{ASKED} === 'false'")
        until(page, "return document.getElementById('job-text').textContent.includes('unit = \"inch\"')")


def test_a_stroke_that_fits_no_unit_scales_the_solid_which_the_command_line_then_has(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    page, path = load(window, app), small.crank(tmp_path)
    with nothing_wrong(page, app):
        chosen(page, path)
        until(page, f"{ASKED} === 'true' && {READY.removeprefix('return ')}")
        runs = app.ask("/api/runs").json["runs"]
        report = app.ask(f"/api/runs/{runs[-1]['id']}/report").json
        before = 2.0 * report["crank"]["throws"][0]["crank_radius_mm"]
        original = report["input"]["file"].rpartition("/")[2]
        put(page, stroke="79")
        page.click_on(at("by-stroke"))
        says = until(page, "return document.querySelector('[data-testid=scaled]')?.textContent")
        assert original in says
        assert "79.00 mm" in says
        until(page, "return document.getElementById('tree').textContent.includes('39.50 mm')")
        job = app.ask("/api/project").json["job"]
        assert job["crankshaft"]["unit"] == "mm"
        scaled = app.project / job["crankshaft"]["file"]
        assert (app.project / original).read_bytes() == path.read_bytes()  # the original stays
        assert jobs.corners_of(scaled) == pytest.approx(79.0 / before * jobs.corners_of(path), rel=1e-6)
        same = ab.inspect(ab.read_crank(scaled, unit="mm", density_kg_m3=7850.0)).report
        assert 2.0 * same["crank"]["throws"][0]["crank_radius_mm"] == pytest.approx(79.0, abs=0.005)
        assert page.run("return document.querySelectorAll('#unit-yes').length") == 0


def test_a_stroke_scales_a_crank_that_is_too_small_to_be_measured_in_mm(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    solid, _ = make_crank([0.0], Shape(segments=24))
    page, path = load(window, app), tmp_path / "tiny.stl"
    jobs.write_stl(path, solid.mesh.corners / 100.0)
    chosen(page, path)
    until(page, "return document.getElementById('error').textContent.includes('mm long')")
    assert text_of(page, "state-line").startswith("No crank recognised in tiny.stl")
    put(page, stroke="79")
    page.click_on(at("by-stroke"))
    scaled = "return document.querySelector('[data-testid=scaled]')?.textContent.includes('tiny.stl')"
    until(page, scaled)
    until(page, "return document.getElementById('tree').textContent.includes('39.50 mm')")


def test_of_two_bodies_the_solid_is_shown_and_the_question_has_three_answers(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    solid, _ = make_crank([0.0], Shape(segments=24))
    corners, path = solid.mesh.corners, tmp_path / "two.stl"
    jobs.write_stl(path, np.concatenate([corners, corners + np.array([300.0, 0.0, 0.0])]))
    page = load(window, app)
    with nothing_wrong(page, app):
        chosen(page, path)
        until(page, "return document.querySelector('[data-testid=bodies]')")
        answers = (
            "return [...document.querySelectorAll('[data-testid=bodies] button')].map(b => b.dataset.body)"
        )
        assert page.run(answers) == ["1", "2", "all"]
        assert page.run("return Number(document.getElementById('model').dataset.triangles)") == 2 * len(
            corners
        )
        page.click_on("[data-testid=bodies] button")
        until(page, "return document.querySelectorAll('[role=treeitem][data-kind=throw]').length === 1")
        assert app.ask("/api/project").json["job"]["crankshaft"]["body"] == 1
        assert page.run("return document.querySelector('[data-testid=bodies]')") is None


def test_the_page_of_a_project_with_a_result_is_there_after_few_requests(
    window: Browser, tmp_path: Path
) -> None:
    with served(tmp_path / "project") as app:  # in which no other test has left anything
        app.ask(f"/api/files?name={small.NAME}", small.crank(tmp_path).read_bytes())
        for verb in ("inspect", "balance"):
            small.ran(app, verb, small.DRILLED)
        app.ask("/api/job", small.DRILLED, "PUT")
        window.requests()
        load(window, app)
        until(window, "return document.querySelector('#strip svg') !== null")
        asked = window.requests()
        assert len(asked) < 15, "\n".join(asked)


SLOW_POLARS = """
const fetched = window.fetch;
window.polars = [];
window.answers = 0;
window.fetch = async (path, options) => {
  if (path !== "/api/polars") return fetched(path, options);
  const { polars } = JSON.parse(options.body);
  for (const each of polars) window.polars.push(JSON.stringify(each));
  await new Promise(ended => setTimeout(ended, 300));
  const answer = await fetched(path, options);
  window.answers++;
  return answer;
};
"""


def test_a_polar_that_is_on_its_way_is_not_asked_for_again(page: Browser) -> None:
    page.run(SLOW_POLARS)
    page.click_on(at("tab-parts"))
    page.run(
        "const input = document.querySelector('[data-testid=weight-g]');"
        "input.value = '123'; input.dispatchEvent(new Event('input', { bubbles: true }));"
    )
    until(page, "return window.polars.length > 0", most_s=20.0)
    for _ in range(2):
        page.click_on(at("more-columns"))  # draws the page anew
    until(page, "return window.answers > 0", most_s=20.0)
    asked = page.run("return window.polars")
    assert len(asked) == len(set(asked)), asked


COUNTED = """
const told = Date.prototype.toLocaleString, fetched = window.fetch;
window.drawn = window.listed = 0; // times of results are told anew whenever the page is drawn
window.last = performance.now();
Date.prototype.toLocaleString = function (...how) {
  window.drawn++;
  window.last = performance.now();
  return told.apply(this, how);
};
window.fetch = async (path, options) => {
  const answer = await fetched(path, options);
  if (path === "/api/runs") window.listed++;
  return answer;
};
"""


def test_a_list_of_runs_that_is_as_it_was_draws_nothing(page: Browser) -> None:
    """While a run goes on the page asks eight times a second how far it is."""
    page.run(COUNTED)
    until(
        page, "return performance.now() - window.last > 1000", most_s=20.0
    )  # all that a load brings is drawn
    page.run("window.drawn = 0")
    for times in (1, 2, 3):
        page.run("window.dispatchEvent(new Event('focus'))")
        until(page, "return window.listed === arguments[0]", times, most_s=20.0)
    assert page.run("return window.drawn") == 0
    page.click_on(at("tab-parts"))
    page.click_on(at("more-columns"))
    until(page, "return window.drawn > 0", most_s=20.0)


PAINTED = """
const paint = performance.getEntriesByType("paint").find(each => each.name === "first-contentful-paint");
return paint ? paint.startTime / 1000 : null;
"""
FIRST_PAINT_S = 0.4


@pytest.mark.timing
def test_the_page_is_painted_soon(window: Browser, app: Served) -> None:
    """The best of three: the machine may be busy."""
    painted = []
    for _ in range(3):
        load(window, app)
        painted.append(until(window, PAINTED))
    assert min(painted) < FIRST_PAINT_S


DRAG = """
const [kind, path, related] = arguments, dataTransfer = new DataTransfer();
dataTransfer.items.add(new File([window.dropped || "solid"], "dropped.stl"));
const more = related ? { relatedTarget: document.body } : {};
document.getElementById(path).dispatchEvent(
  new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true, ...more }));
"""
TARGET = """
const words = document.querySelector("[data-testid=drop-target]"), box = document.getElementById("drop-root");
if (!words) return null;
const { width, height } = box.getBoundingClientRect();
return [words.textContent, width === innerWidth && height === innerHeight];
"""


@pytest.mark.looks
def test_a_file_may_be_dropped_on_every_step(page: Browser) -> None:
    wanted = ["Drop to open as a new crank", True]
    for step in ("open", "parts", "correct", "see", "machine", "analyse", "history"):
        page.click_on(at(f"tab-{step}"))
        page.run(DRAG, "dragover", f"panel-{step}", False)
        assert until(page, TARGET) == wanted
        page.run(DRAG, "dragleave", f"panel-{step}", True)  # from one part of the page to another
        page.run(DRAG, "dragover", "model", False)
        assert until(page, TARGET) == wanted
        page.run(DRAG, "dragleave", "model", False)  # out of the window
        until(page, f"return (() => {{ {TARGET} }})() === null")


def test_what_is_dropped_on_any_step_is_opened(window: Browser, app: Served, tmp_path: Path) -> None:
    page = load(window, app)
    chosen(page, small.crank(tmp_path))
    until(page, READY)
    with nothing_wrong(page, app):
        data = base64.b64encode((tmp_path / small.NAME).read_bytes()).decode()
        page.click_on(at("tab-machine"))
        page.run("window.dropped = Uint8Array.from(atob(arguments[0]), each => each.charCodeAt(0))", data)
        page.run(DRAG, "drop", "line", False)
        until(page, "return document.getElementById('crank-name').textContent === 'dropped'")
        until(page, READY)
        assert app.ask("/api/project").json["job"]["crankshaft"]["file"] == "dropped.stl"
        assert page.run(TARGET) is None


def test_a_crank_that_is_far_too_heavy_or_light_raises_a_question(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    page, path = load(window, app), small.crank(tmp_path)
    corners = jobs.corners_of(path)
    solid = ab.read_crank(path, unit="mm", density_kg_m3=7850.0)
    mass_g = ab.inspect(solid).report["crank"]["mass_g"]
    for name, wanted_g, words in (("light", 16.7, "16.7 g"), ("heavy", 3.8e6, "3800 kg")):
        scaled = tmp_path / f"{name}.stl"
        jobs.write_stl(scaled, corners * (wanted_g / mass_g) ** (1.0 / 3.0))
        chosen(page, scaled)
        says = until(page, "return document.querySelector('[data-testid=unit-strange]')?.textContent")
        assert words in says.replace("\u202f", "").replace(",", "")
        page.click_on(at("unit-yes"))  # the unit is answered, the doubt stays
        until(page, f"{ASKED} === 'false'")
        assert page.run("return document.getElementById('tab-open').dataset.is") == "ask"
        assert page.run("return document.querySelector('[data-testid=unit-strange]') !== null")


@pytest.mark.looks
def test_the_share_of_the_facets_is_all_of_the_uncertainty_on_page_and_report(
    page: Browser, project: Served
) -> None:
    told = latest(project, "balance")
    residual = told["report"]["residual"]
    shares, together = residual["uncertainty_shares_g_mm"], residual["uncertainty_g_mm"]
    assert shares["facets"] == max(shares.values())
    assert together == pytest.approx(sum(each**2 for each in shares.values()) ** 0.5, rel=1e-6)
    shown = numbers(page)
    assert shown["residual.uncertainty_shares_g_mm.facets"] == shares["facets"]
    assert shown["residual.uncertainty_g_mm"] == together
    html = project.ask(f"/api/runs/{told['id']}/files/report.html").body.decode()
    text = re.sub(r"<[^>]+>", " ", html)
    said = re.search(r"Uncertainty\s+±\s+([\d.]+)\s+g·mm\s+facets\s+([\d.]+)", text)
    assert said
    assert [*map(float, said.groups())] == pytest.approx([together, shares["facets"]], abs=0.00501)


@pytest.mark.looks
def test_the_start_has_examples_with_pictures_and_leads_back_to_where_one_was(
    page: Browser, project: Served
) -> None:
    until(page, READY)
    page.click_on(at("to-start"))
    until(page, "return document.querySelectorAll('.recent li .badge').length > 0", most_s=20.0)
    drawn = "[...document.querySelectorAll('.example img, .recent img')]"
    until(page, f"return {drawn}.length > 2 && {drawn}.every(each => each.naturalWidth > 100)", most_s=20.0)
    made = latest(project, "balance")
    row = f".recent li[data-run='{made['id']}']"
    words = page.run("return document.querySelector(arguments[0]).textContent", row)
    stroke = 2.0 * made["report"]["crank"]["throws"][0]["crank_radius_mm"]
    assert f"stroke {stroke:.1f} mm" in words
    assert "holes: 2" in words
    page.click_on(f"{row} button")
    until(page, "return document.body.dataset.tab === 'see'", most_s=10.0)
    assert page.run("return document.querySelector('.first')") is None
    page.click_on(at("to-start"))
    page.click_on(at("all-cranks"))
    until(page, "return document.body.dataset.tab === 'history'", most_s=10.0)


def test_the_empty_page_is_there_after_few_requests_with_the_v8_as_an_example_with_its_weights(
    window: Browser, tmp_path: Path
) -> None:
    with served(tmp_path / "project") as empty:
        window.requests()
        page = load(window, empty)
        asked = window.requests()
        assert len(asked) < 15, asked
        page.click_on(at("example-v8"))
        until(page, READY)
        job = empty.ask("/api/project").json["job"]
        assert job["engine"]["rods_per_throw"] == 2
        page.click_on(at("tab-parts"))
        until(page, "return document.getElementById('line').textContent.includes('1750.00 g')", most_s=20.0)
        refused = empty.ask("/api/example", {"preset": "inline-4", "weighed": True})
        assert refused.status == 400


def test_only_a_small_png_of_a_crank_of_the_project_is_kept(project: Served) -> None:
    url = f"/api/cranks/picture?file={small.NAME}"
    kept = project.ask(url)
    assert project.ask(url, b"<svg/>", "PUT").status == 400
    assert project.ask(url, b"\x89PNG\r\n\x1a\n" + bytes(1 << 18), "PUT").status == 413
    assert project.ask("/api/cranks/picture?file=../job.toml", b"\x89PNG\r\n\x1a\n", "PUT").status == 400
    assert project.ask("/api/cranks/picture?file=other.stl").status == 404
    assert project.ask(url).body == kept.body
