"""The whole report of `balance`, `recut` and `inspect`, and JSON Schemas of what is written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np

from autobalance.balancing.record import BalanceFactor, Input
from autobalance.balancing.sections import section_types
from autobalance.balancing.web_metal import WebMetal, weak_places
from autobalance.correction import KINDS
from autobalance.crank.against import Against
from autobalance.crank.sections import WebWeight
from autobalance.declare import (
    ABSENT,
    INLINE,
    Absent,
    Angle,
    KgMm2,
    Like,
    Matrix3,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    Registered,
    Triple,
    fields_of,
    record,
)
from autobalance.declare.schema import schema_of
from autobalance.job.balance import LISTED
from autobalance.planning.relaxation import Relaxation, Step
from autobalance.quantities import Text, listed
from autobalance.report.records.answers import JobEcho
from autobalance.report.records.balance import (
    Counterweight,
    Engine,
    ReasonQuantity,
    Tolerance,
    Unbalance,
)
from autobalance.report.records.corrections import (
    Correction,
    Overbalance,
    PlanKept,
    kept_corrections,
)
from autobalance.report.records.crank import Crank
from autobalance.report.records.outputs import Outputs
from autobalance.report.records.scan import Face, NamedFace, TrueSurfaces
from autobalance.report.records.sections import Section, SectionTable
from autobalance.report.records.source import Frame, Versions
from autobalance.report.records.stage import AssemblyStage, Staged, Suggestions
from autobalance.report.records.with_bob_weights import WithBobWeights
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.running_gear.roll import ShakingForce
from autobalance.units import G_MM2_PER_KG_MM2, wrapped_deg
from autobalance.version import SCHEMA_VERSION

if TYPE_CHECKING:
    from autobalance.balancing import record as balancing
    from autobalance.balancing.external import CarriedUnbalance
    from autobalance.balancing.loop import Result
    from autobalance.job import model


# The whole report of `balance`, `recut` and `inspect`.


@record
class Seconds:
    """Time of each stage [s]."""

    load: NotNegative | None
    measure: NotNegative | None
    plan: NotNegative | None
    cut: NotNegative | None
    write: NotNegative | None
    total: NotNegative | None

    @classmethod
    def of(cls, seconds: Mapping[str, float]) -> Self:
        return cls(**{stage.key: seconds.get(stage.key) for stage in fields_of(Seconds)})


@record
class ExternalPart:
    """Unbalance that an external part carries, its change, and its uncertainty."""

    name: str
    z_mm: float
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    change_g_mm: Pair
    pm_g_mm: NotNegative

    @classmethod
    def of(cls, carried: CarriedUnbalance) -> Self:
        x, y = carried.unbalance_g_mm
        return cls(
            name=carried.part.name,
            z_mm=carried.part.z_mm,
            unbalance_g_mm=carried.unbalance_g_mm,
            magnitude_g_mm=math.hypot(x, y),
            angle_deg=wrapped_deg(math.degrees(math.atan2(y, x))),
            change_g_mm=carried.unbalance_g_mm - np.array(carried.part.unbalance_g_mm),
            pm_g_mm=carried.pm_g_mm,
        )


@record
class ThrowOil:
    """Oil in bores and drillings of a throw and of the mains beside it, up to halfway to its neighbours.

    Rotor frame, about its origin. `on_crankpin_g` is in the bob-weight: it pulls along the throw as the oil.
    """

    throw: Ordinal
    mass_g: Positive
    centre_mm: Triple
    inertia_kg_mm2: Matrix3
    on_crankpin_g: NotNegative

    @classmethod
    def of(cls, throw: int, oil: model.ThrowOil) -> Self:
        return cls(
            throw=throw,
            mass_g=oil.moments.mass_g,
            centre_mm=oil.moments.centre_mm,
            inertia_kg_mm2=oil.moments.inertia_g_mm2 / G_MM2_PER_KG_MM2,
            on_crankpin_g=oil.on_crankpin_g,
        )


@record
class WithSlugs:
    """The corrected crank with its slugs, rotor frame."""

    mass_g: Positive
    centre_of_mass_mm: Triple

    @classmethod
    def of(cls, result: Result) -> Self | Absent:
        """Return the crank with what was pressed in, where anything was: the written solid lacks it."""
        if result.measured is None or not any(KINDS[each.kind].pressed_in for each in result.corrections):
            return ABSENT
        final = result.final_moments
        return cls(mass_g=final.mass_g, centre_of_mass_mm=final.centre_mm)


@record
class Forces:
    """Inertia forces before and after."""

    speed_rpm: NotNegative
    before: ShakingForce
    after: ShakingForce

    @classmethod
    def of(cls, forces: balancing.Forces, job: Mapping[str, Any]) -> Self:
        """Return the forces of a run; ``job`` as the report describes it."""
        return cls(
            speed_rpm=job["balance"]["speed_rpm"],
            before=forces.before,
            after=forces.after,
        )


@record
class Report:
    """A report: `report.json`."""

    schema_version: Literal[1] = SCHEMA_VERSION
    autobalance: Versions
    command: Literal["balance", "inspect", "recut"]
    job: JobEcho | None = None
    job_set: Sequence[str] | Absent = ABSENT
    input: Input
    frame: Frame
    crank: Crank
    counterweight: Counterweight | None = None
    engine: Engine | None = None
    balance_factor: BalanceFactor | None = None
    tolerance: Tolerance | None = None
    initial: Unbalance
    residual: Unbalance | None = None
    corrections: Sequence[Correction] = ()
    steps: Sequence[Step] = ()
    inertia_change_g_mm2: KgMm2 | None = None
    forces: Forces | Absent | None = None
    outcome: Outcome | None = None
    proven: Annotated[
        bool | None,
        "whether residual plus uncertainty is within the permissible, however crank.doubts are meant",
    ] = None
    reason: str | None = None
    reason_parts: (
        Annotated[Sequence[str | ReasonQuantity], "parts of reason, with its quantities separate"] | Absent
    ) = ABSENT
    overbalance: Overbalance | None = None
    warnings: Sequence[str] | Absent = ABSENT
    outputs: Annotated[Mapping[str, Any], Like(Outputs)]
    seconds: Seconds
    faces: (
        Annotated[
            Sequence[NamedFace | Face],
            "surfaces that a correction can use (inspect), or those that one names (balance)",
        ]
        | Absent
    ) = ABSENT
    relaxations: (
        Annotated[
            Sequence[Relaxation],
            "above tolerance: remedies; those that were tried first, by rising metal",
        ]
        | Absent
    ) = ABSENT
    notes: (
        Annotated[
            Sequence[str],
            "Kinds of correction without a place, and drills that were not used, each with its reason",
        ]
        | Absent
    ) = ABSENT
    web_metal: (
        Annotated[
            Sequence[WebMetal],
            "Minimum metal of each web between its crankpin and main journal, along the axis, within the web",
        ]
        | Absent
    ) = ABSENT
    weak_places: (
        Annotated[
            Sequence[str], "Webs that the cuts thin, walls that are thin for their hole, holes near a fillet"
        ]
        | Absent
    ) = ABSENT
    plan_kept: Annotated[PlanKept, "the earlier report whose cuts were kept, with new depths"] | Absent = (
        ABSENT
    )
    final_with_slugs: WithSlugs | Absent = ABSENT
    of_addons: Annotated[Mapping[str, Any], INLINE, Registered(section_types)] = field(default_factory=dict)
    external: (
        Annotated[
            Sequence[ExternalPart], "Share of the crank's unbalance that damper, flexplate or flywheel carry."
        ]
        | Absent
    ) = ABSENT
    oil: (
        Annotated[Sequence[ThrowOil], "Of jobs with `[engine.oil]`: the oil that the crank holds."] | Absent
    ) = ABSENT
    assembly: (
        Annotated[
            Sequence[AssemblyStage],
            "parts put on the crank, or on separate shafts, in the order of the job",
        ]
        | Absent
    ) = ABSENT
    staged: Annotated[Staged | None, INLINE] = None
    true_surfaces: (
        Annotated[
            TrueSurfaces,
            "Of files that keep them: faces by kind before and after the cut, and "
            "the difference of the triangles that it was planned on.",
        ]
        | Absent
    ) = ABSENT
    sections: Sequence[Section] | Absent = ABSENT
    counterweights: Sequence[WebWeight] | Absent = ABSENT
    section_table: SectionTable | Absent = ABSENT
    present: (
        Annotated[
            float | None, "balance factor of the crank as it is with the job's parts; null: its throws cancel"
        ]
        | Absent
    ) = ABSENT
    with_bob_weights: (
        Annotated[WithBobWeights | None, "inspect of a job with attached parts: how well they are balanced"]
        | Absent
    ) = ABSENT
    suggestions: (
        Annotated[
            Suggestions,
            "only with --suggest: what would give the crank a wanted factor or "
            "inertia, each tried on the solid",
        ]
        | Absent
    ) = ABSENT
    against: Annotated[Against, "only with --against: how a crank differs from its drawing"] | Absent = ABSENT

    @classmethod
    def of(cls, record: balancing.Record) -> Self:
        """Return the report of a run."""
        balanced, anatomy = record.balanced, record.crank.anatomy
        return cls(
            autobalance=Versions.here(),
            command=record.command,
            job=None if balanced is None else balanced.job,
            job_set=(record.job_set if balanced is None else balanced.job_set) or ABSENT,
            input=record.input,
            frame=Frame(file_to_rotor=anatomy.file_to_rotor),
            crank=Crank.of(record.crank),
            initial=Unbalance.of(
                record.initial,
                record.planes_z_mm,
                None if balanced is None else balanced.result.initial_doubt,
            ),
            warnings=record.warnings,
            outputs=record.outputs,
            seconds=Seconds.of(record.seconds),
            staged=record.staged,
            true_surfaces=ABSENT if record.surfaces is None else TrueSurfaces.of(record.surfaces, balanced),
            sections=ABSENT if record.sections is None else [Section.of(part) for part in record.sections],
            counterweights=ABSENT if record.web_weights is None else record.web_weights,
            section_table=ABSENT if record.section_table is None else SectionTable.of(*record.section_table),
            present=record.present,
            with_bob_weights=ABSENT if record.loaded is None else WithBobWeights.of(record.loaded),
            suggestions=ABSENT if record.suggested is None else Suggestions.of(*record.suggested),
            against=ABSENT if record.against is None else record.against,
            faces=_faces(record),
            **({} if balanced is None else _balanced(balanced, record)),
        )


def _faces(record: balancing.Record) -> Sequence[NamedFace | Face] | Absent:
    """Return the faces that cuts of a run name, or all that could be cut."""
    anatomy = record.crank.anatomy
    if record.balanced is not None:
        return [NamedFace.of(face, anatomy) for face in record.balanced.faces]
    return ABSENT if record.faces is None else [Face.of(offer, anatomy) for offer in record.faces]


def _balanced(balanced: balancing.Balanced, record: balancing.Record) -> dict[str, Any]:
    """Return the fields that only a balancing run has."""
    result, anatomy = balanced.result, record.crank.anatomy
    weight, left, forces = balanced.counterweight, balanced.overbalance, balanced.forces
    change = result.final_moments.polar_inertia_g_mm2 - result.initial_moments.polar_inertia_g_mm2
    return {
        "counterweight": None if weight is None else Counterweight.of(weight),
        "engine": Engine.of(balanced.loads),
        "balance_factor": balanced.factor,
        "tolerance": Tolerance.of(balanced.tolerance, balanced.job),
        "residual": Unbalance.of(result.residual, record.planes_z_mm, result.doubt),
        "corrections": _corrections(balanced, record),
        "plan_kept": ABSENT if balanced.kept is None else PlanKept.of(balanced.kept),
        "steps": result.steps,
        "inertia_change_g_mm2": change,
        "forces": None if forces is None else Forces.of(forces, balanced.job),
        "outcome": result.outcome,
        "proven": balanced.tolerance.is_proven_by(result.residual, result.doubt),
        "reason": result.reason,
        "reason_parts": listed(result.reason) if isinstance(result.reason, Text) else ABSENT,
        "overbalance": None if left is None else Overbalance.of(left, anatomy),
        "relaxations": result.relaxations,
        "notes": result.notes,
        "web_metal": balanced.web_metal,
        "weak_places": weak_places(balanced.web_metal, result.corrections, anatomy, record.cuts_before + 1),
        "final_with_slugs": WithSlugs.of(result),
        "of_addons": balanced.sections,
        "external": [ExternalPart.of(each) for each in balanced.external] or ABSENT,
        "oil": [ThrowOil.of(*each) for each in sorted(balanced.oil.items())] or ABSENT,
        "assembly": [
            AssemblyStage.of(number, each, record.planes_z_mm)
            for number, each in enumerate(balanced.assembly, 1)
        ]
        or ABSENT,
    }


def _corrections(balanced: balancing.Balanced, record: balancing.Record) -> list[Correction]:
    result, anatomy = balanced.result, record.crank.anatomy
    if balanced.kept is not None:
        return kept_corrections(balanced.kept, result, anatomy)
    return [
        Correction.of(number, each, anatomy)
        for number, each in enumerate(result.corrections, record.cuts_before + 1)
    ]


# The JSON Schemas of what is written, made from the typed records.


Values = dict[str, Any]

REPORT_HEAD: Values = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "$id": "https://autobalance.invalid/report-1.schema.json",
    "title": "Report of autobalance, schema_version 1",
    "description": "Numbers are in the unit that a key ends with; positions and vectors in the rotor "
    "frame unless the key begins with file_; angles counter-clockwise seen from +z.",
}
RULES: list[Values] = [
    {
        "if": {"properties": {"command": {"enum": ["balance", "recut"]}}},
        "then": {
            "properties": {
                "job": {"type": "object"},
                "engine": {"type": "object"},
                "balance_factor": {"type": "object"},
                "tolerance": {"type": "object"},
                "residual": {"type": "object"},
                "outcome": {"type": "string"},
                "inertia_change_kg_mm2": {"type": "number"},
                "outputs": {"required": ["solid"]},
            }
        },
        "else": {"required": ["faces"], "properties": {"job": {"type": "null"}}},
    },
    {
        "if": {"properties": {"outcome": {"const": "above_tolerance"}}},
        "then": {"properties": {"reason": {"type": "string"}}},
        "else": {"properties": {"reason": {"type": "null"}}},
    },
    {
        "if": {"properties": {"command": {"const": "recut"}}},
        "then": {
            "required": [
                "serial",
                "previous",
                "stages",
                "machine_reading",
                "earlier_corrections",
                "input_is_untouched",
            ]
        },
    },
]
"""Conditions that depend on the values: a balanced crank has a job, an unreached tolerance a reason."""


def written_schema() -> Values:
    """Return the JSON Schema (draft 2020-12) of reports, from the records.

    The kinds of correction in it are those that exist.
    """
    schema = schema_of(Report, REPORT_HEAD, RULES)
    method = schema["$defs"]["job_correction"]["properties"]["method"]
    method["items"]["enum"] = [*KINDS, LISTED]
    schema["$defs"]["correction"]["properties"]["kind"]["enum"] = list(KINDS)
    return schema
