"""The uncertain quantities of a job, as draws with what each changes of the planned crank."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.correction import KINDS
from autobalance.errors import JobError
from autobalance.job import PartWeights, Weight
from autobalance.job.model import Distribution
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.studies.study.input import study_options
from autobalance.studies.study.plan import StudyPlan
from autobalance.studies.study.statistics import Draw, axis_effect, effect_of, shift_effect, turn_effect
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass

TABLES = ("rotating", "reciprocating", "crankpin")
DENSITY, DEPTH = "crankshaft.density_kg_m3", "correction.depth"
POSITION, WANDER, JOURNAL = "study.position", "study.wander", "study.journal"
WHERE_TO_STATE = (
    "a weight's pm ({ g = 158.0, pm = 0.5 }), crankshaft.density_pm_kg_m3, engine.attached pm_g_mm, "
    "correction.depth_tolerance_mm, study.position_pm_mm, study.wander_pm_deg, study.journal_pm_mm, "
    "study.measurement"
)


@dataclass(frozen=True, eq=False)
class Causes:
    """The draws of a plan, and what some change of the target factor and of D = Σ m_rec r e.

    ``factor_rates`` and ``direction_rates`` are by label: per unit, and (2,) [g·mm per unit].
    """

    draws: tuple[Draw, ...]
    factor_rates: Mapping[str, float]
    direction_rates: Mapping[str, Array]


def causes_of(plan: StudyPlan) -> Causes:
    """Return the causes of uncertainty of cranks made to a plan.

    Raises
    ------
    JobError
        If nothing is.
    """
    collected = _CollectedDraws(plan)
    collected.weights()
    collected.original_weights()
    collected.density()
    collected.attached()
    collected.depths()
    collected.holes()
    collected.journals()
    collected.measurement()
    if not collected.draws:
        raise JobError(
            f"{plan.job.path.name}: nothing is uncertain, every ± is 0;"
            f" these keys may say one: {WHERE_TO_STATE}"
        )
    return Causes(tuple(collected.draws), collected.factor_rates, collected.direction_rates)


class _CollectedDraws:
    """Draws as they are found."""

    def __init__(self, plan: StudyPlan) -> None:
        self.plan, self.job, self.anatomy = plan, plan.job, plan.crank.anatomy
        self.options = study_options(plan.job)
        self.draws: list[Draw] = []
        self.factor_rates: dict[str, float] = {}
        self.direction_rates: dict[str, Array] = {}
        self._per_factor = effect_of(plan.rotor.loads_per_factor)

    @property
    def _original(self) -> bool:
        return self.job.balance.factor is None

    def _add(self, draw: Draw, factor_rate: float = 0.0) -> None:
        if factor_rate:
            self.factor_rates[draw.label] = factor_rate
            draw = replace(draw, effect=draw.effect + factor_rate * self._per_factor)
        self.draws.append(draw)

    def weights(self) -> None:
        """Add the parts on the throws, one draw a throw."""
        uncertain: dict[str, list[tuple[int, str, Weight]]] = {}
        for throw in self.anatomy.throws:
            weights = self.job.engine.of_throw(throw.number).weights
            for table in TABLES:
                for name, weight in getattr(weights, table).items():
                    if weight.pm_g > 0.0:
                        uncertain.setdefault(f"engine.{table}_g.{name}", []).append(
                            (throw.number, table, weight)
                        )
        for cause, rows in uncertain.items():
            for number, table, weight in rows:
                label = cause if len(rows) == 1 else f"{cause}[throw {number}]"
                self._weight(cause, label, number, table, weight)

    def _weight(self, cause: str, label: str, number: int, table: str, weight: Weight) -> None:
        throw = self.anatomy.throws[number - 1]
        rods = 1 if table == "crankpin" else self.job.engine.of_throw(number).rods
        share = self.plan.rotor.factor if table == "reciprocating" else 1.0
        effect = effect_of(Moments.point(rods * share, throw.crankpin.centre_mm))
        if table == "reciprocating":
            self.direction_rates[label] = rods * throw.crankpin.centre_mm[:2]
        self._add(
            Draw(cause, label, "g", weight.pm_g, self._distribution(weight), effect[None], weight.mass_g)
        )

    def _distribution(self, weight: Weight) -> Distribution:
        return weight.distribution or self.options.distribution

    def original_weights(self) -> None:
        """Add the parts that the crank was balanced for, where they make the target factor."""
        original = self.job.original
        if not self._original or original is None:
            return
        for table in TABLES:
            for name, weight in getattr(original, table).items():
                if weight.pm_g > 0.0:
                    label = f"original.{table}_g.{name}"
                    heavy, light = (
                        self.original_factor(self.plan.crank.moments, heavier(original, table, name, off))
                        for off in (weight.pm_g, -min(weight.pm_g, weight.mass_g))
                    )
                    rate = (heavy - light) / (weight.pm_g + min(weight.pm_g, weight.mass_g))
                    distribution = self._distribution(weight)
                    draw = Draw(label, label, "g", weight.pm_g, distribution, np.zeros((1, 4)), weight.mass_g)
                    self._add(draw, rate)

    def original_factor(self, crank: Moments, weights: PartWeights | None) -> float:
        """Return the factor of an untouched crank with its original parts."""
        loads = rotor_from_job.throw_loads(self.anatomy, self.job.engine, weights)
        attached = rotor_from_job.beside_throws(self.job.engine)
        factor = rotor_from_job.crank_factor(crank, loads, attached)
        assert factor is not None  # the plan's was found from the same
        return factor

    def density(self) -> None:
        """Add the density of all metal, which with ``original`` moves the target too."""
        pm = self.job.crankshaft.density_pm_g_mm3
        if not pm:
            return
        nominal = self.job.crankshaft.density_g_mm3 / G_PER_MM3_PER_KG_M3
        effect = effect_of(self.plan.metal.scaled(1.0 / nominal))
        draw = Draw(
            DENSITY,
            DENSITY,
            "kg/m³",
            pm / G_PER_MM3_PER_KG_M3,
            self.options.distribution,
            effect[None],
            nominal,
        )
        rate = 0.0
        if self._original:
            crank = self.plan.crank.moments
            heavier_crank = crank + crank.scaled(1.0 / nominal)
            rate = self.original_factor(heavier_crank, self.job.original) - self.original_factor(
                crank, self.job.original
            )
        self._add(draw, rate)

    def attached(self) -> None:
        """Add the unbalance of attached parts, each a vector at its place."""
        for part in self.job.engine.attached:
            if part.pm_g_mm > 0.0:
                label = f"engine.attached.{part.name}"
                effect = np.stack(
                    [
                        effect_of(rotor_from_job.unbalance_at(unit, part.z_mm))
                        for unit in ((1.0, 0.0), (0.0, 1.0))
                    ]
                )
                self._add(Draw(label, label, "g·mm", part.pm_g_mm, self.options.distribution, effect))

    def depths(self) -> None:
        """Add the depth of each cut."""
        pm = self.job.depth_tolerance_mm
        cuts = [
            (number, cut)
            for number, cut in enumerate(self.plan.result.corrections, 1)
            if cut.rate is not None and effect_of(cut.rate).any()
        ]
        for number, cut in cuts if pm else ():
            assert pm is not None
            assert cut.rate is not None
            label = DEPTH if len(cuts) == 1 else f"{DEPTH}[cut {number}]"
            effect = effect_of(cut.rate)[None]
            self._add(Draw(DEPTH, label, "mm", pm, self.options.distribution, effect, cut.depth_mm))

    def holes(self) -> None:
        """Add the place of each hole or slug, and the wander of each drill."""
        options = self.options
        holes = [cut for cut in self.plan.result.corrections if KINDS[cut.kind].has_axis]
        for number, hole in enumerate(holes, 1):
            axes = square_to(np.asarray(hole.details["inward"]))
            where = "" if len(holes) == 1 else f"[hole {number}]"
            if options.position_pm_mm > 0.0:
                self._add(
                    Draw(
                        POSITION,
                        f"{POSITION}{where}",
                        "mm",
                        options.position_pm_mm,
                        options.distribution,
                        shift_effect(hole.change, axes),
                        axes=("u", "v"),
                    )
                )
            if options.wander_pm_deg > 0.0:
                turned = turn_effect(hole.change, hole.position_mm, axes) * math.radians(1.0)
                self._add(
                    Draw(
                        WANDER,
                        f"{WANDER}{where}",
                        "deg",
                        options.wander_pm_deg,
                        options.distribution,
                        turned,
                        axes=("u", "v"),
                    )
                )

    def journals(self) -> None:
        """Add the offset from the axis of each of the outermost main journals."""
        options, journals = self.options, self.anatomy.main_journals
        if not options.journal_pm_mm > 0.0:
            return
        if len(journals) < 2:
            raise JobError(
                f"{self.job.path.name}: study.journal_pm_mm needs two main journals, found {len(journals)}"
            )
        places = float(journals[0].centre_mm[2]), float(journals[-1].centre_mm[2])
        body = turning_about_the_axis(self.plan)
        for at, journal in enumerate((journals[0], journals[-1])):
            label = f"{JOURNAL}[journal {journal.number}]"
            effect = axis_effect(body, places, at)
            self._add(Draw(JOURNAL, label, "mm", options.journal_pm_mm, options.distribution, effect))

    def measurement(self) -> None:
        """Add facets, rounding and axis of the error budget, as vectors where the crank's mass centre is."""
        budget = self.plan.result.doubt
        if not self.options.measurement or budget is None:
            return
        z = float(self.plan.crank.moments.centre_mm[2])
        effect = np.stack(
            [effect_of(rotor_from_job.unbalance_at(unit, z)) for unit in ((1.0, 0.0), (0.0, 1.0))]
        )
        for name in ("facets", "rounding", "axis"):
            pm = budget.shares[name].resultant_g_mm
            if pm > 0.0:
                label = f"study.{name}"
                self._add(Draw(label, label, "g·mm", pm, self.options.distribution, effect))


def turning_about_the_axis(plan: StudyPlan) -> Moments:
    """Return the crank, its slugs and its bob-weights: what goes with the journals."""
    loads = rotor_from_job.throw_loads(plan.crank.anatomy, plan.job.engine)
    return plan.crank_and_slugs + bob_weight_moments(loads, plan.rotor.factor)


def heavier(weights: PartWeights, table: str, name: str, by_g: float) -> PartWeights:
    """Return weights with one part heavier."""
    named = getattr(weights, table)
    part = replace(named[name], mass_g=named[name].mass_g + by_g)
    return replace(weights, **{table: {**named, name: part}})


def square_to(direction: Array) -> Array:
    """Return two unit vectors (2, 3) square to a direction and to each other: the first is square to z too.

    Along z they are x and y.
    """
    across = np.cross([0.0, 0.0, 1.0], direction)
    length = float(np.linalg.norm(across))
    if length < 1e-9:
        return np.eye(3)[:2]
    first = across / length
    return np.stack([first, np.cross(direction, first)])
