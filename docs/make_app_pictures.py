"""Take the pictures of docs/app.md: the app in a browser without a screen, used as its page describes.

Run from a checkout, with Chromium and its driver installed: ``python docs/make_app_pictures.py``. It writes
``docs/app-*.png``; ``docs/app-see.png`` is the picture for the README. With ``examples`` it takes the
pictures of the examples that the app begins with.
"""

from __future__ import annotations

import base64
import io
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.report.browser import Browser, browser  # noqa: E402
from tests.web_app.page import READY, at, opened, outcome, put, until  # noqa: E402
from tests.web_app.serving import served  # noqa: E402

JOB = ROOT / "fixtures" / "crf250r" / "drafted" / "factor-0.28.toml"
SIZE = (1280, 860)
PHONE = (390, 844)
ROD_MM = "104"
COLOURS = 128
"""Of a picture's palette: a quarter of the size."""


STATIC = ROOT / "autobalance" / "browser" / "static"
EXAMPLES = {"bundled": "example-motocross", "example-v8": "example-v8"}
"""Button of an example in the app → its picture, as wide and high as the app takes of any crank."""
TAKEN = """
const [file, done] = arguments;
fetch(`/api/cranks/picture?file=${encodeURIComponent(file)}`).then(each => each.arrayBuffer())
  .then(bytes => done(btoa(String.fromCharCode(...new Uint8Array(bytes)))));
"""


def examples() -> None:
    """Take the pictures of the examples, as the app keeps one of every crank."""
    from PIL import Image

    for button, name in EXAMPLES.items():
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            with served(place / "project") as app, browser(place / "profile", pixels=2.0) as page:
                page.resize(*SIZE)
                page.call("POST", "/url", {"url": app.address})
                until(page, "return document.body.dataset.ready === 'true'")
                page.click_on(at(button))
                until(page, READY)
                file = app.ask("/api/project").json["job"]["crankshaft"]["file"]
                while not app.ask("/api/cranks").json["cranks"].get(file, {}).get("picture"):
                    time.sleep(0.1)
                data = page.call("POST", "/execute/async", {"script": TAKEN, "args": [file]})
                picture = Image.open(io.BytesIO(base64.b64decode(data)))
                picture.quantize(COLOURS).save(STATIC / f"{name}.png", optimize=True)


def main() -> None:
    """Take all pictures."""
    if sys.argv[1:] == ["examples"]:
        examples()
        return
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        with served(place / "project", str(JOB)) as app, browser(place / "profile", pixels=1.0) as page:
            page.resize(*SIZE)
            page.call("POST", "/url", {"url": app.address})
            until(page, "return document.body.dataset.ready === 'true'")
            _take(page)


def _take(page: Browser) -> None:
    opened(page)
    page.press("[data-kind=throw]", "\ue007")
    _shot(page, "open")
    page.click_on(at("tab-parts"))
    put(page, key_engine_rod_length_mm=ROD_MM)  # the shaking forces need it
    until(page, "return !document.getElementById('preview').hidden")
    page.run("document.querySelector('[data-testid=weight-name]').focus(); window.scrollTo(0, 0)")
    _shot(page, "parts")
    page.click_on(at("tab-correct"))
    page.run("document.querySelector('[data-face=w1-a] input').click();")
    page.run("document.querySelector('[data-face=w2-d] input').click();")
    _shot(page, "correct")
    page.click_on(at("balance"))
    outcome(page)
    page.run("window.scrollTo(0, 0)")
    _shot(page, "see")
    page.press(".handle[data-cut='2']", 12 * "\ue013")  # the arrow up: deeper
    until(page, "return !document.getElementById('dragged').hidden")
    _shot(page, "drag")
    page.run("document.getElementById('undo-dragged').click()")
    _dark(page, True)
    _shot(page, "dark")
    _dark(page, False)
    page.click_on(at("tab-analyse"))
    page.click_on(at("question-forces"))
    page.click_on(at("analyse"))
    until(page, "return document.querySelectorAll('#analysis-forces img').length > 3")
    _shot(page, "analyse")
    page.click_on(at("tab-machine"))
    put(page, umar=0.5, g_mm_1=9, angle_1=200, g_mm_2=2, angle_2=60)
    page.run("window.scrollTo(0, 0)")
    _shot(page, "machine")
    page.click_on(at("big"))
    _shot(page, "big")
    page.run("[...document.querySelectorAll('#big-digits button')].pop().click()")
    page.resize(*PHONE)
    page.click_on(at("tab-see"))
    page.run("window.scrollTo(0, 0)")
    _shot(page, "phone")


def _dark(page: Browser, on: bool) -> None:
    scheme = {"name": "prefers-color-scheme", "value": "dark" if on else "light"}
    asked = {"cmd": "Emulation.setEmulatedMedia", "params": {"features": [scheme]}}
    page.call("POST", "/goog/cdp/execute", asked)


def _shot(page: Browser, name: str) -> None:
    from PIL import Image

    time.sleep(0.8)  # the view draws in its own time
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    small = picture.quantize(COLOURS, dither=Image.Dither.NONE)
    small.save(ROOT / "docs" / f"app-{name}.png", optimize=True)


if __name__ == "__main__":
    main()
