"""The whole report of `balance`, `recut` and `inspect`."""

from typing import Annotated, Any, Literal, NotRequired, TypedDict

from autobalance.machine_models.gas_loads import LoadsWithGas
from autobalance.records import Angle, Bound, Count, NotNegative, Ordinal, Pair, Positive, Triple
from autobalance.report.records.balance import (
    BalanceFactor,
    Correction,
    Counterweight,
    Engine,
    Outputs,
    Overbalance,
    Relaxation,
    Step,
    Tolerance,
    Unbalance,
)
from autobalance.report.records.crank import Crank, Frame, Input, Versions
from autobalance.report.records.forces import ShakingForce
from autobalance.report.records.job import Job
from autobalance.report.records.stage import AssemblyStage, Previous, Stage, Suggestions


class Seconds(TypedDict):
    """Time of each stage [s]."""

    load: NotNegative | None
    measure: NotNegative | None
    plan: NotNegative | None
    cut: NotNegative | None
    write: NotNegative | None
    total: NotNegative | None


class ExternalPart(TypedDict):
    """What an external part carries, by how much that changes, and by how much it may be off."""

    name: str
    z_mm: float
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    change_g_mm: Pair
    pm_g_mm: NotNegative


class Section(TypedDict):
    """A section of the crank along its axis."""

    kind: Literal["main journal", "crankpin", "web", "counterweight", "shaft"]
    number: Ordinal
    mass_g: NotNegative
    centre_mm: Triple
    unbalance_g_mm: Pair
    moment_g_mm2: Pair


class SectionTableRow(TypedDict):
    """A row of the section table: a stretch of the crank, or what the job puts on it."""

    kind: Literal[
        "main journal",
        "crankpin",
        "web",
        "counterweight",
        "shaft",
        "facets",
        "balance hole",
        "bob-weight",
        "oil",
        "on crankpin",
        "attached",
    ]
    number: Ordinal | None
    name: str | None
    mass_g: float
    centre_mm: Triple | None
    unbalance_g_mm: Pair
    moment_g_mm2: Pair


class SectionTableSums(TypedDict):
    """Sums over all rows."""

    mass_g: float
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    moment_g_mm2: Pair


class SectionTablePlane(TypedDict):
    """The table's verdict in a plane."""

    name: Literal["A", "B"]
    z_mm: float
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    permissible_g_mm: NotNegative


class CounterweightWanted(TypedDict):
    """A counterweight that would balance the table in its plane."""

    web: Ordinal
    product_g_mm: Pair
    change_g_mm: Pair


class SectionTable(TypedDict):
    """The crank section by section, with what the job puts on it, about a datum."""

    datum_mm: float
    rows: list[SectionTableRow]
    sums: SectionTableSums
    planes: Annotated[list[SectionTablePlane], Bound("maxItems", 2)]
    permissible_g_mm: NotNegative | None
    judge: Literal["dynamic", "static", None]
    within: bool | None
    counterweights_wanted: Annotated[list[CounterweightWanted], Bound("maxItems", 2)]


class WebWeight(TypedDict):
    """A web's counterweight."""

    web: int | None
    mass_g: NotNegative
    radius_mm: float
    product_g_mm: float


class NamedFace(TypedDict):
    """A face that a correction names."""

    id: str
    kind: Literal["plane", "cylinder"]
    web: Ordinal | None
    area_mm2: Positive
    normal: Triple
    centroid_mm: Triple
    file_centroid_mm: Triple


class Face(NamedFace):
    """A face that a correction may use."""

    unbalance_per_mm_g_mm: Pair
    max_depth_mm: NotNegative | None


class WithSlugs(TypedDict):
    """The corrected crank with its slugs, rotor frame."""

    mass_g: Positive
    centre_of_mass_mm: Triple


class Forces(TypedDict):
    """Inertia forces before and after."""

    speed_rpm: NotNegative
    before: ShakingForce
    after: ShakingForce


class FacesByKind(TypedDict):
    """How many true surfaces of each kind."""

    plane: Count
    cylinder: Count
    cone: Count
    sphere: Count
    torus: Count
    other: Count


class FacetsHide(TypedDict):
    """What triangles laid over the surfaces would miss."""

    mass_g: float
    unbalance_g_mm: Pair


class SurfacesOfSolid(TypedDict):
    """The true surfaces of a solid."""

    faces: FacesByKind
    facets_hide: FacetsHide


class TrueSurfaces(TypedDict):
    """Surfaces before and after the cut."""

    before: SurfacesOfSolid
    after: SurfacesOfSolid | None


class Report(TypedDict):
    """A report: `report.json`."""

    schema_version: Literal[1]
    autobalance: Versions
    command: Literal["balance", "inspect", "recut"]
    job_set: NotRequired[list[str]]
    job: Job | None
    input: Input
    frame: Frame
    crank: Crank
    counterweight: Counterweight | None
    engine: Engine | None
    balance_factor: BalanceFactor | None
    tolerance: Tolerance | None
    initial: Unbalance
    residual: Unbalance | None
    corrections: list[Correction]
    steps: list[Step]
    inertia_change_kg_mm2: float | None
    outcome: Literal["within_tolerance", "already_within_tolerance", "above_tolerance", None]
    proven: Annotated[bool | None, "whether the residual plus its uncertainty is within what is permitted"]
    reason: str | None
    relaxations: NotRequired[
        Annotated[
            list[Relaxation],
            "above tolerance: what would reach it; those that were tried first, least metal first",
        ]
    ]
    outputs: Outputs
    warnings: NotRequired[list[str]]
    notes: NotRequired[
        Annotated[
            list[str],
            "Kinds of correction without a place, and drills that were not used, each with its reason",
        ]
    ]
    seconds: Seconds
    sections: NotRequired[list[Section]]
    section_table: NotRequired[SectionTable]
    counterweights: NotRequired[list[WebWeight]]
    faces: NotRequired[
        Annotated[
            list[NamedFace | Face], "what a correction can use (inspect), or those that one names (balance)"
        ]
    ]
    final_with_slugs: NotRequired[WithSlugs]
    overbalance: Overbalance | None
    forces: NotRequired[Forces | None]
    loads_with_gas: NotRequired[
        Annotated[
            LoadsWithGas, "Of jobs with a cycle: loads over it at top speed, of the crank before and after."
        ]
    ]
    external: NotRequired[
        Annotated[list[ExternalPart], "What damper, flexplate or flywheel carry of the crank's unbalance."]
    ]
    true_surfaces: NotRequired[
        Annotated[
            TrueSurfaces,
            "Of files that keep them: faces by kind before and after the cut, and "
            "by how much the triangles that it was planned on differ from them.",
        ]
    ]
    serial: NotRequired[Annotated[str | None, "recut only: serial number of the crank"]]
    previous: NotRequired[Annotated[Previous, "recut only: the report it went on from"]]
    stages: NotRequired[
        Annotated[
            list[Stage],
            "recut only: all stages so far, this one last",
            Bound("minItems", 2),
            Bound("maxItems", 10),
        ]
    ]
    machine_reading: NotRequired[
        Annotated[
            dict[str, Any],
            "recut only: the reading file with its defaults, and what the machine read in the rotor frame",
        ]
    ]
    earlier_corrections: NotRequired[Annotated[list[dict[str, Any]], "recut only: cuts of the stages before"]]
    input_is_untouched: NotRequired[Annotated[bool, "recut only: no stage has cut the crank before"]]
    assembly: NotRequired[
        Annotated[
            list[AssemblyStage], "parts put on the crank, or on shafts of their own, in the order of the job"
        ]
    ]
    suggestions: NotRequired[
        Annotated[
            Suggestions,
            "only with --suggest: what would give the crank a wanted factor or "
            "inertia, each tried on the solid",
        ]
    ]
