"""Pages of prose, tables and drawings as a PDF, each in its frame with head and foot."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, Literal

from reportlab import rl_config
from reportlab.lib.styles import ParagraphStyle
from reportlab.platypus import BaseDocTemplate, Flowable, Frame, PageTemplate, Paragraph

from autobalance.paper.lettering import POINTS_PER_MM, SMALLEST_PT, font_of, safe
from autobalance.paper.pen import INK, Pen
from autobalance.paper.title_block import FOOT_MM, MARGIN_MM, NumberedCanvas, Sheet, title_block
from autobalance.wording import part_name

Paper = Literal["A4", "Letter"]
PAPERS_MM = {"A4": (210.0, 297.0), "Letter": (215.9, 279.4)}
SIZES_PT = {"A4": (595.2756, 841.8898), "Letter": (612.0, 792.0)}
NO_NUMBER_FIRST = re.compile(r" (?=[-−+±]?\d)")
"""Spaces at which prose must not break: only rows of tables begin with a number."""


def written(
    sheet: Sheet, paper: Paper, templates: Sequence[PageTemplate], story: list[Flowable]
) -> tuple[int, bytes]:
    """Return the number of pages and the PDF of a story; the same input gives the same bytes."""
    buffer = io.BytesIO()
    document = BaseDocTemplate(
        buffer,
        pagesize=SIZES_PT[paper],
        title=safe(f"{sheet.name} {part_name(sheet.report)}"),
        author=f"autobalance {sheet.report['autobalance']['version']}",
        invariant=1,
        pageCompression=1,
    )
    document.addPageTemplates(list(templates))
    with _binary_streams():
        document.build(story, canvasmaker=partial(NumberedCanvas, sheet=sheet))
    return document.page, buffer.getvalue()


@contextmanager
def _binary_streams() -> Iterator[None]:
    """Make reportlab write pages as bytes: text in base 85 takes a quarter more room, and time."""
    before, rl_config.useA85 = rl_config.useA85, 0
    try:
        yield
    finally:
        rl_config.useA85 = before


def prose(
    text: str, size: float = SMALLEST_PT, colour: str = INK, bold: bool = False, after: float = 1.2
) -> Flowable:
    """Return a paragraph, in the sheet's fonts, with ``after`` mm below it; never smaller than 9 pt."""
    size = max(size, SMALLEST_PT)
    shown = NO_NUMBER_FIRST.sub("\u00a0", safe(text))
    font = font_of(shown, bold)
    style = ParagraphStyle(
        "text",
        fontName=font,
        fontSize=size,
        leading=1.2 * size,
        textColor=colour,
        spaceAfter=after * POINTS_PER_MM,
    )
    return Paragraph(html.escape(shown, quote=False), style)


def template(name: str, sheet: Sheet, block_mm: float) -> PageTemplate:
    """Return a page with room for its text between head and foot, less the title block."""
    p = POINTS_PER_MM
    frame = Frame(
        MARGIN_MM * p,
        (FOOT_MM + block_mm) * p,
        (sheet.wide_mm - 2.0 * MARGIN_MM) * p,
        (sheet.high_mm - sheet.head_mm - FOOT_MM - block_mm) * p,
        leftPadding=0.0,
        rightPadding=0.0,
        topPadding=0.0,
        bottomPadding=0.0,
    )

    def draw(canvas: Any, _document: Any) -> None:
        if block_mm:
            title_block(Pen(canvas, sheet.high_mm), sheet)

    return PageTemplate(name, [frame], onPage=draw)
