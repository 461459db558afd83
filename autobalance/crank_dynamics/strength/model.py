"""Strength of a crank's fillets, from a job."""

from __future__ import annotations

from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class FilletFactorPair:
    """Factors of a fillet that the job gives in place of computed ones: local over nominal stress."""

    bending: float
    torsion: float


@dataclass(frozen=True)
class OilBore:
    """Radial oil bores of the crankpins: their diameter, and the angle of their outlet.

    The angle is at the crankpin's own axis, from the direction away from the crank axis, counter-clockwise
    seen from +z; None: not known.
    """

    diameter_mm: float
    angle_rad: float | None


@dataclass(frozen=True)
class Strength:
    """Fillets [mm], the metal's strengths [MPa], and factors where they are given."""

    pin_fillet_mm: float
    journal_fillet_mm: float
    recess_mm: float
    tensile_MPa: float
    yield_MPa: float | None
    fatigue_MPa: float | None
    factor: FilletFactorPair | None
    oil_bore: OilBore | None = None
