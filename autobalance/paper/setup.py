"""Set-up of the crank: the end that is up, the datums, the zero of the degree wheel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.paper.cheeks import Cheek
from autobalance.paper.cuts import side_of
from autobalance.report.balance import kinds
from autobalance.report.balance.datums import z_datum_face
from autobalance.report.balance.zero import CRANKPIN, KEYWAY, Zero
from autobalance.report.display_units import DisplayUnits
from autobalance.types import Report
from autobalance.wording import at, degrees

TURNED_TEXT = "round the rim"
SET_UPS = {
    "from +z": ("T", "+z end up, tool along the axis"),
    "from -z": ("B", "-z end up, tool along the axis"),
    "from the rim": ("R", "crank in V-blocks or on centres, tool square to the axis"),
    TURNED_TEXT: ("L", "crank between centres in the lathe"),
}
"""Side from which cuts are made → letter of the set-up, position of the crank."""
ALIKE_MM = 0.05
"""Difference of diameters below which holes look equal."""


def set_up(report: Report, u: DisplayUnits, zero: Zero, cheeks: Mapping[int, Cheek]) -> list[str]:
    """Return the set-up, a sentence or two a line."""
    return [
        _ends(report),
        f"Degree wheel: zero is {_zero_words(report, u, zero)} ccw counts counter-clockwise seen from the +z "
        "end, cw clockwise seen from there; seen from the -z end the two change places.",
        _datums(report, cheeks.values(), u),
        *_sides(report["corrections"]),
    ]


def _ends(report: Report) -> str:
    axis = np.asarray(report["frame"]["file_to_rotor"], dtype=np.float64)[2, :3]
    towards = ", ".join(f"{value:.4g}" for value in axis.round(4) + 0.0)
    mains = at(report, "crank.main_journals") or []
    end = ""
    if mains:
        last = max(mains, key=lambda main: float(main["centre_mm"][2]))
        end = f", the end of main journal {last['number']}"
    return f"Ends: +z is the direction ({towards}) of the crank's file{end}."


def _zero_words(report: Report, u: DisplayUnits, zero: Zero) -> str:
    """Return the zero, the way to find it, and the angle of crankpin 1 or the keyway from it."""
    other = None if zero.other_deg is None else zero.other_deg - zero.angle_deg
    place = "" if other is None else f"{degrees(other)} ccw, {degrees(-other)} cw from it"
    if zero.name != CRANKPIN:
        return f"the middle of {_key_words(report, zero.angle_deg, u)}; crankpin 1 is at {place}."
    if zero.other_deg is None:
        return "crankpin 1, up under a dial gauge (no keyway or bolt circle is found in the file)."
    if zero.other == KEYWAY:
        return f"crankpin 1; {_key_words(report, zero.other_deg, u)} is at {place}."
    return f"crankpin 1; {_hole_words(report, zero.other_deg, u)} is at {place}."


def _key_words(report: Report, angle_deg: float, u: DisplayUnits) -> str:
    key = _the_one(report["crank"]["datums"]["keyways"], angle_deg, "keyways")
    return f"keyway K ({u.mm(key['width_mm'], u.diameter_digits)} {u.length} wide, at the {key['end']} end)"


def _hole_words(report: Report, angle_deg: float, u: DisplayUnits) -> str:
    flanges = report["crank"]["datums"]["flanges"]
    holes = [{**hole, "flange": flange} for flange in flanges for hole in flange["holes"]]
    hole = _the_one(holes, angle_deg, "flanges")
    flange = hole["flange"]
    size = (
        f"⌀{u.mm(hole['diameter_mm'], u.diameter_digits)} on radius {u.mm(hole['radius_mm'])} {u.length}, "
        f"at the {flange['end']} end"
    )
    alike = [h for h in flange["holes"] if abs(h["diameter_mm"] - hole["diameter_mm"]) < ALIKE_MM]
    among = f", the nearest to crankpin 1 of {len(alike)} equal ones" if len(alike) > 1 else ""
    return f"flange's hole H ({size}{among})"


def _the_one(datums: Sequence[Report], angle_deg: float, name: str) -> Report:
    for datum in datums:
        if datum["angle_deg"] == angle_deg:
            return datum
    raise KeyError(f"crank.datums.{name}, which lacks that of {angle_deg:g}°")


def _datums(report: Report, cheeks: Iterable[Cheek], u: DisplayUnits) -> str:
    face = z_datum_face(report)
    face_f = "" if face is None else f", face F is the {face['name']} (z {u.mm(face['z_mm'])})"
    listed = ", ".join(f"{each.letter} {each.name} (z {u.mm(each.z_mm)})" for each in cheeks)
    from_cheeks = f"beside the webs from a cheek: {listed}" if listed else ""
    return (
        "Datums: O is the axis of the main journals; z counts from the middle of crankpin 1's width, "
        f"{from_cheeks}{face_f}. Places of holes and slugs are those of the entry on the tool's axis, of all "
        "others of the metal's centre."
    )


def _sides(items: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the set-ups with the numbers of their cuts, and the datums of the depths."""
    set_ups = []
    for side, (letter, text) in SET_UPS.items():
        count = sum(_side(item) == side for item in items)
        if count:
            set_ups.append(f"Set-up {letter} for {count} cut{'s' * (count > 1)} {side}: {text}.")
    return [" ".join(set_ups), " ".join(kinds.datums(items))] if set_ups else kinds.datums(items)


def _side(item: Mapping[str, Any]) -> str:
    """Return the side from which a cut is made, rims turned all round included; empty without one."""
    return side_of(item) or (TURNED_TEXT if "new_radius_mm" in item else "")


def set_up_letter(item: Mapping[str, Any]) -> str:
    """Return the letter of the set-up in which a cut is made; empty without one."""
    side = _side(item)
    return SET_UPS[side][0] if side in SET_UPS else ""
