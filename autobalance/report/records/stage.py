"""Stages, assemblies and suggestions."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np

from autobalance.balancing.machine_reading import StageSuspect
from autobalance.balancing.suggestions import wanted as suggested
from autobalance.balancing.suggestions.wanted import SuggestedBore, SuggestedChange
from autobalance.declare import (
    INLINE,
    Angle,
    Count,
    Floats,
    KgMm2,
    Like,
    NotNegative,
    Ordinal,
    Pair,
    Range,
    Size,
    record,
)
from autobalance.declare.schema import open_keys
from autobalance.report.records.balance import Plane, Unbalance
from autobalance.rigid_rotor import unbalance as rigid_rotor
from autobalance.rigid_rotor.staged_assembly import CRANK
from autobalance.types import Array
from autobalance.units import wrapped_deg

if TYPE_CHECKING:
    from autobalance.rigid_rotor import staged_assembly
    from autobalance.rigid_rotor.unbalance import Moments


@record
class Previous:
    """The report of the stage before."""

    report: str
    sha256: str


@record
class StageUnbalance:
    """An unbalance of a stage."""

    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    planes: Annotated[Sequence[Plane], Like(Sequence[Mapping[str, Any]])]
    moment_g_mm2: Pair
    uncertainty_g_mm: float | None

    @classmethod
    def of(cls, unbalance: Unbalance) -> Self:
        """Return an unbalance without the shares of what it may be off."""
        return cls(
            unbalance_g_mm=unbalance.unbalance_g_mm,
            magnitude_g_mm=unbalance.magnitude_g_mm,
            angle_deg=unbalance.angle_deg,
            planes=unbalance.planes,
            moment_g_mm2=unbalance.moment_g_mm2,
            uncertainty_g_mm=unbalance.uncertainty_g_mm,
        )


@record
class Stage:
    """A stage of the balancing loop."""

    stage: Annotated[int, Range(least=1, most=10)]
    serial: str | None
    report: Annotated[str, "relative to this report's folder"]
    outcome: Literal["within_tolerance", "already_within_tolerance", "above_tolerance"]
    bob_weights_g: Sequence[float]
    speed_rpm: float | None
    corrections: Count
    removed_mass_g: float
    reading: StageUnbalance | None
    expected: StageUnbalance | None
    deviation: StageUnbalance | None
    predicted: StageUnbalance | None
    suspects: Sequence[StageSuspect]


@record
class ReadPlane:
    """Reading of a machine in a plane, rotor frame; without a place where it read the resultant alone."""

    z_mm: float | None
    unbalance_g_mm: Pair


@record
class ReadUnbalance:
    """The reading file with its defaults, and the machine's readings in the rotor frame."""

    file: Mapping[str, Any]
    zero_deg: float
    unbalance_g_mm: Pair
    moment_g_mm2: Pair
    planes: Sequence[ReadPlane]


@record
class Staged:
    """Values of a stage after the first."""

    serial: Annotated[str | None, "recut only: serial number of the crank"]
    previous: Annotated[Previous, "recut only: the report it went on from"]
    stages: Annotated[
        Sequence[Stage],
        "recut only: all stages so far, this one last",
        Size(2, 10),
    ]
    machine_reading: Annotated[
        ReadUnbalance,
        Like(Mapping[str, Any]),
        "recut only: the reading file with its defaults, and the machine's readings in the rotor frame",
    ]
    earlier_corrections: Annotated[Sequence[Mapping[str, Any]], "recut only: cuts of the stages before"]
    input_is_untouched: Annotated[bool, "recut only: no stage has cut the crank before"]


@record
class AssemblyCorrection:
    """Correction of an assembly after a part was put on."""

    z_mm: float
    g_mm: NotNegative
    angle_deg: float


@record
class AssemblyStage:
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
    corrections: Sequence[AssemblyCorrection]
    left: Pair

    @classmethod
    def of(
        cls, number: int, stage: staged_assembly.AssemblyStage, places_mm: tuple[float, float] | None
    ) -> Self:
        """Return a stage, numbered from 1; the crank's sum is in two planes too."""
        part = stage.part
        total = rigid_rotor.Unbalance(_xy(stage.sum_g_mm), _xy(stage.sum_moment_g_mm2))
        return cls(
            stage=number,
            name=part.name,
            shaft=part.shaft,
            mass_g=stage.mass_g,
            part_g_mm=_xy(part.unbalance_g_mm),
            runout_g_mm=_xy(stage.runout_g_mm),
            key_g_mm=_xy(stage.key_g_mm),
            sum=Unbalance.of(total, places_mm if part.shaft == CRANK else None),
            permissible_g_mm=stage.permissible_g_mm,
            within=stage.within,
            corrections=[
                AssemblyCorrection(
                    z_mm=each.z_mm,
                    g_mm=abs(each.unbalance_g_mm),
                    angle_deg=wrapped_deg(math.degrees(cmath.phase(each.unbalance_g_mm))),
                )
                for each in stage.corrections
            ],
            left=_xy(stage.left_g_mm),
        )


def _xy(value: complex) -> Array:
    return np.array([value.real, value.imag])


@record
class SuggestionWanted:
    """Wanted balance factor and inertia."""

    balance_factor: float | None
    inertia_g_mm2: KgMm2 | None


@record
class SuggestionState:
    """Factor, inertia, mass and unbalance of a crank."""

    balance_factor: float | None
    inertia_g_mm2: KgMm2
    mass_g: float
    unbalance_g_mm: Floats

    @classmethod
    def of(cls, aim: suggested.Aim, moments: Moments) -> Self:
        return cls(
            balance_factor=aim.factor(moments),
            inertia_g_mm2=moments.polar_inertia_g_mm2,
            mass_g=moments.mass_g,
            unbalance_g_mm=moments.first_g_mm[:2],
        )


@open_keys
@record
class SuggestionLeaves:
    """Result of the tried suggestion, and its shortfall."""

    state: Annotated[SuggestionState, INLINE]
    short_balance_factor: float | None
    short_inertia_g_mm2: KgMm2 | None
    mass_change_g: float


@record
class Suggestion:
    """A change that was tried on the solid."""

    kind: str
    text: str
    reached: bool
    changes: Sequence[SuggestedChange]
    bores: Sequence[SuggestedBore]
    leaves: SuggestionLeaves

    @classmethod
    def of(cls, aim: suggested.Aim, each: suggested.Suggestion) -> Self:
        goal, factor = aim.wanted.balance_factor, aim.factor(each.tried)
        return cls(
            kind=each.kind,
            text=each.text,
            reached=aim.reached(each.tried),
            changes=each.changes,
            bores=each.bores,
            leaves=SuggestionLeaves(
                state=SuggestionState.of(aim, each.tried),
                short_balance_factor=None if goal is None or factor is None else goal - factor,
                short_inertia_g_mm2=aim.missing(each.tried).inertia_g_mm2,
                mass_change_g=each.tried.mass_g - aim.start.mass_g,
            ),
        )


@open_keys
@record
class RefusedSuggestion:
    """A change that does not do it, and why."""

    kind: str
    reason: str


@record
class Suggestions:
    """Changes of the crank for a wanted factor or inertia."""

    wanted: SuggestionWanted
    now: SuggestionState
    found: Sequence[Suggestion]
    refused: Sequence[RefusedSuggestion]

    @classmethod
    def of(
        cls,
        aim: suggested.Aim,
        suggestions: Sequence[suggested.Suggestion],
        refused: Sequence[suggested.Refused],
    ) -> Self:
        return cls(
            wanted=SuggestionWanted(
                balance_factor=aim.wanted.balance_factor, inertia_g_mm2=aim.wanted.inertia_g_mm2
            ),
            now=SuggestionState.of(aim, aim.start),
            found=[Suggestion.of(aim, each) for each in suggestions],
            refused=[RefusedSuggestion(kind=each.kind, reason=each.reason) for each in refused],
        )
