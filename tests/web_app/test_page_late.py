"""Answers of the server that come late: what was typed meanwhile stays."""

import contextlib
import tomllib
from collections.abc import Iterator

import pytest

from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import BROWSER, READY, at, job_text, load, nothing_wrong, other_crank, put, until
from tests.web_app.serving import Served

pytestmark = BROWSER
HOLD = """
const own = window.fetch, [path] = arguments;
window.held = false;
window.fetch = async (asked, options) => {
  const answer = await own(asked, options);
  if (asked === path) { window.held = true; await new Promise(release => { window.release = release; }); }
  return answer;
};
"""


@contextlib.contextmanager
def late(page: Browser, path: str) -> Iterator[None]:
    """Hold the answers of one address back until the end of the block."""
    page.run(HOLD, path)
    yield
    until(page, "return window.held")
    page.run("window.release()")


def grams(page: Browser, group: str, text: str) -> None:
    """Type a weight into the first row of a group."""
    page.run(
        "const field = document.querySelector(`[data-group=${arguments[0]}] [data-testid=weight-g]`);"
        "field.value = arguments[1]; field.dispatchEvent(new Event('input', { bubbles: true }));",
        group,
        text,
    )


@pytest.fixture
def shown(window: Browser, app: Served, project: Served) -> Iterator[Browser]:
    """The page with the small crank, in a project of which the tests may open other cranks."""
    app.ask(f"/api/files?name={small.NAME}", (project.project / small.NAME).read_bytes())
    small.ran(app, "inspect", small.DRILLED)
    app.ask("/api/job", small.DRILLED, "PUT")
    load(window, app)
    until(window, READY)
    with nothing_wrong(window, app):
        yield window


def test_what_is_typed_while_a_crank_is_drawn_is_in_its_job(shown: Browser) -> None:
    other_crank(shown)
    put(shown, preset="single")
    with late(shown, "/api/example"):
        shown.click_on(at("draw-preset"))
        assert not shown.run(READY)
        shown.click_on(at("tab-parts"))
        put(shown, factor="0,45", grade=6.3)
        grams(shown, "rotating_g", "222,")
    until(shown, READY)
    job = tomllib.loads(job_text(shown, "single"))
    assert (job["balance"]["factor"], job["balance"]["grade"]) == (0.45, 6.3)
    assert "speed_rpm" not in job["balance"]  # of the crank before, and not typed since
    assert job["engine"] == {"rotating_g": {"rod": 222}, "reciprocating_g": {}}
    assert shown.run("return document.getElementById('factor').value") == "0,45"


def test_what_is_typed_while_a_typed_job_is_read_stays(shown: Browser) -> None:
    shown.run("document.getElementById('job-box').open = true")
    shown.click_on("#edit-job")
    put(shown, job_toml=job_text(shown, "speed_rpm").replace("6000", "7000"))
    with late(shown, "/api/job/text"):
        shown.click_on(at("take-job"))
        shown.click_on(at("tab-parts"))
        put(shown, grade=2.5)
    balance = tomllib.loads(job_text(shown, "grade = 2.5"))["balance"]
    assert (balance["speed_rpm"], balance["grade"]) == (7000, 2.5)
