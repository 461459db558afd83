"""Datums from which a report's angles and places are measured."""

from __future__ import annotations

import math

from autobalance.crank.datums import DatumAngle, DatumFace, Datums
from autobalance.declare import changed, present
from autobalance.report.records.balanced import BalancedReport, Cut

MOVED_MM = 0.05
"""Distance from a cut face within which a face counts as the same one."""


ROUNDING_MM = 0.01
"""Difference of an entry from the rim beyond the facets, by the rim's own fit."""


FACETS_DIFFER = 1.5
"""Chord height of one facet of a rim, up to so many times that of the report."""


def with_design_radii(report: BalancedReport) -> BalancedReport:
    """Return a report for people: the entries of holes in a rim lie on the rim's own circle.

    The model drills into a facet, up to its chord height below the circle; entries of one rim would differ by
    that. A hole counts as one in the rim where it differs by no more.
    """
    facets = report.crank.facet_error
    sag_mm = 0.0 if facets is None else facets.sag_mm
    outlines = {web.number: present(web.outline) for web in report.crank.webs}
    rims = {number: shape.rim_radius_mm for number, shape in outlines.items() if shape is not None}
    items = [_on_rim(item, rims.get(item.web or 0), sag_mm) for item in report.corrections]
    return changed(report, corrections=items)


def _on_rim(item: Cut, rim_mm: float | None, sag_mm: float) -> Cut:
    entry = None if item.hole is None else item.hole.entry_radius_mm
    if not rim_mm or item.hole is None or entry is None or item.direction != "radial":
        return item
    if not -ROUNDING_MM <= rim_mm - entry <= FACETS_DIFFER * sag_mm + ROUNDING_MM:
        return item
    x, y, z = item.position_mm
    scale = rim_mm / math.hypot(x, y)
    hole = changed(item.hole, entry_radius_mm=rim_mm)
    return changed(item, hole=hole, position_mm=[scale * x, scale * y, z])


def angle_datum(report: BalancedReport) -> DatumAngle | None:
    """Return the datum of a report's angles besides crankpin 1; None without one."""
    return datums_of(report).angle


def z_datum_face(report: BalancedReport) -> DatumFace | None:
    """Return the best datum face for a report's z that no cut moves; None without one."""
    cuts = [*report.corrections, *report.earlier_corrections]
    moved = [cut.new_face.face_height_mm for cut in cuts if cut.new_face is not None]
    for face in datums_of(report).faces:
        if all(abs(abs(height) - abs(face.z_mm)) > MOVED_MM for height in moved):
            return face
    return None


def datums_of(report: BalancedReport) -> Datums:
    """Return the features of a crank that can be touched; none where they were not looked for."""
    return report.crank.datums or Datums()
