"""What sheets, cards and pages say of an engine's sense of turning and its external balance."""

from __future__ import annotations

from autobalance.types import Report
from autobalance.wording import at

EXTERNAL = {
    "solve": "They carry the unbalance that is missing: weld or bolt it on at the angle, or drill opposite.",
    "detroit": "They carry this now, and the crank is cut to suit them.",
    "neutral": "They carry nothing: balance each alone.",
}


def turning_words(report: Report) -> str:
    """Return, with a space before it, that an engine turns clockwise; nothing of those that do not."""
    clockwise = at(report, "job.engine.turns") == "cw"
    return " In the engine the crank turns clockwise, seen from +z." if clockwise else ""


def external_words(report: Report) -> str:
    """Return how the parts of an external balance count."""
    words = EXTERNAL[str(at(report, "job.balance.external"))]
    return f"{words} Spin the crank with them on, or say attached_fitted = false in the reading."
