"""The zero of a sheet's angles: the keyway if there is one, else crankpin 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from autobalance.report.balance import kinds
from autobalance.report.balance.datums import angle_datum
from autobalance.types import Item, Report
from autobalance.wording import degrees

ZeroChoice = Literal["keyway", "crankpin"]
CRANKPIN, KEYWAY, HOLE = "crankpin 1", "keyway K", "hole H"
SIGNS = {CRANKPIN: "P1", KEYWAY: "K", HOLE: "H"}
"""Text of a zero beside an angle."""


@dataclass(frozen=True)
class Zero:
    """The zero of a sheet, and the other possible one.

    ``angle_deg`` is the angle of the zero, counter-clockwise from crankpin 1, ``other_deg`` that of the other
    one, None without one.
    """

    name: str
    angle_deg: float
    other: str | None = None
    other_deg: float | None = None

    @classmethod
    def of(cls, report: Report, choice: ZeroChoice = "keyway") -> Zero:
        """Return the chosen zero; crankpin 1 if there is no keyway."""
        datum = angle_datum(report)
        if datum is None:
            return cls(CRANKPIN, 0.0)
        if datum["of"] == "keyway" and choice == "keyway":
            return cls(KEYWAY, float(datum["angle_deg"]), CRANKPIN, 0.0)
        return cls(CRANKPIN, 0.0, KEYWAY if datum["of"] == "keyway" else HOLE, float(datum["angle_deg"]))

    @property
    def sign(self) -> str:
        """Return its text beside an angle."""
        return SIGNS[self.name]

    def ccw(self, angle_deg: float) -> float:
        """Return an angle from crankpin 1, counter-clockwise from this zero, in [0, 360)."""
        return (angle_deg - self.angle_deg) % 360.0

    def counted(self, item: Item) -> Item:
        """Return a correction with its angles counted from this zero."""
        shifted: dict[str, Any] = dict(item)
        angle = kinds.angle_deg(item)
        if angle is not None:
            shifted["angle_deg"] = self.ccw(angle)
        for key in ("start_deg", "end_deg"):
            if item.get(key) is not None:
                shifted[key] = self.ccw(float(item[key]))
        if isinstance(item.get("sector_deg"), list | tuple):
            low, high = map(float, item["sector_deg"])
            shifted["sector_deg"] = [self.ccw(low), self.ccw(low) + (high - low)]
        return shifted

    def words(self, angle_deg: float) -> str:
        """Return an angle from crankpin 1 in both senses from this zero: ``198.3° (161.7°)``."""
        return f"{degrees(angle_deg - self.angle_deg)} ({degrees(self.angle_deg - angle_deg)})"


FROM_CRANKPIN = Zero(CRANKPIN, 0.0)
