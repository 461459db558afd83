"""Keyways, flanges and faces as a report tells them, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, cast

from autobalance.crank.datums import Datums

if TYPE_CHECKING:
    from autobalance.report.records import crank as crank_records

MOVED_MM = 0.05
"""A face this near to one that is cut is that face."""


def datum_values(datums: Datums) -> crank_records.Datums:
    """Return what can be touched to set the crank up."""
    angle = datums.angle
    return {
        "keyways": [cast("crank_records.Keyway", asdict(key)) for key in datums.keyways],
        "flanges": [
            cast("crank_records.Flange", {**asdict(flange), "holes": [asdict(hole) for hole in flange.holes]})
            for flange in datums.flanges
        ],
        "angle": None if angle is None else {"of": angle[0], "angle_deg": angle[1]},
        "faces": [cast("crank_records.DatumFace", asdict(face)) for face in datums.faces],
    }


def told_angle(report: Mapping[str, Any]) -> crank_records.DatumAngle | None:
    """Return what a report's angles can be told from besides crankpin 1."""
    angle: crank_records.DatumAngle | None = _datums(report).get("angle")
    return angle


def told_face(report: Mapping[str, Any]) -> crank_records.DatumFace | None:
    """Return the face from which a report's z can be told: the best one that no cut moves."""
    cuts = [*report["corrections"], *report.get("earlier_corrections", ())]
    moved = [height for cut in cuts if (height := cut.get("face_height_mm")) is not None]
    faces: list[crank_records.DatumFace] = _datums(report).get("faces", [])
    for face in faces:
        if all(abs(abs(height) - abs(face["z_mm"])) > MOVED_MM for height in moved):
            return face
    return None


def _datums(report: Mapping[str, Any]) -> Mapping[str, Any]:
    return report["crank"].get("datums") or {}
