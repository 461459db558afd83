"""Findings of a run, before they are written down; put together by the commands, computed elsewhere."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np

from autobalance.balancing.facet_correction import FacetCorrection
from autobalance.declare import ABSENT, SHARE, Absent, NotNegative, Ordinal, Pair, Sha256, record
from autobalance.quantities import g_mm, mm, said
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Share
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.balancing.external import CarriedUnbalance
    from autobalance.balancing.kept import KeptPlan
    from autobalance.balancing.loop import Result
    from autobalance.balancing.scan_calibration import Calibration
    from autobalance.balancing.section_rows import SectionTable
    from autobalance.balancing.suggestions.wanted import Aim, Refused, Suggestion
    from autobalance.balancing.web_metal import WebMetal
    from autobalance.correction.contract import Correction
    from autobalance.crank.against import Against
    from autobalance.crank.anatomy import Anatomy, Face
    from autobalance.crank.sections import Section, WebWeight
    from autobalance.job.model import ThrowOil
    from autobalance.rigid_rotor.staged_assembly import AssemblyStage
    from autobalance.rigid_rotor.tolerance import Tolerance
    from autobalance.rigid_rotor.unbalance import Moments, Unbalance
    from autobalance.running_gear.roll import ShakingForce


@record
class CrankFile:
    """A file that holds a crank, as it was read."""

    file: Annotated[str | None, "null: made in memory"]
    sha256: Sha256
    format: str | None
    triangles: Ordinal
    bodies: Ordinal
    repairs: Sequence[str]


@record
class Input(CrankFile):
    """The crank file."""

    scan: Annotated[CrankFile, "whose mass and unbalance count, where the drawing is cut"] | Absent = ABSENT


@record
class HiddenMetal:
    """Metal between facets and true surfaces."""

    mass_g: float
    unbalance_g_mm: Pair
    moment_g_mm2: Pair
    polar_inertia_kg_mm2: float

    @classmethod
    def of(cls, moments: Moments) -> Self:
        """Return hidden metal of moments in the rotor frame."""
        return cls(
            mass_g=moments.mass_g,
            unbalance_g_mm=moments.first_g_mm[:2],
            moment_g_mm2=moments.second_g_mm2[:2, 2],
            polar_inertia_kg_mm2=moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        )


@record
class HiddenMetalAdded:
    """Hidden metal added to the moments before and after the cut."""

    before: HiddenMetal
    after: HiddenMetal


@record
class TooCoarse:
    """Factor by which the mesh would have to be finer."""

    finer: NotNegative
    needed_sag_mm: NotNegative
    text: str


@record
class FacetError:
    """Metal between facets and true surfaces, with its error bar: excess of mass, magnitude of unbalance.

    ``sag_mm`` is the largest chord height. ``correction`` is whether the estimate was added to the measured
    moments (None: not requested); ``reason`` is why not or not all of it.
    """

    mass_g: float
    unbalance_g_mm: float
    mass_bar_g: NotNegative = 0.0
    unbalance_bar_g_mm: NotNegative = 0.0
    sag_mm: NotNegative = 0.0
    correction: Literal["applied", "mass_only", "declined", "not_needed"] | None = None
    reason: str | None = None
    added: HiddenMetalAdded | None = None
    too_coarse: TooCoarse | None = None


@dataclass(frozen=True, eq=False)
class MeasuredCrank:
    """The crank before correction, in the rotor frame; ``mass_pm_g`` (95 %) for a scanned one."""

    moments: Moments
    volume_mm3: float
    anatomy: Anatomy
    facet_error: FacetError | None = None
    calibration: Calibration | None = None
    mass_pm_g: float | None = None


@dataclass(frozen=True)
class Counterweight:
    """Counterweight of a crank of one throw: m_cw, and its product with r′ before, wanted and after."""

    mass_g: float
    initial_g_mm: float
    target_g_mm: float
    final_g_mm: float


@dataclass(frozen=True)
class BobWeights:
    """Sums of the parts of one throw [g], and the bob-weight on each throw.

    ``fit_g`` are the weights to clamp on where the crank is spun, without a crankpin that is not in the file.
    All bob-weights off by ``tolerance_g`` at once use a tenth of the permissible value.
    """

    rotating_g: float
    reciprocating_g: float
    crankpin_g: float
    bob_weights_g: Mapping[int, float]
    fit_g: Mapping[int, float]
    tolerance_g: float


@record
class BalanceFactor:
    """Before, wanted, after; null if the crank has no factor."""

    initial: float | None
    target: Annotated[float, SHARE]
    final: float | None


@dataclass(frozen=True, eq=False)
class FaceOffer:
    """A face that a correction can use: change of the unbalance per millimetre, and how deep it may go."""

    face: Face
    unbalance_per_mm_g_mm: Array
    max_depth_mm: float | None


@dataclass(frozen=True, eq=False)
class Overbalance:
    """Unbalance left on purpose for final drilling, and where the last holes belong; not cut yet.

    ``predicted`` is the residual unbalance with them, as judged without the allowance. ``reason`` explains a
    missing or insufficient list.
    """

    unbalance: Unbalance
    holes: tuple[Correction, ...]
    predicted: Unbalance | None
    reason: str | None


@dataclass(frozen=True, eq=False)
class Forces:
    """Shaking forces before and after, at top speed; without a rod length the first order only."""

    before: ShakingForce
    after: ShakingForce


@dataclass(frozen=True, eq=False)
class Balanced:
    """Findings of a balancing run only.

    ``faces`` are those that corrections name. ``forces`` are None if the job lacks a cylinder's direction.
    ``sections`` are the records of add-ons by their key in the report. ``job_set`` are the keys of the job
    that were set from outside, as given. ``kept`` is the earlier plan whose cuts were kept, if any.
    """

    job: Mapping[str, Any]
    counterweight: Counterweight | None
    loads: BobWeights
    factor: BalanceFactor
    tolerance: Tolerance
    result: Result
    overbalance: Overbalance | None = None
    forces: Forces | None = None
    external: tuple[CarriedUnbalance, ...] = ()
    oil: Mapping[int, ThrowOil] = field(default_factory=dict)
    job_set: tuple[str, ...] = ()
    assembly: tuple[AssemblyStage, ...] = ()
    faces: tuple[Face, ...] = ()
    kept: KeptPlan | None = None
    web_metal: tuple[WebMetal, ...] = ()
    sections: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class TrueSurfaces:
    """Faces of a solid by kind, and their excess of moments over triangles laid over them."""

    faces: Mapping[str, int]
    hidden: Moments


@dataclass(frozen=True, eq=False)
class Record:
    """Content of a report.

    ``initial`` is the bare crank's unbalance for ``inspect``, as judged for ``balance``. ``planes_z_mm`` are
    the places of planes A and B, or None. ``outputs`` has one entry a written file. ``warnings`` has one line
    each for the user about the job and the crank. ``surfaces`` are the crank's as read, if its file keeps
    true ones. ``staged`` is the content of a stage after the first alone; its corrections are numbered from
    ``cuts_before`` on. ``section_table`` has the plane [mm] that its moments are about. ``loaded`` is the
    crank with all parts that a job attaches to it, ``present`` its balance
    factor then. ``suggested`` is an aim with the suggestions that reach it and the refused ones.
    """

    command: Literal["balance", "inspect", "recut"]
    input: Input
    crank: MeasuredCrank
    initial: Unbalance
    planes_z_mm: tuple[float, float] | None
    faces: tuple[FaceOffer, ...] | None = None
    sections: tuple[Section, ...] | None = None
    web_weights: tuple[WebWeight, ...] | None = None
    balanced: Balanced | None = None
    warnings: tuple[str, ...] = ()
    outputs: Mapping[str, Any] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    surfaces: TrueSurfaces | None = None
    staged: Any = None
    cuts_before: int = 0
    job_set: tuple[str, ...] = ()
    section_table: tuple[SectionTable, float] | None = None
    loaded: SectionTable | None = None
    present: float | Absent | None = ABSENT
    suggested: tuple[Aim, Sequence[Suggestion], Sequence[Refused]] | None = None
    against: Against | None = None


# The report's entry on a mesh's facets, and the fineness that a grade needs of them.


MAX_DOUBT = 1.0 / 3.0
"""Share of a permissible value that facets may put in doubt before a mesh is too coarse for the grade."""


def facet_entry(
    facets: ChordalError | None,
    correction: FacetCorrection,
    finer: TooCoarse | None = None,
    after: Moments | None = None,
) -> FacetError | None:
    """Return the report's entry on the facets; ``after`` is the correction of the cut crank."""
    if facets is None:
        return None
    added = None
    if correction.mass:
        before = correction.part(facets.missing)
        left = before if after is None else after
        added = HiddenMetalAdded(before=HiddenMetal.of(before), after=HiddenMetal.of(left))
    return FacetError(
        mass_g=facets.missing.mass_g,
        unbalance_g_mm=facets.unbalance_g_mm,
        mass_bar_g=facets.mass_bar_g,
        unbalance_bar_g_mm=facets.unbalance_bar_g_mm,
        sag_mm=facets.sag_mm,
        correction=correction.verdict,
        reason=correction.reason,
        added=added,
        too_coarse=finer,
    )


def needed(facets: ChordalError, tolerance: Tolerance, share: Share) -> TooCoarse | None:
    """Return the fineness that a tolerance needs of the facets; None where they are fine enough.

    Their error falls as the square of their number around a circle, as does their chord height.
    """
    used = [share.resultant_g_mm / tolerance.permissible_g_mm]
    if tolerance.judge == "dynamic":
        planes = zip(share.planes_g_mm, tolerance.planes, strict=True)
        used += [hidden / plane.permissible_g_mm for hidden, plane in planes]
    place = int(np.argmax(used))
    if used[place] <= MAX_DOUBT:
        return None
    finer = math.sqrt(used[place] / MAX_DOUBT)
    names = ["the resultant", *(f"plane {plane.name}" for plane in tolerance.planes)]
    hidden = (share.resultant_g_mm, *share.planes_g_mm)[place]
    permitted = hidden / used[place]
    sag = facets.sag_mm / finer**2
    chord = (
        said(
            "a chord height of {} at most (now {}), ",
            mm(_two_digits(sag, math.floor), "g"),
            mm(facets.sag_mm, ".2g"),
        )
        if sag > 0.0
        else ""
    )
    text = said(
        "the mesh is too coarse for G {}: its facets put {} of {} in doubt, of {} permitted; "
        "a third of that needs {}{} times as many facets around a circle, or the crank as STEP",
        f"{tolerance.grade_mm_s:g}",
        g_mm(hidden, ".2f"),
        names[place],
        g_mm(permitted, ".2f"),
        chord,
        f"{_two_digits(finer, math.ceil):g}",
    )
    return TooCoarse(finer=finer, needed_sag_mm=sag, text=text)


def _two_digits(value: float, rounded: Callable[[float], int]) -> float:
    """Return a value to two digits, ``rounded`` down or up."""
    place = 1 - math.floor(math.log10(value))
    return round(rounded(round(value * 10.0**place, 6)) / 10.0**place, max(place, 0))
