"""The table [strength] of a job: fillets of crankpins and journals, and the strength of their metal."""

from __future__ import annotations

import math
from typing import Literal

from autobalance.declare import NOT_NEGATIVE, POSITIVE, Key, Range, Values
from autobalance.errors import JobError
from autobalance.job.tables import AddonTables, TablesRead
from autobalance.value_classes import dataclass

# Strength of a crank's fillets, from a job.


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


AT_LEAST_ONE = Range("must be ≥ 1", least=1.0)
MATERIAL = (
    Key("tensile_MPa", float, "tensile strength", POSITIVE),
    Key("yield_MPa", float, "yield strength", POSITIVE, None),
    Key(
        "fatigue_MPa",
        float | Literal["none"],
        "alternating bending that the fillet bears for ever",
        POSITIVE,
        "none",
        usual='`"none"`: by tensile strength and size, IACS UR M53',
    ),
)
FACTORS = (
    Key("bending", float, "stress concentration in bending, local over nominal stress", AT_LEAST_ONE),
    Key("torsion", float, "of torsion", AT_LEAST_ONE),
)
OIL_BORE = Key(
    "oil_bore",
    says="radial oil bore in the middle of each crankpin, for the stress at its outlet",
    default=None,
    keys=(
        Key("diameter_mm", float, "bore's diameter", POSITIVE),
        Key(
            "angle_deg",
            float,
            "direction of the outlet from the crankpin's axis: 0 away from the crank axis, counter-clockwise "
            "seen from +z",
            default=None,
            usual="the worst one",
        ),
    ),
)
STRENGTH = Key(
    "strength",
    says="fillets of crankpins and journals, and the strength of their metal",
    default=None,
    verbs="strength",
    keys=(
        Key("pin_fillet_mm", float, "radius of the crankpins' fillets", POSITIVE),
        Key("journal_fillet_mm", float, "radius of the main journals' fillets", POSITIVE, None,
            usual="`pin_fillet_mm`"),
        Key("recess_mm", float, "depth of the fillets' undercut into the web", NOT_NEGATIVE, 0.0),
        Key("material", says="strengths of the crank's metal", keys=MATERIAL),
        Key("factor", Literal["iacs"], "stress concentration: IACS UR M53, or a table of given ones",
            default="iacs", keys=FACTORS),
        OIL_BORE,
    ),
)  # fmt: skip


def _made(read: TablesRead) -> Strength | None:
    table = read.values.get("strength")
    return None if table is None else strength_of(table)


TABLES = AddonTables((STRENGTH,), _made)


def strength_of(values: Values) -> Strength:
    """Return the strength values of the job's table.

    Raises
    ------
    JobError
        If the metal yields or tires above its tensile strength.
    """
    metal, factors = values["material"], values["factor"]
    tensile = metal["tensile_MPa"]
    fatigue = None if metal["fatigue_MPa"] == "none" else metal["fatigue_MPa"]
    for name, value in (("yield_MPa", metal["yield_MPa"]), ("fatigue_MPa", fatigue)):
        if value is not None and value > tensile:
            raise JobError(
                f"strength.material.{name} is {value:g}, above tensile_MPa = {tensile:g}; expected less"
            )
    pin, bore = values["pin_fillet_mm"], values["oil_bore"]
    journal = values["journal_fillet_mm"]
    return Strength(
        pin,
        pin if journal is None else journal,
        values["recess_mm"],
        tensile,
        metal["yield_MPa"],
        fatigue,
        None if factors == "iacs" else FilletFactorPair(factors["bending"], factors["torsion"]),
        None if bore is None else _oil_bore(bore),
    )


def _oil_bore(values: Values) -> OilBore:
    angle = values["angle_deg"]
    return OilBore(values["diameter_mm"], None if angle is None else math.radians(angle))
