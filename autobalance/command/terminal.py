"""Results on a terminal, in the shop's units: fitted to its width, and coloured by rich.

Nothing else imports rich.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from autobalance.errors import AutobalanceError
from autobalance.report.files import earlier_report
from autobalance.report.tables import DRAWN_BY, Rows, fitted, fitted_table, has_heading
from autobalance.toml_files.document import text_of, toml_of
from autobalance.user_folders import shop_file

# Results on a terminal: fitted to its width, and coloured by rich, which nothing else imports.
#
# Where standard output is not a terminal the width is that of ``COLUMNS``, else 80.


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


# The units in which a shop works, as the default of commands.


WRITTEN = ("command", "json", "output", "plots", "series", "picture", "units")
"""Arguments that are not a file to read."""


def fill_in_units(arguments: argparse.Namespace) -> None:
    """Set ``units`` if the command has them and the user requests none."""
    if getattr(arguments, "units", "metric") is not None:
        return
    named = (Path(each) for name, each in vars(arguments).items() if name not in WRITTEN and _is_name(each))
    source = next((path for path in named if path.exists()), None)
    arguments.units = shop_units(source, getattr(arguments, "settings", None) or ())


def _is_name(value: object) -> bool:
    return isinstance(value, str) and "\0" not in value and 0 < len(value) < 4096


def shop_units(source: Path | None, settings: Sequence[str] = ()) -> str:
    """Return the units of ``--set``, else of a job or report, else of the shop's file beside it, else metric.

    Parameters
    ----------
    source : Path or None
        Job, report, crank or folder; None: the working folder.
    settings : sequence of str
        As typed, ``shop.units=inch``.
    """
    said = (each.partition("=") for each in settings)
    set_to = [value.strip().strip("\"'") for key, _, value in said if key.strip() == "shop.units"]
    here = Path() if source is None else source if source.is_dir() else source.parent
    files = [path for path in (source, shop_file(here)) if path is not None]
    found = (*set_to[-1:], *(_units_in(path) for path in files))
    return next((units for units in found if units in ("metric", "inch")), "metric")


def _units_in(path: Path) -> Any:
    """Return ``shop.units`` of a file; None if it is wrong: the command that reads it reports that."""
    if not path.is_file():  # a pipe would be waited for
        return None
    tables: Any = None
    if path.suffix == ".toml":
        try:
            tables = toml_of(text_of(path, "job file"), path.name)
        except AutobalanceError:
            return None
    elif path.suffix == ".json":
        tables = (earlier_report(path) or {}).get("job")
    shop = tables.get("shop") if isinstance(tables, Mapping) else None
    return shop.get("units") if isinstance(shop, Mapping) else None
