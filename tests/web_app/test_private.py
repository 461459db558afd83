"""What other users of the machine see of the app: no token on a command line, no file of the project."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from autobalance.browser.serving import _redirect
from tests.web_app.serving import Served, served


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("private") / "project") as running:
        yield running


def test_the_browser_is_given_a_file_that_this_user_alone_reads() -> None:
    address = "http://127.0.0.1:8000/?token=secret"
    path = _redirect(address)
    try:
        assert "secret" not in path.as_uri()
        assert f"url={address}" in path.read_text(encoding="utf-8")
        if sys.platform != "win32":
            assert stat.S_IMODE(path.stat().st_mode) == 0o600
    finally:
        path.unlink()


@pytest.mark.skipif(sys.platform == "win32", reason="modes of files are POSIX")
def test_a_project_is_its_users_alone(app: Served) -> None:
    assert app.ask("/api/files?name=note.stl", b"x").status == 201
    assert app.ask("/api/job/text", {"toml": "a = 1"}, "PUT").status == 200
    for name in ("note.stl", "job.toml"):
        path: Path = app.project / name
        assert stat.S_IMODE(os.stat(path).st_mode) == 0o600


def test_a_deep_key_is_refused_before_it_is_parsed(app: Served) -> None:
    answer = app.ask("/api/job/text", {"toml": ".".join("a" * 30_000) + " = 1"}, "PUT")
    assert answer.status == 400
    assert "line 1 nests deeper than 32 tables" in answer.json["error"]
