"""The cheek of each web from which its z is measured, and its letter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.paper.drawing import webs_cut
from autobalance.types import Item, Report

VIEW_LETTERS = "CDEGJMNPQSUVW"
"""Not A, B (tolerance planes), F, H, K, O (datums), B, L, R, T (set-ups), I and X, Y, Z."""
MOVED_MM = 0.05


@dataclass(frozen=True)
class Cheek:
    """A plane side of a web: its letter, its z in the rotor frame, and whether it looks along +z."""

    letter: str
    web: int
    z_mm: float
    looks_up: bool

    @property
    def name(self) -> str:
        return f"{'+z' if self.looks_up else '-z'} cheek of web {self.web}"


def cheeks(report: Report) -> dict[int, Cheek]:
    """Return by web the cheek nearest to its cuts, one that no cut moves if there is one."""
    cuts = [*report["corrections"], *report.get("earlier_corrections", ())]
    moved = [abs(float(cut["face_height_mm"])) for cut in cuts if cut.get("face_height_mm") is not None]
    cheeks_by_web: dict[int, Cheek] = {}
    for web in report["crank"]["webs"]:
        number = int(web["number"])
        own = [item for item in report["corrections"] if number in webs_cut(item)]
        if not own:
            continue
        ends = [(float(web["z_min_mm"]), False), (float(web["z_max_mm"]), True)]
        left = [end for end in ends if all(abs(abs(end[0]) - height) > MOVED_MM for height in moved)]
        z, looks_up = min(left or ends, key=lambda end: _away(own, end[0]))
        cheeks_by_web[number] = Cheek(_letter(len(cheeks_by_web)), number, z, looks_up)
    return cheeks_by_web


def _away(items: Sequence[Item], z_mm: float) -> float:
    return sum(abs(float(item["position_mm"][2]) - z_mm) for item in items)


def _letter(place: int) -> str:
    """Return the letter of a place in the list; after the last, letters come doubled.

    Examples
    --------
    >>> _letter(0), _letter(12), _letter(13)
    ('C', 'W', 'CC')
    """
    return VIEW_LETTERS[place % len(VIEW_LETTERS)] * (1 + place // len(VIEW_LETTERS))
