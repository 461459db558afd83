"""The zero and datums of a report's angles and places, and the cuts to make as a table for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

from autobalance.correction.holes import drills
from autobalance.crank.datums import DatumAngle, DatumFace, Datums
from autobalance.declare import changed, present
from autobalance.report.balance import kinds
from autobalance.report.balance.kinds import angle_deg
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.report.tables import table
from autobalance.value_classes import dataclass
from autobalance.wording import NO_VALUE, degrees

# The zero of a sheet's angles: the keyway if there is one, else crankpin 1.


ZeroChoice = Literal["keyway", "crankpin"]
CRANKPIN, KEYWAY, HOLE = "crankpin 1", "keyway K", "hole H"
SIGNS = {CRANKPIN: "P1", KEYWAY: "K", HOLE: "H"}
"""Text of a zero beside an angle."""


@dataclass(frozen=True)
class Zero:
    """The zero of a sheet, and the other possible one.

    ``angle_deg`` is the angle of the zero, counter-clockwise from crankpin 1, ``other_deg`` that of the other
    one, None without one.
    """

    name: str
    angle_deg: float
    other: str | None = None
    other_deg: float | None = None

    @classmethod
    def of(cls, report: BalancedReport, choice: ZeroChoice = "keyway") -> Zero:
        """Return the chosen zero; crankpin 1 if there is no keyway."""
        datum = angle_datum(report)
        if datum is None:
            return cls(CRANKPIN, 0.0)
        if datum.of == "keyway" and choice == "keyway":
            return cls(KEYWAY, datum.angle_deg, CRANKPIN, 0.0)
        return cls(CRANKPIN, 0.0, KEYWAY if datum.of == "keyway" else HOLE, datum.angle_deg)

    @property
    def sign(self) -> str:
        """Return its text beside an angle."""
        return SIGNS[self.name]

    def ccw(self, angle_deg: float) -> float:
        """Return an angle from crankpin 1, counter-clockwise from this zero, in [0, 360)."""
        return (angle_deg - self.angle_deg) % 360.0

    def counted(self, item: Cut) -> Cut:
        """Return a correction with its angles counted from this zero."""
        shifted: dict[str, Any] = {}
        if (angle := angle_deg(item)) is not None:
            shifted["angle_deg"] = self.ccw(angle)
        if (ends := item.pocket) is not None:
            start, end = self.ccw(ends.start_deg), self.ccw(ends.end_deg)
            shifted["pocket"] = changed(ends, start_deg=start, end_deg=end)
        if item.sector is not None:
            low, high = item.sector
            shifted["sector_deg"] = [self.ccw(low), self.ccw(low) + (high - low)]
        return changed(item, **shifted)

    def words(self, angle_deg: float) -> str:
        """Return an angle from crankpin 1 in both senses from this zero: ``198.3° (161.7°)``."""
        return f"{degrees(angle_deg - self.angle_deg)} ({degrees(self.angle_deg - angle_deg)})"


FROM_CRANKPIN = Zero(CRANKPIN, 0.0)


# Datums from which a report's angles and places are measured.


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


# The cuts to make, as a table for people.


LESS_THAN_A_SIDE_DEG = 179.0
"""Span below which the part of a face is named."""


def remarks(report: BalancedReport) -> tuple[str, ...]:
    """Return the lines beneath the cuts: places that they weaken, then notes."""
    return (*report.weak_places, *report.notes)


def corrections_text(report: BalancedReport, units: DisplayUnits, zero: Zero) -> str:
    """Return a row for each cut, and remarks below; empty without cuts."""
    if not report.corrections:
        return ""
    notes = [f"  {in_units(remark, units)}" for remark in remarks(report)]
    angles = f"  Angles: ccw seen from +z, from {zero.name}. Radius: hole entry, else centre."
    cuts, pads = kinds.apart(with_design_radii(report).corrections)
    tables = [cut_rows("Cuts to make", cuts, units, zero)] if cuts else []
    tables += [cut_rows("Metal to add", pads, units, zero)] if pads else []
    return "\n".join([*tables, angles, *notes])


def cut_rows(title: str, corrections: Sequence[Cut], units: DisplayUnits, zero: Zero) -> str:
    """Return cuts, or pads, as rows: tool and place, angle, depth or height, metal, radius and z."""
    signs = {each.removed_mass_g >= 0.0 for each in corrections}
    metal = "metal" if len(signs) > 1 else "metal off" if signs == {True} else "metal on"
    rows: list[Sequence[str]] = [(title, "web", "angle", corrections[0].of_kind.extent, metal, "radius", "z")]
    rows += [_row(each, units, zero, len(signs) > 1) for each in corrections]
    return table(rows)


def _row(correction: Cut, units: DisplayUnits, zero: Zero, names_sign: bool) -> tuple[str, ...]:
    web, angle = correction.web, angle_deg(correction)
    size = units.of_size(abs(correction.depth_mm))
    if correction.hole is not None and (old_mm := correction.hole.deepened_from_mm):
        size += f" deeper, to {units.of_size(old_mm + correction.depth_mm)}"
    off = "off" if correction.removed_mass_g >= 0.0 else "on"
    return (
        f"  {correction.number:>2}. {_what(correction, units, zero)}",
        NO_VALUE if web is None else str(web),
        NO_VALUE if angle is None else degrees(zero.ccw(angle)),
        size,
        units.of_mass(abs(correction.removed_mass_g)) + f" {off}" * names_sign,
        units.of_place(correction.shown_radius_mm),
        units.of_place(correction.position_mm[2]),
    )


def _what(correction: Cut, units: DisplayUnits, zero: Zero) -> str:
    what = correction.of_kind.verb
    if correction.diameter_mm is not None:
        what += f" ⌀{units.of_size(correction.diameter_mm)}"
        drill = drills.called(correction.item)
        what += f" ({drill})" if drill and drill not in what else ""
    if correction.face is not None:
        what += f" {correction.face}"
    start, end = correction.sector or (0.0, 360.0)
    if 0.0 < (end - start) % 360.0 < LESS_THAN_A_SIDE_DEG:
        first = round(zero.ccw(start), 1) % 360.0
        what += f" {first:g}-{round(first + (end - start) % 360.0, 1):g}°"
    return what
