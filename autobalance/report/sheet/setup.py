"""How the crank is set up: which end is up, the datums, the zero of the degree wheel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.report.balance import kinds
from autobalance.report.balance.datum_values import told_angle, told_face
from autobalance.report.display_units import DisplayUnits
from autobalance.report.sheet.cuts import side_of
from autobalance.wording import at, degrees

Report = Mapping[str, Any]
ALIKE_MM = 0.05
"""Holes whose diameters differ by less look alike."""


def face_z_mm(report: Report) -> float:
    """Return the z of face F, that a depth gauge can touch [mm]."""
    return _face(report)[1]


def _face(report: Report) -> tuple[str, float]:
    """Return the name and z of face F: as recognised, else the -z face of the web at the -z end."""
    told = told_face(report)
    if told is not None:
        return told["name"], told["z_mm"]
    webs = at(report, "crank.webs") or []
    z, number = min(((float(web["z_min_mm"]), int(web["number"])) for web in webs), default=(0.0, 1))
    return f"-z face of web {number}", z


def set_up(report: Report, u: DisplayUnits) -> list[str]:
    """Return the set-up, a sentence or two a line."""
    return [_ends(report), _wheel(report, u), _datums(report, u), *_sides(report["corrections"])]


def _ends(report: Report) -> str:
    axis = np.asarray(report["frame"]["file_to_rotor"], dtype=np.float64)[2, :3]
    towards = ", ".join(f"{value:.4g}" for value in axis.round(6) + 0.0)
    mains = at(report, "crank.main_journals") or []
    end = ""
    if mains:
        last = max(mains, key=lambda main: float(main["centre_mm"][2]))
        end = f", the end of main journal {last['number']}"
    return f"Ends: +z is the direction ({towards}) of the crank's file{end}. Views are seen from the +z end."


def _wheel(report: Report, u: DisplayUnits) -> str:
    return (
        "Degree wheel: zero is the middle of crankpin 1. ccw counts counter-clockwise seen from the +z end, "
        f"cw clockwise seen from there; seen from the -z end the two change places. {_touched(report, u)}"
    )


def _touched(report: Report, u: DisplayUnits) -> str:
    """Return how zero is found: by the keyway or flange's hole that was recognised, else on crankpin 1."""
    datum = told_angle(report)
    if datum is None:
        return "No keyway or bolt circle is found in the file: set zero on crankpin 1, up under a dial gauge."
    ccw = datum["angle_deg"]
    place = f"its middle stands at {degrees(ccw)} ccw, {degrees(-ccw)} cw from crankpin 1"
    angles = "Below each web its cuts are told from there too."
    found = report["crank"]["datums"]
    if datum["of"] == "keyway":
        key = _the_one(found["keyways"], ccw, "keyways")
        size = f"{u.mm(key['width_mm'], u.diameter_digits)} {u.length} wide, at the {key['end']} end"
        return f"Keyway K ({size}): {place}. {angles}"
    holes = [{**hole, "flange": flange} for flange in found["flanges"] for hole in flange["holes"]]
    hole = _the_one(holes, ccw, "flanges")
    flange = hole["flange"]
    size = (
        f"⌀{u.mm(hole['diameter_mm'], u.diameter_digits)} on radius {u.mm(hole['radius_mm'])} {u.length}, "
        f"at the {flange['end']} end"
    )
    alike = [h for h in flange["holes"] if abs(h["diameter_mm"] - hole["diameter_mm"]) < ALIKE_MM]
    among = f", of {len(alike)} alike the nearest to crankpin 1" if len(alike) > 1 else ""
    return f"Flange's hole H ({size}{among}): {place}. {angles}"


def _the_one(datums: Sequence[Report], angle_deg: float, name: str) -> Report:
    for datum in datums:
        if datum["angle_deg"] == angle_deg:
            return datum
    raise KeyError(f"crank.datums.{name}, which lacks that of {angle_deg:g}°")


def _datums(report: Report, u: DisplayUnits) -> str:
    name, z = _face(report)
    return (
        "Datums: O is the axis of the main journals. z counts from the middle of crankpin 1's width; "
        f"face F is the {name}, at z = {u.mm(z)} {u.length}, for a gauge. "
        "Radius, angle, x and y of holes and slugs are those of the entry on the tool's axis, of all others "
        "those of the centre of the metal."
    )


def _sides(items: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return which end is up for which cuts, and where their depths begin."""
    texts = {
        "from +z": ("T", "+z end up, tool along the axis"),
        "from -z": ("B", "-z end up, tool along the axis (seen from above, ccw now counts clockwise)"),
        "from the rim": ("R", "crank lying in V-blocks or on centres, tool square to the axis"),
        TURNED: ("L", "crank between centres in the lathe"),
    }
    found = []
    for side, (letter, text) in texts.items():
        count = sum(_side(item) == side for item in items)
        if count:
            found.append(f"Set-up {letter} for {count} cut{'s' * (count > 1)} {side}: {text}.")
    return found + kinds.datums(items)


TURNED = "round the rim"


def _side(item: Mapping[str, Any]) -> str:
    """Return from where a cut is made, rims turned all round included."""
    return side_of(item) or (TURNED if "new_radius_mm" in item else "")
