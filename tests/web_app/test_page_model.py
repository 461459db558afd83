"""What stands over the model: the cube, names of its parts, the tolerance planes and the heavy side."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.report.browser import Browser
from tests.web_app.page import BROWSER, READY, at, latest, until
from tests.web_app.serving import Served

pytestmark = BROWSER
OUT = {
    "Front": (0.0, 0.0, -1.0),
    "Rear": (0.0, 0.0, 1.0),
    "Side": (0.0, 1.0, 0.0),
    "Far side": (0.0, -1.0, 0.0),
    "Top": (1.0, 0.0, 0.0),
    "Bottom": (-1.0, 0.0, 0.0),
}
"""Faces of the cube: the way out of each, rotor frame."""
EYE = "return document.getElementById('model').view.eye()"
AWAY = "document.getElementById('model').view.turnTo(arguments[0], null)"
FACES = "return [...document.querySelectorAll('#cube button:not([hidden])')].map(each => each.dataset.face)"
TAGS = """
const box = document.getElementById("model").getBoundingClientRect();
return [...document.querySelectorAll("#model-tags span:not([hidden])")].map(each => {
  const { left, top, right, bottom } = each.getBoundingClientRect();
  return { kind: each.dataset.tag, words: each.textContent, left, top, right, bottom };
});
"""
PICKED = """
const [x, y] = arguments, view = document.getElementById("model").view, hit = view.pick(x, y);
return hit && { ...(view.parts[hit.part - 1] || {}), point: hit.point };
"""
ARROWS = """
const found = document.getElementById("model").view.scene.children.find(each => each.userData.arrows);
return found ? found.userData.arrows : [];
"""


INSIDE = """
const view = document.getElementById("model").view, { clientWidth, clientHeight } = view.box;
const found = view.scene.children.find(each => each.userData.arrows);
return found.children.at(-1).geometry.attributes.position.array
  .reduce((rows, value, k) => { (rows[Math.floor(k / 3)] ||= []).push(value); return rows; }, [])
  .map(point => view.placed(point)).every(([x, y]) => x > 0 && y > 0 && x < clientWidth && y < clientHeight);
"""


FITTED = """
if (document.querySelectorAll("#strip .polar").length !== 3) return false;
return new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(() => drawn(true))));
"""
"""What stands beside the crank comes with its preview, and the view is fitted to it and drawn anew."""


def tags(page: Browser, kind: str) -> list[dict[str, Any]]:
    """Wait for tags of a kind; return what is seen of them."""
    script = f"const found = (() => {{ {TAGS} }})().filter(e => e.kind === arguments[0]);"
    found: list[dict[str, Any]] = until(page, f"{script} return found.length ? found : null", kind)
    return found


@pytest.mark.looks
def test_a_face_of_the_cube_shows_the_crank_from_there(page: Browser) -> None:
    until(page, READY)
    for face, out in OUT.items():
        page.run(AWAY, [value + 0.4 for value in out])  # aslant: three faces are seen
        until(page, f"return (() => {{ {FACES} }})().includes(arguments[0])", face, most_s=10.0)
        page.run("document.querySelector(`#cube [data-face='${arguments[0]}']`).click()", face)
        assert page.run(EYE) == pytest.approx(out, abs=2e-6)
        until(page, f"return (() => {{ {FACES} }})().join() === arguments[0]", face, most_s=10.0)


@pytest.mark.looks
def test_ends_without_keyway_and_flange_have_the_names_of_the_axis(page: Browser) -> None:
    until(page, READY)
    for face, words in (("Front", "\u2212z"), ("Rear", "+z")):
        page.run(AWAY, OUT[face])
        seen = "[...document.querySelectorAll('#model-tags [data-tag=end]:not([hidden])')]"
        until(
            page, f"return {seen}.map(each => each.textContent).join() === arguments[0]", words, most_s=10.0
        )


@pytest.mark.looks
def test_parts_are_named_where_they_are_and_names_never_touch(page: Browser, project: Served) -> None:
    until(page, READY)
    until(page, FITTED)
    named = tags(page, "part")
    crank = latest(project, "inspect")["report"]["crank"]
    numbers = [each["number"] for each in crank["main_journals"]]
    assert {each["words"] for each in named} & {f"Main journal {number}" for number in numbers}
    for each in named:
        words, _, number = each["words"].rpartition(" ")
        found = page.run(PICKED, (each["left"] + each["right"]) / 2, (each["top"] + each["bottom"]) / 2)
        if words in ("Main journal", "Throw"):
            kind = {"Main journal": "main_journal", "Throw": "throw"}[words]
            assert kind != "main_journal" or found.get("kind") in (kind, None, "face")
            pins = (
                crank["main_journals"] if kind == "main_journal" else [t["crankpin"] for t in crank["throws"]]
            )
            pin = pins[int(number) - 1]
            assert abs(found["point"][2] - pin["centre_mm"][2]) < 0.5 * pin["width_mm"] + 1.0
            assert math.dist(found["point"][:2], pin["centre_mm"][:2]) < 0.5 * pin["diameter_mm"] + 1.0
        else:
            web = crank["webs"][int(number) - 1]
            assert web["z_min_mm"] - 1.0 < found["point"][2] < web["z_max_mm"] + 1.0
            away = found["point"][0] < 0.0  # crankpin 1 is at +x
            assert away == (words == "Counterweight") or abs(found["point"][0]) < 5.0
    boxes = [(each["left"], each["top"], each["right"], each["bottom"]) for each in named]
    for k, one in enumerate(boxes):
        assert not any(over(one, other) for other in boxes[k + 1 :])
    page.run("document.querySelectorAll('#views button')[1].click()")  # from the front
    until(page, f"return !(() => {{ {TAGS} }})().some(each => each.words === 'Main journal 2')")


def over(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


@pytest.mark.looks
def test_planes_and_their_heavy_sides_stand_in_the_model(page: Browser, project: Served) -> None:
    until(page, READY)
    page.click_on(at("tab-parts"))
    until(page, "return document.querySelectorAll('#strip .polar').length === 3")
    planes = latest(project, "balance")["report"]["tolerance"]["planes"]
    assert [each["words"] for each in tags(page, "plane")] == [each["name"] for each in planes]
    arrows = until(page, f"const all = (() => {{ {ARROWS} }})(); return all.length ? all : null")
    initial = latest(project, "balance")["report"]["initial"]["planes"]
    assert [each["z"] for each in arrows] == pytest.approx([each["z_mm"] for each in planes])
    for found, plane in zip(arrows, initial, strict=True):
        x, y = plane["unbalance_g_mm"]
        assert found["angle"] == pytest.approx(math.atan2(y, x), abs=0.01)
    assert page.run(INSIDE)
    said = tags(page, "heavy")[0]["words"]
    shown = page.run(
        "return document.querySelectorAll('#strip .polar')[1].querySelectorAll('dd')[1].textContent"
    )
    assert said == f"heavy at {shown}"
    page.click_on(at("tab-see"))  # within: nothing is heavy any more
    until(page, f"return !(() => {{ {ARROWS} }})().length")
    assert [each["words"] for each in tags(page, "plane")] == [each["name"] for each in planes]


@pytest.mark.looks
def test_what_was_dragged_stands_in_the_panel_and_covers_no_model(page: Browser) -> None:
    page.click_on(at("tab-see"))
    until(page, "return document.querySelectorAll('.handle').length > 1")
    page.press(".handle", 3 * "\ue013")
    until(page, "return !document.getElementById('dragged').hidden")
    inside = (
        "const a = document.getElementById('dragged').getBoundingClientRect(),"
        "b = document.querySelector('.panel').getBoundingClientRect();"
        "return a.right <= b.right && a.top >= b.top"
    )
    assert page.run(inside)
    page.run("document.getElementById('undo-dragged').click()")
