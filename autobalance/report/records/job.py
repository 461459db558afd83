"""The job in a report, a record for each table."""

from typing import Annotated, Any, Literal, NotRequired, TypedDict

from autobalance.declare import NotNegative, Ordinal, Pair, Pattern, Positive, Share, Size, Triple
from autobalance.declare.schema import open_keys


class JobCrankshaft(TypedDict):
    """The job's crank file and its data of the crank."""

    file: Annotated[str | None, "null: the crank was given in memory"]
    unit: Literal["mm", "cm", "m", "inch", None]
    density_kg_m3: Positive
    crankpin_in_file: bool
    axis_point_mm: Triple | None
    axis_direction: Triple | None
    crankpins: list[dict[str, Any]] | None
    main_journals: list[dict[str, Any]] | None
    body: Ordinal | Annotated[str, Pattern(least=1)] | None
    density_pm_kg_m3: NotRequired[NotNegative | None]


class Weight(TypedDict):
    """A weight with its uncertainty."""

    g: NotNegative
    pm: NotNegative
    distribution: NotRequired[Literal["normal", "rectangular"]]


class JobThrow(TypedDict):
    """A throw that differs from the others."""

    number: Ordinal
    rods: Ordinal
    rotating_g: dict[str, NotNegative | Weight]
    reciprocating_g: dict[str, NotNegative | Weight]
    crankpin_g: dict[str, NotNegative | Weight]
    bank_deg: NotRequired[list[float]]


class JobAttached(TypedDict):
    """An attached part that turns with the crank and is out of balance."""

    name: str
    mass_g: NotNegative
    unbalance_g_mm: Pair
    z_mm: float
    pm_g_mm: NotRequired[NotNegative]


class JobLayout(TypedDict):
    """Banks and offsets of the cylinders."""

    bank_deg: list[float] | None
    rod_pitch_mm: float
    offset_mm: float


class JobRod(TypedDict):
    """A connecting rod by its ends."""

    big_end_g: NotNegative
    small_end_g: NotNegative
    inertia_kg_mm2: Positive | None
    solid: NotRequired[dict[str, Any]]


@open_keys
class JobEngine(TypedDict):
    """The parts that the crank carries."""

    rod_length_mm: Positive | None
    stroke_mm: Positive | None
    rods_per_throw: Ordinal
    rotating_g: dict[str, NotNegative | Weight]
    reciprocating_g: dict[str, NotNegative | Weight]
    crankpin_g: dict[str, NotNegative | Weight]
    throw: list[JobThrow]
    attached: list[JobAttached]
    layout: NotRequired[JobLayout]
    rod: NotRequired[JobRod]


class WeightTables(TypedDict):
    """Three tables of weights."""

    rotating_g: dict[str, NotNegative | Weight]
    reciprocating_g: dict[str, NotNegative | Weight]
    crankpin_g: dict[str, NotNegative | Weight]


@open_keys
class JobBalance(TypedDict):
    """Balance factor, top speed and quality grade."""

    factor: Share | Literal["original"] | None
    grade: Positive | None
    speed_rpm: Positive | None
    judge: Literal["dynamic", "static"]
    rotor_mass_g: Positive | None
    tolerance_planes_mm: Pair | None
    margin: NotRequired[Literal["none", "expanded"]]
    facet_correction: NotRequired[bool]


@open_keys
class JobCorrection(TypedDict):
    """Kinds of correction and their preference; each kind's own table is next to these."""

    method: Annotated[list[str], Size(1)] | None
    depth_tolerance_mm: NotRequired[NotNegative | None]


@open_keys
class Job(TypedDict):
    """The job as read, defaults filled in."""

    file: str
    crankshaft: JobCrankshaft
    engine: JobEngine
    original: WeightTables | None
    balance: JobBalance
    correction: JobCorrection
    drive: NotRequired[dict[str, Any]]
