"""The section table of a job's crank as lines to read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.report.tables import table

HEADS = ("Section", "W [g]", "X [mm]", "Y [mm]", "Z [mm]", "WX [g·mm]", "WY", "CX [g·mm²]", "CY")


def section_table_text(values: Mapping[str, Any]) -> str:
    """Return the table with its sums and the verdict; Z and the couples count from the datum."""
    datum = values["datum_mm"]
    rows: list[Sequence[str]] = [HEADS]
    for row in values["rows"]:
        centre = row["centre_mm"]
        place = ["-"] * 3 if centre is None else _digits([centre[0], centre[1], centre[2] - datum], 3)
        products = [*_digits(row["unbalance_g_mm"], 1), *_digits(row["moment_g_mm2"], 0)]
        rows.append((f"  {_name(row)}", f"{row['mass_g']:.2f}", *place, *products))
    sums = values["sums"]
    products = [*_digits(sums["unbalance_g_mm"], 1), *_digits(sums["moment_g_mm2"], 0)]
    rows.append(("  sum", f"{sums['mass_g']:.2f}", "", "", "", *products))
    head = f"Datum: z = {datum:.3f} mm from the middle of crankpin 1"
    return "\n".join([head, table(rows), *_verdict(values), *_wanted(values)])


def _name(row: Mapping[str, Any]) -> str:
    number = "" if row["number"] is None else f" {row['number']}"
    return f"{row['kind']}{number}" + ("" if row["name"] is None else f" ({row['name']})")


def _digits(numbers: Sequence[float], digits: int) -> list[str]:
    return [f"{round(number, digits) + 0.0:.{digits}f}" for number in numbers]


def _verdict(values: Mapping[str, Any]) -> list[str]:
    if values["within"] is None:
        return ["No verdict: the job says no grade and speed, or there is no job"]
    word = "WITHIN TOLERANCE" if values["within"] else "NOT WITHIN TOLERANCE"
    sums = values["sums"]
    lines = [
        f"{word} (judged: {values['judge']})",
        f"  resultant {sums['magnitude_g_mm']:.2f} g·mm, permitted {values['permissible_g_mm']:.2f}",
    ]
    return lines + [
        f"  plane {plane['name']} at z {plane['z_mm']:.2f} mm: {plane['magnitude_g_mm']:.2f} g·mm,"
        f" permitted {plane['permissible_g_mm']:.2f}"
        for plane in values["planes"]
    ]


def _wanted(values: Mapping[str, Any]) -> list[str]:
    return [
        f"  no force and no couple with the counterweight of web {each['web']} at"
        f" ({', '.join(_digits(each['product_g_mm'], 0))}) g·mm, a change of"
        f" ({', '.join(_digits(each['change_g_mm'], 0))})"
        for each in values["counterweights_wanted"]
    ]
