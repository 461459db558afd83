"""The app in a separate process, for tests."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.kept import kept
from tests.read_once import FOLDER_VARIABLE, read_once


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)


def pause(since: float) -> None:
    """Wait before asking again: a tenth of the time that went already, for to ask takes time itself."""
    time.sleep(min(max(0.03, 0.1 * (time.monotonic() - since)), 0.5))


class _Stay(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any) -> None:
        return None


@dataclass(frozen=True)
class Served:
    """A running app: its address, its token, its process and project."""

    base: str
    token: str
    process: subprocess.Popen[str]
    project: Path

    @property
    def address(self) -> str:
        return f"{self.base}/?token={self.token}"

    def ask(
        self, path: str, body: Any = None, method: str | None = None, token: bool = True, **headers: Any
    ) -> Answer:
        """Send a request; a body that is no bytes goes as JSON."""
        data = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
        sent: dict[str, str] = {key.replace("_", "-"): value for key, value in headers.items()}
        if token:
            sent["X-Autobalance-Token"] = self.token
        request = urllib.request.Request(self.base + path, data, sent, method=method)
        opener = urllib.request.build_opener(_Stay)
        try:
            with opener.open(request, timeout=60) as answer:
                return Answer(answer.status, _lower(answer.headers), answer.read())
        except urllib.error.HTTPError as error:
            with error:
                return Answer(error.code, _lower(error.headers), error.read())

    def ended(self, run: str, most_s: float = 240.0) -> dict[str, Any]:
        """Wait for the end of a run."""
        begun = time.monotonic()
        while time.monotonic() < begun + most_s:
            told: dict[str, Any] = self.ask(f"/api/runs/{run}").json
            if told["state"] in ("done", "failed", "cancelled"):
                return told
            pause(begun)
        raise AssertionError(f"run {run} does not end: {told}")


def _lower(headers: Any) -> dict[str, str]:
    return {key.lower(): value for key, value in headers.items()}


@contextlib.contextmanager
def served(project: Path, *options: str) -> Iterator[Served]:
    """Start the app and end it with SIGTERM, as a service manager would.

    What it reads is kept for its runs and for the apps of other tests, as it is for a user's next run.
    """
    command = [
        sys.executable,
        "-m",
        "autobalance",
        "app",
        "--no-browser",
        "--project",
        str(project),
        *options,
    ]
    reading = read_once() if FOLDER_VARIABLE in os.environ else contextlib.nullcontext()
    with reading, kept(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        line = process.stdout.readline()
        base, _, token = line.removeprefix("autobalance app: ").strip().partition("/?token=")
        assert token, line + process.stderr.read()
        yield Served(base, token, process, project)
