"""What a report says of stages, assemblies and suggestions."""

from typing import Annotated, Any, Literal, TypedDict

from autobalance.records import Angle, Bound, Count, NotNegative, Ordinal, Pair
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.schema import open_keys


class Previous(TypedDict):
    """The report of the stage before."""

    report: str
    sha256: str


class StageUnbalance(TypedDict):
    """An unbalance of a stage."""

    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    planes: list[dict[str, Any]]
    moment_g_mm2: Pair
    uncertainty_g_mm: float | None


class StageSuspect(TypedDict):
    """A likely mistake in a reading."""

    cause: Literal["mirrored", "opposite", "turned", "exchanged", "scaled", "bob_weights"]
    key: str
    difference_g_mm: NotNegative
    left_g_mm: NotNegative
    says: str


class Stage(TypedDict):
    """A stage of the balancing loop."""

    stage: Annotated[int, Bound("minimum", 1), Bound("maximum", 10)]
    serial: str | None
    report: Annotated[str, "relative to this report's folder"]
    outcome: Literal["within_tolerance", "already_within_tolerance", "above_tolerance"]
    bob_weights_g: list[float]
    speed_rpm: float | None
    corrections: Count
    removed_mass_g: float
    reading: StageUnbalance | None
    expected: StageUnbalance | None
    deviation: StageUnbalance | None
    predicted: StageUnbalance | None
    suspects: list[StageSuspect]


class AssemblyCorrection(TypedDict):
    """What was taken out after a part was put on."""

    z_mm: float
    g_mm: NotNegative
    angle_deg: float


class AssemblyStage(TypedDict):
    """A part put on, and what it brings."""

    stage: Ordinal
    name: str
    shaft: str
    mass_g: NotNegative
    part_g_mm: Pair
    runout_g_mm: Pair
    key_g_mm: Pair
    sum: Unbalance
    permissible_g_mm: NotNegative
    within: bool
    corrections: list[AssemblyCorrection]
    left: Pair


class SuggestionWanted(TypedDict):
    """What was asked for."""

    balance_factor: float | None
    inertia_kg_mm2: float | None


SuggestedChange = TypedDict("SuggestedChange", {"key": str, "from": float, "closed_form": float, "to": float})


open_keys(SuggestedChange)


@open_keys
class SuggestedBore(TypedDict):
    """A bore for heavy metal."""

    web: Any
    diameter_mm: Any
    depth_mm: Any
    closed_form_depth_mm: Any
    radius_mm: Any
    angle_deg: Any
    z_mm: Any
    mass_g: Any


@open_keys
class SuggestionLeaves(TypedDict):
    """What the tried suggestion leaves."""

    balance_factor: Any
    inertia_kg_mm2: Any
    mass_g: Any
    unbalance_g_mm: Any
    short_balance_factor: Any
    short_inertia_kg_mm2: Any
    mass_change_g: Any


class Suggestion(TypedDict):
    """A change that was tried on the solid."""

    kind: str
    text: str
    reached: bool
    changes: list[SuggestedChange]
    bores: list[SuggestedBore]
    leaves: SuggestionLeaves


@open_keys
class RefusedSuggestion(TypedDict):
    """A change that does not do it, and why."""

    kind: str
    reason: str


class Suggestions(TypedDict):
    """What would give a wanted factor or inertia."""

    wanted: SuggestionWanted
    now: dict[str, Any]
    found: list[Suggestion]
    refused: list[RefusedSuggestion]
