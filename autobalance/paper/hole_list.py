"""``holes.csv``: the cuts as rows for a digital read-out or a spreadsheet."""

from __future__ import annotations

import csv
import io

from autobalance.paper.cuts import side_of
from autobalance.paper.setup import set_up_letter
from autobalance.report.balance import kinds
from autobalance.report.balance.datums import angle_datum, with_design_radii
from autobalance.report.display_units import ON_PAPER, UnitSystem
from autobalance.types import Report
from autobalance.units import wrapped_deg

ANGLE_DIGITS, LENGTH_DIGITS, MASS_DIGITS = 4, 5, 4


def hole_list(report: Report, units: UnitSystem = "metric") -> bytes:
    """Return a row for each cut; angles count from crankpin 1, and from a keyway in separate columns.

    Lengths and masses are in the units that the names of their columns end with.
    """
    u, report = ON_PAPER[units], with_design_radii(report)
    mm, g = ("mm", "g") if u.is_metric else ("in", "oz")
    datum = angle_datum(report)
    key = datum["angle_deg"] if datum is not None and datum["of"] == "keyway" else None
    of_key = [] if key is None else ["keyway_ccw_deg", "keyway_cw_deg"]
    heads = ["number", "setup", "kind", "web", "side", "angle_ccw_deg", "angle_cw_deg", *of_key]
    heads += [f"{name}_{mm}" for name in ("radius", "x", "y", "z", "diameter", "depth", "point")]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([*heads, f"depth_with_point_{mm}", f"mass_{g}"])
    for item in report["corrections"]:
        ccw, point = kinds.angle_deg(item), item.get("point_mm")
        angles = [ccw, None if ccw is None else -ccw]
        if key is not None:
            angles += [None, None] if ccw is None else [ccw - key, key - ccw]
        depth = abs(float(item["depth_mm"]))
        lengths = [item.get("entry_radius_mm", item["radius_mm"]), *item["position_mm"]]
        lengths += [item.get("diameter_mm"), depth, point, depth + float(point or 0.0)]
        webs = item.get("webs") or ([] if item.get("web") is None else [item["web"]])
        writer.writerow(
            [
                item["number"],
                set_up_letter(item),
                item["kind"],
                " ".join(map(str, webs)),
                side_of(item),
                *map(_angle, angles),
                *(_number(each, u.mm_per_length, LENGTH_DIGITS) for each in lengths),
                _number(item["removed_mass_g"], u.g_per_mass, MASS_DIGITS),
            ]
        )
    return stream.getvalue().encode()


def _angle(value_deg: float | None) -> str:
    return _number(None if value_deg is None else wrapped_deg(value_deg), 1.0, ANGLE_DIGITS)


def _number(value: float | None, per: float, digits: int) -> str:
    return "" if value is None else f"{round(value / per, digits) + 0.0:.{digits}f}"
