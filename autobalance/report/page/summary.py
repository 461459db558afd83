"""Page of a command without a separate page: its printed text, with its table and plots."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from autobalance.report.page.templates import rendered


def summary_page(title: str, text: str, is_good: bool, table: str = "", plots: Sequence[str] = ()) -> bytes:
    """Return a page in HTML.

    Parameters
    ----------
    title : str
        Title of the browser's window.
    text : str
        What the command prints: its first three lines, up to the first empty one, head the page.
    is_good : bool
        Show the verdict in the colour of a good one.
    table : str
        Table in HTML above the text.
    plots : sequence of str
        Plots as SVG.
    """
    head, _, rest = text.partition("\n\n")
    first, *lines = head.split("\n")
    drawn = [Markup(svg[max(svg.find("<svg"), 0) :]) for svg in plots]
    page = rendered(
        "summary.html",
        title=title,
        headline=first,
        lines=lines,
        is_good=is_good,
        table=Markup(table),
        plots=drawn,
        text=rest,
    )
    return page.encode()
