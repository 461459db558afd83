"""Tables of the cuts, one line each, and of their slugs."""

from __future__ import annotations

from collections.abc import Sequence

from reportlab.platypus import Flowable

from autobalance.paper.drawing import MIN_AXIAL_COMPONENT
from autobalance.paper.tables import Column, table
from autobalance.paper.tolerances import press_fit, retention
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import FROM_CRANKPIN, Zero
from autobalance.report.display_units import DisplayUnits, plain
from autobalance.types import Item
from autobalance.wording import NO_VALUE, degrees


def cut_table(items: Sequence[Item], u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
    """Return a table of every cut, angles in both senses, depths with and without the point."""
    columns = [Column("No", 7.5), *cut_columns(u, zero)]
    return table(wide_mm, columns, [cut_row(item, u, zero) for item in items])


def cut_columns(u: DisplayUnits, zero: Zero) -> list[Column]:
    """Return the columns of a cut, without its number."""
    from_crankpin = zero.angle_deg != 0.0
    return [
        Column("cut", 17.5, "left"),
        Column("how", 24.0, "left"),
        Column("where", 10.0, "left"),
        Column(f"{zero.name}\nccw" if from_crankpin else "angle\nccw", 13.0),
        Column("\ncw" if from_crankpin else "angle\ncw", 12.0),
        *([Column("(crankpin 1\nccw", 12.0), Column("\ncw)", 11.5)] if from_crankpin else []),
        Column(f"radius\n{u.length}", 11.5),
        Column(f"z\n{u.length}", 12.5),
        Column(f"diameter\n{u.length}", 13.0),
        Column(f"depth\n{u.length}", 11.5),
        Column("with point\n" + u.length, 14.5),
        Column(f"mass\n{u.mass}", 11.0 if u.is_metric else 12.5),
        *([] if u.is_metric else [Column("\ng", 11.5)]),
    ]


def cut_row(item: Item, u: DisplayUnits, zero: Zero = FROM_CRANKPIN) -> list[str]:
    """Return the cells of a cut: number, kind, place, angles, radius, z, sizes, mass.

    Where angles count from a keyway, those from crankpin 1, as in the report, follow in brackets.
    """
    ccw = kinds.angle_deg(item)
    point = item.get("point_mm")
    depth, mass = float(item["depth_mm"]), item["removed_mass_g"]
    if kinds.adds_metal(item):
        depth, mass = abs(depth), abs(mass)
    own = from_crankpin = [NO_VALUE, NO_VALUE]
    if ccw is not None:
        own = [degrees(ccw - zero.angle_deg), degrees(zero.angle_deg - ccw)]
        from_crankpin = [f"({degrees(ccw)}", f"{degrees(-ccw)})"]
    return [
        str(item["number"]),
        kinds.noun(item),
        how(item),
        webs_of(item),
        *own,
        *(from_crankpin if zero.angle_deg != 0.0 else []),
        u.mm(item.get("entry_radius_mm", item["radius_mm"]), u.length_digits - 1),
        u.mm(item["position_mm"][2], u.length_digits - 1),
        u.mm(item.get("diameter_mm"), u.diameter_digits),
        u.mm(depth),
        u.mm(depth + float(point)) if point else NO_VALUE,
        u.g(mass),
        *([] if u.is_metric else [plain(mass, 2)]),
    ]


def how(item: Item) -> str:
    """Return the kind's name and the side of the tool: ``drill from +z``."""
    if kinds.adds_metal(item):
        return f"{item['kind']}: {kinds.verb(item)}"
    word, side = str(item["kind"]), side_of(item)
    return f"{word} {side}" if side else word


def side_of(item: Item) -> str:
    """Return the side from which the tool enters; empty where a face or a rim is cut all over."""
    inward = item.get("inward")
    if inward is not None:
        if abs(inward[2]) < MIN_AXIAL_COMPONENT:
            return "from the rim"
        return "from -z" if inward[2] > 0.0 else "from +z"
    if item.get("face_z_mm") is not None:
        return "from -z" if item["position_mm"][2] > item["face_z_mm"] else "from +z"
    normal = item.get("normal")
    if normal is not None and abs(normal[2]) > MIN_AXIAL_COMPONENT:
        return "from +z" if normal[2] > 0.0 else "from -z"
    return ""


def webs_of(item: Item) -> str:
    """Return the webs: ``web 2``, ``web 1, 2``, of many in a row ``web 1-8``."""
    webs = [web for web in item.get("webs") or [item.get("web")] if web is not None]
    if len(webs) > 3 and webs == list(range(webs[0], webs[-1] + 1)):
        return f"web {webs[0]}-{webs[-1]}"
    return f"web {', '.join(map(str, webs))}" if webs else NO_VALUE


def slug_table(items: Sequence[Item], u: DisplayUnits, wide_mm: float) -> Flowable:
    """Return a table of the slugs: sizes, mass, density, fit and retention."""
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
