"""Results on a terminal: fitted to its width, and coloured by rich, which nothing else imports.

Where standard output is not a terminal the width is that of ``COLUMNS``, else 80.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from autobalance.report.tables import DRAWN_BY, Rows, fitted, fitted_table, has_heading

STYLES = {
    "bold red": r"(NOT WITHIN|ABOVE) TOLERANCE",
    "bold green": r"(?<!NOT )WITHIN TOLERANCE( ALREADY)?",
    "bold yellow": r"NOT PROVEN",
    "dim": r"(?m)^Written: .*$",
    "bold": r"(?m)^Open: .*$",
}
"""Styles of the words of results."""
HEADING, PLAIN = "\x1b[1;36m", "\x1b[0m"
LEAST_WIDTH = 40
USUAL_SIZE = (80, 24)


def is_terminal() -> bool:
    """Return whether standard output is a terminal that can show more than plain text."""
    return sys.stdout.isatty() and os.environ.get("TERM") != "dumb" and find_spec("rich") is not None


def width() -> int:
    """Return the number of characters of a line."""
    return max(shutil.get_terminal_size(USUAL_SIZE).columns, LEAST_WIDTH)


@contextmanager
def drawn_tables() -> Iterator[None]:
    """Fit tables to the terminal inside the block."""
    token = DRAWN_BY.set(_table)
    try:
        yield
    finally:
        DRAWN_BY.reset(token)


def _table(rows: Rows) -> str:
    """Return a table, on a terminal with its heading in colour."""
    drawn = fitted_table(rows, width())
    if not (is_terminal() and has_heading(rows)):
        return drawn
    return "\n".join(
        line if line.startswith(" ") else f"{HEADING}{line}{PLAIN}" for line in drawn.split("\n")
    )


def fit(text: str) -> str:
    """Return a text with lines no wider than the terminal, as far as its words allow."""
    return fitted(text, width())


def show(text: str) -> None:
    """Print a result with its verdict in colour."""
    from rich.console import Console
    from rich.text import Text

    shown = Text.from_ansi(text)
    for style, words in STYLES.items():
        shown.highlight_regex(words, style)
    Console(file=sys.stdout, highlight=False).print(shown, soft_wrap=True)
