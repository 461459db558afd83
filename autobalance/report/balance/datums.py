"""Datums from which a report's angles and places are measured."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalance.types import Values
from autobalance.wording import at

MOVED_MM = 0.05
"""Distance from a cut face within which a face counts as the same one."""


ROUNDING_MM = 0.01
"""Difference of an entry from the rim beyond the facets, by the rim's own fit."""


FACETS_DIFFER = 1.5
"""Chord height of one facet of a rim, up to so many times that of the report."""


def with_design_radii(report: Values) -> Values:
    """Return a report for people: the entries of holes in a rim lie on the rim's own circle.

    The model drills into a facet, up to its chord height below the circle; entries of one rim would differ by
    that. A hole counts as one in the rim where it differs by no more.
    """
    sag_mm = float(at(report, "crank.facet_error.sag_mm") or 0.0)
    rims = {web["number"]: at(web, "outline.rim_radius_mm") for web in report["crank"]["webs"]}
    items = [_on_rim(item, rims.get(item.get("web")), sag_mm) for item in report["corrections"]]
    return {**report, "corrections": items}


def _on_rim(item: Values, rim_mm: float | None, sag_mm: float) -> Values:
    entry = item.get("entry_radius_mm")
    if not rim_mm or entry is None or item.get("direction") != "radial":
        return item
    if not -ROUNDING_MM <= rim_mm - entry <= FACETS_DIFFER * sag_mm + ROUNDING_MM:
        return item
    x, y, z = item["position_mm"]
    scale = rim_mm / math.hypot(x, y)
    return {**item, "entry_radius_mm": rim_mm, "position_mm": [scale * x, scale * y, z]}


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
