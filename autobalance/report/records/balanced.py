"""The report of `balance` and of its stages, as what shows it reads it.

A key that a report of an earlier version lacks has its default here: None, or an empty sequence.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Self

from autobalance.balancing.record import BalanceFactor
from autobalance.balancing.web_metal import WebMetal
from autobalance.correction import KINDS
from autobalance.correction.kind import Kind
from autobalance.declare import (
    INLINE,
    OMITTED,
    UNWRITTEN,
    Floats,
    KgMm2,
    Named,
    Pair,
    Triple,
    changed,
    decoded,
    record,
)
from autobalance.declare import encoded as as_json
from autobalance.planning.relaxation import Relaxation
from autobalance.quantities import Text, g_mm, said
from autobalance.report.records.answers import JobEcho
from autobalance.report.records.balance import Engine, Tolerance, Unbalance
from autobalance.report.records.corrections import Correction, Overbalance
from autobalance.report.records.job import Job
from autobalance.report.records.outputs import Outputs
from autobalance.report.records.report import ExternalPart, Forces, Report, ThrowOil
from autobalance.report.records.stage import AssemblyStage, Stage, Staged
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.types import Values
from autobalance.wording import NOT_PROVEN, OUTCOMES, number


@record
class Hole:
    """Further fields of a correction by a drill or a slug."""

    inward: Triple
    diameter_mm: float
    entry_radius_mm: Annotated[float | None, OMITTED] = None
    point_mm: Annotated[float | None, OMITTED] = None
    drill: Annotated[str | None, OMITTED] = None
    deepened_from_mm: Annotated[float | None, OMITTED] = None


@record
class Slug:
    """Further fields of a slug."""

    slug_mass_g: float
    length_mm: float
    density_kg_m3: float
    centrifugal_load_N: float | None = None


@record
class Pocket:
    """Further fields of a milled pocket."""

    start_deg: float
    end_deg: float
    inner_radius_mm: float
    cutter_mm: float | None = None
    face_z_mm: Annotated[float | None, OMITTED] = None


@record
class NewFace:
    """Further fields of a lowered face, or of metal on a face."""

    normal: Triple
    face_height_mm: float
    new_height_mm: float


@record
class NewRim:
    """Further fields of a turned rim."""

    rim_radius_mm: float
    new_radius_mm: float


@record
class Cut(Correction):
    """A correction; what its kind adds is in the record of its shape, None of another shape."""

    label: str
    unbalance_per_mm_g_mm: Pair | None = None
    moment_per_mm_g_mm2: Pair | None = None
    webs: Annotated[Sequence[int] | None, OMITTED] = None
    direction: Annotated[str | None, OMITTED] = None
    sector_deg: Annotated[float | Floats | None, OMITTED] = None
    outer_radius_mm: float
    depth_left_mm: Annotated[float | None, OMITTED] = None
    wall_left_mm: Annotated[float | None, OMITTED] = None
    hole: Annotated[Hole | None, INLINE] = None
    slug: Annotated[Slug | None, INLINE] = None
    pocket: Annotated[Pocket | None, INLINE] = None
    new_face: Annotated[NewFace | None, INLINE] = None
    new_rim: Annotated[NewRim | None, INLINE] = None
    details: Annotated[Mapping[str, Any], INLINE]

    @property
    def of_kind(self) -> Kind[Any]:
        return KINDS[self.kind]

    @property
    def item(self) -> Values:
        """The correction as the report lists it, for its kind."""
        listed: Values = as_json(self)
        return listed

    @property
    def sector(self) -> tuple[float, float] | None:
        """Ends of the part of a face; None of a whole one, or where a kind has another angle of the name."""
        sector = self.sector_deg
        return None if sector is None or isinstance(sector, float) else (sector[0], sector[1])

    @property
    def diameter_mm(self) -> float | None:
        return None if self.hole is None else self.hole.diameter_mm

    @property
    def only_hole(self) -> Hole:
        """The hole of a correction that is one."""
        assert self.hole is not None
        return self.hole

    @property
    def is_deepened(self) -> bool:
        """Whether it deepens a hole that was there before."""
        return self.hole is not None and bool(self.hole.deepened_from_mm)

    @property
    def shown_radius_mm(self) -> float:
        """Radius of a hole's entry, else of the centre of the metal."""
        entry = None if self.hole is None else self.hole.entry_radius_mm
        return self.radius_mm if entry is None else entry

    @property
    def all_webs(self) -> Sequence[int]:
        """The webs that it is in."""
        return self.webs or ([] if self.web is None else [self.web])


@record
class LastHoles(Overbalance):
    """Unbalance left on purpose."""

    last_holes: Sequence[Cut]


@record
class BalancedReport(Report):
    """A report of `balance` or `recut`."""

    values: Annotated[Values, UNWRITTEN]
    job: JobEcho
    given: Annotated[Job, Named("job")]
    engine: Engine
    balance_factor: BalanceFactor
    tolerance: Tolerance
    residual: Unbalance
    outcome: Outcome
    corrections: Sequence[Cut] = ()
    inertia_change_g_mm2: KgMm2
    forces: Forces | None = None
    overbalance: LastHoles | None = None
    external: Sequence[ExternalPart] = ()
    oil: Sequence[ThrowOil] = ()
    assembly: Sequence[AssemblyStage] = ()
    relaxations: Sequence[Relaxation] = ()
    notes: Sequence[str] = ()
    warnings: Sequence[str] = ()
    weak_places: Sequence[str] = ()
    web_metal: Sequence[WebMetal] = ()
    of_addons: Annotated[Mapping[str, Any], INLINE]
    staged: Annotated[Staged | None, UNWRITTEN] = None
    serial: str | None = None
    stages: Sequence[Stage] = ()
    input_is_untouched: bool = False
    earlier_corrections: Sequence[Cut] = ()
    written: Annotated[Outputs, Named("outputs")]

    @classmethod
    def read(cls, values: Values) -> Self:
        """Return a report from its JSON values; parts that an earlier version lacks are lacking.

        Raises
        ------
        ValueError
            If a value is of another type; the message begins with its place.
        """
        return changed(decoded(cls, values, partly=True), values=values)

    @property
    def is_above(self) -> bool:
        """Whether the residual is above tolerance."""
        return self.outcome == "above_tolerance"

    @property
    def is_unproven(self) -> bool:
        """Whether a residual that is within tolerance may, with its uncertainty, be above it."""
        return not self.is_above and self.proven is False

    @property
    def shown_outcome(self) -> Outcome:
        """The outcome of the crank: after earlier stages it was not within tolerance from the first."""
        is_later = self.stages and self.outcome == "already_within_tolerance"
        return "within_tolerance" if is_later else self.outcome

    @property
    def outcome_words(self) -> str:
        """The outcome, and whether the uncertainty leaves it unproven."""
        return OUTCOMES[self.shown_outcome] + NOT_PROVEN * self.is_unproven

    @property
    def verdict_class(self) -> str:
        """``good``, ``open`` where the verdict is not proven, or ``bad``."""
        return "bad" if self.is_above else "open" if self.is_unproven else "good"

    @property
    def verdict(self) -> Text:
        """The verdict in two or three sentences."""
        residual, tolerance = self.residual, self.tolerance
        name, share = max(tolerance.shares(residual), key=lambda pair: pair[1])
        where = "" if name == "resultant" else f" (in plane {name})"
        what = "With its uncertainty it" if tolerance.counts_uncertainty else "It"
        amounts = (g_mm(each, ",.2f") for each in (residual.magnitude_g_mm, tolerance.permissible_g_mm))
        limits = f"G {tolerance.grade_mm_s:g} at {number(tolerance.speed_rpm, 0)} rpm"
        return (
            said("The residual unbalance is {}; {} is permitted by ", *amounts)
            + f"{limits}. {what} uses {number(100.0 * share, 1)} % of the permissible unbalance{where}."
            + (" " + self._why_unproven if self.is_unproven else "")
        )

    @property
    def _why_unproven(self) -> str:
        """Why a residual within tolerance is not proven: another reading, or uncertainty."""
        found = self.reason
        return (
            said("Not proven: {}.", found) if found else "With its uncertainty it exceeds that: not proven."
        )

    @property
    def file_name(self) -> str:
        """Name of the crank's file, without its folder."""
        return without_folder(self.input.file)

    @property
    def part_name(self) -> str:
        """The part's name in the job, else that of the crank's original file, of the first stage."""
        if self.given.job.part:
            return self.given.job.part
        first = self.given.crankshaft.file if self.stages else None
        return without_folder(first or self.input.file)

    def oil_on_crankpin_g(self, throw: int) -> float:
        """Return the oil that is part of a throw's bob-weight [g]; 0 without oil."""
        return sum(each.on_crankpin_g for each in self.oil if each.throw == throw)


def without_folder(file: str | None) -> str:
    """Return the name of a file without its folder, on any system."""
    return str(file).replace("\\", "/").rpartition("/")[2]
