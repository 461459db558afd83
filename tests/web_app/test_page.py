"""The app's page in a browser, as people use it: from a dropped file to the corrected solid."""

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from autobalance.graphics.words import at as value_at
from tests import jobs
from tests.report.browser import Browser, missing
from tests.web_app.page import at, chosen, job_text, limit, numbers, opened, outcome, put, until
from tests.web_app.serving import Served

CRANK = jobs.BUNDLED / "drafted" / "crank.stl"
pytestmark = [
    pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()}"),
    pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX"),
    pytest.mark.slow,
]


def error(page: Browser) -> str:
    said: str = page.run("return document.querySelector('[data-testid=error]').textContent")
    return said


def test_from_a_file_to_the_corrected_solid(page: Browser, app: Served) -> None:
    chosen(page, CRANK)
    assert page.run("return !document.getElementById('unit-field').hidden")
    opened(page)
    assert page.run("return Number(document.querySelector('[data-testid=model]').dataset.triangles)") == 12416
    assert page.run("return document.getElementById('crankpin-in-file').value") == "false"
    kinds = page.run(
        "return [...document.querySelectorAll('[role=treeitem]')].map(each => each.dataset.kind)"
    )
    assert {"axis", "main_journal", "throw", "web", "counterweight", "face"} == set(kinds)

    page.click_on(at("tab-parts"))
    weights = {
        "rotating_g": [("big_end", 95.04), ("bearing", 39.0)],
        "reciprocating_g": [("small", 34.0), ("piston", 227.5)],
        "crankpin_g": [("crankpin", 114.65)],
    }
    for group, rows in weights.items():
        for name, grams in rows:
            page.click_on(at(f"add-{group}"))
            page.run(
                "const row = [...document.querySelectorAll(`[data-group=${arguments[0]}]`)].pop();"
                "for (const [key, value] of Object.entries(arguments[1])) {"
                "const input = row.querySelector(`[data-testid=weight-${key}]`);"
                "input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }",
                group,
                {"name": name, "g": str(grams)},
            )
    put(page, factor=0.28, grade=6.3, speed_rpm=15200)
    page.click_on(at("tab-correct"))
    put(page, method="shoulder")
    page.click_on(at("balance"))
    assert outcome(page) == "within_tolerance"
    run = app.ask("/api/runs").json["runs"][-1]
    report = app.ask(f"/api/runs/{run['id']}/report").json
    shown = numbers(page)
    assert shown["residual.magnitude_g_mm"] == report["residual"]["magnitude_g_mm"]
    of_run = {key: value for key, value in shown.items() if not key.startswith(("faces.", "rows."))}
    assert len(of_run) > 20
    for key, value in of_run.items():
        assert value == pytest.approx(value_at(report, key), rel=1e-15), key
    path = app.project / "again.toml"
    path.write_text(page.run("return document.getElementById('job-text').textContent"), encoding="utf-8")
    again = jobs.computed(path, app.project.parent / "again")
    assert again["residual"] == report["residual"]
    link = page.run("return document.querySelector('[data-testid=download-solid]').href")
    assert link.endswith("balanced.stl")


def test_before_anything_is_cut_the_weights_tell_what_they_do(page: Browser, app: Served) -> None:
    page.click_on(at("tab-parts"))
    until(page, "return !document.getElementById('preview').hidden")
    told = page.run(
        "return [...document.querySelectorAll('#preview-facts [data-predicted]')]"
        ".map(each => Number(each.dataset.predicted))"
    )
    assert told == pytest.approx([321.91, 0.8182, 3785.86, 10.69], abs=0.005)
    assert page.run("return document.querySelectorAll('#preview-polar svg[role=img] .permitted').length") == 3
    page.run(
        "const field = document.querySelector('[data-group=rotating_g] [data-testid=weight-name]');"
        "const clipboardData = new DataTransfer(); clipboardData.setData('text', arguments[0]);"
        "const paste = { clipboardData, bubbles: true, cancelable: true };"
        "field.dispatchEvent(new ClipboardEvent('paste', paste));",
        "Part\tg\t±\nbig end\t100,04\t0,5\nshells\t20 g\t\n",
    )
    text = job_text(page, "shells")
    table = tomllib.loads(text)["engine"]["rotating_g"]
    assert table == {"big_end": {"g": 100.04, "pm": 0.5}, "shells": 20, "bearing": 39}
    until(
        page,
        "return Math.abs(Number(document.querySelector('#preview-facts [data-predicted]').dataset.predicted)"
        " - (100.04 + 20 + 39 + 0.28 * 261.5 + 114.65)) < 1e-9",
    )
    back = tomllib.loads(text)
    back["engine"]["rotating_g"] = {"big_end": 95.04, "bearing": 39.0}
    app.ask("/api/job", back, "PUT")
    page.run("window.dispatchEvent(new Event('focus'))")
    job_text(page, "95.04")


def test_faces_and_angles_are_picked_in_the_model(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    place = "return document.getElementById('model').view.parts.findIndex(each => each.id === 'w2-d') + 1"
    where = page.run(f"{place.replace('return', 'const part =')}; return model.view.whereIs(part)")
    page.click(*where)
    assert '["w2-d"]' in job_text(page, "w2-d")
    page.click(*where)
    until(page, "return !document.getElementById('job-text').textContent.includes('w2-d')")
    page.click_on("#pick-zone")
    page.click(*where)
    page.click(where[0] + 12, where[1])
    text = job_text(page, "sector_deg")
    low, high = tomllib.loads(text)["correction"]["shoulder"]["sector_deg"]
    assert 90.0 < low < 270.0
    assert low != high
    page.click_on("#zones button")
    put(page, method="drill")
    page.click_on("#add-forbidden")
    sectors = tomllib.loads(job_text(page, "sectors_deg"))["correction"]["drill"]["sectors_deg"]
    assert sectors == [[0, 170], [190, 360]]
    page.click_on("#zones button")


def test_an_infeasible_job_offers_what_would_suffice(page: Browser, app: Served) -> None:
    put(page, method="shoulder", factor=0.28)
    limit(page, "shoulder.max_depth_mm", 2)
    for face in ("w1-a", "w2-d"):
        page.run("document.querySelector(`[data-face=${arguments[0]}] input`).click()", face)
    page.click_on(at("balance"))
    assert outcome(page) == "above_tolerance"
    assert "max_depth_mm" in page.run("return document.querySelector('[data-testid=reason]').textContent")
    changes = page.run(
        "const button = document.querySelector('#relaxations button'); button.click();"
        "return JSON.parse(button.dataset.changes)"
    )
    until(page, "return document.querySelector('[data-testid=verdict]').dataset.outcome === ''")
    assert outcome(page) == "within_tolerance"
    key, value = next(iter(changes.items()))
    assert value_at(tomllib.loads(job_text(page, key.rpartition(".")[2])), key) == value


def test_a_depth_that_is_dragged_is_predicted(page: Browser, app: Served) -> None:
    page.run("document.getElementById('drag-box').open = true")
    before = page.run("return document.querySelector('#predictions [data-predicted]').dataset.predicted")
    page.run(
        "const slider = document.querySelector('#drags input'); slider.value = 3;"
        "slider.dispatchEvent(new Event('input', { bubbles: true }))"
    )
    until(
        page,
        "return document.querySelector('#predictions [data-predicted]').dataset.predicted !== arguments[0]",
        before,
    )
    run = app.ask("/api/runs").json["runs"][-1]["id"]
    model = app.ask(f"/api/runs/{run}/model").json
    depths = [3.0, *(cut["depth_mm"] for cut in model["cuts"][1:])]
    own = app.ask(f"/api/runs/{run}/predict", {"depths_mm": depths}).json["magnitude_g_mm"]
    shown = page.run("return document.querySelector('#predictions [data-predicted]').dataset.predicted")
    assert float(shown) == pytest.approx(own, rel=0.05)  # the slider stands on its own steps


def test_a_reading_becomes_the_next_cuts(page: Browser, app: Served) -> None:
    page.click_on(at("tab-machine"))
    put(page, umar=0.5, g_mm_1=30, angle_1=180, g_mm_2=30, angle_2=180)
    page.click_on(at("recut"))
    until(page, "return document.querySelectorAll('[data-testid=stages] tbody tr').length === 2")
    run = app.ask("/api/runs").json["runs"][-1]
    assert (run["verb"], run["state"]) == ("recut", "done")
    report = app.ask(f"/api/runs/{run['id']}/report").json
    shown = numbers(page)
    key = "stages.1.reading.magnitude_g_mm"
    assert shown[key] == report["stages"][1]["reading"]["magnitude_g_mm"]
    assert page.run("return document.querySelectorAll('#stages a').length") == 4
    put(page, g_mm_1=900, angle_1=20)
    page.click_on(at("recut"))
    until(
        page,
        "return !document.getElementById('trust').hidden"
        " || document.getElementById('stages').tBodies[0].rows.length === 3",
    )


def test_a_reload_in_the_middle_and_a_second_tab_lose_nothing(page: Browser, app: Served) -> None:
    put(page, method="shoulder", factor=0.28)
    job_text(page, 'method = "shoulder"')
    page.click_on(at("tab-correct"))
    page.click_on(at("balance"))
    until(page, "return !document.getElementById('cancel').disabled")
    page.call("POST", "/refresh", {})
    until(page, "return document.body.dataset.ready === 'true'")
    first = page.call("GET", "/window")
    second = page.call("POST", "/window/new", {"type": "tab"})["handle"]
    page.call("POST", "/window", {"handle": second})
    page.call("POST", "/url", {"url": app.address})
    until(page, "return document.body.dataset.ready === 'true'")
    until(page, "return document.querySelector('[data-testid=verdict]').dataset.outcome")
    assert outcome(page) == "within_tolerance"
    put(page, grade=2.5)
    job_text(page, "grade = 2.5")
    page.call("DELETE", "/window")
    page.call("POST", "/window", {"handle": first})
    page.run("window.dispatchEvent(new Event('focus'))")
    job_text(page, "grade = 2.5")
    assert outcome(page) == "within_tolerance"
    assert page.run("return document.getElementById('factor').value") == "0.28"


def test_a_run_that_is_cancelled_leaves_nothing(page: Browser, app: Served) -> None:
    page.click_on(at("tab-correct"))
    page.click_on(at("compare"))
    run = until(page, "return document.getElementById('cancel').dataset.run")
    page.click_on(at("cancel"))
    until(page, "return document.getElementById('cancel').disabled", most_s=10.0)
    assert app.ended(run, 3.0)["state"] == "cancelled"
    assert not (app.project / "runs" / run).exists()
    assert not (app.project / ".app" / run).exists()


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


@pytest.mark.parametrize("width", [1400, 820, 390])
def test_nothing_is_wider_than_the_window(page: Browser, width: int) -> None:
    page.resize(width, 900)
    for tab in ("open", "parts", "correct", "see", "machine"):
        page.click_on(at(f"tab-{tab}"))
        wide = page.run("return document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert wide <= 0, tab
    page.resize(1400, 900)


def test_nothing_was_wrong_and_nothing_left_the_machine(page: Browser, app: Served) -> None:
    assert [entry for entry in page.log("browser") if entry["level"] == "SEVERE"] == []
    asked = page.requests()
    assert asked
    assert all(url.startswith(app.base) for url in asked)


def test_a_wrong_file_is_one_line(page: Browser, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.stl"
    wrong.write_bytes(b"no crank")
    chosen(page, wrong)
    until(page, "return document.getElementById('chosen').textContent === 'wrong.stl'")
    page.click_on(at("tab-open"))
    page.click_on(at("open"))
    until(page, "return document.querySelector('[data-testid=error]').textContent !== ''")
    assert re.search(r"wrong\.stl", error(page))
    assert "\n" not in error(page)


def test_a_job_with_its_crank_opens_at_once_and_cylinders_are_called_what_they_are(
    page: Browser, app: Served, tmp_path: Path
) -> None:
    job = jobs.pin_job(tmp_path / "pin", method='"shoulder"\nfaces = [[1.5, 20.0, -30.0]]')
    chosen(page, job, job.parent / "crank-with-pin.stl")
    text = job_text(page, "crank-with-pin.stl")
    assert tomllib.loads(text)["correction"]["shoulder"]["faces"] == [[1.5, 20.0, -30.0]]
    assert tomllib.loads(text)["engine"]["reciprocating_g"] == {"piston": 261.5}
    until(page, "return document.querySelector('[data-testid=tree] [data-kind=throw]')")
    until(page, "return document.getElementById('model').dataset.state === 'ready'")
    page.press("[data-kind=main_journal][data-number='2']", "\ue007")
    until(page, "return !document.getElementById('cylinder').hidden")
    page.click_on("#is-journal")
    table = tomllib.loads(job_text(page, "main_journals"))["crankshaft"]
    assert len(table["main_journals"]) == 2
    until(page, "return document.getElementById('model').dataset.state === 'ready'")
    assert error(page) == ""


def test_a_page_of_another_origin_reads_and_starts_nothing(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    """The page is a file here, so its origin is ``null``; the app's cookie is in the same browser."""
    before = app.ask("/api/runs").json
    hostile = tmp_path / "hostile.html"
    hostile.write_text(
        f"<img src='{app.base}/api/project'><iframe src='{app.base}/'></iframe><script>"
        "window.found = []; (async () => { for (const [path, options] of ["
        "['/api/health', {}], ['/api/runs', {}], ['/api/runs', { credentials: 'include' }],"
        "['/api/runs', { method: 'POST', mode: 'no-cors', credentials: 'include', body: '{}' }]"
        f"]) try {{ const a = await fetch('{app.base}' + path, options); window.found.push(a.type); }}"
        " catch { window.found.push('refused'); } window.done = true; })();</script>",
        encoding="utf-8",
    )
    window.open(hostile)
    until(window, "return window.done")
    assert window.run("return window.found") == ["refused"] * 4
    assert window.run("return document.images[0].naturalWidth") == 0
    assert window.run("try { return frames[0].document.title } catch { return 'closed' }") == "closed"
    assert app.ask("/api/runs").json == before


def test_the_view_in_a_notebook_draws_without_the_app(window: Browser, tmp_path: Path) -> None:
    pytest.importorskip("anywidget")
    import base64

    import autobalance as ab

    crank = ab.read_crank(CRANK, unit="mm", density_kg_m3=7850.0, crankpin_in_file=False)
    widget = ab.app(crank)
    assert (widget.kind, len(widget.data) > 100_000) == ("crank", True)
    page = tmp_path / "notebook.html"
    data = base64.b64encode(widget.data).decode()
    module = str(widget._esm).replace("</script", r"<\/script")
    page.write_text(
        f"<div id=here></div><script type=module>{module}\n"
        f"const raw = Uint8Array.from(atob('{data}'), each => each.charCodeAt(0));"
        "const model = { get: name => name === 'data' ? new DataView(raw.buffer) : 'crank' };"
        "render({ model, el: document.getElementById('here') });</script>",
        encoding="utf-8",
    )
    window.open(page)
    until(
        window, "return document.querySelector('.autobalance-view')?.dataset.state === 'ready'", most_s=30.0
    )
    assert window.run("return Number(document.querySelector('.autobalance-view').dataset.triangles)") == 12416
