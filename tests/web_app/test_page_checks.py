"""Faults of every step that came back once: moving fields, lost clicks, keys as words, a speck of a crank."""

from __future__ import annotations

import math
import re
import time
import tomllib
from typing import Any

import pytest

from tests.golden.messages import job_messages
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, at, job_text, latest, load, until
from tests.web_app.serving import Served

pytestmark = BROWSER
STEPS = ("open", "parts", "correct", "see", "machine", "analyse")
FIELDS = "[...document.querySelectorAll('#panels :is(input, select)')].filter(each => each.offsetParent)"
PLACES = """
return [...document.querySelectorAll("#panels :is(input, select, button, summary), .line button")]
  .filter(each => each.offsetParent).map(each => Math.round(each.getBoundingClientRect().y));
"""
KEYS_SHOWN = r"""
const found = new Set(), key = /[a-z]_[a-z]|[a-z]\.[a-z]+_|\/(tmp|home|root)\b/;
const shown = "label, legend, option, button, summary, h2, h3, p, th, td, dt, dd, small, span, b, text";
for (const each of document.querySelectorAll(`#panels :is(${shown}), .line *, .head *, .strip *`)) {
  if (each.closest("pre, code, textarea, #job-box")) continue;
  const own = [...each.childNodes].filter(node => node.nodeType === 3).map(node => node.data);
  const named = ["aria-label", "placeholder", "title"].map(name => each.getAttribute(name) || "");
  for (const text of [...own, ...named]) if (key.test(text)) found.add(text.trim().slice(0, 90));
}
return [...found];
"""
SHARE = """
const view = document.getElementById("model").view, { clientWidth: wide, clientHeight: high } = view.box;
const place = view.sets[view.mode].fine[0].geometry.attributes.position, at = new THREE.Vector3();
const low = [1e9, 1e9], most = [-1e9, -1e9];
for (let k = 0; k < place.count; k++) {
  at.fromBufferAttribute(place, k).project(view.camera);
  [at.x * wide / 2, at.y * high / 2].forEach((value, axis) => {
    low[axis] = Math.min(low[axis], value); most[axis] = Math.max(most[axis], value);
  });
}
return Math.max(most[0] - low[0], most[1] - low[1]) / Math.min(wide, high);
"""


def settled(page: Browser) -> Any:
    """Return the places once what a step asks for as it is opened has come."""
    before, now = None, page.run(PLACES)
    while now != before:
        time.sleep(0.5)
        before, now = now, page.run(PLACES)
    return now


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.looks
def test_nothing_moves_as_fields_have_the_focus(page: Browser, step: str) -> None:
    page.click_on(at(f"tab-{step}"))
    page.run("for (const each of document.querySelectorAll('#panels details')) each.open = true")
    before = settled(page)
    fields = page.run(f"return {FIELDS}.length")
    for place in range(0, fields, max(1, fields // 8)):
        page.run(f"{FIELDS}[arguments[0]].focus({{ preventScroll: true }})", place)
        assert page.run(PLACES) == before, place


def real_click(page: Browser, selector: str) -> None:
    """Press and release a real mouse on the middle of what is seen of an element."""
    x, y = page.run(
        "const each = document.querySelector(arguments[0]); each.scrollIntoView({ block: 'center' });"
        "const box = each.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]",
        selector,
    )
    page.click(x, y)


CLICKS = {
    "parts": (
        "#factor",
        "[data-testid=add-crankpin_g]",
        "return document.querySelectorAll('[data-group=crankpin_g]').length > 0",
    ),
    "correct": (
        "#limit-drill-min_wall_mm",
        ".kind[data-kind=shoulder]",
        "return document.querySelector('.kind[data-kind=shoulder]').classList.contains('chosen')",
    ),
    "machine": ("#g-mm-1", "[data-testid=big]", "return document.getElementById('big-digits')"),
    "analyse": (
        "#asks input",
        "[data-testid=question-parts]",
        "return document.getElementById('asks').dataset.verb === 'parts'",
    ),
}


@pytest.mark.parametrize("step", CLICKS)
def test_the_first_click_after_typing_acts(page: Browser, project: Served, step: str) -> None:
    field, button, acted = CLICKS[step]
    if step == "analyse":  # with something to type
        engine = {key: value for key, value in small.DRILLED["engine"].items() if key != "rod_length_mm"}
        project.ask("/api/job", {**small.DRILLED, "engine": engine}, "PUT")
        load(page, project)
    page.click_on(at(f"tab-{step}"))
    page.run("document.querySelector(arguments[0]).scrollIntoView({ block: 'center' })", field)
    page.press(field, "7")
    real_click(page, button)
    until(page, acted, most_s=10.0)
    page.run("[...document.querySelectorAll('#big-digits button')].pop()?.click()")


@pytest.mark.parametrize("step", [*STEPS, "history"])
@pytest.mark.looks
def test_no_key_or_folder_stands_in_place_of_words(page: Browser, step: str) -> None:
    page.click_on(at(f"tab-{step}"))
    page.run("for (const each of document.querySelectorAll('#panels details')) each.open = true")
    assert page.run(KEYS_SHOWN) == []


PREVIEWED = """
const own = window.fetch, [why] = arguments;
window.fetch = async (asked, options) => String(asked).endsWith("/preview")
  ? new Response(JSON.stringify({ why }), { headers: { "content-type": "application/json" } })
  : own(asked, options);
"""
JOB_KEYS = re.compile(
    r"[a-z]_[a-z]|\b(?:balance|correction|crankshaft|engine|original|drill)\.[a-z]|--[a-z]|job\.toml|\[(?:original|correction|balance|engine)"
)


def as_shown(page: Browser, *messages: str) -> list[str]:
    """Return messages of the program as the page shows them below what is typed."""
    page.run(PREVIEWED, " ¦ ".join(messages))
    now = page.run("return document.getElementById('factor').value")
    page.run(
        "const field = document.getElementById('factor'); field.value = arguments[0];"
        "field.dispatchEvent(new Event('input', { bubbles: true }))",
        "0.31" if now != "0.31" else "0.32",
    )
    shown: str = until(
        page, "const text = document.getElementById('preview-why').textContent; return text || false"
    )
    return shown.split(" ¦ ")


def test_a_message_has_the_labels_of_fields_in_place_of_keys(page: Browser) -> None:
    page.click_on(at("tab-parts"))
    wrong = [message for _, message in job_messages() if "unknown key" not in message]  # typed as text
    said = as_shown(
        page,
        "job.toml: balance.speed_rpm is -1; must be > 0",
        'no hole of ⌀10 mm keeps min_wall_mm = 4; zone = "anywhere" takes more of the webs',
        "Set crankpins, or crankpin_in_file = true if they are in the file (--no-crankpin)",
        "balance.factor is missing; [original] has the weights, original.reciprocating_g.piston too",
        "--set 'correction.method=[\"slug\"]' --set correction.drill.max_depth_mm=30: leaves 0.42",
        "limited by [correction.drill] of job.toml",
        *wrong,
    )
    assert len(said) == 6 + len(wrong) > 60
    assert said[:6] == [
        "Speed is -1; must be > 0",
        "no hole of ⌀10 mm keeps Min wall: 4; Zone: anywhere takes more of the webs",
        "Set crankpins, or Crankpin in file: yes if they are in the file",
        "Factor is missing; the weights before has the weights, Piston (before) too",
        "Correction method: slug; Max depth: 30: leaves 0.42",
        "limited by Drilled hole: limits of the job",
    ]
    assert [text for text in said if JOB_KEYS.search(text)] == []


def test_what_is_wrong_is_said_at_its_field_and_gone_with_its_cause(page: Browser) -> None:
    page.click_on(at("tab-analyse"))
    page.click_on(at("question-orders"))
    page.click_on(at("analyse"))
    assert "record" in until(page, "return document.getElementById('error').textContent")
    page.click_on(at("tab-parts"))
    assert page.run("return document.getElementById('error').textContent") == ""
    page.click_on(at("tab-machine"))
    page.press("#g-mm-1", "15o")
    until(page, "return document.getElementById('g-mm-1').getAttribute('aria-invalid') === 'true'")
    assert "15o" in page.run("return document.getElementById('g-mm-1-note').textContent")
    page.run(
        "const field = document.getElementById('g-mm-1'); field.value = '';"
        "field.dispatchEvent(new Event('input', { bubbles: true }))"
    )
    until(page, "return document.getElementById('g-mm-1').getAttribute('aria-invalid') !== 'true'")


def test_the_crank_fills_the_view_whatever_was_shown_before(page: Browser) -> None:
    shares = [page.run(SHARE)]
    page.click_on(at("tab-see"))
    shares.append(page.run(SHARE))
    page.run("const view = document.getElementById('model').view; view.camera.zoom = 9")
    page.call("POST", "/refresh", {})
    until(page, "return document.body.dataset.ready === 'true'")
    until(page, "return document.querySelectorAll('.handle').length > 1")
    shares.append(page.run(SHARE))
    page.click_on(at("tab-open"))
    shares.append(page.run(SHARE))
    assert all(0.6 <= share <= 0.95 for share in shares), shares


@pytest.mark.looks
def test_an_angle_read_in_the_rear_view_is_the_tables(page: Browser, project: Served) -> None:
    report = latest(project, "balance")["report"]
    page.click_on(at("tab-see"))
    until(page, "return document.querySelectorAll('.handle').length > 1")
    page.click_on("#views button:nth-child(3)")
    for cut in report["corrections"]:
        x, y, z = cut["position_mm"]
        placed = "return document.getElementById('model').view.placed(arguments[0])"
        (left, top, _), (middle, axis, _) = page.run(placed, [x, y, z]), page.run(placed, [0, 0, z])
        seen = math.degrees(math.atan2(middle - left, axis - top)) % 360  # 0° up, to the left counts up
        assert seen == pytest.approx(cut["angle_deg"] % 360, abs=0.05)


@pytest.mark.looks
def test_a_button_is_not_broken_inside_a_word(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    try:
        for width in (1440, 390):
            page.resize(width, 900)
            broken: list[Any] = page.run(
                "return [...document.querySelectorAll('#run-list button, .badge, .tools button, .handle')]"
                ".filter(each => each.offsetParent && each.textContent.trim().split(/\\s+/).length === 1)"
                ".filter(each => { const range = document.createRange(); range.selectNodeContents(each);"
                "return new Set([...range.getClientRects()].map(box => Math.round(box.y))).size > 1; })"
                ".map(each => each.outerHTML.slice(0, 80))"
            )
            assert broken == [], width
    finally:
        page.resize(1400, 900)


def test_what_is_typed_has_no_digits_that_nobody_typed(page: Browser) -> None:
    page.click_on(at("tab-correct"))
    page.run(
        "const field = document.getElementById('limit-drill-max_depth_mm'); field.value = '7,3';"
        "field.dispatchEvent(new Event('input', { bubbles: true }))"
    )
    text = job_text(page, "max_depth_mm")
    assert tomllib.loads(text)["correction"]["drill"]["max_depth_mm"] == 7.3
    assert not re.search(r"\d\.\d{7,}", text)


def test_the_jobs_text_is_folded_and_whole_once_it_is_unfolded(page: Browser, project: Served) -> None:
    text = "document.getElementById('job-text')"
    page.run("document.getElementById('job-box').open = false")
    load(page, project)
    for step in STEPS:
        page.click_on(at(f"tab-{step}"))
        assert page.run("return document.getElementById('job-box').open") is False
        assert page.run(f"return {text}.checkVisibility()") is False
    page.run("document.getElementById('job-box').open = true")
    shown, whole = page.run(f"return [{text}.clientHeight, {text}.scrollHeight]")
    assert shown == whole > 200  # one scroller: the panel's
    assert 'method = "drill"' in page.run(f"return {text}.textContent")


OVER = """
const boxes = [...document.querySelectorAll(arguments[0])]
  .filter(each => each.getClientRects().length && getComputedStyle(each).opacity > 0)
  .map(each => [each.textContent, each.getBoundingClientRect()]);
return boxes.flatMap(([one, a], k) => boxes.slice(k + 1)
  .filter(([, b]) => a.left < b.right - 1 && b.left < a.right - 1)
  .filter(([, b]) => a.top < b.bottom - 1 && b.top < a.bottom - 1)
  .map(([other]) => `${one} over ${other}`));
"""


@pytest.mark.parametrize("view", [1, 2, 3, 4])
@pytest.mark.looks
def test_no_number_or_label_of_the_model_lies_over_another(page: Browser, view: int) -> None:
    """Two holes of the small crank stand one behind the other in the end views."""
    page.click_on(at("tab-see"))
    until(page, "return document.querySelectorAll('.handle').length > 1")
    page.click_on("[data-testid=tool-degrees]")
    page.click_on(f"#views button:nth-child({view})")
    time.sleep(0.4)  # the view has turned
    try:
        assert page.run(OVER, ".handle") == []
        assert page.run(OVER, "#wheel-names > *") == []
    finally:
        page.click_on("[data-testid=tool-degrees]")
        page.click_on("#views button:nth-child(1)")
