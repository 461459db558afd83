"""The style sheet that the pages in HTML share."""

from __future__ import annotations

from functools import cache
from importlib import resources


@cache
def page_style() -> str:
    """Return the style sheet of the report's page."""
    return (resources.files("autobalance.report") / "assets" / "page.css").read_text(encoding="utf-8")
