"""History: cranks and their results, a deleted one had back, two side by side; steps back through the job."""

import time
import tomllib
from pathlib import Path

import pytest

from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, READY, at, job_text, load, put, text_of, until
from tests.web_app.serving import Served

pytestmark = BROWSER
ROWS = (
    "return [...document.querySelectorAll('[data-testid=history-crank] tr[data-run]')]"
    ".map(row => row.dataset.run)"
)
BUTTON = "document.querySelector(`tr[data-run='${arguments[0]}'] [aria-label^=Delete]`).click()"


def test_results_stand_under_their_crank_and_any_two_side_by_side(window: Browser, app: Served) -> None:
    page = window
    app.ask(f"/api/files?name={small.NAME}", small.crank(app.project.parent).read_bytes())
    job = {**small.DRILLED, "correction": {"method": "shoulder"}}
    runs = [small.ran(app, verb, small.DRILLED) for verb in ("inspect", "balance")][1:]
    runs.append(small.ran(app, "balance", job))
    app.ask("/api/job", job, "PUT")
    load(page, app)
    page.click_on(at("tab-history"))
    assert until(page, ROWS) == runs[::-1]
    until(page, "return document.querySelectorAll('tr[data-run] .badge').length === 2")
    assert page.run("return document.querySelector('[data-testid=history-crank] h3').textContent") == (
        "small open now"
    )
    for run in runs:
        page.run("document.querySelector(`tr[data-run='${arguments[0]}'] input`).click()", run)
    reports = [app.ask(f"/api/runs/{run}/report").json for run in runs]
    shown = page.run(
        "return [...document.querySelectorAll('[data-testid=compare-two] tbody tr')]"
        ".map(row => [...row.querySelectorAll('[data-value]')].map(each => Number(each.dataset.value)))"
    )
    assert shown[0] == [each["residual"]["magnitude_g_mm"] for each in reports]
    assert shown[3] == [len(each["corrections"]) for each in reports]
    metal = [sum(cut["removed_mass_g"] for cut in each["corrections"]) for each in reports]
    assert shown[4] == pytest.approx(metal, rel=1e-12)
    had_back(page, app, runs)


REDRAWN = """
window.isRedrawn = false;
import("/static/store.js").then(store => { store.redrawNow(); window.isRedrawn = true; });
"""


def test_a_crank_has_the_name_that_its_user_gives_it(page: Browser, project: Served, tmp_path: Path) -> None:
    def named(name: str) -> None:
        page.click_on(at("tab-open"))
        put(page, crank_called=name)
        page.run(REDRAWN)  # as what was measured meanwhile does
        until(page, "return window.isRedrawn")
        assert page.run("return document.getElementById('crank-called').value") == name
        page.run("document.getElementById('crank-called').dispatchEvent(new Event('change'))")
        until(
            page, "return document.getElementById('crank-name').textContent === arguments[0]", name or "small"
        )

    named("V8: 001")
    page.click_on(at("tab-see"))
    saved = "return [...document.querySelectorAll('#downloads a[download]')].map(each => each.download)"
    assert all(name.startswith("V8- 001-") for name in page.run(saved))
    allowed = {"behavior": "allow", "downloadPath": str(tmp_path)}
    page.call("POST", "/goog/cdp/execute", {"cmd": "Browser.setDownloadBehavior", "params": allowed})
    for name in ("sheet.pdf", "certificate.pdf", "report.json"):  # the server's name, which a browser prefers
        page.run("document.querySelector(`#downloads a[data-file='${arguments[0]}']`).click()", name)
        end = time.monotonic() + 20.0
        while not (tmp_path / f"V8- 001-{name}").exists():
            assert time.monotonic() < end, sorted(path.name for path in tmp_path.iterdir())
            time.sleep(0.05)
    page.click_on(at("tab-history"))
    title = "return document.querySelector('[data-testid=history-crank] h3').textContent"
    assert page.run(title) == "V8: 001 open now"
    load(page, project)
    assert page.run("return document.getElementById('crank-name').textContent") == "V8: 001"
    refused = project.ask("/api/cranks", {"file": small.NAME, "name": "a\nb"}, "PUT")
    assert refused.status == 400
    assert project.ask("/api/cranks", {"file": "in-no-project.stl", "name": "a"}, "PUT").status == 400
    named("")


def test_a_second_job_stands_beside_the_first_and_each_is_there_when_its_crank_is(
    window: Browser, app: Served
) -> None:
    page = window
    if not (app.project / small.NAME).exists():
        app.ask(f"/api/files?name={small.NAME}", small.crank(app.project.parent).read_bytes())
    app.ask("/api/job", small.DRILLED, "PUT")
    load(page, app)
    page.click_on(at("tab-history"))
    page.click_on(at("duplicate"))
    until(page, "return document.getElementById('crank-name').textContent === 'small 2'")
    until(page, READY)
    other = app.ask("/api/project").json["job"]
    assert other == {**small.DRILLED, "crankshaft": {**small.DRILLED["crankshaft"], "file": "small-2.stl"}}
    page.click_on(at("tab-parts"))
    put(page, factor="0.31")
    job_text(page, "factor = 0.31")
    page.click_on(at("tab-history"))
    titles = (
        "return [...document.querySelectorAll('[data-testid=history-crank] h3')]"
        ".map(each => each.textContent.trim())"
    )
    assert page.run(titles)[0] == "small 2 open now"
    assert "small" in page.run(titles)
    page.run("document.querySelector(`[data-crank='small.stl'] button`).click()")
    until(page, "return document.getElementById('crank-name').textContent === 'small'")
    until(page, READY)
    assert app.ask("/api/project").json["job"] == small.DRILLED
    page.click_on(at("tab-history"))
    page.run("document.querySelector(`[data-crank='small-2.stl'] button`).click()")
    until(page, "return document.getElementById('crank-name').textContent === 'small 2'")
    job_text(page, "factor = 0.31")


def had_back(page: Browser, app: Served, runs: list[str]) -> None:
    """Delete a result, have it back, delete it again: its files go once it cannot be had back."""
    page.run(BUTTON, runs[0])
    until(page, f"const rows = (() => {{ {ROWS} }})(); return rows.length === 1")
    assert "small" in text_of(page, "toast")
    page.click_on(at("toast-act"))
    until(page, f"const rows = (() => {{ {ROWS} }})(); return rows.length === 2")
    assert (app.project / "runs" / runs[0]).is_dir()
    page.run(BUTTON, runs[0])
    until(page, f"const rows = (() => {{ {ROWS} }})(); return rows.length === 1")
    assert (app.project / "runs" / runs[0]).is_dir()


def test_the_job_is_taken_back_step_by_step(page: Browser, project: Served) -> None:
    press = (
        "document.activeElement?.blur(); document.body.dispatchEvent(new KeyboardEvent('keydown',"
        "{ key: 'z', ctrlKey: true, shiftKey: arguments[0], bubbles: true, cancelable: true }))"
    )
    page.click_on(at("tab-parts"))
    for factor in ("0.31", "0.32"):
        put(page, factor=factor)
        job_text(page, f"factor = {factor}")
    for shift, factor in ((False, "0.31"), (False, "0.25"), (True, "0.31"), (True, "0.32")):
        page.run(press, shift)
        found = tomllib.loads(job_text(page, f"factor = {factor}"))["balance"]
        assert found == {**small.DRILLED["balance"], "factor": float(factor)}
        assert page.run("return document.getElementById('factor').value") == factor


def test_a_result_is_current_or_earlier_by_the_job_of_its_own_crank(window: Browser, app: Served) -> None:
    page, tables = window, {**small.DRILLED["crankshaft"], "file": "apart.stl"}
    if app.project.joinpath("apart.stl").exists() is False:
        app.ask("/api/files?name=apart.stl", small.crank(app.project.parent).read_bytes())
    mine, other = {**small.DRILLED, "crankshaft": tables}, "beside-it.stl"
    run = small.ran(app, "balance", mine)
    app.ask("/api/job", mine, "PUT")
    app.ask(f"/api/files?name={other}", small.crank(app.project.parent).read_bytes())

    def shown() -> tuple[str, str]:
        load(page, app)
        page.click_on(at("tab-history"))
        row = "document.querySelector(`tr[data-run='${arguments[0]}'] .badge`)"
        until(page, f"return {row} !== null", run)
        found: list[str] = page.run(f"return [{row}.dataset.tone, {row}.textContent]", run)
        return found[0], found[1]

    current = shown()
    assert current[0] in ("good", "warn")
    assert app.ask("/api/open", {"file": other}).status == 200
    assert app.ask(f"/api/runs/{run}").json["job_changed"] is False
    assert shown() == current  # though the crank that is open has another job
    assert app.ask("/api/open", {"file": "apart.stl"}).status == 200
    app.ask("/api/job", {**mine, "balance": {**mine["balance"], "factor": 0.31}}, "PUT")
    assert app.ask("/api/open", {"file": other}).status == 200
    tone, words = shown()
    assert tone == "stale"
    assert words.startswith("Earlier result")


def test_the_job_of_a_crank_is_kept_whatever_is_opened_after_it(app: Served) -> None:
    if not (app.project / "kept.stl").exists():
        app.ask("/api/files?name=kept.stl", small.crank(app.project.parent).read_bytes())
    mine = {**small.DRILLED, "crankshaft": {**small.DRILLED["crankshaft"], "file": "kept.stl"}}
    app.ask("/api/job", mine, "PUT")
    assert app.ask("/api/example", {"preset": None}).status == 200  # comes with a job of its own
    assert app.ask("/api/project").json["job"]["crankshaft"]["file"] != "kept.stl"
    app.ask("/api/open", {"file": "kept.stl"})
    assert app.ask("/api/project").json["job"] == mine
