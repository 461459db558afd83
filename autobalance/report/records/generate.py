"""The report of `generate`."""

from typing import Annotated, Literal, NotRequired, TypedDict

from autobalance.records import Bound, Count, NotNegative, Ordinal, Positive, Sha256
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.crank import Crank, Frame, Versions
from autobalance.report.records.stage import Suggestions


class DrawnShaft(TypedDict):
    """A shaft as drawn."""

    diameter_mm: Positive
    width_mm: Positive
    bore_mm: NotNegative


class DesignWeb(TypedDict):
    """The webs as drawn."""

    thickness_mm: Positive
    outline: Literal["pear", "disc"]
    pin_end_radius_mm: NotRequired[Positive]
    hub_radius_mm: NotRequired[Positive]
    disc_radius_mm: NotRequired[Positive]
    between_pins_mm: Positive


class DesignBay(TypedDict):
    """What lies between two main journals."""

    crankpins_deg: Annotated[list[float], Bound("minItems", 1)]
    counterweights: Annotated[list[bool], Bound("minItems", 2), Bound("maxItems", 2)]


class DesignCounterweight(TypedDict):
    """The counterweights as drawn."""

    radius_mm: Positive
    fan_angle_deg: Annotated[float, Bound("exclusiveMinimum", 0), Bound("maximum", 180)]
    thickness_mm: NotRequired[Positive]
    inner_radius_mm: NotRequired[Positive]
    draft_deg: NotNegative


class DesignNoseKeyway(TypedDict):
    """The keyway as drawn."""

    width_mm: Positive
    depth_mm: Positive
    length_mm: Positive


class DesignNose(TypedDict):
    """The nose as drawn."""

    diameter_mm: Positive
    length_mm: Positive
    end_diameter_mm: NotRequired[Positive]
    keyway: NotRequired[DesignNoseKeyway]


class DesignFlange(TypedDict):
    """The flange as drawn."""

    diameter_mm: Positive
    thickness_mm: Positive
    bolts: Count
    bolt_diameter_mm: NotNegative
    bolt_circle_mm: NotNegative


class Design(TypedDict):
    """Every dimension, defaults filled in."""

    name: str
    stroke_mm: Positive
    main_journal: DrawnShaft
    crankpin: DrawnShaft
    web: DesignWeb
    bays: Annotated[list[DesignBay], Bound("minItems", 1)]
    counterweight: NotRequired[DesignCounterweight]
    end_journal_width_mm: NotRequired[Positive]
    fillet_mm: NotNegative
    oil_hole_mm: NotNegative
    nose: NotRequired[DesignNose]
    flange: NotRequired[DesignFlange]
    journals: Literal["both", "first"]
    crankpin_in_file: bool
    density_kg_m3: Positive
    segments: Annotated[int, Bound("minimum", 8)]


class DrawnBobWeight(TypedDict):
    """The bob-weight of a throw."""

    throw: Ordinal
    mass_g: NotNegative


class DrawnEngine(TypedDict):
    """What the given parts make of the drawn crank."""

    balance_factor: float | None
    bob_weights: list[DrawnBobWeight]


class DrawnSolid(TypedDict):
    """The written file."""

    file: str
    sha256: Sha256
    triangles: Annotated[int, Bound("minimum", 4)] | None


class DrawnOutputs(TypedDict):
    """The written files."""

    solid: DrawnSolid


class GenerateReport(TypedDict):
    """What `generate --json` writes."""

    schema_version: Literal[1]
    autobalance: Versions
    command: Literal["generate"]
    design: Design
    frame: Frame
    crank: Crank
    initial: Unbalance
    engine: DrawnEngine | None
    outputs: DrawnOutputs
    suggestions: NotRequired[
        Annotated[
            Suggestions,
            "only with --suggest: what would give the crank a wanted factor or "
            "inertia, each tried on the solid",
        ]
    ]
