"""What people do on the page, for tests."""

from __future__ import annotations

import time
from typing import Any

from tests.report.browser import ELEMENT, Browser


def at(name: str) -> str:
    return f"[data-testid={name}]"


def until(page: Browser, script: str, *given: Any, most_s: float = 120.0) -> Any:
    """Wait until a script returns something, and return that."""
    end = time.monotonic() + most_s
    while not (found := page.run(script, *given)):
        if time.monotonic() > end:
            said = page.run("return document.getElementById('error').textContent")
            raise AssertionError(f"not so after {most_s} s: {script}; the page says {said!r}")
        time.sleep(0.1)
    return found


def chosen(page: Browser, *paths: Any) -> None:
    """Choose files, as by dropping them."""
    found = page.call("POST", "/element", {"using": "css selector", "value": at("file-input")})
    text = "\n".join(str(path) for path in paths)
    page.call("POST", f"/element/{found[ELEMENT]}/value", {"text": text})


def put(page: Browser, **values: Any) -> None:
    """Give fields, by their ids, values; a dash stands in a name for an underscore."""
    for name, value in values.items():
        page.run(
            "const field = document.getElementById(arguments[0]);"
            "field.value = arguments[1]; field.dispatchEvent(new Event('input', { bubbles: true }));",
            name.replace("_", "-"),
            str(value),
        )


def limit(page: Browser, key: str, value: Any) -> None:
    """Give a limit of a kind, ``drill.max_holes``, a value."""
    page.run(
        "const field = document.getElementById(`limit-${arguments[0].replace('.', '-')}`);"
        "field.value = arguments[1]; field.dispatchEvent(new Event('input', { bubbles: true }));",
        key,
        str(value),
    )


def outcome(page: Browser) -> str:
    """Wait for a verdict."""
    found: str = until(page, "return document.querySelector('[data-testid=verdict]').dataset.outcome")
    return found


def job_text(page: Browser, holds: str) -> str:
    """Wait until the job's text on the page holds something; return the text."""
    script = "const t = document.getElementById('job-text').textContent; return t.includes(arguments[0]) && t"
    found: str = until(page, script, holds)
    return found


def opened(page: Browser) -> None:
    """Open the crank and wait for it."""
    page.click_on(at("tab-open"))
    page.click_on(at("open"))
    until(page, "return document.querySelector('[data-testid=model]').dataset.state === 'ready'")


def numbers(page: Browser) -> dict[str, float]:
    """Return what the page shows as measured, by key."""
    found: dict[str, float] = page.run(
        "return Object.fromEntries([...document.querySelectorAll('[data-key]')]"
        ".map(each => [each.dataset.key, Number(each.dataset.value)]))"
    )
    return found
