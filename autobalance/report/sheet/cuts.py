"""The tables of cuts: one line each, what makes it, its tolerances, its slug."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from reportlab.platypus import Flowable

from autobalance.report.balance import kinds
from autobalance.report.display_units import DisplayUnits
from autobalance.report.sheet.tables import Column, table
from autobalance.report.sheet.tolerances import CARE, SHARE, Tolerances, press_fit, retention
from autobalance.wording import degrees

if TYPE_CHECKING:
    from autobalance.report.records.crank import DatumAngle

Item = Mapping[str, Any]
NONE = "–"
AXIAL = 0.7
"""Least z of a feed's direction that is called axial."""


def cut_table(items: Sequence[Item], u: DisplayUnits, wide_mm: float) -> Flowable:
    """List every cut with its angles in both senses and its depths with and without the point."""
    columns = [
        Column("No", 8.5),
        Column("cut", 20.0, "left"),
        Column("how", 20.0, "left"),
        Column("where", 12.0, "left"),
        Column("angle\nccw", 12.5),
        Column("angle\ncw", 12.5),
        Column(f"radius\n{u.length}", 14.5),
        Column(f"z\n{u.length}", 15.0),
        Column(f"diameter\n{u.length}", 13.5),
        Column(f"depth\n{u.length}", 14.5),
        Column("with point\n" + u.length, 14.5),
        Column(f"mass\n{u.mass}", 14.5),
    ]
    return table(wide_mm, columns, [cut_row(item, u) for item in items])


def cut_row(item: Item, u: DisplayUnits) -> list[str]:
    """Return what the table tells of a cut: number, kind, place, angles, radius, z, sizes, mass."""
    ccw = kinds.angle_deg(item)
    point = item.get("point_mm")
    depth, mass = float(item["depth_mm"]), item["removed_mass_g"]
    if kinds.adds_metal(item):
        depth, mass = abs(depth), abs(mass)
    return [
        str(item["number"]),
        kinds.noun(item),
        how(item),
        webs_of(item),
        NONE if ccw is None else degrees(ccw),
        NONE if ccw is None else degrees(-ccw),
        u.mm(item.get("entry_radius_mm", item["radius_mm"])),
        u.mm(item["position_mm"][2]),
        u.mm(item.get("diameter_mm"), u.diameter_digits),
        u.mm(depth),
        u.mm(depth + float(point)) if point else NONE,
        u.g(mass),
    ]


def how(item: Item) -> str:
    """Return the kind's name and from where the tool comes: ``drill from +z``."""
    if kinds.adds_metal(item):
        return f"{item['kind']}: {kinds.verb(item)}"
    word, side = str(item["kind"]), side_of(item)
    return f"{word} {side}" if side else word


def side_of(item: Item) -> str:
    """Return from which side the tool enters; nothing where a face or a rim is cut all over."""
    inward = item.get("inward")
    if inward is not None:
        if abs(inward[2]) < AXIAL:
            return "from the rim"
        return "from -z" if inward[2] > 0.0 else "from +z"
    if item.get("face_z_mm") is not None:
        return "from -z" if item["position_mm"][2] > item["face_z_mm"] else "from +z"
    normal = item.get("normal")
    if normal is not None and abs(normal[2]) > AXIAL:
        return "from +z" if normal[2] > 0.0 else "from -z"
    return ""


def webs_of(item: Item) -> str:
    """Return the webs: ``web 2``, ``web 1, 2``, of many in a row ``web 1-8``."""
    webs = [web for web in item.get("webs") or [item.get("web")] if web is not None]
    if len(webs) > 3 and webs == list(range(webs[0], webs[-1] + 1)):
        return f"web {webs[0]}-{webs[-1]}"
    return f"web {', '.join(map(str, webs))}" if webs else NONE


def making_table(
    items: Sequence[Item], u: DisplayUnits, wide_mm: float, face_z_mm: float, datum: DatumAngle | None = None
) -> Flowable:
    """List how each cut of a web is made, its place in coordinates, from what can be touched.

    ``datum`` is what angles are told from besides crankpin 1, where there is such a thing.
    """
    name = None if datum is None else {"keyway": "keyway K", "flange_hole": "hole H"}[datum["of"]]
    columns = [
        Column("cut", 11.0, "left"),
        Column("what to do", 88.0 if datum is None else 62.0, "left"),
        *([] if name is None else [Column(f"ccw from\n{name}", 13.0), Column(f"cw from\n{name}", 13.0)]),
        Column(f"x\n{u.length}", 15.0),
        Column(f"y\n{u.length}", 15.0),
        Column(f"z from\nface F {u.length}", 16.0),
        Column(f"wall left\n{u.length}", 14.0),
        Column(f"depth left\n{u.length}", 14.0),
    ]
    rows = [
        [
            f"cut {item['number']}",
            _instruction(item, u),
            *([] if datum is None else _from_datum(item, datum["angle_deg"])),
            u.mm(item["position_mm"][0]),
            u.mm(item["position_mm"][1]),
            u.mm(item["position_mm"][2] - face_z_mm),
            u.mm(item.get("wall_left_mm")),
            u.mm(item.get("depth_left_mm")),
        ]
        for item in items
    ]
    return table(wide_mm, columns, rows)


def _from_datum(item: Item, datum_deg: float) -> list[str]:
    """Return a cut's angle from a keyway or hole, in both senses."""
    ccw = kinds.angle_deg(item)
    return [NONE, NONE] if ccw is None else [degrees(ccw - datum_deg), degrees(datum_deg - ccw)]


def _instruction(item: Item, u: DisplayUnits) -> str:
    told = kinds.instruction(item, u)
    if item.get("deepened_from_mm"):
        told += f"; the hole is there, {u.mm(item['deepened_from_mm'])} deep"
    if item.get("new_radius_mm") is not None:
        told += f"; from radius {u.mm(item['rim_radius_mm'])} to {u.mm(item['new_radius_mm'])}"
    if item.get("face_height_mm") is not None and kinds.adds_metal(item):
        told += f"; height {u.mm(item['face_height_mm'])} to {u.mm(item['new_height_mm'])}"
    return told


def tolerance_table(found: Tolerances, items: Sequence[Item], u: DisplayUnits, wide_mm: float) -> Flowable:
    """List the tolerances of each kind's cuts."""
    columns = [
        Column("each", 22.0, "left"),
        Column("cuts", 72.0, "left"),
        Column("angle", 18.0),
        Column(f"position {u.length}", 20.0),
        Column(f"depth {u.length}", 20.0),
        Column(f"diameter {u.length}", 20.0),
    ]
    rows = []
    for kind, values in found.by_kind.items():
        own = [item for item in items if item["kind"] == kind]
        rows.append(
            [
                kinds.noun(own[0]),
                _numbers([int(item["number"]) for item in own]),
                _plus_minus(values.get("angle_deg"), 3, "°"),
                *(
                    _plus_minus(
                        None if values.get(key) is None else values[key] / u.mm_per_length, u.length_digits
                    )
                    for key in ("position_mm", "depth_mm", "diameter_mm")
                ),
            ]
        )
    return table(wide_mm, columns, rows)


def tolerance_words(found: Tolerances) -> list[str]:
    """Return what the tolerances are worth: what they use together, and what to do where they are close."""
    told = [
        f"± of each cut of a kind: usual workshop accuracy times {found.factor:.2g}, from what each error "
        f"does to the unbalance. All errors of all cuts at their limits at once, the worst way round, use "
        f"{100.0 * found.worst:.0f} % of what the verdict leaves (at most {100.0 * SHARE:.0f} % is given "
        f"away); independent errors, as the root of the sum of squares, {100.0 * found.independent:.0f} %. "
        "Position: how far the axis may lie from its place, square to it; of a pocket, its outline."
    ]
    if found.factor < CARE:
        told.append(
            "Closer than a workshop usually holds: read the machined crank on the balancing machine, "
            "and finish by that reading (recut)."
        )
    return told


def _plus_minus(value: float | None, digits: int, unit: str = "") -> str:
    """Return a tolerance cut to as many decimals as it needs, at least ``digits``; never more than it is."""
    if value is None:
        return NONE
    while digits < 7 and _cut(value, digits) < 0.95 * value:
        digits += 1
    return f"±{_cut(value, digits):.{digits}f}{unit}"


def _cut(value: float, digits: int) -> float:
    """Return a value cut after some decimals; rounding of binary fractions does not count."""
    return math.floor(value * 10.0**digits + 1e-6) / 10.0**digits


def _numbers(numbers: Sequence[int]) -> str:
    """Return numbers in runs: ``all of 1-12, 14``."""
    runs: list[list[int]] = []
    for each in sorted(numbers):
        if runs and each == runs[-1][1] + 1:
            runs[-1][1] = each
        else:
            runs.append([each, each])
    return "No " + ", ".join(f"{a}" if a == b else f"{a}-{b}" for a, b in runs)


def slug_table(items: Sequence[Item], u: DisplayUnits, wide_mm: float) -> Flowable:
    """List the slugs: sizes, material, fit and how each is held."""
    columns = [
        Column("slug", 13.0, "left"),
        Column(f"bore\n{u.length}", 22.0),
        Column(f"slug's diameter\n{u.length}", 26.0),
        Column(f"length\n{u.length}", 14.0),
        Column(f"mass\n{u.mass}", 13.0),
        Column("kg/m³", 12.0),
        Column("fit", 12.0, "left"),
        Column("retention", 75.0, "left"),
    ]
    rows = []
    for item in items:
        fit = press_fit(float(item["diameter_mm"]))
        rows.append(
            [
                f"cut {item['number']}",
                " to ".join(u.mm(value) for value in fit.bore_mm),
                " to ".join(u.mm(value) for value in fit.slug_mm),
                u.mm(item.get("length_mm")),
                u.g(item["slug_mass_g"]),
                f"{item['density_kg_m3']:.0f}",
                fit.name,
                retention(item),
            ]
        )
    return table(wide_mm, columns, rows)
