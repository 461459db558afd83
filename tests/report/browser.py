"""A browser without a screen, driven over the WebDriver protocol: for tests of pages; no package needed."""

from __future__ import annotations

import base64
import contextlib
import json
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.kept import kept

SHELL = "chromium-headless-shell"
"""The same browser without windows and menus: a page is there after three quarters of the work."""
BARS_PX = 142
"""Height of what a window has above its page, where the shell has nothing."""
FLAGS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
]
UNCOVERED = """
const found = document.querySelector(arguments[0]), box = found?.getBoundingClientRect();
const top = box && document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
if (box?.width && !found.contains(top)) found.scrollIntoView({ block: "center" });
"""
QUIET: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"


def missing() -> str:
    """Return what is not installed, or nothing."""
    return ", ".join(tool for tool in ("chromium", "chromedriver") if shutil.which(tool) is None)


class Browser:
    """One window."""

    def __init__(self, base: str, session: str, bars_px: int) -> None:
        self.base = f"{base}/session/{session}"
        self.bars_px = bars_px
        self.seen = ""
        """Address of a page that no test has changed since it was loaded."""

    def call(self, method: str, path: str, body: Any = None) -> Any:
        if path == "/url":
            self.seen = ""
        return _request(method, self.base + path, body)

    def open(self, page: Path) -> None:
        self.call("POST", "/url", {"url": page.resolve().as_uri()})

    def resize(self, width: int, height: int) -> None:
        """Give the window a size as people see it: with the bars above the page."""
        self.call("POST", "/window/rect", {"width": width, "height": height - self.bars_px})

    def run(self, script: str, *arguments: Any) -> Any:
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def click(self, x: float, y: float) -> None:
        """Click with a real pointer at a place in the window."""
        moves = [
            {"type": "pointerMove", "duration": 0, "x": round(x), "y": round(y)},
            {"type": "pointerDown", "button": 0},
            {"type": "pointerUp", "button": 0},
        ]
        self.call("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": moves}]})

    def click_on(self, selector: str) -> None:
        """Click on an element, scrolled first from under a part of the page that stays."""
        self.run(UNCOVERED, selector)
        self._on(selector, "click", {})

    def press(self, selector: str, keys: str) -> None:
        self._on(selector, "value", {"text": keys})

    def _on(self, selector: str, action: str, body: dict[str, Any]) -> None:
        """Act on an element; once more where the page drew it anew between seeking it and acting."""
        for last in (False, True):
            found = self.call("POST", "/element", {"using": "css selector", "value": selector})
            try:
                self.call("POST", f"/element/{found[ELEMENT]}/{action}", body)
            except RuntimeError as error:
                if last or "stale element" not in str(error):
                    raise
            else:
                return

    def log(self, kind: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self.call("POST", "/se/log", {"type": kind})
        return found

    def requests(self) -> list[str]:
        """Return the addresses on a network that were asked for since the last call."""
        events = [json.loads(entry["message"])["message"] for entry in self.log("performance")]
        sent = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
        return [url for url in sent if url.startswith(("http:", "https:", "ws:", "wss:"))]

    def screenshot(self) -> bytes:
        return base64.b64decode(self.call("GET", "/screenshot"))


def _request(method: str, url: str, body: Any = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.loads(answer.read())["value"]
    except urllib.error.HTTPError as error:
        with error:
            raise RuntimeError(error.read().decode()[:600]) from None


@contextlib.contextmanager
def browser(folder: Path, pixels: float = 0.5, *flags: str) -> Iterator[Browser]:
    """Start chromedriver and Chromium, and end them.

    ``pixels`` are those of the screen to each of a page: the processor draws them, and tests that look at
    places and texts need few.
    """
    own = [*FLAGS, f"--user-data-dir={folder}", f"--force-device-scale-factor={pixels:g}", *flags]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with contextlib.ExitStack() as running:
        base = f"http://127.0.0.1:{port}"
        running.enter_context(kept(["chromedriver", f"--port={port}"], **QUIET))
        _wait_for(base)
        is_shell = shutil.which(SHELL) is not None
        options: dict[str, Any] = {"args": ["--headless=new", *own]}
        if is_shell:
            options = {"debuggerAddress": f"127.0.0.1:{running.enter_context(_shell(folder, own))}"}
        wanted = {
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
        }
        made = _request("POST", f"{base}/session", {"capabilities": {"alwaysMatch": wanted}})
        window = Browser(base, made["sessionId"], BARS_PX if is_shell else 0)
        try:
            yield window
        finally:
            window.call("DELETE", "")


@contextlib.contextmanager
def _shell(folder: Path, flags: list[str]) -> Iterator[int]:
    """Start the shell with a page, for the driver finds none in one that it starts itself; its port."""
    folder.mkdir(parents=True, exist_ok=True)  # what the page saves is put where the shell was started
    told = folder / "DevToolsActivePort"
    with kept([SHELL, *flags, "--remote-debugging-port=0", "data:,"], cwd=folder, **QUIET) as process:
        begun = time.monotonic()
        while not (told.exists() and told.read_text()):
            if process.poll() is not None or time.monotonic() > begun + 60.0:
                raise RuntimeError(f"{SHELL} does not begin")
            time.sleep(0.03)
        yield int(told.read_text().splitlines()[0])


def _wait_for(base: str) -> None:
    for _ in range(200):
        with contextlib.suppress(OSError, RuntimeError):
            if _request("GET", f"{base}/status")["ready"]:
                return
        time.sleep(0.1)
    raise RuntimeError("chromedriver does not answer")
