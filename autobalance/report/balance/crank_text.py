"""Summary of ``inspect``, for people, and its parts."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.crank.sections import WebWeight
from autobalance.declare import ABSENT, Absent, present
from autobalance.report.balance.sections_text import against_text, scan_lines, section_heads, suggestions_text
from autobalance.report.display_units import ON_SCREEN, DisplayUnits, fixed
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.crank import Crank, Journal, Pin, Web
from autobalance.report.records.report import Report
from autobalance.report.records.scan import Face, NamedFace
from autobalance.report.records.with_bob_weights import WithBobWeights
from autobalance.report.tables import table
from autobalance.wording import degrees

MOST_FACES = 12
ON_AXIS_SHARE = 0.015
"""A cylinder whose middle is off the axis by less than this share of its diameter is on it."""
ROLES = {"collar": "collar", "shaft": "shaft", "web": "web", "none": "cylinder"}
METRIC = ON_SCREEN["metric"]


def inspect_text(report: Report, units: DisplayUnits) -> str:
    """Return the summary of a measured crank: mass, anatomy, unbalance, faces."""
    parts = [
        _measured(report, units),
        anatomy_text(report.crank, units),
        unbalance_text(report.initial, units),
        _present(report.present),
        _with_bob_weights(present(report.with_bob_weights), units),
        _counterweights(present(report.counterweights), units),
        _faces(present(report.faces), units),
        against_text(present(report.against), report.crank.body.mass_g, units),
        suggestions_text(present(report.suggestions)),
    ]
    return "\n\n".join(part for part in parts if part)


def _counterweights(weights: Sequence[WebWeight] | None, units: DisplayUnits) -> str:
    if not weights:
        return ""
    rows = [("Webs with counterweights", "m_cw", "r′", "m_cw·r′")]
    for weight in weights:
        rows.append(
            (
                "  all" if weight.web is None else f"  web {weight.web}",
                units.of_mass(weight.mass_g),
                units.of_length(weight.radius_mm),
                units.of_unbalance(weight.product_g_mm),
            )
        )
    return table(rows)


def sections_text(report: Report, units: DisplayUnits = METRIC) -> str:
    """Return the table of a crank's parts: mass, centre, and their products, in the order of the axis.

    W is the mass, WX and WY its unbalance, CX and CY ∫ x z dm and ∫ y z dm, so that every column of products
    adds up to the whole's.
    """
    u = units
    rows: list[tuple[str, ...]] = [section_heads(u)]
    parts = []
    for part in present(report.sections) or ():
        parts.append([part.mass_g, *part.centre_mm, *part.unbalance_g_mm, *part.moment_g_mm2])
        rows.append((f"  {part.kind} {part.number}", *_cells(parts[-1], u)))
    sums = [sum(column) for column in zip(*parts, strict=True)]
    rows.append(("  sum", *_cells([sums[0], *report.crank.body.centre_of_mass_mm, *sums[4:]], u)))
    return table(rows)


def _cells(numbers: Sequence[float], u: DisplayUnits) -> tuple[str, ...]:
    digits = (2, 3, 3, 3, 1, 1, 0, 0) if u.is_metric else (3, 4, 4, 4, 3, 3, 2, 2)
    per = (
        u.g_per_mass, *(u.mm_per_length,) * 3, *(u.g_mm_per_unbalance,) * 2,
        *(u.g_mm_per_unbalance * u.mm_per_length,) * 2,
    )  # fmt: skip
    return tuple(fixed(n / p, places) for n, p, places in zip(numbers, per, digits, strict=True))


def _measured(report: Report, units: DisplayUnits) -> str:
    source, body = report.input, report.crank.body
    centre = ", ".join(units.of_length(value) for value in body.centre_of_mass_mm)
    bodies = "body" if source.bodies == 1 else "bodies"
    lines = [
        f"{source.file}: {_boundary(report)}, {source.bodies} {bodies}, closed",
        f"  mass {units.of_mass(body.mass_g)}, volume {units.of_volume(body.volume_mm3)}",
        f"  centre of mass {centre} (rotor frame)",
        f"  polar inertia {units.of_inertia(body.polar_inertia_kg_mm2)}",
    ]
    return "\n".join(lines)


def _boundary(report: Report) -> str:
    """Return the kinds of a solid's true surfaces, if its file keeps them, else its number of triangles."""
    if report.true_surfaces is ABSENT:
        return f"{report.input.triangles} triangles"
    faces = vars(report.true_surfaces.before.faces)
    many = {"torus": "tori", "other": "others"}
    named = {kind: kind if count == 1 else many.get(kind, kind + "s") for kind, count in faces.items()}
    listed = [f"{count} {named[kind]}" for kind, count in faces.items() if count]
    return f"true surfaces ({', '.join(listed)})"


def anatomy_text(crank: Crank, units: DisplayUnits) -> str:
    """Return journals, throws and webs of a crank in columns."""
    rows = [("Part", "z", "diameter", "width", "crank radius", "angle")]
    for pin in crank.main_journals:
        rows.append((f"  main journal {pin.number}", *_pin_cells(pin, units), "", ""))
    for throw in crank.throws:
        place = units.of_length(throw.crank_radius_mm), degrees(throw.angle_deg, 2)
        rows.append((f"  throw {throw.number}", *_pin_cells(throw.crankpin, units), *place))
    off = units.of_length(crank.journal_misalignment_mm)
    return "\n".join(
        [
            table(rows),
            f"  main journals within {off} of the common axis",
            *scan_lines(crank, units),
            *_webs(crank.webs, units),
            *_also_on_axis(crank, units),
        ]
    )


def _also_on_axis(crank: Crank, units: DisplayUnits) -> list[str]:
    """Return the table of cylinders on the axis that are not main journals; empty without any."""
    rows: list[tuple[str, ...]] = [("Also on the axis", "z", "diameter", "width")]
    for each in crank.cylinders:
        on_axis = each.offset_mm < ON_AXIS_SHARE * each.diameter_mm
        if on_axis and each.role not in ("main_journal", "crankpin"):
            name = ROLES[each.role] if each.kind == "outside" else "bore"
            sizes = (each.z_mm, each.diameter_mm, each.width_mm)
            rows.append((f"  {name}", *(units.of_length(size) for size in sizes)))
    return ["", table(rows)] if len(rows) > 1 else []


def _webs(webs: Sequence[Web], units: DisplayUnits) -> list[str]:
    """Return the table of the webs, with their counterweights' rims if there are any."""
    rows: list[tuple[str, ...]] = [("Web", "z", "width", "counterweight's rim", "over")]
    for web in webs:
        middle, width = 0.5 * (web.z_min_mm + web.z_max_mm), web.z_max_mm - web.z_min_mm
        outline = present(web.outline)
        rim = "found" if web.counterweight else "none"
        angle = ""
        if web.counterweight and outline is not None:
            rim, angle = f"radius {units.of_length(outline.rim_radius_mm)}", f"{outline.fan_angle_deg:.1f}°"
        rows.append((f"  web {web.number}", units.of_length(middle), units.of_length(width), rim, angle))
    if not any(web.counterweight for web in webs):
        rows = [row[:3] for row in rows]
    return ["", table(rows)] if webs else []


def _pin_cells(pin: Journal | Pin, units: DisplayUnits) -> tuple[str, str, str]:
    return (
        units.of_length(pin.centre_mm[2]),
        units.of_length(pin.diameter_mm),
        units.of_length(pin.width_mm),
    )


def unbalance_text(initial: Unbalance, units: DisplayUnits) -> str:
    """Return the unbalance of the bare crank, and its doubt."""
    lines = ["Unbalance of the bare crank: " + units.of_vector(initial.magnitude_g_mm, initial.angle_deg)]
    lines += [f"  plane {plane.name}: {units.of_unbalance(plane.magnitude_g_mm)}" for plane in initial.planes]
    return "\n".join(lines)


def _present(factor: float | Absent | None) -> str:
    """Return the balance factor of the crank as it is; empty without weights."""
    if isinstance(factor, Absent):
        return ""
    if factor is None:
        return "Balance factor: none, the throws cancel each other's force"
    return f"Balance factor of the crank as it is, with these parts: {factor:.4f}"


def _with_bob_weights(loaded: WithBobWeights | None, units: DisplayUnits) -> str:
    """Return the unbalance by plane with all that the job hangs on the crank; empty without a job."""
    if not loaded:
        return ""
    hung = ", ".join(
        f"{each.kind}{'' if each.number is None else ' ' + str(each.number)}"
        f" {units.of_bob_weight(each.mass_g)}"
        for each in loaded.hung_on
    )
    rows: list[Sequence[str]] = [("With bob-weights", "take off", "at", "or add at", "permitted", "")]
    for each in loaded.planes:
        plane = "" if each.z_mm is None else f"plane {each.name} (z {units.of_length(each.z_mm)})"
        rows.append(
            (
                f"  {plane or each.name}",
                units.of_unbalance(each.magnitude_g_mm),
                units.heavy_at(each.magnitude_g_mm, each.angle_deg),
                units.heavy_at(each.magnitude_g_mm, each.add_at_deg),
                units.of_unbalance(each.permissible_g_mm),
                "within" if each.within else "ABOVE",
            )
        )
    return table(rows) + f"\n  on the crank: {hung or 'nothing'}; nothing is planned"


def _faces(faces: Sequence[NamedFace | Face] | None, units: DisplayUnits) -> str:
    offered = [face for face in faces or () if isinstance(face, Face)]
    if not offered:
        return ""
    rows = [("Face", "web", "area", f"{units.unbalance} per {units.length}", "deepest")]
    for face in offered[:MOST_FACES]:
        x, y = (
            value * units.mm_per_length / units.g_mm_per_unbalance for value in face.unbalance_per_mm_g_mm
        )
        deepest = "" if face.max_depth_mm is None else units.of_length(face.max_depth_mm)
        web = "" if face.named.web is None else str(face.named.web)
        area = units.of_area(face.named.area_mm2)
        rows.append((f"  {face.named.id}", web, area, f"{fixed(x, 3)}, {fixed(y, 3)}", deepest))
    more = len(offered) - MOST_FACES
    return table(rows) + (f"\n  and {more} more (--json FILE lists all)" if more > 0 else "")
