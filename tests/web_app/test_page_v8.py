"""A V8 from the scale to the certificate, in the app alone: with a crank file, or with none on a phone."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.browser.drawing import RADIUS
from tests.report.browser import Browser
from tests.web_app.page import (
    BROWSER,
    READY,
    at,
    balanced,
    job_text,
    latest,
    load,
    nothing_wrong,
    numbers,
    other_crank,
    put,
    text_of,
    until,
)
from tests.web_app.serving import Served, served

pytestmark = BROWSER
WEIGHED = {
    "connecting_rod_big_end": 480,
    "big_end_bearing": 45,
    "connecting_rod_small_end": 150,
    "piston": 450,
    "wrist_pin": 100,
}
BOB_WEIGHT_G = 2 * (480 + 45) + 0.5 * 2 * (150 + 450 + 100)
assert BOB_WEIGHT_G == 1750
RADIUS_MM = 97.1
"""Of counterweights for bob-weights up to 2 100 g."""
TYPE = """
const row = [...document.querySelectorAll("[data-testid=weight-row]")]
  .find(each => each.querySelector("[data-testid=weight-name]").value === arguments[0]);
const field = row.querySelector("[data-testid=weight-g]");
field.value = arguments[1];
field.dispatchEvent(new Event("input", { bubbles: true }));
"""
FILE_OF = "document.querySelector('#panel-open .named small').textContent"
FILE = f"return {FILE_OF}"
TOO_LIGHT_OF = "document.querySelector('[data-testid=draw-for]')"
TOO_LIGHT = f"return {TOO_LIGHT_OF} && document.querySelector('[data-testid=state-line]').textContent"
GIVEN = "const link = document.querySelector(arguments[0]); return link ? link.href : ''"


def weighed_and_described(page: Browser) -> None:
    """Enter what the scale says, the engine, and what is wanted."""
    page.click_on(at("tab-parts"))
    for name, grams in WEIGHED.items():
        page.run(TYPE, name, str(grams))
    put(page, factor="0,5", grade=6.3, speed_rpm=6500, layout=90, key_engine_rod_length_mm=145)
    put(page, key_cycle_bore_mm=94, key_cycle_compression_ratio=11, key_cycle_heat_J=1500)
    put(page, key_cycle_firing_order="1-8-4-3-6-5-7-2", key_balance_margin="none")
    put(page, key_job_customer="Ann")
    page.run("for (const id of ['engine', 'lists']) document.getElementById(id).open = true")
    page.click_on("#key-engine-attached-add")
    until(page, "return document.getElementById('key-engine-attached-1-name')")
    values = {"name": "flywheel", "mass_g": 9000, "unbalance_g_mm": "0; 0", "z_mm": 300, "pm_g_mm": 20}
    for key, value in values.items():
        put(page, **{f"key_engine_attached-1-{key}": value})
    job = tomllib.loads(job_text(page, "pm_g_mm = 20"))
    assert job["engine"]["layout"] == {"bank_deg": [-45, 45]}
    assert job["engine"]["rods_per_throw"] == 2
    assert job["engine"]["attached"] == [{**values, "unbalance_g_mm": [0, 0]}]
    assert job["cycle"]["firing_order"] == [1, 8, 4, 3, 6, 5, 7, 2]
    until(page, "return !document.getElementById('preview').hidden")
    script = "return Number(document.querySelector('#preview-facts [data-predicted]').dataset.predicted)"
    until(page, f"{script} === {BOB_WEIGHT_G}")


def papers(page: Browser, app: Served) -> dict[str, bytes]:
    """Take the sheet, the certificate and the card from the page's links."""
    found = {}
    for name in ("certificate.pdf", "bob-weights.pdf", "holes.csv"):
        link = page.run(GIVEN, f'a[data-file="{name}"]')
        found[name] = app.ask(link.removeprefix(app.base)).body
    return found


def programmed_and_spun(page: Browser, app: Served) -> dict[str, Any]:
    """Write NC programs from an example of a machine file, then follow a reading of the machine."""
    page.click_on(at("tab-machine"))
    page.run("document.getElementById('nc-box').open = true")
    page.click_on(at("nc-example"))
    page.click_on(at("nc"))
    until(page, "return !document.getElementById('setups').hidden")
    assert latest(app, "nc")["report"]["not_programmed"] == []
    put(page, umar=5, g_mm_1=400, angle_1=200, g_mm_2=300, angle_2=20)
    page.click_on(at("recut"))
    until(page, "return document.querySelectorAll('[data-testid=stages] tbody tr').length === 2")
    return latest(app, "recut")


def story(page: Browser, app: Served) -> None:
    weighed_and_described(page)
    assert balanced(page) == "within_tolerance"
    report = latest(app, "balance")["report"]
    assert [each["mass_g"] for each in report["engine"]["bob_weights"]] == [BOB_WEIGHT_G] * 4
    assert report["corrections"]
    assert numbers(page)["residual.magnitude_g_mm"] == report["residual"]["magnitude_g_mm"]
    made = papers(page, app)
    assert made["certificate.pdf"].startswith(b"%PDF")
    assert made["bob-weights.pdf"].startswith(b"%PDF")
    assert len(made["holes.csv"].decode().splitlines()) > len(report["corrections"])
    recut = programmed_and_spun(page, app)
    assert recut["report"]["outcome"] == "within_tolerance"
    assert text_of(page, "error") == ""


def dropped(page: Browser, crank: Path) -> None:
    """Drop a crank's file, which opens at once, and say that its unit is right."""
    found = page.call("POST", "/element", {"using": "css selector", "value": at("file-input")})
    page.call("POST", f"/element/{next(iter(found.values()))}/value", {"text": str(crank)})
    until(page, "return document.getElementById('crank-name').textContent === arguments[0]", crank.stem)
    until(page, READY)
    page.click_on(at("unit-yes"))
    assert page.run("return document.querySelectorAll('[data-kind=throw]').length") == 4


def test_a_v8_is_built_on_a_phone_without_a_file_but_the_crank(
    window: Browser, app: Served, tmp_path: Path
) -> None:
    """From a drawn crank, and on from its file; that a drawn one has its certificate, a story counts."""
    crank = tmp_path / "my v8.stl"
    crank.write_bytes(ab.generate("v8-crossplane", segments=24, settings={RADIUS: RADIUS_MM}).data)
    window.resize(390, 844)
    app.ask("/api/job", {}, "PUT")
    page = load(window, app)
    try:
        with nothing_wrong(page, app):
            other_crank(page)
            put(page, preset="v8-crossplane")
            page.click_on(at("draw-preset"))
            until(page, READY)
            assert f"radius of {RADIUS_MM} mm for bob-weights up to 2100 g" in text_of(page, "drawn")
            assert 200 < page.run("return document.getElementById('model').clientHeight") <= 250
            dropped(page, crank)
            assert 200 < page.run("return document.getElementById('model').clientHeight") <= 250
            story(page, app)
            page.click_on(at("tab-see"))
            page.click_on(at("turn-to"))  # a cut in the list
            for tab in ("open", "parts", "correct", "see", "analyse", "machine", "history"):
                page.click_on(at(f"tab-{tab}"))
                wide = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
                assert page.run(f"return {wide}") <= 0, tab
    finally:
        page.resize(1400, 900)


def dimension(page: Browser, key: str, value: float | str) -> None:
    page.run("document.getElementById('dimensions').open = true")
    page.run(
        "const field = document.querySelector(`[data-testid='drawn-${arguments[0]}']`);"
        "field.value = arguments[1]; field.dispatchEvent(new Event('input', { bubbles: true }))",
        key,
        str(value),
    )


def test_dimensions_of_a_drawn_crank_are_typed_and_kept(window: Browser, tmp_path: Path) -> None:
    """The stroke that was typed is the crank's; a radius that nobody typed follows it, a typed one stays."""
    with served(tmp_path / "project") as app:
        page = load(window, app)
        put(page, preset="v8-crossplane")
        page.click_on(at("draw-preset"))
        until(page, READY)
        page.click_on(at("tab-parts"))
        for name, grams in WEIGHED.items():
            page.run(TYPE, name, str(grams))
        put(page, factor="0,5", grade=6.3, speed_rpm=6500)
        for key, value, says in (
            ("stroke_mm", 79, "radius of 93.3 mm for bob-weights up to 2100 g"),
            (RADIUS, 90, "radius of 90.0 mm for bob-weights up to"),
        ):
            page.click_on(at("tab-open"))
            before = page.run(FILE)
            dimension(page, key, value)
            page.click_on(at("draw-again"))
            until(page, f"return ({FILE_OF}) !== arguments[0]", before)
            until(page, READY)
            assert says in text_of(page, "drawn")
        job = app.ask("/api/project").json["job"]
        assert job["engine"]["rotating_g"]["connecting_rod_big_end"] == WEIGHED["connecting_rod_big_end"]
        crank = ab.inspect(ab.read_crank(app.project / job["crankshaft"]["file"], unit="mm")).report["crank"]
        assert crank["throws"][0]["crank_radius_mm"] == pytest.approx(39.5, abs=1e-3)
        assert crank["webs"][0]["outline"]["rim_radius_mm"] == pytest.approx(90.0, abs=0.05)
        page.click_on(at("tab-parts"))
        assert "1750 g is more" in until(page, TOO_LIGHT)
        page.click_on(at("draw-for"))
        until(page, f"return !({TOO_LIGHT_OF})")
        until(page, READY)
        page.click_on(at("tab-open"))
        assert "for bob-weights up to 2100 g" in text_of(page, "drawn")
