"""What the app's page does, each thing by itself: every test loads it on a project with a small crank."""

import json
import re
import time
import tomllib
from typing import Any

import pytest

from autobalance.correction import KINDS
from autobalance.job.template import USUAL_PARTS
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import (
    BROWSER,
    ENDED,
    READY,
    at,
    job_text,
    latest,
    limit,
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

pytestmark = BROWSER
PRESS = """
const card = [...document.querySelectorAll("#board article")].find(each => each.ariaLabel === arguments[0]);
card.querySelector("button").click();
"""

# --- what it comes back to ----------------------------------------------------------------------------------


def test_it_goes_on_where_the_project_was_left(page: Browser, project: Served) -> None:
    assert page.run(READY)
    assert page.run(ENDED)  # of a run that ended before the page was there
    run = latest(project, "balance")
    assert outcome(page) == run["report"]["outcome"]
    assert numbers(page)["residual.magnitude_g_mm"] == run["report"]["residual"]["magnitude_g_mm"]
    assert tomllib.loads(text_of(page, "job-text")) == small.DRILLED


def test_it_shows_the_crank_of_its_job_though_another_was_opened_since(
    unopened: Browser, project: Served
) -> None:
    other = "other.stl"
    data = (project.project / small.NAME).read_bytes()
    assert project.ask(f"/api/files?name={other}", data).status == 201
    table = {**small.DRILLED["crankshaft"], "file": other}
    small.ran(project, "inspect", {**small.DRILLED, "crankshaft": table})
    project.ask("/api/job", small.DRILLED, "PUT")
    page = load(unopened, project)
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
    assert page.run("return document.querySelectorAll('#preview-polar [role=img] .permitted').length") == 3
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


def test_parts_that_nobody_weighed_yet_are_named(unopened: Browser, project: Served) -> None:
    job = {**small.DRILLED, "engine": {}}
    project.ask("/api/job", job, "PUT")
    page = load(unopened, project)
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
    page.run("document.getElementById('job-box').open = true")
    page.click_on(at("edit-job"))
    text = page.run("return document.getElementById('job-toml').value")
    put(page, job_toml=text.replace("[balance]", "[balance]\noverbalance_g_mm = 7.5 # typed", 1))
    page.click_on(at("take-job"))
    assert tomllib.loads(job_text(page, "overbalance_g_mm = 7.5"))["balance"]["overbalance_g_mm"] == 7.5
    assert page.run("return document.getElementById('key-balance-overbalance_g_mm').value") == "7.5"
    page.click_on(at("edit-job"))
    put(page, job_toml="[balance")
    page.click_on(at("take-job"))
    until(page, "return document.getElementById('error').textContent.includes('not valid TOML')")
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


def kind_cards(page: Browser, rows: dict[str, dict[str, Any]]) -> None:
    """Hold the cards of the kinds to it: a picture each, and cuts, grams, wall and residual as compared."""
    found = page.run(
        "return [...document.querySelectorAll('.kind[data-kind]')]"
        ".map(each => [each.dataset.kind, each.dataset.old,"
        "each.querySelectorAll('svg .k-metal ~ *').length, each.querySelector('.badge').dataset.tone,"
        "each.querySelector('.says').textContent])"
    )
    assert {kind for kind, *_ in found} == set(KINDS)
    for kind, is_old, drawn, tone, says in found:
        row = rows[kind]
        assert (is_old, drawn > 2) == ("false", True)
        if row["outcome"] is None:
            assert (tone, says) == ("plain", "no place on this crank")
            continue
        assert tone == ("bad" if row["outcome"] == "above_tolerance" else "good")
        assert f": {row['cuts']}, {row['metal_moved_g']:.1f} g" in says
        wall = row["wall_left_mm"]
        assert ("no thin wall" if wall is None else f"wall left {wall:.1f} mm") in says
    seen = [f"limit-drill-{key}_mm" for key in ("min_wall", "max_depth", "depth_step")]
    boxes = "return arguments[0].map(id => document.getElementById(id).getClientRects().length)"
    assert page.run(boxes, seen) == [1, 1, 1]


def test_the_board_shows_every_alternative(page: Browser, project: Served) -> None:
    page.click_on(at("tab-correct"))
    page.click_on(at("compare"))
    until(page, "return document.querySelector('#board article')", most_s=300.0)
    until(page, "return document.querySelector('#board [role=status]') === null", most_s=300.0)
    report, shown = latest(project, "compare")["report"], numbers(page)
    names = page.run("return [...document.querySelectorAll('#board h3')].map(each => each.textContent)")
    assert names[0] == "+".join(report["recommended"])
    why = page.run("return document.getElementById('board-why').textContent")
    assert why.lower().replace(" + ", "+").replace("−", "-") == report["why"].lower()
    methods = report["recommended"]  # is chosen
    said = f"method = {json.dumps(methods[0] if len(methods) == 1 else methods)}"
    job_text(page, said)
    marked = "[...document.querySelectorAll('.kind[aria-checked=true]')].map(each => each.dataset.kind)"
    assert page.run(f"return {marked}") == (methods if len(methods) == 1 else [])
    page.click_on(at("kind-drill"))  # another card takes another
    job_text(page, 'method = "drill"')
    cards = {"+".join(row["method"]): place for place, row in enumerate(report["rows"])}
    assert set(names) <= set(cards)
    ranks = [report["rows"][cards[name]]["rank"] or 1e6 for name in names]
    assert ranks == sorted(ranks)
    plans: dict[object, str] = {}
    for name, place in cards.items():
        row = report["rows"][place]
        plans.setdefault(
            (row["outcome"], row["residual_g_mm"], row["cuts"]) if row["outcome"] else name, name
        )
    assert set(names) == set(plans.values())
    for name in names:
        if report["rows"][cards[name]]["outcome"]:
            key = f"rows.{cards[name]}.residual_g_mm"
            assert shown[key] == report["rows"][cards[name]]["residual_g_mm"]
    kind_cards(page, {row["method"][0]: row for row in report["rows"] if len(row["method"]) == 1})
    page.run("for (const each of document.querySelectorAll('#board img')) each.loading = 'eager'")
    pictures = "[...document.querySelectorAll('#board img')]"
    until(page, f"return {pictures}.length >= 2 && {pictures}.every(each => each.naturalWidth > 100)")
    page.run("document.querySelector('#board article').dispatchEvent(new MouseEvent('mouseenter'))")
    until(page, "return document.querySelector('#big-picture img')?.naturalWidth > 100")
    fails = [name for name in names if report["rows"][cards[name]]["outcome"] == "above_tolerance"]
    if fails:
        page.run(PRESS, fails[0])
        page.run("return 0")
        assert 'method = "drill"' in text_of(page, "job-text")  # not without a word
        assert page.run("return document.querySelector('#board [role=alert]') !== null")
    other = next(name for name in names if name != "drill" and report["rows"][cards[name]]["rank"])
    page.run(PRESS, other)
    until(page, "return !document.getElementById('job-text').textContent.includes('method = \"drill\"')")
    found = tomllib.loads(text_of(page, "job-text"))["correction"]["method"]
    assert found == (other if "+" not in other else other.split("+"))
    says_why_in_german(page, project)


def says_why_in_german(page: Browser, project: Served) -> None:
    """Say why a method is recommended in the page's language, with the same numbers."""
    page.run("localStorage.setItem('autobalance-language', 'de')")
    try:
        load(page, project)
        page.click_on(at("tab-correct"))
        why = until(page, "return document.getElementById('board-why')?.textContent")
        assert "geordnet nach: am wenigsten verschiedene Schnitte" in why
        assert re.search(r"\b(moved|ranked|cuts?|wall|next|kept)\b", why) is None
        report = latest(project, "compare")["report"]
        assert re.findall(r"\d+", why) == re.findall(r"\d+", report["why"])
    finally:
        page.run("localStorage.removeItem('autobalance-language')")


# --- by keys, at any width ----------------------------------------------------------------------------------


def test_a_comparison_that_ends_leaves_what_was_chosen_meanwhile(page: Browser) -> None:
    """A result of a kind that somebody took must not be of an earlier job a moment later."""
    page.click_on(at("tab-correct"))
    page.click_on(at("compare"))
    until(page, "return document.querySelector('[data-testid=state-line]').textContent.includes('Comparing')")
    page.click_on(at("kind-add"))
    job_text(page, 'method = "add"')
    until(page, "return document.getElementById('balance') !== null", most_s=300.0)
    assert 'method = "add"' in text_of(page, "job-text")
    marked = "[...document.querySelectorAll('.kind[aria-checked=true]')].map(each => each.dataset.kind)"
    assert page.run(f"return {marked}") == ["add"]


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
    assert focused()["id"] == "crank-called"  # the first field of the step
    unnamed = page.run(
        "return [...document.querySelectorAll('button, input, select, a, [role]')].filter(each =>"
        "!(each.labels?.length || each.getAttribute('aria-label') || each.getAttribute('aria-labelledby')"
        "|| each.textContent.trim() || each.id === 'error')).map(each => each.outerHTML)"
    )
    assert unnamed == []


@pytest.mark.looks
def test_nothing_is_wider_than_the_window(page: Browser) -> None:
    try:
        for width in (1440, 1024, 768, 390):
            page.resize(width, 900)
            for tab in ("open", "parts", "correct", "see", "machine", "analyse", "history"):
                page.click_on(at(f"tab-{tab}"))
                wide = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
                assert page.run(f"return {wide}") <= 0, (width, tab)
    finally:
        page.resize(1400, 900)


# --- in one's own units and language, and what else a person wants of it ------------------------------------


def test_lengths_and_unbalance_are_shown_and_typed_in_the_units_that_are_chosen(
    page: Browser, project: Served
) -> None:
    report = latest(project, "balance")["report"]
    try:
        for system, per in (("oz-in", 720.0778892), ("g-in", 25.4)):
            put(page, units=system)
            cell = '[data-key="residual.magnitude_g_mm"]'
            until(page, "return document.getElementById('numbers').caption.textContent.includes('in')")
            text = page.run(f"return document.querySelector('{cell}').textContent")
            assert float(text) * per == pytest.approx(report["residual"]["magnitude_g_mm"], abs=0.006 * per)
            value = page.run(f"return Number(document.querySelector('{cell}').dataset.value)")
            assert value == report["residual"]["magnitude_g_mm"]
        put(page, key_engine_rod_length_mm="5.5")
        text = job_text(page, "rod_length_mm = 139.7")
        assert tomllib.loads(text)["engine"]["rod_length_mm"] == 139.7
        limit(page, "drill.min_wall_mm", 0.25)
        assert tomllib.loads(job_text(page, "6.35"))["correction"]["drill"]["min_wall_mm"] == 6.35
        depth = '[data-key="corrections.0.depth_mm"]'
        text = page.run(f"return document.querySelector('{depth}').textContent")
        assert float(text) * 25.4 == pytest.approx(report["corrections"][0]["depth_mm"], abs=0.002)
    finally:
        put(page, units="metric")
    until(page, "return document.getElementById('key-engine-rod_length_mm').value === '139.7'")


def test_the_page_speaks_german_with_a_decimal_comma(page: Browser, project: Served) -> None:
    try:
        page.run("localStorage.setItem('autobalance-language', 'de'); location.reload()")
        time.sleep(0.3)
        until(page, "return document.body.dataset.ready === 'true' && document.documentElement.lang === 'de'")
        assert "Kurbelwelle" in text_of(page, "tab-open")
        cell = "document.querySelector('[data-key=\"residual.magnitude_g_mm\"]')"
        until(page, f"return {cell}?.textContent.includes(',')")
        assert page.run(f"return Number({cell}.textContent.replace(',', '.'))") == pytest.approx(
            page.run(f"return Number({cell}.dataset.value)"), abs=0.006
        )
    finally:
        page.run("localStorage.removeItem('autobalance-language')")


def test_a_reload_comes_back_to_the_same_tab(page: Browser) -> None:
    page.click_on(at("tab-machine"))
    page.call("POST", "/refresh", {})
    until(page, "return document.body.dataset.ready === 'true'")
    assert page.run("return !document.getElementById('panel-machine').hidden")


def test_a_run_is_deleted_with_its_files(unopened: Browser, project: Served) -> None:
    run = small.ran(project, "balance", small.DRILLED)
    page = load(unopened, project)
    page.click_on(at("tab-correct"))
    assert (project.project / "runs" / run).is_dir()
    page.run(f"document.querySelector('[data-run=\"{run}\"] [aria-label^=Delete]').click()")
    until(page, f"return !document.querySelector('[data-run=\"{run}\"]')")
    assert (project.project / "runs" / run).is_dir()  # until it cannot be undone any more
    latest_s = time.monotonic() + 30.0
    while project.ask(f"/api/runs/{run}").status != 404 and time.monotonic() < latest_s:
        time.sleep(0.2)
    assert project.ask(f"/api/runs/{run}").status == 404
    assert not (project.project / "runs" / run).exists()
    assert not (project.project / ".app" / run).exists()
    assert page.run("return document.getElementById('verdict').dataset.outcome") == ""


def test_the_polar_moves_as_a_reading_is_typed(page: Browser, project: Served) -> None:
    page.click_on(at("tab-machine"))
    permitted = latest(project, "balance")["report"]["tolerance"]["planes"][0]["permissible_g_mm"]
    figure = "document.querySelector('[data-testid=read-polar-1]')"
    for share, within in ((0.5, "true"), (3.0, "false")):
        put(page, g_mm_1=share * permitted, angle_1=90)
        until(page, f"return {figure}.dataset.within === '{within}'")
        tip = f"return ['cx', 'cy'].map(name => Number({figure}.querySelector('.tip')?.getAttribute(name)))"
        # 90° from crankpin 1, which is up, counter-clockwise: to the left; a circle of one size
        until(
            page,
            f"const [x] = (() => {{ {tip} }})(); return Math.abs(x - arguments[0]) < 0.01",
            100.0 - min(44.0 * share, 66.0),
        )
        assert page.run(tip)[1] == pytest.approx(100.0)
    put(page, rotation="cw")
    until(page, f"return Number({figure}.querySelector('.tip')?.getAttribute('cx')) > 150")
    put(page, rotation="ccw")
    page.click_on(at("big"))
    size = "Number.parseFloat(getComputedStyle(document.getElementById('big-g-mm-1')).fontSize)"
    until(page, f"return {size} >= 40")
    page.run("[...document.querySelectorAll('#big-digits button')][1].click()")
    until(page, "return document.querySelector('.big-cut dd')")
    page.run("[...document.querySelectorAll('#big-digits button')].pop().click()")


def test_an_index_test_separates_crank_and_tooling(page: Browser) -> None:
    page.click_on(at("tab-machine"))
    page.run("document.getElementById('index-test').open = true")
    for name, size, angle in (("first", 30, 0), ("second", 10, 180)):
        put(page, **{f"index-{name}-size": size, f"index-{name}-angle": angle})
    page.click_on(at("index-test"))
    until(page, "return document.querySelector('[data-testid=index-found]').textContent.includes('20.00')")


@pytest.mark.looks
def test_views_are_at_a_press(page: Browser) -> None:
    away = (
        "const view = document.getElementById('model').view;"
        "return view.camera.position.clone().sub(view.controls.target).normalize().toArray()"
    )
    buttons = "document.querySelectorAll('#views button')"
    for place, (axis, sign) in {1: (2, -1), 2: (2, 1), 3: (1, 1)}.items():  # front, rear, side: square on
        page.run(f"{buttons}[{place}].click()")
        assert sign * page.run(away)[axis] == pytest.approx(1.0, abs=1e-6)
    page.run(f"{buttons}[0].click()")
    assert page.run(away)[2] > 0.5
