"""Results as HTML for a notebook: verdict, numbers, a picture, with their style."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from autobalance.report.pictures import polar
from autobalance.wording import number

if TYPE_CHECKING:  # every result loads this module
    from autobalance.report.records.balanced import BalancedReport

ROWS = 60
"""Most rows of a table of records; the others are counted."""
LINES = 28
"""Most lines of a command's text."""
CUT_COLUMNS = (
    *("number", "kind", "web", "side", "angle_deg", "radius_mm", "depth_mm", "diameter_mm"),
    *("removed_mass_g",),
)


def box(*parts: str) -> str:
    """Return parts in a box with their style, which holds in this box only."""
    return f'<div class="autobalance"><style>{_style()}</style>{"".join(parts)}</div>'


@cache
def _style() -> str:
    return files("autobalance.report").joinpath("assets/notebook.css").read_text(encoding="utf-8")


def row(*parts: str) -> str:
    """Return parts side by side if there is width."""
    return f'<div class="row">{"".join(f"<div>{part}</div>" for part in parts if part)}</div>'


def facts(values: Iterable[tuple[str, str]]) -> str:
    """Return a table of names and values, one a row."""
    rows = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in values)
    return f"<table>{rows}</table>"


def text(words: str) -> str:
    """Return the first lines of a command's text, and the number of the others."""
    lines = words.splitlines()
    rest = [f"… and {len(lines) - LINES} lines more: print(result.text())"] if len(lines) > LINES else []
    return f"<pre>{escape(chr(10).join(lines[:LINES] + rest))}</pre>"


def plot(svg: str) -> str:
    return f'<div class="plot">{svg[max(svg.find("<svg"), 0) :]}</div>'


def picture(png: bytes, caption: str) -> str:
    """Return a picture; ``caption`` describes it in words."""
    return f'<img alt="{escape(caption)}" src="data:image/png;base64,{b64encode(png).decode()}">'


def records(rows: Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> str:
    """Return records as a table of the keys that hold plain values in any of them."""
    if columns is None:
        columns = list(dict.fromkeys(key for each in rows for key, value in each.items() if _is_plain(value)))
    else:
        columns = [key for key in columns if any(each.get(key) is not None for each in rows)]
    if not rows:
        return '<p class="soft">none</p>'
    head = "".join(f"<th>{escape(key)}</th>" for key in columns)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(_text(each.get(key)))}</td>' for key in columns)}</tr>"
        for each in rows[:ROWS]
    )
    rest = f'<p class="soft">and {len(rows) - ROWS} more</p>' if len(rows) > ROWS else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{rest}"


def _is_plain(value: Any) -> bool:
    return value is None or isinstance(value, str | int | float)


def _text(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def balance(report: BalancedReport) -> str:
    """Return a run's verdict, residual unbalance and cuts."""
    cuts = report.corrections
    removed_g = sum(each.removed_mass_g for each in cuts)
    title = f"{len(cuts)} cut{'s' * (len(cuts) != 1)}, {number(removed_g)} g removed"
    style = report.verdict_class
    return box(
        f'<h3 class="{style}">{report.outcome_words}</h3><p>{escape(report.verdict)}</p>',
        f"<p>{escape(report.reason)}</p>" if report.reason else "",
        row(*polar.figures(report)),
        f"<h4>{title}</h4>{records([each.item for each in cuts], CUT_COLUMNS)}" if cuts else "",
    )
