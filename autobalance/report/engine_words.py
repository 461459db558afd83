"""An engine's sense of turning and its external balance in words, for sheets, cards and pages."""

from __future__ import annotations

from autobalance.types import Report
from autobalance.wording import at

EXTERNAL_TEXTS = {
    "solve": "They carry the unbalance that is missing: weld or bolt it on at the angle, or drill opposite.",
    "detroit": "They carry this now, and the crank is cut to suit them.",
    "neutral": "They carry nothing: balance each alone.",
}


def turning_words(report: Report) -> str:
    """Return a sentence, after a space, for an engine that turns clockwise; empty for any other."""
    clockwise = at(report, "job.engine.turns") == "cw"
    return " In the engine the crank turns clockwise, seen from +z." if clockwise else ""


def external_words(report: Report) -> str:
    """Return the words on the parts of an external balance."""
    words = EXTERNAL_TEXTS[str(at(report, "job.balance.external"))]
    return f"{words} Spin the crank with them on, or say attached_fitted = false in the reading."
