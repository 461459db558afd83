"""The cuts to make, as a table for people."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.correction.holes import drill_words
from autobalance.report.balance.datums import with_design_radii
from autobalance.report.balance.kinds import angle_deg, verb
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.tables import table
from autobalance.types import Values
from autobalance.wording import NO_VALUE, degrees

LESS_THAN_A_SIDE_DEG = 179.0
"""Span below which the part of a face is named."""


def remarks(report: Values) -> tuple[str, ...]:
    """Return the lines beneath the cuts: places that they weaken, then notes."""
    return (*(report.get("weak_places") or ()), *(report.get("notes") or ()))


def corrections_text(report: Values, units: DisplayUnits, zero: Zero) -> str:
    """Return a row for each cut, and remarks below; empty without cuts."""
    if not report["corrections"]:
        return ""
    notes = [f"  {in_units(remark, units)}" for remark in remarks(report)]
    angles = f"  Angles: ccw seen from +z, from {zero.name}. Radius: hole entry, else centre."
    cuts = with_design_radii(report)["corrections"]
    return "\n".join([cut_rows("Cuts to make", cuts, units, zero), angles, *notes])


def cut_rows(title: str, corrections: Sequence[Values], units: DisplayUnits, zero: Zero) -> str:
    """Return cuts as rows: tool and place, angle, depth, metal, radius and z."""
    signs = {each["removed_mass_g"] >= 0.0 for each in corrections}
    metal = "metal" if len(signs) > 1 else "metal off" if signs == {True} else "metal on"
    rows: list[Sequence[str]] = [(title, "web", "angle", "depth", metal, "radius", "z")]
    rows += [_row(each, units, zero, len(signs) > 1) for each in corrections]
    return table(rows)


def _row(correction: Values, units: DisplayUnits, zero: Zero, names_sign: bool) -> tuple[str, ...]:
    web, angle = correction["web"], angle_deg(correction)
    size = units.of_size(abs(correction["depth_mm"]))
    if old_mm := correction.get("deepened_from_mm"):
        size += f" deeper, to {units.of_size(old_mm + correction['depth_mm'])}"
    off = "off" if correction["removed_mass_g"] >= 0.0 else "on"
    radius = correction.get("entry_radius_mm")
    return (
        f"  {correction['number']:>2}. {_what(correction, units, zero)}",
        NO_VALUE if web is None else str(web),
        NO_VALUE if angle is None else degrees(zero.ccw(angle)),
        size,
        units.of_mass(abs(correction["removed_mass_g"])) + f" {off}" * names_sign,
        units.of_place(correction["radius_mm"] if radius is None else radius),
        units.of_place(correction["position_mm"][2]),
    )


def _what(correction: Values, units: DisplayUnits, zero: Zero) -> str:
    what = verb(correction)
    if correction.get("diameter_mm") is not None:
        what += f" ⌀{units.of_size(correction['diameter_mm'])}"
        drill = drill_words.called(correction)
        what += f" ({drill})" if drill and drill not in what else ""
    if correction["face"] is not None:
        what += f" {correction['face']}"
    sector = correction.get("sector_deg")
    start, end = sector if isinstance(sector, list | tuple) else (0.0, 360.0)  # may be one angle
    if 0.0 < (end - start) % 360.0 < LESS_THAN_A_SIDE_DEG:
        first = round(zero.ccw(start), 1) % 360.0
        what += f" {first:g}-{round(first + (end - start) % 360.0, 1):g}°"
    return what
