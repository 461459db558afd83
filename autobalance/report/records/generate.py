"""The report of `generate`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import (
    ABSENT,
    Absent,
    Count,
    Like,
    NotNegative,
    Ordinal,
    Positive,
    Range,
    Sha256,
    Size,
    record,
)
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.crank import Crank
from autobalance.report.records.source import Frame, Versions
from autobalance.report.records.stage import Suggestions
from autobalance.version import SCHEMA_VERSION


@record
class DrawnShaft:
    """A shaft as drawn."""

    diameter_mm: Positive
    width_mm: Positive
    bore_mm: NotNegative


@record
class DesignWeb:
    """The webs as drawn."""

    thickness_mm: Positive
    outline: Literal["pear", "disc"]
    pin_end_radius_mm: Positive | Absent = ABSENT
    hub_radius_mm: Positive | Absent = ABSENT
    disc_radius_mm: Positive | Absent = ABSENT
    between_pins_mm: Positive


@record
class DesignBay:
    """Throws and webs between two main journals."""

    crankpins_deg: Annotated[Sequence[float], Size(1)]
    counterweights: Annotated[Sequence[bool], Size(2, 2)]


@record
class DesignCounterweight:
    """The counterweights as drawn."""

    radius_mm: Positive
    fan_angle_deg: Annotated[float, Range(above=0, most=180)]
    thickness_mm: Positive | Absent = ABSENT
    inner_radius_mm: Positive | Absent = ABSENT
    draft_deg: NotNegative


@record
class DesignNoseKeyway:
    """The keyway as drawn."""

    width_mm: Positive
    depth_mm: Positive
    length_mm: Positive


@record
class DesignNose:
    """The nose as drawn."""

    diameter_mm: Positive
    length_mm: Positive
    end_diameter_mm: Positive | Absent = ABSENT
    keyway: DesignNoseKeyway | Absent = ABSENT


@record
class DesignFlange:
    """The flange as drawn."""

    diameter_mm: Positive
    thickness_mm: Positive
    bolts: Count
    bolt_diameter_mm: NotNegative
    bolt_circle_mm: NotNegative


@record
class Design:
    """Every dimension, defaults filled in."""

    name: str
    stroke_mm: Positive
    main_journal: DrawnShaft
    crankpin: DrawnShaft
    web: DesignWeb
    bays: Annotated[Sequence[DesignBay], Size(1)]
    counterweight: DesignCounterweight | Absent = ABSENT
    end_journal_width_mm: Positive | Absent = ABSENT
    fillet_mm: NotNegative
    oil_hole_mm: NotNegative
    nose: DesignNose | Absent = ABSENT
    flange: DesignFlange | Absent = ABSENT
    journals: Literal["both", "first"]
    crankpin_in_file: bool
    density_kg_m3: Positive
    segments: Annotated[int, Range(least=8)]


@record
class DrawnBobWeight:
    """The bob-weight of a throw."""

    throw: Ordinal
    mass_g: NotNegative


@record
class DrawnEngine:
    """Balance factor and bob-weights of the drawn crank with the given parts."""

    balance_factor: float | None
    bob_weights: Sequence[DrawnBobWeight]


@record
class DrawnSolid:
    """The written file."""

    file: str
    sha256: Sha256
    triangles: Annotated[int, Range(least=4)] | None


@record
class DrawnOutputs:
    """The written files."""

    solid: DrawnSolid


@record
class GenerateReport:
    """Report of `generate --json`: dimensions in, mass properties out."""

    schema_version: Literal[1] = SCHEMA_VERSION
    autobalance: Versions
    command: Literal["generate"] = "generate"
    design: Annotated[Mapping[str, Any], Like(Design)]
    frame: Frame
    crank: Crank
    initial: Unbalance
    engine: DrawnEngine | None
    outputs: DrawnOutputs
    suggestions: (
        Annotated[
            Suggestions,
            "only with --suggest: what would give the crank a wanted factor or "
            "inertia, each tried on the solid",
        ]
        | Absent
    ) = ABSENT
