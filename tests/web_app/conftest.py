"""One browser for all tests of the page; a project with a small crank for those that need no other."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.report.browser import Browser, browser
from tests.web_app import small
from tests.web_app.page import SIZE, anew, load, nothing_wrong, seen, seen_again
from tests.web_app.serving import Served, served

SOFTWARE_PAGES = "--disable-gpu-compositing"
"""The emulated graphics card draws the 3D views alone and not the pages: a third less work."""
STILL = "--force-prefers-reduced-motion"
"""Nothing turns on the page that is opened first: sixty pictures a second take much of a processor."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Bring tests that only look at the page together: most of them then see one that is loaded once."""
    looking = [item for item in items if item.get_closest_marker("looks")]
    if looking:
        first, here = items.index(looking[0]), set(looking)
        rest = [item for item in items[first:] if item not in here]
        items[first:] = [*looking, *rest]


@pytest.fixture(scope="session")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile"), 0.5, SOFTWARE_PAGES, STILL) as opened:
        opened.resize(*SIZE)
        yield opened


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("app") / "project") as running:
        yield running


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A project in which the small crank was opened and drilled; tests add no other result to it."""
    data = small.crank(tmp_path_factory.mktemp("crank")).read_bytes()
    with served(tmp_path_factory.mktemp("small") / "project") as running:
        assert running.ask(f"/api/files?name={small.NAME}", data).status == 201
        for verb in ("inspect", "balance"):
            small.ran(running, verb, small.DRILLED)
        yield running


@pytest.fixture
def page(request: pytest.FixtureRequest, project: Served, window: Browser) -> Iterator[Browser]:
    """The page as it is loaded on that project, whatever was done on it before.

    Tests with the mark ``looks`` leave job and page as they are: after such a one the next has the same page.
    """
    looks = request.node.get_closest_marker("looks") is not None
    if not (looks and seen_again(window, project, small.DRILLED)):
        anew(window, project)
        load(window, project)
        if looks:
            seen(window, project)
    with nothing_wrong(window, project):
        yield window


@pytest.fixture
def unopened(project: Served, window: Browser) -> Iterator[Browser]:
    """As ``page``, not loaded yet: for tests that load it once they have changed something."""
    anew(window, project)
    with nothing_wrong(window, project):
        yield window
