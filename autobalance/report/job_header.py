"""Job, shop and engine of a report in words, as the head of every page has them."""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any, NamedTuple

from autobalance.report.records.balanced import BalancedReport
from autobalance.report.records.job import JobPart

# Job and shop of a report, as the head of every page has them.


NAMED = ("customer", "engine", "serial", "operator", "note")
"""Keys of ``[job]``, in the order in which pages have them."""
NOT_IN_NAMES = re.compile(r"[^\w.+-]+")
"""Characters that no name of a file should have on any system."""
MAGIC = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}
"""First bytes of the pictures that a page can hold → their media type."""


class Logo(NamedTuple):
    """A picture with its media type."""

    data: bytes
    media_type: str


def work(report: BalancedReport) -> dict[str, str]:
    """Return the entries of ``[job]`` that exist, by key; the serial of a reading takes precedence."""
    own = report.given.job
    entries = {name: getattr(own, name) for name in NAMED} | {"serial": report.serial or own.serial}
    return {name: text for name, text in entries.items() if text}


def file_prefix(own: JobPart, serial: str | None = None) -> str:
    """Return the beginning of the names of papers, ``V8-001-``; nothing unless the job names the part.

    ``serial`` is that of a reading.
    """
    if not own.part:
        return ""
    words = (own.part, serial or own.serial or "")
    return "".join(
        f"{word}-" for word in (NOT_IN_NAMES.sub("_", each).strip("_. ") for each in words) if word
    )


def work_words(report: BalancedReport) -> str:
    """Return the entries of ``[job]`` on one line: ``customer A. Owner · serial C-17``."""
    return " · ".join(f"{name} {value}" for name, value in work(report).items())


def shop_name(report: BalancedReport) -> str:
    """Return the shop's name; empty without one."""
    return report.given.shop.name or ""


def stage_words(report: BalancedReport) -> str:
    """Return the stage of a crank that was cut again; empty for any other."""
    return f"stage {report.stages[-1].stage}" if report.stages else ""


def logo(report: BalancedReport) -> Logo | None:
    """Return the shop's picture; None without one, or where its file is no longer a PNG or JPEG."""
    path = report.given.shop.logo
    return None if not path else picture_of(Path(path))


def picture_of(path: Path) -> Logo | None:
    """Return the picture of a file; None where it is not a PNG or JPEG."""
    if not path.is_file():
        return None
    data = path.read_bytes()
    return next((Logo(data, kind) for magic, kind in MAGIC.items() if data.startswith(magic)), None)


def page_header(report: BalancedReport) -> dict[str, Any]:
    """Return shop and job for the head of a page in HTML (``parts.header``)."""
    picture = logo(report)
    if picture is not None:
        encoded = {"media_type": picture.media_type, "base64": base64.b64encode(picture.data).decode()}
    return {
        "logo": None if picture is None else encoded,
        "shop": shop_name(report),
        "work": work(report),
    }


# An engine's sense of turning and its external balance in words, for sheets, cards and pages.


EXTERNAL_TEXTS = {
    "solve": "They carry the unbalance that is missing: weld or bolt it on at the angle, or drill opposite.",
    "detroit": "They carry this now, and the crank is cut to suit them.",
    "neutral": "They carry nothing: balance each alone.",
}


def turning_words(report: BalancedReport) -> str:
    """Return a sentence, after a space, for an engine that turns clockwise; empty for any other."""
    clockwise = report.given.engine.turns == "cw"
    return " In the engine the crank turns clockwise, seen from +z." if clockwise else ""


def external_words(report: BalancedReport) -> str:
    """Return the words on the parts of an external balance."""
    words = EXTERNAL_TEXTS[str(report.given.balance.external)]
    return f"{words} Spin the crank with them on, or say attached_fitted = false in the reading."
