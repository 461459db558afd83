"""What the app's page does, each thing by itself: every test loads it on a project with a small crank."""

import sys
import tomllib
from typing import Any

import pytest

from autobalance.job.template import USUAL_PARTS
from tests.report.browser import Browser, missing
from tests.web_app import small
from tests.web_app.page import (
    ENDED,
    READY,
    at,
    job_text,
    latest,
    load,
    numbers,
    outcome,
    predicted,
    put,
    text_of,
    until,
    weighed,
)
from tests.web_app.serving import Served

pytestmark = [
    pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()}"),
    pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX"),
    pytest.mark.slow,
]
# --- what it comes back to ----------------------------------------------------------------------------------


def test_it_goes_on_where_the_project_was_left(page: Browser, project: Served) -> None:
    assert page.run(READY)
    assert page.run(ENDED)  # of a run that ended before the page was there
    run = latest(project, "balance")
    assert outcome(page) == run["report"]["outcome"]
    assert numbers(page)["residual.magnitude_g_mm"] == run["report"]["residual"]["magnitude_g_mm"]
    assert tomllib.loads(text_of(page, "job-text")) == small.DRILLED


def test_it_shows_the_crank_of_its_job_though_another_was_opened_since(
    page: Browser, project: Served
) -> None:
    other = "other.stl"
    data = (project.project / small.NAME).read_bytes()
    assert project.ask(f"/api/files?name={other}", data).status == 201
    table = {**small.DRILLED["crankshaft"], "file": other}
    small.ran(project, "inspect", {**small.DRILLED, "crankshaft": table})
    project.ask("/api/job", small.DRILLED, "PUT")
    load(page, project)
    assert page.run("return Boolean(document.getElementById('model').view.rays)")


def test_a_reload_in_the_middle_and_a_second_tab_lose_nothing(page: Browser, project: Served) -> None:
    page.click_on(at("tab-correct"))
    page.click_on(at("balance"))
    run = until(page, "return document.getElementById('cancel').dataset.run")
    page.call("POST", "/refresh", {})
    until(page, "return document.body.dataset.ready === 'true'")
    first = page.call("GET", "/window")
    second = page.call("POST", "/window/new", {"type": "tab"})["handle"]
    try:
        page.call("POST", "/window", {"handle": second})
        load(page, project)
        until(page, ENDED)
        assert project.ended(run)["state"] == "done"
        assert outcome(page) == "within_tolerance"
        put(page, grade=2.5)
        job_text(page, "grade = 2.5")
        page.call("DELETE", "/window")
    finally:
        page.call("POST", "/window", {"handle": first})
    page.run("window.dispatchEvent(new Event('focus'))")
    job_text(page, "grade = 2.5")
    until(page, ENDED)
    assert outcome(page) == "within_tolerance"
    assert page.run("return document.getElementById('factor').value") == "0.25"


# --- parts --------------------------------------------------------------------------------------------------


def test_before_anything_is_cut_the_weights_tell_what_they_do(page: Browser, project: Served) -> None:
    page.click_on(at("tab-parts"))
    until(page, "return !document.getElementById('preview').hidden")
    report = latest(project, "balance")["report"]
    own = [
        report["engine"]["bob_weights"][0]["mass_g"],
        report["balance_factor"]["initial"],
        report["initial"]["magnitude_g_mm"],
        report["tolerance"]["permissible_g_mm"],
    ]
    assert predicted(page, "preview-facts") == pytest.approx(own, rel=1e-9)
    assert page.run("return document.querySelectorAll('#preview-polar svg[role=img] .permitted').length") == 3
    page.run(
        "const field = document.querySelector('[data-group=rotating_g] [data-testid=weight-name]');"
        "const clipboardData = new DataTransfer(); clipboardData.setData('text', arguments[0]);"
        "const paste = { clipboardData, bubbles: true, cancelable: true };"
        "field.dispatchEvent(new ClipboardEvent('paste', paste));",
        "Part\tg\t±\nbig end\t400,04\t0,5\nshells\t20 g\t\n",
    )
    table = tomllib.loads(job_text(page, "shells"))["engine"]["rotating_g"]
    assert table == {"big_end": {"g": 400.04, "pm": 0.5}, "shells": 20}
    until(
        page,
        "return Math.abs(Number(document.querySelector('#preview-facts [data-predicted]').dataset.predicted)"
        " - (400.04 + 20 + 0.25 * 500)) < 1e-9",
    )


def test_a_part_that_is_entered_twice_counts_twice(page: Browser) -> None:
    page.click_on(at("tab-parts"))
    for grams in (20, 70):
        weighed(page, "crankpin_g", "slug", grams)
    page.run(
        "const fields = document.querySelectorAll('[data-group=crankpin_g] [data-testid=weight-pieces]');"
        "const pieces = [...fields].pop();"
        "pieces.value = '2'; pieces.dispatchEvent(new Event('input', { bubbles: true }));"
    )
    page.click_on(at("add-crankpin_g"))  # a row that was not weighed is not in the job
    table = tomllib.loads(job_text(page, "pieces"))["engine"]["crankpin_g"]
    assert table == {"slug": 20, "slug_2": {"g": 70, "pieces": 2}}
    assert page.run("return document.querySelector('[data-testid=sum-crankpin_g]').textContent") == (
        "160.00 g in all; 1 not weighed: not in the job"
    )


def test_parts_that_nobody_weighed_yet_are_named(page: Browser, project: Served) -> None:
    job = {**small.DRILLED, "engine": {}}
    project.ask("/api/job", job, "PUT")
    load(page, project)
    names = page.run(
        "return [...document.querySelectorAll('[data-testid=weight-name]')].map(each => each.value)"
    )
    assert names == [name for table in USUAL_PARTS.values() for name in table]
    assert not page.run("return document.getElementById('job-text').textContent.includes('piston')")


def test_every_key_of_a_job_is_a_field(page: Browser) -> None:
    page.click_on(at("tab-parts"))
    page.run("document.getElementById('everything').open = true")
    put(page, key_engine_rod_length_mm="120,5", key_job_customer="Ann")
    put(page, key_balance_facet_correction="true", **{"key_engine_layout-bank_deg": "-45, 45"})
    job = tomllib.loads(job_text(page, "facet_correction"))
    assert job["engine"]["rod_length_mm"] == 120.5
    assert job["engine"]["layout"] == {"bank_deg": [-45, 45]}
    assert job["job"] == {"customer": "Ann"}
    assert job["balance"]["facet_correction"] is True
    put(page, key_job_customer="", **{"key_engine_layout-bank_deg": ""})
    until(page, "return !document.getElementById('job-text').textContent.includes('Ann')")
    job = tomllib.loads(text_of(page, "job-text"))
    assert "layout" not in job["engine"]
    assert "job" not in job


def test_the_jobs_text_may_be_typed(page: Browser) -> None:
    page.click_on(at("edit-job"))
    text = page.run("return document.getElementById('job-toml').value")
    put(page, job_toml=text.replace("[balance]", "[balance]\noverbalance_g_mm = 7.5 # typed", 1))
    page.click_on(at("take-job"))
    assert tomllib.loads(job_text(page, "overbalance_g_mm = 7.5"))["balance"]["overbalance_g_mm"] == 7.5
    assert page.run("return document.getElementById('key-balance-overbalance_g_mm').value") == "7.5"
    page.click_on(at("edit-job"))
    put(page, job_toml="[balance")
    page.click_on(at("take-job"))
    until(page, "return document.getElementById('error').textContent.includes('job.toml')")
    assert "overbalance_g_mm = 7.5" in text_of(page, "job-text")
    assert all("400" in each["message"] for each in page.log("browser"))  # a browser logs what is refused


# --- correct ------------------------------------------------------------------------------------------------


def test_faces_and_angles_are_picked_in_the_model(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    put(page, method="shoulder")
    face = "w2-b"
    place = f"return document.getElementById('model').view.parts.findIndex(each => each.id === '{face}') + 1"

    def where() -> tuple[float, float]:  # a click on a button below may have scrolled the page
        x, y = page.run(f"{place.replace('return', 'const part =')}; return model.view.whereIs(part)")
        return x, y

    page.click(*where())
    assert f'["{face}"]' in job_text(page, face)
    page.click(*where())
    until(page, f"return !document.getElementById('job-text').textContent.includes('{face}')")
    page.click_on("#pick-zone")
    x, y = where()
    page.click(x, y)
    page.click(x + 12, y)
    low, high = tomllib.loads(job_text(page, "sector_deg"))["correction"]["shoulder"]["sector_deg"]
    assert 0.0 <= low < 360.0
    assert low != high
    page.click_on("#zones button")
    put(page, method="drill")
    page.click_on("#add-forbidden")
    sectors = tomllib.loads(job_text(page, "sectors_deg"))["correction"]["drill"]["sectors_deg"]
    assert sectors == [[0, 170], [190, 360]]


def test_a_run_that_is_cancelled_leaves_nothing(page: Browser, project: Served) -> None:
    page.click_on(at("tab-correct"))
    page.click_on(at("compare"))
    run = until(page, "return document.getElementById('cancel').dataset.run")
    page.click_on(at("cancel"))
    until(page, "return document.getElementById('cancel').disabled", most_s=10.0)
    assert project.ended(run, 3.0)["state"] == "cancelled"
    assert not (project.project / "runs" / run).exists()
    assert not (project.project / ".app" / run).exists()


def test_the_board_shows_every_alternative(page: Browser, project: Served) -> None:
    page.click_on(at("tab-correct"))
    page.click_on(at("compare"))
    until(page, "return document.querySelector('#board article')", most_s=300.0)
    report, shown = latest(project, "compare")["report"], numbers(page)
    names = page.run("return [...document.querySelectorAll('#board h3')].map(each => each.textContent)")
    assert names == ["+".join(row["method"]) for row in report["rows"]]
    for place, row in enumerate(report["rows"]):
        if row["outcome"]:
            assert shown[f"rows.{place}.residual_g_mm"] == row["residual_g_mm"]
    page.run("for (const each of document.querySelectorAll('#board img')) each.loading = 'eager'")
    within = sum(row["outcome"] == "within_tolerance" for row in report["rows"])
    pictures = "[...document.querySelectorAll('#board img')]"
    until(page, f"return {pictures}.filter(each => each.naturalWidth > 100).length === {within}")
    assert within >= 2
    best = next(k for k, row in enumerate(report["rows"]) if row["outcome"] and row["method"] != ["drill"])
    page.run(f"document.querySelectorAll('#board article')[{best}].querySelector('button').click()")
    method = report["rows"][best]["method"]
    until(page, "return !document.getElementById('job-text').textContent.includes('method = \"drill\"')")
    found = tomllib.loads(text_of(page, "job-text"))["correction"]["method"]
    assert found == (method[0] if len(method) == 1 else method)


# --- by keys, at any width ----------------------------------------------------------------------------------


def test_it_is_worked_by_keys_alone(page: Browser) -> None:
    def focused() -> dict[str, Any]:
        found: dict[str, Any] = page.run(
            "const e = document.activeElement; return { id: e.id, kind: e.dataset.kind, role: e.role }"
        )
        return found

    arrow_right, arrow_left, arrow_down, enter, tab = "\ue014", "\ue012", "\ue015", "\ue007", "\ue004"
    page.press("#tab-open", arrow_right)
    assert focused()["id"] == "tab-parts"
    page.press("#tab-parts", arrow_left)
    assert page.run("return !document.getElementById('panel-open').hidden")
    page.press("[role=treeitem][tabindex='0']", arrow_down + enter)
    assert focused()["kind"] == "main_journal"
    assert page.run("return document.activeElement.getAttribute('aria-selected')") == "true"
    assert page.run("return !document.getElementById('cylinder').hidden")
    page.press("#tab-open", tab)
    assert focused()["id"] == "file-input"
    unnamed = page.run(
        "return [...document.querySelectorAll('button, input, select, a, [role]')].filter(each =>"
        "!(each.labels?.length || each.getAttribute('aria-label') || each.getAttribute('aria-labelledby')"
        "|| each.textContent.trim() || each.id === 'error')).map(each => each.outerHTML)"
    )
    assert unnamed == []


def test_nothing_is_wider_than_the_window(page: Browser) -> None:
    try:
        for width in (1400, 820, 390):
            page.resize(width, 900)
            for tab in ("open", "parts", "correct", "see", "machine"):
                page.click_on(at(f"tab-{tab}"))
                wide = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
                assert page.run(f"return {wide}") <= 0, (width, tab)
    finally:
        page.resize(1400, 900)
