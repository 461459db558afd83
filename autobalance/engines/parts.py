"""``ab.parts``: the weights of a job rolled up, and its bob-weights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Literal

from autobalance import job as jobs
from autobalance.balancing import plausibility
from autobalance.declare import ABSENT, Absent, Count, KgMm2, NotNegative, Ordinal, record
from autobalance.errors import JobError
from autobalance.job import Job, JobSource
from autobalance.job.model import ThrowParts, Weight
from autobalance.report.display_units import DisplayUnits
from autobalance.report.files import from_here
from autobalance.report.plots import Drawn, Plots
from autobalance.report.records.answers import JobReport
from autobalance.report.tables import table
from autobalance.running_gear.conrod import ConnectingRod, TwoMasses
from autobalance.running_gear.parts import PartWeight, RolledUp, Sum, rolled_up, sum_of_parts
from autobalance.runtime import Progress
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.value_classes import dataclass
from autobalance.verbs.crank_job import OPEN
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import job_keys, request
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.verbs.crank import Crank


# The report of `parts`.


@record
class ThrowWeights:
    """The weights on a throw; number None: on every throw without separate weights."""

    number: Ordinal | None
    rods: Count
    rotating: RolledUp
    reciprocating: RolledUp
    crankpin: RolledUp
    balance_factor: float | None
    bob_weight_g: float | None
    bob_weight_pm_g: NotNegative | None
    bob_weight_pin_fitted_g: float | None


@dataclass(frozen=True)
class RodEnds(TwoMasses):
    """A connecting rod as two masses, and what these miss of its inertia."""

    couple_inertia_g_mm2: KgMm2 | None


@record
class PartsReport(JobReport):
    """The weights of a job rolled up, and its bob-weights."""

    command: Literal["parts"] = "parts"
    present: (
        Annotated[float | None, "balance factor of the crank as it is; null: its throws cancel"] | Absent
    ) = ABSENT
    throws: Sequence[ThrowWeights]
    rod: RodEnds | None
    warnings: Sequence[str]


# Weights of parts as lines to read.


def parts_text(report: PartsReport, units: DisplayUnits) -> str:
    """Return the roll-up of the parts and the bob-weights."""
    blocks: list[str] = [from_here(report.job["file"])]
    for throw in report.throws:
        rows = [("Throw" if throw.number is None else f"Throw {throw.number}", "weight", "may be off by")]
        for weights, title in (
            (throw.rotating, "rotating, one rod"),
            (throw.reciprocating, "reciprocating, one rod"),
            (throw.crankpin, "on the crankpin"),
        ):
            rows += [
                (f"    {part.name}", units.of_mass(part.mass_g), _off(part.pm_g, units))
                for part in weights.parts
            ]
            rows.append((f"  {title}", units.of_mass(weights.mass_g), _off(weights.pm_g, units)))
        blocks.append(table(rows))
        blocks.append(_bob_weight_text(throw, units))
    if report.present is not ABSENT:
        blocks.append(_present(report.present))
    if report.rod is not None:
        blocks.append(_rod_text(report.rod, units))
    return "\n".join(blocks)


def _bob_weight_text(throw: ThrowWeights, units: DisplayUnits) -> str:
    rods = f"  {throw.rods} rod{'s' * (throw.rods != 1)}"
    if throw.bob_weight_g is None or throw.balance_factor is None:
        return f"{rods}; no bob-weight without a balance factor"
    pin_fitted = throw.bob_weight_pin_fitted_g
    fitted = ""
    if pin_fitted is not None and pin_fitted != throw.bob_weight_g:
        fitted = f"; with the crankpin fitted {units.of_mass(pin_fitted)}"
    return (
        f"{rods}; bob-weight at {throw.balance_factor:.4f}: {units.of_mass(throw.bob_weight_g)}"
        f"{_plus_minus(throw.bob_weight_pm_g or 0.0, units)}{fitted}"
    )


def _present(factor: float | None) -> str:
    if factor is None:
        return "The throws cancel: the crank has no balance factor."
    return f"Balance factor of the crank as it is, with these parts: {factor:.4f}"


def _off(pm_g: float, units: DisplayUnits) -> str:
    return f"± {units.of_mass(pm_g)}" if pm_g else ""


def _rod_text(rod: RodEnds, units: DisplayUnits) -> str:
    lines = [
        f"Bare rod: {units.of_mass(rod.big_end_g)} at the big end,"
        f" {units.of_mass(rod.small_end_g)} at the small end"
    ]
    if rod.centre_from_big_end_mm is not None:
        lines.append(f"  centre of mass {units.of_length(rod.centre_from_big_end_mm)} from the big end")
    if rod.couple_inertia_g_mm2 is not None:
        lines.append(
            f"  its two masses miss {rod.couple_inertia_g_mm2 / G_MM2_PER_KG_MM2:.1f} kg·mm² of inertia:"
            " the bearing loads count the couple"
        )
    return "\n".join(lines)


def _plus_minus(pm_g: float, units: DisplayUnits) -> str:
    """Return an uncertainty with its sign, or that none is stated."""
    return f" ± {units.of_mass(pm_g)}" if pm_g else ", uncertainty not stated"


# The public function.


@dataclass(frozen=True, eq=False, repr=False)
class PartsResult(VerbResult):
    """Weights of a job, with their uncertainty."""

    content: PartsReport

    def text(self, units: str = "metric") -> str:
        """Return tables of weights and bob-weights."""
        from autobalance.report.display_units import ON_SCREEN

        return parts_text(self.content, ON_SCREEN[units])

    def plots(self) -> Plots:
        """Return bars of the weights on each throw."""
        return Plots(_plots(self.content.throws))


@documented
def parts(job: JobSource, crank: Crank | None = None, *, progress: Progress | None = None) -> PartsResult:
    """Roll up the weights of a job: rotating, reciprocating, bob-weights, with their uncertainty.

    Parameters
    ----------
    job : Job, path or dict
        Job file; its crank is read only if its factor is "original" or left open.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job, or the crank where it is needed.

    Examples
    --------
    >>> from autobalance.bundled import bundled_folder
    >>> rolled = parts(bundled_folder() / "crf250r" / "drafted" / "factor-0.28.toml")
    >>> round(rolled.report["throws"][0]["bob_weight_g"], 2)
    321.91
    """
    job = jobs.as_job(job, may_lack=OPEN["parts"])
    factor = None if "balance.factor" in job.lacks else job.balance.factor
    if factor is None:
        case = request(job, crank, progress=progress)
        factor = case.present if case.target is None else case.target
        present: float | Absent | None = case.present
        odd = case.warnings
    else:
        present, odd = ABSENT, plausibility.odd_alone(job)
    throws = [(None, job.engine.default), *sorted(job.engine.by_throw.items())]
    return PartsResult(
        PartsReport(
            **job_keys(job),
            present=present,
            throws=[_throw(number, parts, factor) for number, parts in throws],
            rod=_rod(job),
            warnings=odd,
        )
    )


def _plots(throws: Sequence[ThrowWeights]) -> Drawn:
    from autobalance.report import plots

    named = {
        f"throw {each.number}" if each.number else "every throw": (
            each.rotating,
            each.reciprocating,
            each.crankpin,
        )
        for each in throws
    }
    return {
        "parts-weights": plots.named_bars(
            "Weights on a throw",
            ("motion of the parts [-]", "mass [g]"),
            ["rotating,\neach rod", "reciprocating,\neach rod", "crankpin"],
            {name: [each.mass_g for each in roles] for name, roles in named.items()},
            {name: [each.pm_g for each in roles] for name, roles in named.items()},
        )
    }


def _throw(number: int | None, parts: ThrowParts, factor: float | None) -> ThrowWeights:
    weights = parts.weights
    bob = None if factor is None else _bob_weight(parts, factor)
    pin = weights.crankpin.get("crankpin")
    return ThrowWeights(
        number=number,
        rods=parts.rods,
        rotating=_rolled_up(weights.rotating),
        reciprocating=_rolled_up(weights.reciprocating),
        crankpin=_rolled_up(weights.crankpin),
        balance_factor=factor,
        bob_weight_g=None if bob is None else bob.mass_g,
        bob_weight_pm_g=None if bob is None else bob.pm_g,
        bob_weight_pin_fitted_g=None
        if bob is None
        else bob.mass_g - (pin.mass_g if pin is not None else 0.0),
    )


def _bob_weight(parts: ThrowParts, factor: float) -> Sum:
    """Return the bob-weight of a throw, with its uncertainty."""
    weights = parts.weights
    shares = [
        (1.0, weights.crankpin),
        (parts.rods, weights.rotating),
        (factor * parts.rods, weights.reciprocating),
    ]
    scaled = [(share, weight) for share, named in shares for weight in named.values()]
    return sum_of_parts(
        [share * weight.mass_g for share, weight in scaled], [share * weight.pm_g for share, weight in scaled]
    )


def _rolled_up(named: Mapping[str, Weight]) -> RolledUp:
    return rolled_up([PartWeight(name, each.mass_g, each.pm_g) for name, each in named.items()])


def _rod(job: Job) -> RodEnds | None:
    ends, length = job.engine.rod, job.engine.rod_length_mm
    if ends is None:
        return None
    try:
        rod = ConnectingRod.from_two_scales(
            ends.big_end_g, ends.small_end_g, length or 1.0, ends.inertia_g_mm2
        )
    except ValueError as error:
        raise JobError(f"{job.path.name}: engine.rod: {error}") from None
    known = length is not None
    couple = known and ends.inertia_g_mm2 is not None
    return RodEnds(
        rod.mass_g,
        rod.big_end_g,
        rod.small_end_g,
        rod.centre_from_big_end_mm if known else None,
        rod.couple_inertia_g_mm2 if couple else None,
    )
