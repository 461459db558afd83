"""Results on a terminal: tables and colours by rich, which nothing else imports.

Where standard output is not a terminal, where the terminal is dumb, or without the extra ``terminal``,
results are plain text, byte for byte the same as ever.
"""

from __future__ import annotations

import io
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from autobalance.report.tables import DRAWN_BY, Rows, has_heading

STYLES = {
    "bold red": r"(NOT WITHIN|ABOVE) TOLERANCE",
    "bold green": r"(?<!NOT )WITHIN TOLERANCE( ALREADY)?",
    "dim": r"(?m)^Written: .*$",
}
"""Styles of the words of results."""
LEAST_WIDTH = 60


def is_terminal() -> bool:
    """Return whether standard output is a terminal that can show more than plain text."""
    return sys.stdout.isatty() and os.environ.get("TERM") != "dumb" and find_spec("rich") is not None


@contextmanager
def drawn_tables() -> Iterator[None]:
    """Draw tables with rich inside the block, on a terminal."""
    if not is_terminal():
        yield
        return
    token = DRAWN_BY.set(rich_table)
    try:
        yield
    finally:
        DRAWN_BY.reset(token)


def rich_table(rows: Rows) -> str:
    """Return rows as a table of the terminal's width."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    heading = has_heading(rows)
    drawn = Table(box=box.SIMPLE_HEAD if heading else None, show_header=heading, header_style="bold cyan")
    for place in range(len(rows[0])):
        title = Text(rows[0][place].strip()) if heading else ""
        drawn.add_column(title, justify="left" if place == 0 else "right", overflow="fold")
    for row in rows[1:] if heading else rows:
        drawn.add_row(*(Text(cell) for cell in row))
    buffer = io.StringIO()
    width = max(shutil.get_terminal_size().columns, LEAST_WIDTH)
    Console(file=buffer, force_terminal=True, width=width, highlight=False).print(drawn)
    lines = [line.rstrip() for line in buffer.getvalue().splitlines()]
    return "\n".join(line for line in lines if line)


def show(text: str) -> None:
    """Print a result with its verdict in colour."""
    from rich.console import Console
    from rich.text import Text

    shown = Text.from_ansi(text)
    for style, words in STYLES.items():
        shown.highlight_regex(words, style)
    Console(file=sys.stdout, highlight=False).print(shown, soft_wrap=True)
