"""One angle for a hole everywhere: from the keyway if there is one, on the page and on papers."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ezdxf
import pytest
from pypdf import PdfReader

import autobalance as ab
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, at, load, nothing_wrong, put, seen, seen_again, until
from tests.web_app.serving import Served

pytestmark = BROWSER
JOB: dict[str, Any] = {
    "crankshaft": {"file": "keyed.stl", "unit": "mm", "density_kg_m3": 7850.0},
    "engine": {
        "rod_length_mm": 104.0,
        "rotating_g": {"big_end": 134.04},
        "reciprocating_g": {"piston": 261.5},
    },
    "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000.0},
    "correction": {"method": "drill", "drill": {"diameters_mm": [8.0, 10.0]}},
}
CONTRAST = """
const parts = text => text.match(/[\\d.]+/g).map(Number);
const linear = v => v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4;
const light = text => parts(text).map(linear).slice(0, 3)
  .reduce((sum, v, k) => sum + [0.2126, 0.7152, 0.0722][k] * v, 0);
const box = document.getElementById("big-digits"), ground = light(getComputedStyle(box).backgroundColor);
const texts = [...box.querySelectorAll("text, dt, dd, p, h2, span, b")];
return texts.filter(each => each.textContent.trim() && !each.children.length).map(each => {
  const ink = light(each instanceof SVGElement ? getComputedStyle(each).fill : getComputedStyle(each).color);
  return [each.textContent.slice(0, 30), (Math.max(ink, ground) + 0.05) / (Math.min(ink, ground) + 0.05)];
}).filter(each => each[1] < 7);
"""


def kinds_of(app: Served) -> dict[str, Any]:
    return {each["name"]: each for each in app.ask("/api/kinds").json["kinds"]}


@pytest.fixture(scope="module")
def keyed(tmp_path_factory: pytest.TempPathFactory, app: Served) -> Served:
    """A project with a crank that has a keyway, drilled."""
    folder: Path = tmp_path_factory.mktemp("keyed")
    ab.generate("single", file=folder / "keyed.stl", segments=16).write(folder)
    assert app.ask("/api/files?name=keyed.stl", (folder / "keyed.stl").read_bytes()).status == 201
    for verb in ("inspect", "balance"):
        small.ran(app, verb, JOB)
    app.ask("/api/job", JOB, "PUT")
    return app


@pytest.fixture
def shown(window: Browser, keyed: Served) -> Iterator[Browser]:
    if not seen_again(window, keyed, JOB):
        window.resize(1400, 900)
        load(window, keyed)
        seen(window, keyed)
    with nothing_wrong(window, keyed):
        yield window


def test_a_hole_has_the_same_angle_on_the_page_and_on_every_paper(shown: Browser, keyed: Served) -> None:
    run = [each for each in keyed.ask("/api/runs").json["runs"] if each["verb"] == "balance"][-1]
    report = keyed.ask(f"/api/runs/{run['id']}/report").json
    zero = report["crank"]["datums"]["angle"]["angle_deg"]
    assert zero != 0.0
    cut = report["corrections"][0]
    angle = f"{(cut['angle_deg'] - zero) % 360:.1f}°"
    until(shown, "return document.querySelectorAll('.handle').length > 0")
    shown.click_on(at("tab-see"))
    row = shown.run(
        "return [...document.querySelector('#cuts tr.turns').cells].map(each => each.textContent)"
    )
    assert row[2] == f"{angle} K↺"
    assert "keyway" in shown.run("return document.querySelector('[data-testid=zero]').textContent")
    (key,) = report["crank"]["datums"]["keyways"]
    ends = "[...document.querySelectorAll('#model-tags [data-tag=end]')].map(each => each.textContent)"
    nose = f"nose ({key['end']})".replace("-", "\u2212")
    until(shown, f"return {ends}.includes(arguments[0])", nose, most_s=20.0)

    def paper(name: str) -> bytes:
        room = "papers" if name in ("certificate.pdf", "holes.csv", "drawing.dxf") else "files"
        return keyed.ask(f"/api/runs/{run['id']}/{room}/{name}").body

    text = " ".join(page.extract_text() for page in PdfReader(io.BytesIO(paper("sheet.pdf"))).pages)
    (line,) = [each for each in text.splitlines() if re.match(r"\s*1 Drilled hole", each)]
    assert re.search(r"[\d.]+°", line)[0] == angle  # type: ignore[index]
    number = angle.removesuffix("°")
    holes = paper("holes.csv").decode("utf-8-sig").splitlines()
    assert any(number in each for each in holes)
    assert angle in paper("report.html").decode()
    drawing = ezdxf.read(io.StringIO(paper("drawing.dxf").decode("utf-8")))  # type: ignore[attr-defined]
    texts = [each.dxf.text for each in drawing.blocks[f"WEB_{cut['web']}"].query("TEXT")]
    assert {"1", f"{angle} K", "0° K"} <= set(texts)
    titles = [each.dxf.text for each in drawing.modelspace().query("TEXT")]
    assert all("ccw from keyway K" in each for each in titles if "web" in each or "rim" in each)
    heavy = f"{(report['initial']['angle_deg'] - zero) % 360:.1f}°"
    certificate = " ".join(
        page.extract_text() for page in PdfReader(io.BytesIO(paper("certificate.pdf"))).pages
    )
    assert heavy in certificate
    assert "keyway" in certificate
    screen = ab.balance(ab.Job.from_dict(JOB, folder=keyed.project)).text()
    (listed,) = [each.split() for each in screen.splitlines() if each.split()[:2] == ["1.", "drill"]]
    assert angle in listed
    assert "from keyway K" in screen
    # one radius, of the entry on the rim's own circle, and one letter of the set-up
    header, first = (each.split(",") for each in holes[:2])
    of_csv = dict(zip(header, first, strict=True))
    assert float(of_csv["keyway_ccw_deg"]) == pytest.approx(float(number), abs=0.05)
    radius = f"{float(of_csv['radius_mm']):.2f}"
    assert row[3] == radius
    assert radius in line.split()
    assert radius in listed
    group = shown.run("return document.querySelector('#cuts tbody').dataset.setup")
    assert group == of_csv["setup"]
    assert f"Set-up {group} for" in text
    assert shown.run("return document.querySelector('#cuts tr.group th').textContent").startswith(
        f"Set-up {group}: from the rim"
    )
    noun = kinds_of(keyed)["drill"]["noun"]
    assert shown.run("return document.querySelector('#cuts tr.turns .words').textContent").startswith(noun)
    assert noun in line
    assert noun in paper("report.html").decode()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_big_digits_have_the_zero_in_words_and_are_read_from_afar(shown: Browser, scheme: str) -> None:
    shown.seen = ""  # the screen goes on where it was left
    until(shown, "return document.querySelectorAll('.handle').length > 0")
    shown.click_on(at("tab-machine"))
    put(shown, g_mm_1=150, angle_1=200, g_mm_2=150, angle_2=20)
    angle = shown.run("return document.querySelector('#cuts tr.turns td:nth-child(3) span').textContent")
    command = "Emulation.setEmulatedMedia"
    try:
        asked = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        shown.call("POST", "/goog/cdp/execute", {"cmd": command, "params": asked})
        shown.click_on(at("big"))
        until(shown, "return document.querySelector('#big-digits text')")
        assert shown.run(CONTRAST) == []
        shown.run("[...document.querySelectorAll('#big-digits button')][1].click()")
        until(shown, "return document.querySelector('.big-cut dd')")
        assert shown.run(CONTRAST) == []
        words = shown.run("return document.getElementById('big-digits').textContent")
        assert angle in words
        assert "keyway" in words
        shown.run("[...document.querySelectorAll('#big-digits button')].pop().click()")
    finally:
        shown.call("POST", "/goog/cdp/execute", {"cmd": command, "params": {"features": []}})


def test_a_reading_has_the_angle_that_was_typed_on_the_certificate(shown: Browser, keyed: Served) -> None:
    runs = keyed.ask("/api/runs").json["runs"]
    balanced = [each["id"] for each in runs if each["verb"] == "balance"][-1]
    planes = keyed.ask(f"/api/runs/{balanced}/report").json["tolerance"]["planes"]
    amounts = [0.5 * plane["permissible_g_mm"] for plane in planes]
    shown.click_on(at("tab-machine"))
    put(shown, g_mm_1=amounts[0], angle_1=200, g_mm_2=amounts[1], angle_2=200, umar=0.05)
    shown.click_on(at("recut"))
    doubted = "!document.getElementById('trust').hidden"
    rows = "document.querySelectorAll('#stages tbody tr').length === 2"
    until(shown, f"return {doubted} || {rows}")
    if shown.run(f"return {doubted}"):
        shown.click_on(at("trust"))
    until(shown, f"return {rows}")
    shown.seen = ""  # but for a result that is deleted below
    run = [each for each in keyed.ask("/api/runs").json["runs"] if each["verb"] == "recut"][-1]
    try:
        report = keyed.ask(f"/api/runs/{run['id']}/report").json
        assert report["corrections"] == []
        shown.click_on(at("tab-see"))
        assert "200.0° K↺" in until(shown, "return document.querySelector('.strip')?.textContent")
        caption = shown.run("return document.getElementById('numbers').caption.textContent")
        assert caption.startswith("Read on the balancing machine")
        data = keyed.ask(f"/api/runs/{run['id']}/papers/certificate.pdf").body
        lines = PdfReader(io.BytesIO(data)).pages[0].extract_text().splitlines()
        of_planes = [line.split() for line in lines if line.startswith("Plane ")]
        assert len(of_planes) == 2
        for line, amount in zip(of_planes, amounts, strict=True):
            assert line[6:8] == [f"{amount:.2f}", "200.0°"]
        assert any("from keyway K" in line for line in lines) or "keyway" in " ".join(lines)
    finally:
        assert keyed.ask(f"/api/runs/{run['id']}", method="DELETE").status == 200
