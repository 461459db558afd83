"""One server and one browser for all tests of the page."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.report.browser import Browser, browser
from tests.web_app.page import until
from tests.web_app.serving import Served, served


@pytest.fixture(scope="session")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        opened.resize(1400, 900)
        yield opened


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("app") / "project") as running:
        yield running


@pytest.fixture(scope="module")
def page(app: Served, window: Browser) -> Browser:
    window.call("POST", "/url", {"url": app.address})
    until(window, "return document.body.dataset.ready === 'true'")
    return window
