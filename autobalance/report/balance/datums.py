"""What a report's angles and places are measured from."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.types import Values

MOVED_MM = 0.05
"""A face this near to one that is cut is that face."""


def told_angle(report: Values) -> Values | None:
    """Return what a report's angles can be measured from besides crankpin 1."""
    angle: Values | None = _datums(report).get("angle")
    return angle


def told_face(report: Values) -> Values | None:
    """Return the face from which a report's z can be measured: the best one that no cut moves."""
    cuts = [*report["corrections"], *report.get("earlier_corrections", ())]
    moved = [height for cut in cuts if (height := cut.get("face_height_mm")) is not None]
    faces: Sequence[Values] = _datums(report).get("faces", [])
    for face in faces:
        if all(abs(abs(height) - abs(face["z_mm"])) > MOVED_MM for height in moved):
            return face
    return None


def _datums(report: Values) -> Values:
    return report["crank"].get("datums") or {}
