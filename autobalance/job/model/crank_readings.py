"""A shop's measurements of the crank in the hand: on a scale, with a micrometer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Calibrate = Literal["skin", "density", "none"]
"""Quantity that absorbs a difference of mass: an even offset of the surface, the density, or nothing."""


@dataclass(frozen=True)
class CrankReadings:
    """Readings of the bare crank, with half-widths (``pm``) of about 95 %.

    ``micrometer_mm`` has ``main_journal`` and ``crankpin`` where they were measured.
    """

    weighed_g: float | None = None
    weighed_pm_g: float = 0.0
    calibrate: Calibrate = "none"
    micrometer_mm: Mapping[str, float] = field(default_factory=dict)
    micrometer_pm_mm: float = 0.0

    @property
    def any(self) -> bool:
        """Whether anything was measured."""
        return self.weighed_g is not None or bool(self.micrometer_mm)
