"""Datums from which a report's angles and places are measured."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.types import Values

MOVED_MM = 0.05
"""Distance from a cut face within which a face counts as the same one."""


def angle_datum(report: Values) -> Values | None:
    """Return the datum of a report's angles besides crankpin 1; None without one."""
    angle: Values | None = _datums(report).get("angle")
    return angle


def z_datum_face(report: Values) -> Values | None:
    """Return the best datum face for a report's z that no cut moves; None without one."""
    cuts = [*report["corrections"], *report.get("earlier_corrections", ())]
    moved = [height for cut in cuts if (height := cut.get("face_height_mm")) is not None]
    faces: Sequence[Values] = _datums(report).get("faces", [])
    for face in faces:
        if all(abs(abs(height) - abs(face["z_mm"])) > MOVED_MM for height in moved):
            return face
    return None


def _datums(report: Values) -> Values:
    return report["crank"].get("datums") or {}
