"""Numbers of a page, each with the place in the report that it shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from autobalance.report.page_units import shown
from autobalance.wording import at, number, signed

Report = Mapping[str, Any]


def cell(report: Report, path: str, digits: int = 2, scale: float = 1.0, tag: str = "td") -> str:
    """Return a cell that names the number of the JSON that it shows."""
    value, digits = shown(at(report, path), path, digits)
    text = number(None if value is None else scale * value, digits)
    return f'<{tag} data-path="{path}" data-digits="{digits}">{text}</{tag}>'


def span(report: Report, path: str, digits: int = 2, sign: bool = False) -> str:
    """Return a number that names its place in the JSON."""
    value, digits = shown(at(report, path), path, digits)
    text = signed(value, digits) if sign else number(value, digits)
    return f'<span data-path="{path}" data-digits="{digits}">{text}</span>'
