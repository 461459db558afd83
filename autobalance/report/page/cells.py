"""Numbers of a page, each with its path in the report."""

from __future__ import annotations

from markupsafe import Markup

from autobalance.report.page_units import shown
from autobalance.types import Report
from autobalance.wording import at, number, signed


def cell(report: Report, path: str, digits: int = 2) -> Markup:
    """Return a table cell with a number of the report and its path there."""
    value, digits = shown(at(report, path), path, digits)
    return Markup('<td data-path="{}" data-digits="{}">{}</td>').format(path, digits, number(value, digits))


def span(report: Report, path: str, digits: int = 2, sign: bool = False, style: str = "") -> Markup:
    """Return a number of the report with its path there."""
    value, digits = shown(at(report, path), path, digits)
    text = signed(value, digits) if sign else number(value, digits)
    named = Markup(' class="{}"').format(style) if style else ""
    return Markup('<span{} data-path="{}" data-digits="{}">{}</span>').format(named, path, digits, text)
