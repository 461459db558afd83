"""The page and its papers printed: panel and model on white, without tools; a paper's PDF opens."""

from __future__ import annotations

import base64
import io

import pytest
from pypdf import PdfReader

from tests.report.browser import Browser
from tests.web_app.page import BROWSER, at, until

pytestmark = BROWSER
COPIED = """
const copy = document.getElementById("printed"), { width, height } = copy;
const data = copy.getContext("2d").getImageData(0, 0, width, height).data;
let drawn = 0;
for (let k = 3; k < data.length; k += 4) if (data[k] > 0) drawn++;
return drawn / (width * height);
"""


def printed(page: Browser) -> list[str]:
    """Return the text of each page of the page as it is printed."""
    data = base64.b64decode(page.call("POST", "/print", {"background": True}))
    return [each.extract_text() for each in PdfReader(io.BytesIO(data)).pages]


@pytest.mark.looks
def test_the_page_prints_panel_and_model_without_tools(page: Browser) -> None:
    page.click_on(at("tab-see"))
    until(page, "return document.querySelectorAll('#cuts tr.turns').length === 2")
    pages = printed(page)
    text = "\n".join(pages)
    assert "not proven" in text
    assert "180.0° P1" in text
    assert "Plane A" in text
    for tool in ("Analyses", "To the machine", "Front", "Rear", "English"):
        assert tool not in text
    assert len(pages) <= 2
    assert 0.05 < page.run(COPIED) < 0.95  # the crank, on paper's white


@pytest.mark.looks
def test_a_paper_opens_as_a_pdf_to_be_printed(page: Browser) -> None:
    page.click_on(at("tab-see"))
    until(page, "return document.querySelectorAll('[data-print]').length === 3")
    links = page.run(
        "return Promise.all([...document.querySelectorAll('[data-print]')].map(async (each) => {"
        "const answer = await fetch(each.href), kept = await fetch(each.href.replace('?show', ''));"
        "const head = (one, name) => one.headers.get(name);"
        "const start = String.fromCharCode(...new Uint8Array(await answer.arrayBuffer()).slice(0, 5));"
        "return [each.dataset.print, head(answer, 'content-type'),"
        "head(answer, 'content-disposition'), start,"
        "head(kept, 'content-disposition'), each.target]; }))"
    )
    assert {each[0] for each in links} == {"sheet.pdf", "bob-weights.pdf", "certificate.pdf"}
    for name, kind, shown, start, kept, target in links:
        assert (kind, start, target) == ("application/pdf", "%PDF-", "_blank"), name
        assert shown.startswith("inline")
        assert kept.startswith("attachment")
