"""How the crank is set up: which end is up, the datums, the zero of the degree wheel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.graphics.words import at
from autobalance.report import kinds
from autobalance.report.paper.cuts import side_of
from autobalance.report.paper.units import Units

Report = Mapping[str, Any]


def face_z_mm(report: Report) -> float:
    """Return the z of face F, that a depth gauge can touch: the -z face of the web at the -z end [mm]."""
    return _face(report)[1]


def _face(report: Report) -> tuple[int, float]:
    webs = at(report, "crank.webs") or []
    z, number = min(((float(web["z_min_mm"]), int(web["number"])) for web in webs), default=(0.0, 1))
    return number, z


def set_up(report: Report, u: Units) -> list[str]:
    """Return the set-up, a sentence or two a line."""
    return [_ends(report), _wheel(), _datums(report, u), *_sides(report["corrections"])]


def _ends(report: Report) -> str:
    axis = np.asarray(report["frame"]["file_to_rotor"], dtype=np.float64)[2, :3]
    towards = ", ".join(f"{value:.4g}" for value in axis.round(6) + 0.0)
    mains = at(report, "crank.main_journals") or []
    end = ""
    if mains:
        last = max(mains, key=lambda main: float(main["centre_mm"][2]))
        end = f", the end of main journal {last['number']}"
    return f"Ends: +z is the direction ({towards}) of the crank's file{end}. Views are seen from the +z end."


def _wheel() -> str:
    return (
        "Degree wheel: zero is the middle of crankpin 1. ccw counts counter-clockwise seen from the +z end, "
        "cw clockwise seen from there; seen from the -z end the two change places. No keyway or flange is "
        "recognised in the file: set zero on crankpin 1 itself, up under a dial gauge."
    )


def _datums(report: Report, u: Units) -> str:
    web, z = _face(report)
    return (
        "Datums: O is the axis of the main journals. z counts from the middle of crankpin 1's width; "
        f"face F is the -z face of web {web}, at z = {u.mm(z)} {u.length}, for a gauge. "
        "Radius, angle, x and y of holes and slugs are those of the entry on the tool's axis, of all others "
        "those of the centre of the metal."
    )


def _sides(items: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return which end is up for which cuts, and where their depths begin."""
    texts = {
        "from +z": "+z end up, tool along the axis",
        "from -z": "-z end up, tool along the axis (seen from above, ccw now counts clockwise)",
        "from the rim": "crank lying in V-blocks or on centres, tool square to the axis",
    }
    found = []
    for side, text in texts.items():
        numbers = [int(item["number"]) for item in items if side_of(item) == side]
        if numbers:
            found.append(f"Set-up for {len(numbers)} cut{'s' * (len(numbers) > 1)} {side}: {text}.")
    return found + kinds.datums(items)
