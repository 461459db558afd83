"""The section table of a job's crank as lines to read."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.declare import Floats
from autobalance.report.display_units import ON_SCREEN, DisplayUnits, fixed
from autobalance.report.records.sections import SectionTable, SectionTableRow, SectionTableSums
from autobalance.report.tables import table


def section_table_text(found: SectionTable, u: DisplayUnits = ON_SCREEN["metric"]) -> str:
    """Return the table with its sums and the verdict; Z and the couples count from the datum."""
    datum = found.datum_mm
    fine = u.is_metric
    of_mass, of_place, of_product, of_couple = (
        (u.g_per_mass, 2 if fine else 3),
        (u.mm_per_length, u.length_digits),
        (u.g_mm_per_unbalance, 1 if fine else 3),
        (u.g_mm_per_unbalance * u.mm_per_length, 0 if fine else 2),
    )
    rows: list[Sequence[str]] = [section_heads(u)]

    def add(name: str, row: SectionTableRow | SectionTableSums, place: Sequence[str]) -> None:
        products = [*_digits(row.unbalance_g_mm, *of_product), *_digits(row.moment_g_mm2, *of_couple)]
        rows.append((f"  {name}", *_digits([row.mass_g], *of_mass), *place, *products))

    for row in found.rows:
        place = ["-"] * 3
        if row.centre_mm is not None:
            x, y, z = row.centre_mm
            place = _digits([x, y, z - datum], *of_place)
        add(_name(row), row, place)
    add("sum", found.sums, [""] * 3)
    head = f"Datum: z = {u.of_length(datum)} from the middle of crankpin 1"
    return "\n".join([head, table(rows), *_verdict(found, u), *_balancing_counterweights(found, u)])


def section_heads(u: DisplayUnits) -> tuple[str, ...]:
    couple = "g·mm²" if u.is_metric else "oz·in²"
    places = (f"{axis} [{u.length}]" for axis in "XYZ")
    return ("Section", f"W [{u.mass}]", *places, f"WX [{u.unbalance}]", "WY", f"CX [{couple}]", "CY")


def _name(row: SectionTableRow) -> str:
    number = "" if row.number is None else f" {row.number}"
    return f"{row.kind}{number}" + ("" if row.name is None else f" ({row.name})")


def _digits(numbers: Floats, per: float, digits: int) -> list[str]:
    return [fixed(number / per, digits) for number in numbers]


def _verdict(found: SectionTable, u: DisplayUnits) -> list[str]:
    if found.within is None or found.permissible_g_mm is None:
        return ["No verdict: it needs a job with grade and speed"]
    word = "WITHIN TOLERANCE" if found.within else "NOT WITHIN TOLERANCE"
    lines = [
        f"{word} (judged: {found.judge})",
        f"  resultant {u.of_unbalance(found.sums.magnitude_g_mm)}, "
        f"permitted {u.of_unbalance(found.permissible_g_mm)}",
    ]
    return lines + [
        f"  plane {plane.name} at z {u.of_length(plane.z_mm)}: "
        f"{u.of_unbalance(plane.magnitude_g_mm)}, permitted {u.of_unbalance(plane.permissible_g_mm)}"
        for plane in found.planes
    ]


def _balancing_counterweights(found: SectionTable, u: DisplayUnits) -> list[str]:
    per = (u.g_mm_per_unbalance, 0 if u.is_metric else 3)
    return [
        f"  no force and no couple with the counterweight of web {each.web} at"
        f" ({', '.join(_digits(each.product_g_mm, *per))}) {u.unbalance}, a change of"
        f" ({', '.join(_digits(each.change_g_mm, *per))})"
        for each in found.counterweights_wanted
    ]
