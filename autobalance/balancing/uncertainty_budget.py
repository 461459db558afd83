"""Error budget of a run: the uncertainty from a file, a job and its cuts, cause by cause."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.balancing.facet_correction import FacetCorrection
from autobalance.balancing.measured import ScanShare
from autobalance.correction.contract import Correction
from autobalance.crank.anatomy import Anatomy
from autobalance.job import EngineParts, Job, PartWeights
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import (
    Budget,
    Moments,
    Share,
    along_the_axis,
    displacement_share,
    facets_beside_skin,
    facets_share,
    root_sum,
    rounding_share,
)
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import Source
from autobalance.solid.formats.registry import format_named
from autobalance.value_classes import dataclass

TABLES = ("rotating", "reciprocating", "crankpin")


@dataclass(frozen=True, eq=False)
class UncertaintyBudget:
    """Inputs to the error budget of a run.

    Attributes
    ----------
    job : Job
    anatomy : Anatomy
        Its throws and its ``journal_misalignment_mm``.
    crank : Moments
        The bare crank before correction, rotor frame.
    tolerance : Tolerance
        Where the planes are.
    factor : float
        The balance factor requested.
    facets : ChordalError
    spacing_mm : float
        Between two numbers that the file can distinguish, at the far end of the crank.
    scan : ScanShare or None
        Uncertainty from noise, the scanner and the fitted axis, of a scanned crank.
    calibrated : bool
        Whether ``crank`` includes the metal that its facets hide, by a scale or a micrometer.
    """

    job: Job
    anatomy: Anatomy
    crank: Moments
    tolerance: Tolerance
    factor: float
    facets: ChordalError
    spacing_mm: float
    scan: ScanShare | None = None
    calibrated: bool = False

    def budget(
        self, bare: Moments, corrections: Sequence[Correction] = (), left: Solid | None = None
    ) -> Budget:
        """Return the uncertainty of the unbalance with the crank's moments ``bare`` (rotor frame).

        ``left`` is the cut solid; None: nothing was cut, or it is only planned.
        """
        rates = [cut.rate for cut in corrections if cut.rate is not None]
        facets = None if left is None else self.facets.left(left.mesh.vertices)
        return self.with_depth_rates(bare, rates, facets)

    def with_depth_rates(
        self, bare: Moments, rates: Sequence[Moments], left: ChordalError | None = None
    ) -> Budget:
        """Return the same budget, from each cut's change per millimetre of depth.

        ``left`` is the chordal error of the cut solid: where throws cancel each other out, as an
        inline-four's do, the metal cut off lacked more than all of the crank together.
        """
        places = self.tolerance.places_mm
        facets = self.facets if left is None else left
        bar, (mean, mean_square) = facets.scatter_g_mm, facets.bar_at_mm
        deeper = self.job.depth_tolerance_mm or 0.0
        estimate = FacetCorrection.of(self.facets, self.job.balance.facet_correction)
        corrected = estimate.unbalance or self.calibrated
        of_facets = facets_share(
            self._carried(facets.missing),
            along_the_axis(bar, bar * mean, bar * mean_square),
            corrected,
            places,
            facets.bar_share,
        )
        scanned = {} if self.scan is None else {"scan": self.scan.after(rates)}
        if self.scan is not None and self.scan.scan is not None and not corrected:
            of_facets = facets_beside_skin(of_facets, scanned["scan"])
        elif self.calibrated:  # the metal added is that of the untouched crank
            of_facets = of_facets + Share.of(self.facets.missing - facets.missing, places)
        off = self.job.crankshaft.density_pm_g_mm3 or 0.0
        share = off / self.job.crankshaft.density_g_mm3
        return Budget(
            {
                "facets": of_facets,
                "rounding": rounding_share(self.crank, self.spacing_mm, places),
                **scanned,
                "axis": displacement_share(self.crank, self.anatomy.journal_misalignment_mm, places),
                "density": Share.of(
                    bare.scaled(share) + self._factor_moved(self.crank.scaled(share)), places
                ),
                "weights": root_sum([Share.of(change, places) for change in self._weights()], places),
                "attached": root_sum([Share.of(change, places) for change in self._attached()], places),
                "depth": root_sum([Share.of(rate.scaled(deeper), places) for rate in rates], places),
            },
            places,
            unstated(self.job, scanned=self.scan is not None),
        )

    # --- effect of a change on the residual -----------------------------------------------------------------

    def _carried(self, change: Moments) -> Moments:
        """Return a change of the crank with the change of the bob-weights that follows from it."""
        return change + self._factor_moved(change)

    def _factor_moved(self, change: Moments) -> Moments:
        """Return the change of the bob-weights by one of the crank: with ``"original"`` the factor moves."""
        if self.job.balance.factor is not None:
            return Moments.zero()
        return self._by_factor(self._original_factor(self.crank + change) - self._original_factor(self.crank))

    def _by_factor(self, change: float) -> Moments:
        loads = rotor_from_job.throw_loads(self.anatomy, self.job.engine)
        return (bob_weight_moments(loads, 1.0) - bob_weight_moments(loads, 0.0)).scaled(change)

    def _original_factor(self, crank: Moments, weights: PartWeights | None = None) -> float:
        loads = rotor_from_job.throw_loads(self.anatomy, self.job.engine, weights or self.job.original)
        original = rotor_from_job.crank_factor(crank, loads, rotor_from_job.beside_throws(self.job.engine))
        assert original is not None  # the target factor was found from the same
        return original

    # --- parts ----------------------------------------------------------------------------------------------

    def _weights(self) -> Iterator[Moments]:
        """Yield the effect of the ± of each throw's bob-weight, and of each part of the original ones."""
        pm_g = bob_weight_pm_g(self.job.engine, self.anatomy, self.factor)
        for throw in self.anatomy.throws:
            yield Moments.point(pm_g[throw.number], throw.crankpin.centre_mm)
        if self.job.balance.factor is None and self.job.original is not None:
            for heavier in _each_heavier(self.job.original):
                moved = self._original_factor(self.crank, heavier) - self._original_factor(self.crank)
                yield self._by_factor(moved)

    def _attached(self) -> Iterator[Moments]:
        """Yield the effect of each attached part's ±; its direction does not matter."""
        for part in self.job.engine.attached:
            yield self._carried(rotor_from_job.unbalance_at((part.pm_g_mm, 0.0), part.z_mm))


def spacing_mm(source: Source) -> float:
    """Return the spacing of the numbers that a file can distinguish, at the far end of its solid."""
    reach = float(np.abs(source.solid.bounds).max()) / source.mm_per_unit
    number = np.float64 if source.format is None else format_named(source.format).number
    return max(source.step_mm, float(np.spacing(number(reach))) * source.mm_per_unit)


def unstated(job: Job, scanned: bool = False) -> tuple[str, ...]:
    """Return the causes of uncertainty that a job does not state."""
    weights = [
        weight
        for parts in (job.engine.default, *job.engine.by_throw.values())
        for name in TABLES
        for weight in getattr(parts.weights, name).values()
        if weight.mass_g > 0.0
    ]
    silent = sum(weight.pm_g == 0.0 for weight in weights)
    causes = ["density"] if job.crankshaft.density_pm_g_mm3 is None else []
    if silent:
        causes.append("weights" if silent == len(weights) else "some weights")
    if any(part.pm_g_mm == 0.0 for part in job.engine.attached):
        causes.append("attached")
    if scanned and job.crankshaft.weighed.scan_accuracy_mm is None:
        causes.append("scan accuracy")
    return (*causes, *(["depth"] if job.depth_tolerance_mm is None else []))


def bob_weight_pm_g(engine: EngineParts, anatomy: Anatomy, factor: float) -> dict[int, float]:
    """Return the ± of each throw's bob-weight: its parts' ± added as squares."""
    weight_pm = {}
    for throw in anatomy.throws:
        parts = engine.of_throw(throw.number)
        weights = parts.weights
        scaled = [
            *(weight.pm_g for weight in weights.crankpin.values()),
            *(parts.rods * weight.pm_g for weight in weights.rotating.values()),
            *(parts.rods * factor * weight.pm_g for weight in weights.reciprocating.values()),
        ]
        weight_pm[throw.number] = math.hypot(*scaled)
    return weight_pm


def _each_heavier(weights: PartWeights) -> Iterator[PartWeights]:
    """Yield the weights once for each part with a ±, with that part at its heaviest."""
    for name in TABLES:
        named = getattr(weights, name)
        for part, weight in named.items():
            if weight.pm_g > 0.0:
                heavier = replace(weight, mass_g=weight.mass_g + weight.pm_g)
                yield replace(weights, **{name: {**named, part: heavier}})
