"""``parts``: the weights of a job rolled up, and its bob-weights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from autobalance import job as jobs
from autobalance.balancing import plausibility
from autobalance.declare import ABSENT, Absent
from autobalance.engines.parts.answer import PartsReport, RodEnds, ThrowWeights
from autobalance.errors import JobError
from autobalance.job import Job, JobSource
from autobalance.job.model import ThrowParts, Weight
from autobalance.report.plots import Drawn, Plots
from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.parts import PartWeight, RolledUp, Sum, rolled_up, sum_of_parts
from autobalance.runtime import Progress
from autobalance.value_classes import dataclass
from autobalance.verbs.crank_job import OPEN
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import job_keys, request
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.verbs.crank import Crank


@dataclass(frozen=True, eq=False, repr=False)
class PartsResult(VerbResult):
    """Weights of a job, with their uncertainty."""

    content: PartsReport

    def text(self, units: str = "metric") -> str:
        """Return tables of weights and bob-weights."""
        from autobalance.engines.parts.text import parts_text
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
