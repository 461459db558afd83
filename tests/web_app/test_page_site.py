"""The documentation's site as it is built: read in a browser at the width of a small screen."""

from __future__ import annotations

import html
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from autobalance.registry import VERBS
from tests.report.browser import Browser
from tests.web_app.page import BROWSER

pytest.importorskip("sphinx")
pytestmark = BROWSER
ROOT = Path(__file__).parents[2]
PAGES = ("index", "_generated/commands", "app", "tasks", "_generated/functions")
SIDEWAYS = """
const page = document.documentElement;
const boxes = [...document.querySelectorAll("pre")].filter(each => each.scrollWidth > each.clientWidth + 1);
return [page.scrollWidth - page.clientWidth, boxes.map(each => each.textContent.slice(0, 60))];
"""
SEEN_CONTENTS = """
return [...document.querySelectorAll("article .toctree-wrapper, main .toctree-wrapper")]
  .filter(each => each.getClientRects().length && each.textContent.trim()).length;
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site without the answers of its notebooks, which take minutes."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-b", "html", "-D", "nb_execution_mode=off"]
    done = subprocess.run(
        [*command, "-d", str(folder / "read"), str(ROOT / "docs"), str(folder / "html")],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONWARNINGS": "default"},
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


def test_the_built_site_is_read_without_scrolling_sideways(site: Path, window: Browser) -> None:
    window.resize(1024, 800)
    try:
        for name in PAGES:
            window.open(site / f"{name}.html")
            wide, boxes = window.run(SIDEWAYS)
            assert wide <= 0, name
            if name == "_generated/commands":
                assert boxes == []
                text = window.run("return document.body.textContent")
                assert [verb for verb in VERBS if f"usage: autobalance {verb}" not in text] == []
        window.open(site / "index.html")
        assert window.run(SEEN_CONTENTS) == 0  # the site's own side bar is the one table of contents
    finally:
        window.resize(1400, 900)


def test_the_built_pages_have_no_asterisks_of_bold_text(site: Path) -> None:
    for path in sorted(site.glob("*.html")):
        text = re.sub(r"<(script|style|pre|code)\b.*?</\1>", "", path.read_text("utf-8"), flags=re.DOTALL)
        assert "**" not in html.unescape(re.sub(r"<[^>]*>", " ", text)), path.name


def test_the_sections_to_which_help_leads_are_on_the_built_page(site: Path, window: Browser) -> None:
    """Help links to the page in the repository, whose anchors keep the number of a heading."""
    window.open(site / "app.html")
    found = set(window.run("return [...document.querySelectorAll('section[id]')].map(each => each.id)"))
    sections = (ROOT / "autobalance" / "browser" / "static" / "keys.js").read_text("utf-8")
    (line,) = re.findall(r"const SECTIONS = \{(.*)\}", sections)
    wanted = {re.sub(r"^\d-", "", each) for each in re.findall(r'"([\w-]+)"', line)}
    assert len(wanted) == 7
    assert wanted <= found
