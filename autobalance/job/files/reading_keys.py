"""Keys of the convention of a balancing machine's reading, and angles between its sense and the rotor's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from autobalance.declare import NOT_NEGATIVE, POSITIVE, Key, Range, Values
from autobalance.units import wrapped_deg

Rotation = Literal["ccw", "cw"]
Reads = Literal["heavy", "light"]

PERCENT = Range("must be > 0 and ≤ 100", above=0.0, most=100.0)

ROTATION = Key("rotation", Rotation, "sense in which angle_deg counts, seen from +z", default="ccw")
ZERO_DEG = Key(
    "zero_deg", float, "the machine's zero mark in the rotor frame, ccw from crankpin 1", default=0.0
)
READS = Key("reads", Reads, "heavy: where the mass is too much; light: opposite", default="heavy")
URR_PERCENT = Key("urr_percent", float, "unbalance reduction ratio", PERCENT)
UMAR_G_MM = Key(
    "umar_g_mm", float, "minimum achievable residual unbalance of a plane's reading", NOT_NEGATIVE
)
SPEED_RPM = Key("speed_rpm", float, "speed of the machine", POSITIVE, None)
AS_READ = (
    Key("serial", str, "serial number, goes onto the sheet", default=None),
    SPEED_RPM,
    Key("bob_weights_g", tuple[float, ...], "clamped on, one a throw", NOT_NEGATIVE, None),
    Key("attached_fitted", bool, "were the [[engine.attached]] parts on", default=True),
    URR_PERCENT,
    UMAR_G_MM,
    ROTATION,
    ZERO_DEG,
)
"""Conventions of a machine's reading: of a reading file, and of trials that make one."""


@dataclass(frozen=True)
class Convention:
    """Convention of a reading's angles."""

    rotation: Rotation = "ccw"
    zero_deg: float = 0.0
    reads: Reads = "heavy"

    @staticmethod
    def of(values: Values) -> Convention:
        return Convention(values["rotation"], values["zero_deg"], values["reads"])

    @property
    def sense(self) -> float:
        """Return +1 where the machine counts counter-clockwise, −1 where clockwise."""
        return 1.0 if self.rotation == "ccw" else -1.0

    @property
    def offset_deg(self) -> float:
        """Return the rotor angle of a reading of 0°."""
        return self.zero_deg + (180.0 if self.reads == "light" else 0.0)

    def rotor_deg(self, angle_deg: float) -> float:
        """Return the angle of the heavy side in the rotor frame."""
        return wrapped_deg(self.offset_deg + self.sense * angle_deg)

    def machine_deg(self, rotor_deg: float) -> float:
        """Return the machine's angle for a heavy side at an angle of the rotor frame."""
        return wrapped_deg(self.sense * (rotor_deg - self.offset_deg))
