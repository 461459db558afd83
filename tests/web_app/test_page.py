"""The app's page in a browser, as people use it: from a dropped file to the corrected solid."""

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests import jobs
from tests.report.browser import ELEMENT, Browser, browser, missing
from tests.web_app.serving import Served, served

CRANK = jobs.BUNDLED / "drafted" / "crank.stl"
pytestmark = [
    pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()}"),
    pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX"),
    pytest.mark.slow,
]


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("app") / "project") as running:
        yield running


@pytest.fixture(scope="module")
def page(app: Served, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as window:
        window.resize(1400, 900)
        window.call("POST", "/url", {"url": app.address})
        until(window, "return document.body.dataset.ready === 'true'")
        yield window


def until(page: Browser, script: str, most_s: float = 60.0) -> None:
    end = time.monotonic() + most_s
    while not page.run(script):
        if time.monotonic() > end:
            said = page.run("return document.getElementById('error').textContent")
            raise AssertionError(f"not so after {most_s} s: {script}; the page says {said!r}")
        time.sleep(0.1)


def at(name: str) -> str:
    return f"[data-testid={name}]"


def chosen(page: Browser, name: str, keys: str) -> None:
    found = page.call("POST", "/element", {"using": "css selector", "value": at(name)})
    page.call("POST", f"/element/{found[ELEMENT]}/value", {"text": keys})


def typed(page: Browser, name: str, text: Any) -> None:
    found = page.call("POST", "/element", {"using": "css selector", "value": at(name)})
    page.call("POST", f"/element/{found[ELEMENT]}/clear", {})
    page.call("POST", f"/element/{found[ELEMENT]}/value", {"text": str(text)})


def test_from_a_file_to_the_corrected_solid(page: Browser, app: Served) -> None:
    chosen(page, "file-input", str(CRANK))
    until(page, "return document.getElementById('chosen').textContent === 'crank.stl'")
    assert page.run("return !document.getElementById('unit-field').hidden")
    page.click_on(at("open"))
    until(page, "return document.querySelector('[data-testid=model]').dataset.state === 'ready'")
    assert page.run("return Number(document.querySelector('[data-testid=model]').dataset.triangles)") == 12416
    kinds = page.run(
        "return [...document.querySelectorAll('[role=treeitem]')].map(each => each.dataset.kind)"
    )
    assert page.run("return document.getElementById('crankpin-in-file').value") == "false"
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
            row = f"[data-group={group}]:nth-last-of-type(1)"
            page.run(
                "const row = [...document.querySelectorAll(arguments[0])].pop();"
                "for (const [key, value] of Object.entries(arguments[1])) {"
                "const input = row.querySelector(`[data-testid=weight-${key}]`);"
                "input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }",
                row,
                {"name": name, "g": str(grams)},
            )
    for name, value in (("factor", 0.28), ("grade", 6.3), ("speed-rpm", 15200)):
        typed(page, name, value)
    page.click_on(at("tab-correct"))
    page.run(
        "const m = document.getElementById('method');"
        "m.value = 'shoulder'; m.dispatchEvent(new Event('input'));"
    )
    page.click_on(at("balance"))
    until(page, "return document.querySelector('[data-testid=verdict]').dataset.outcome !== ''")
    assert page.run("return document.getElementById('verdict').dataset.outcome") == "within_tolerance"
    run = app.ask("/api/runs").json["runs"][-1]
    report = app.ask(f"/api/runs/{run['id']}/report").json
    shown = page.run(
        "return Object.fromEntries([...document.querySelectorAll('[data-key]')]"
        ".map(each => [each.dataset.key, Number(each.dataset.value)]))"
    )
    assert shown["residual.magnitude_g_mm"] == report["residual"]["magnitude_g_mm"]
    assert shown["corrections.0.depth_mm"] == report["corrections"][0]["depth_mm"]
    text = page.run("return document.querySelector('[data-testid=job-text]').textContent")
    path = app.project / "again.toml"
    path.write_text(text, encoding="utf-8")
    again = jobs.computed(path, app.project.parent / "again")
    assert again["residual"] == report["residual"]
    assert page.run("return document.querySelector('[data-testid=download-solid]').href").endswith(
        "balanced.stl"
    )
    quiet = [entry for entry in page.log("browser") if entry["level"] == "SEVERE"]
    assert quiet == []
    assert all(url.startswith(app.base) for url in page.requests())


def test_after_a_reload_the_result_is_still_there(page: Browser) -> None:
    page.call("POST", "/refresh", {})
    until(page, "return document.body.dataset.ready === 'true'")
    assert page.run("return document.getElementById('verdict').dataset.outcome") == "within_tolerance"
    assert page.run("return document.getElementById('factor').value") == "0.28"


def test_a_wrong_file_is_one_line(page: Browser, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.stl"
    wrong.write_bytes(b"no crank")
    chosen(page, "file-input", str(wrong))
    until(page, "return document.getElementById('chosen').textContent === 'wrong.stl'")
    page.click_on(at("tab-open"))
    page.click_on(at("open"))
    until(page, "return document.querySelector('[data-testid=error]').textContent !== ''")
    assert "wrong.stl" in page.run("return document.querySelector('[data-testid=error]').textContent")


@pytest.mark.parametrize("width", [1400, 820, 390])
def test_nothing_is_wider_than_the_window(page: Browser, width: int) -> None:
    page.resize(width, 900)
    for tab in ("open", "parts", "correct", "see", "machine"):
        page.click_on(at(f"tab-{tab}"))
        wide = page.run("return document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert wide <= 0, tab
