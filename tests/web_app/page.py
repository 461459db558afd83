"""What people do on the page, for tests."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from autobalance.wording import at as value_at
from tests.report.browser import ELEMENT, Browser, missing
from tests.web_app import small
from tests.web_app.serving import Served, pause

BROWSER = [
    pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()}"),
    pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX"),
    pytest.mark.slow,
]
"""Marks of tests that drive a browser."""
VERDICT = "return document.querySelector('[data-testid=verdict]').dataset.outcome"
ENDED = "return document.getElementById('progress').getAttribute('aria-valuenow') === '100'"
READY = "return document.querySelector('[data-testid=model]').dataset.state === 'ready'"


def at(name: str) -> str:
    return f"[data-testid={name}]"


def until(page: Browser, script: str, *given: Any, most_s: float = 240.0) -> Any:
    """Wait until a script returns something, and return that."""
    begun = time.monotonic()
    while not (found := page.run(script, *given)):
        if time.monotonic() > begun + most_s:
            said = page.run("return document.getElementById('error')?.textContent")
            raise AssertionError(f"not so after {most_s} s: {script}; the page says {said!r}")
        pause(begun)
    return found


def load(page: Browser, app: Served) -> Browser:
    """Open the page at the address that was printed."""
    page.call("POST", "/url", {"url": app.address})
    until(page, "return document.body.dataset.ready === 'true'")
    return page


SIZE = (1400, 900)
FOLDS = "window.folds = new Map([...document.querySelectorAll('details')].map(each => [each, each.open]))"
AT_FIRST = """
document.activeElement?.blur();
for (const each of document.querySelectorAll("details")) each.open = window.folds.get(each) ?? false;
document.getElementById("tab-open").click();
document.querySelector("#views button").click();
scrollTo(0, 0);
"""


def anew(page: Browser, app: Served) -> None:
    """Put back the small crank's job, and the window's size, as a test before may have left them."""
    app.ask("/api/job", small.DRILLED, "PUT")
    page.resize(*SIZE)


def seen(page: Browser, app: Served) -> None:
    """Note that tests only look at the page that was loaded."""
    page.run(FOLDS)
    page.seen = app.base


def seen_again(page: Browser, app: Served, job: dict[str, Any]) -> bool:
    """Lead a page that was only looked at back to its first step; say whether it is there, with this job."""
    if page.seen != app.base or app.ask("/api/project").json["job"] != job:
        return False
    page.run(AT_FIRST)
    return True


@contextlib.contextmanager
def nothing_wrong(page: Browser, app: Served) -> Iterator[None]:
    """Hold a test to it: no error in the browser's log, nothing asked of another machine."""
    page.log("browser")
    page.requests()
    yield
    severe = [entry["message"] for entry in page.log("browser") if entry["level"] == "SEVERE"]
    assert severe == [], severe  # pytest shows what is asserted in files of tests alone
    asked = page.requests()
    assert all(url.startswith((app.base, "blob:")) for url in asked), asked


def text_of(page: Browser, name: str) -> str:
    """Return the text of what has a test id."""
    found: str = page.run("return document.querySelector(arguments[0]).textContent", at(name))
    return found


def chosen(page: Browser, *paths: Path) -> None:
    """Choose files, as by dropping them, and wait until they are taken in."""
    found = page.call("POST", "/element", {"using": "css selector", "value": at("file-input")})
    text = "\n".join(str(path) for path in paths)
    page.call("POST", f"/element/{found[ELEMENT]}/value", {"text": text})
    names = [path.stem for path in paths]
    script = (
        "const t = document.getElementById('chosen').textContent;"
        "return !t.startsWith('sending') && arguments[0].some(name => t.startsWith(name))"
    )
    until(page, script, names)


def put(page: Browser, **values: Any) -> None:
    """Give fields, by their ids, values; a dash stands in a name for an underscore.

    A field made from a job's key is ``key_TABLE_NAME``, and keeps the underscores of its name.
    """
    for name, value in values.items():
        _typed(page, name.replace("_", "-", 2) if name.startswith("key_") else name.replace("_", "-"), value)


def limit(page: Browser, key: str, value: Any) -> None:
    """Give a limit of a kind, ``drill.max_holes``, a value."""
    _typed(page, f"limit-{key.replace('.', '-')}", value)


def _typed(page: Browser, field: str, value: Any) -> None:
    page.run(
        "const field = document.getElementById(arguments[0]);"
        "field.value = arguments[1]; field.dispatchEvent(new Event('input', { bubbles: true }));",
        field,
        str(value),
    )


def weighed(page: Browser, group: str, name: str, grams: float) -> None:
    """Add a row to a table of weights."""
    page.click_on(at(f"add-{group}"))
    page.run(
        "const row = [...document.querySelectorAll(`[data-group=${arguments[0]}]`)].pop();"
        "for (const [key, value] of Object.entries(arguments[1])) {"
        "const input = row.querySelector(`[data-testid=weight-${key}]`);"
        "input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }",
        group,
        {"name": name, "g": str(grams)},
    )


def outcome(page: Browser) -> str:
    """Wait for a verdict."""
    found: str = until(page, VERDICT)
    return found


def balanced(page: Browser) -> str:
    """Press the button, and wait for the verdict."""
    page.click_on(at("tab-correct"))
    page.click_on(at("balance"))
    return outcome(page)


def job_text(page: Browser, holds: str) -> str:
    """Wait until the job's text on the page holds something; return the text."""
    script = "const t = document.getElementById('job-text').textContent; return t.includes(arguments[0]) && t"
    found: str = until(page, script, holds)
    return found


def other_crank(page: Browser) -> None:
    """Unfold the ways to another crank, on the tab of the crank."""
    page.click_on(at("tab-open"))
    page.run("const box = document.getElementById('other-crank'); if (box) box.open = true")


def opened(page: Browser) -> None:
    """Open the crank and wait for it."""
    page.click_on(at("tab-open"))
    page.click_on(at("open"))
    until(page, READY)


def numbers(page: Browser) -> dict[str, float]:
    """Return what the page shows as measured, by key."""
    found: dict[str, float] = page.run(
        "return Object.fromEntries([...document.querySelectorAll('[data-key]')]"
        ".map(each => [each.dataset.key, Number(each.dataset.value)]))"
    )
    return found


def predicted(page: Browser, box: str) -> list[float]:
    """Return what a part of the page, by its id, shows as predicted."""
    found: list[float] = page.run(
        "return [...document.querySelectorAll(`#${arguments[0]} [data-predicted]`)]"
        ".map(each => Number(each.dataset.predicted))",
        box,
    )
    return found


def latest(app: Served, verb: str) -> dict[str, Any]:
    """Return the latest run of a verb with its report."""
    told = [each for each in app.ask("/api/runs").json["runs"] if each["verb"] == verb][-1]
    return {**told, "report": app.ask(f"/api/runs/{told['id']}/report").json}


def shows_the_report(page: Browser, app: Served) -> None:
    """Hold the page to it: every number is the report's, to the last digit."""
    report, shown = latest(app, "balance")["report"], numbers(page)
    assert shown["residual.magnitude_g_mm"] == report["residual"]["magnitude_g_mm"]
    of_run = {key: value for key, value in shown.items() if not key.startswith("faces.")}
    assert len(of_run) > 20
    assert [key for key in of_run if value_at(report, key) is None] == []
    for key, value in of_run.items():
        assert value == pytest.approx(value_at(report, key), rel=1e-15), key
