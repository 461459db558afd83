"""The first view, and the unit of a file that has none: asked until it is answered."""

from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from tests import jobs
from tests.cranks import Shape, make_crank
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, READY, at, chosen, load, nothing_wrong, put, text_of, until
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
        assert page.run(turns) == "turn"
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


def test_the_page_is_there_after_few_requests(window: Browser, tmp_path: Path) -> None:
    with served(tmp_path / "project") as empty:
        window.requests()
        load(window, empty)
        asked = window.requests()
    assert len(asked) < 15, asked


def test_the_page_of_a_project_with_a_result_is_there_after_few_requests(
    window: Browser, project: Served
) -> None:
    project.ask("/api/job", small.DRILLED, "PUT")
    window.requests()
    load(window, project)
    until(window, "return document.querySelector('#strip svg') !== null")
    asked = window.requests()
    assert len(asked) < 15, "\n".join(asked)
