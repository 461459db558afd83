"""The loop: measure, plan, cut, measure again. The only loop of the program."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from autobalance import correction
from autobalance.balancing.measuring import (
    Measure,
    Measured,
    Pass,
    cut_and_measure,
    in_memory,
    made_cuts,
    refuse_sum,
)
from autobalance.balancing.offers import (
    Above,
    BestOffer,
    Offers,
    best_offer,
    why_above,
    why_not_used,
    workpiece,
)
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.balancing.web_metal import taken_of_scan
from autobalance.correction import Limits, remarks
from autobalance.correction.contract import Correction, Cut, Prefer
from autobalance.correction.faces.patches import heavy_vector
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.overlap import Overlap, taken_in_turn
from autobalance.correction.registry import setup_order
from autobalance.crank.anatomy import Web
from autobalance.planning.depths import AIM_SHARE, Plan, worthwhile
from autobalance.planning.reject_worse import harmless, is_harmless
from autobalance.planning.relaxation import Relaxation, Step
from autobalance.planning.too_light import too_light_g_mm, too_light_text
from autobalance.planning.whole_cuts import choose, settable
from autobalance.quantities import said
from autobalance.rigid_rotor.tolerance import Outcome, Tolerance
from autobalance.rigid_rotor.unbalance import Budget, Moments, Unbalance
from autobalance.runtime import Notify
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Half corrections: cuts in one of two like webs of a throw, where both are heavy.


ALIKE_SHARE = 0.02
"""Difference of thickness and rim radius up to which two webs count as equal, as a share."""
BOTH_SHARE = 0.5
"""Share of the heavier web's unbalance, in its direction, from which the other one needs cuts as well."""


def cut_half(chosen: BestOffer, work: Workpiece) -> str | None:
    """Return the web of two equal ones that a plan leaves uncut, in words; None if it cuts both, or neither.

    Such a plan leaves a couple that the crank had not, and two webs that are no longer equal.
    """
    cuts = zip(chosen.candidates.cuts, chosen.plan.depths_mm.tolist(), strict=True)
    cut_webs = {cut.correction(depth).web for cut, depth in cuts if depth > 0.0}
    if None in cut_webs:  # a rim over several webs, or no web at all
        return None
    for throw in work.anatomy.throws:
        pair = [web for web in work.anatomy.webs if throw in work.anatomy.throws_of(web)]
        if len(pair) == 2 and _are_alike(*pair) and len(cut_webs.intersection(w.number for w in pair)) == 1:
            one, other = sorted(pair, key=lambda web: web.number not in cut_webs)
            if _both_heavy(work, one, other):
                return f"the available cuts reach web {one.number} and not its equal, web {other.number}"
    return None


def _are_alike(one: Web, other: Web) -> bool:
    sizes = [(web.z_max_mm - web.z_min_mm, _rim_mm(web)) for web in (one, other)]
    return all(math.isclose(a, b, rel_tol=ALIKE_SHARE) for a, b in zip(*sizes, strict=True))


def _rim_mm(web: Web) -> float:
    return 0.0 if web.outline is None else web.outline.rim_radius_mm


def _both_heavy(work: Workpiece, cut: Web, left: Web) -> bool:
    """Return whether a web left uncut is heavy as the one that is cut is."""
    one, other = (heavy_vector(work.heavy_at, 0.5 * (web.z_min_mm + web.z_max_mm)) for web in (cut, left))
    return float(other @ one) >= BOTH_SHARE * float(one @ one) > 0.0


# The loop: measure, plan, cut, measure again. The only loop of the program.


PASSES = 6
"""Most passes, each from the untouched crank; one or two are usual."""
MEASURED_WORSE = 0.01
"""Share by which a judged value may exceed its initial one, as measured, above the tolerance."""


@dataclass(frozen=True, eq=False)
class Result:
    """The end of a balancing run.

    ``initial_moments`` and ``final_moments`` are the bare crank's with its slugs, in the rotor frame.
    ``initial`` and ``residual`` count bob-weights and attached rotors too, as judged. ``solid`` is the
    corrected crank in file coordinates [mm]. ``measured`` is its measurement, with the bytes of its file if
    these were measured. Both are None when nothing was cut. ``tools`` are the corrections' bodies, file
    coordinates. ``initial_doubt`` and ``doubt`` are the uncertainties of ``initial`` and ``residual``.
    ``made`` are the cuts behind the corrections, each with its depth. ``notes`` name kinds that have no place
    and drills that were not used. ``relaxations`` are the changes of the job that ``reason`` names.
    """

    outcome: Outcome
    reason: str | None
    initial: Unbalance
    residual: Unbalance
    initial_moments: Moments
    final_moments: Moments
    corrections: tuple[Correction, ...]
    steps: tuple[Step, ...]
    solid: Solid | None
    measured: Measured | None
    tools: tuple[Solid, ...] = ()
    initial_doubt: Budget | None = None
    doubt: Budget | None = None
    made: tuple[tuple[Cut, float], ...] = ()
    notes: tuple[str, ...] = ()
    relaxations: tuple[Relaxation, ...] = ()

    @property
    def to_show(self) -> Solid | None:
        """The corrected crank for pictures: as it was read back where that is built already."""
        read_back = None if self.measured is None else self.measured.read_back
        return self.solid if read_back is None else read_back

    @property
    def as_written(self) -> Solid | None:
        """The corrected crank with the facets that a reader of its file has."""
        facets = None if self.measured is None else self.measured.facets
        return self.to_show if facets is None else facets

    def __getstate__(self) -> dict[str, object]:
        """Leave the cuts behind when pickled: they hold parts of the solid's kernel, and the solid's copy."""
        measured = None if self.measured is None else replace(self.measured, read_back=None, facets=None)
        return {**self.__dict__, "made": (), "measured": measured}


def balance(
    rotor: Rotor,
    tolerance: Tolerance,
    methods: Sequence[Limits],
    measure: Measure = in_memory,
    progress: Notify = lambda _: None,
    prefer: Prefer = "simple",
    advise: bool = True,
    offers: Offers = correction.offer,
    cut_anyway: bool = False,
    min_gain: float = 0.0,
) -> Result:
    """Cut a crank until its residual unbalance is within tolerance, or as near as the metal allows.

    Parameters
    ----------
    rotor : Rotor
    tolerance : Tolerance
    methods : sequence of limits
        The kinds of correction that may be mixed.
    measure : Measure
        The way to measure a cut crank; the verdict is on its result (see ``measuring``).
    progress : callable
        Called with the running step, in a few words.
    prefer : Prefer
        The quantity to spare among plans that reach the aim.
    advise : bool
        Compute remedies when the limits fall short, and the plans of drills that are not used; that takes a
        few more plans.
    offers : callable
        Takes a workpiece, limits and a search level, and returns the candidates.
    cut_anyway : bool
        Cut a crank that is within tolerance too: its unbalance is not certain enough.
    min_gain : float
        Share of the worst judged value that cuts must take off where the tolerance is not reached; else
        nothing is cut.

    Returns
    -------
    Result
        Not reaching the tolerance is a result (``above_tolerance`` with its reason), not an error.

    Raises
    ------
    CorrectionError
        If a correction cannot be set up as the job asks.
    """
    initial = Unbalance.of(rotor.moments + rotor.loads)
    doubt = rotor.doubt(rotor.moments)
    if not cut_anyway and tolerance.is_met_by(initial, doubt):
        return left_as_it_is(rotor, "already_within_tolerance", None)
    light_g_mm = too_light_g_mm(workpiece(rotor, tolerance, initial))
    if light_g_mm is not None:
        progress(too_light_text(light_g_mm))
    progress("planning the correction")
    chosen = best_offer(rotor, tolerance, methods, initial, prefer, offers)
    run = _Run(rotor, tolerance, tuple(methods), prefer, advise, progress, initial, doubt, chosen)
    if not chosen.plan.depths_mm.any():
        return run.left_alone(chosen.plan)
    if (
        chosen.plan.share > 1.0
        and not any(each.settles_webs for each in methods)
        and (half := cut_half(chosen, workpiece(rotor, tolerance, initial))) is not None
    ):
        return run.half_left(half)
    gain = 1.0 - chosen.plan.share / tolerance.used_share(initial)
    if chosen.plan.share > 1.0 and gain < min_gain:
        return run.not_worth_it(gain, min_gain)

    passes: list[tuple[Plan, Pass]] = []
    plan, best = chosen.plan, None
    drift = Unbalance(np.zeros(2), np.zeros(2))
    for number in range(1, PASSES + 1):
        progress(f"cutting, pass {number}")
        done = cut_and_measure(rotor, tolerance, chosen.candidates.cuts, plan.depths_mm, measure)
        passes.append((plan, done))
        better = best is None or done.share < best.share
        best = done if best is None or better else best
        if done.share <= max(AIM_SHARE, plan.share * (1.0 + AIM_SHARE)) or not better:
            break
        drift = drift + (done.residual - plan.predicted)
        again = choose(initial + drift, tolerance, chosen.candidates, prefer=prefer, start_mm=plan.depths_mm)
        plan = harmless(initial + drift, tolerance, chosen.candidates, again)
        plan = worthwhile(initial + drift, tolerance, chosen.candidates, plan)
        plan = settable(initial + drift, tolerance, chosen.candidates, plan)
    assert best is not None
    does_harm = best.share > 1.0 and not is_harmless(initial, best.residual, tolerance, MEASURED_WORSE)
    if best.share >= tolerance.used_share(initial) or does_harm:
        return run.left_alone(plan, _steps(passes, range(len(chosen.candidates.cuts))))
    return run.corrected(plan, best, passes)


def cut_as_given(
    rotor: Rotor,
    tolerance: Tolerance,
    given: BestOffer,
    measure: Measure,
    progress: Notify,
    order: Sequence[int],
) -> Result:
    """Make cuts that nobody planned, once, and judge the crank; ``order`` is that of the corrections."""
    progress("cutting, pass 1")
    initial, plan = Unbalance.of(rotor.moments + rotor.loads), given.plan
    run = _Run(
        rotor, tolerance, given.methods, "simple", False, progress, initial, rotor.doubt(rotor.moments), given
    )
    done = cut_and_measure(rotor, tolerance, given.candidates.cuts, plan.depths_mm, measure)
    return run.corrected(plan, done, [(plan, done)], order)


@dataclass(frozen=True, eq=False)
class _Run:
    """Inputs and candidates of a run, with a method for each of its ends."""

    rotor: Rotor
    tolerance: Tolerance
    methods: tuple[Limits, ...]
    prefer: Prefer
    advise: bool
    progress: Notify
    initial: Unbalance
    initial_doubt: Budget | None
    chosen: BestOffer

    def left_alone(self, plan: Plan, steps: Sequence[Step] = ()) -> Result:
        """Return the end of a run whose cuts would do nothing for the crank."""
        if self.tolerance.is_met_by(self.initial, self.initial_doubt):
            return left_as_it_is(self.rotor, "already_within_tolerance", None, steps)
        reason = self.tolerance.why_not(self.initial, self.initial_doubt, plan.binding)
        remedies: tuple[Relaxation, ...] = ()
        if reason is None:
            reason, remedies = self._why(plan, self.initial)
        untouched = left_as_it_is(self.rotor, "above_tolerance", reason, steps)
        return replace(untouched, notes=self.chosen.notes, relaxations=remedies)

    def half_left(self, half: str) -> Result:
        """Return the end of a run that would cut one of two like webs and not reach the tolerance either."""
        nothing = replace(self.chosen.plan, depths_mm=np.zeros(len(self.chosen.candidates.cuts)))
        result = self.left_alone(nothing)
        return replace(result, reason=said("{}; {}: nothing is cut", result.reason, half))

    def not_worth_it(self, gain: float, least: float) -> Result:
        """Return the end of a run whose cuts would not reach the tolerance and bring next to nothing."""
        nothing = replace(self.chosen.plan, depths_mm=np.zeros(len(self.chosen.candidates.cuts)))
        result = self.left_alone(nothing)
        text = (
            f"the available cuts would remove {100.0 * gain:.2g} % of it: nothing is cut "
            f"(min_gain_percent = {100.0 * least:g})"
        )
        return replace(result, reason=said("{}; {}", result.reason, text))

    def corrected(
        self,
        plan: Plan,
        best: Pass,
        passes: Sequence[tuple[Plan, Pass]],
        order: Sequence[int] | None = None,
    ) -> Result:
        """Return the end of a run that cut the crank, its cuts in the order in which they are made."""
        rotor, candidates = self.rotor, self.chosen.candidates
        listed, overlaps = _in_turn(rotor, candidates, best)
        cuts = made_cuts(candidates.cuts, best.depths_mm)
        order = setup_order(listed, [cut for cut, _ in cuts], overlaps) if order is None else order
        corrections = tuple(listed[k] for k in order)
        places = np.flatnonzero(best.depths_mm > 0.0)[list(order)]
        refuse_sum(rotor, best.measured, corrections)
        doubt = rotor.doubt(best.measured.moments, corrections, best.solid)
        within = self.tolerance.is_met_by(best.residual, doubt)
        reason = None if within else self.tolerance.why_not(best.residual, doubt, plan.binding)
        remedies: tuple[Relaxation, ...] = ()
        if not within and reason is None:
            reason, remedies = self._why(plan, best.residual)
        unused = (
            why_not_used(candidates, plan, self.initial, self.tolerance, self.prefer) if self.advise else ()
        )
        return Result(
            outcome="within_tolerance" if within else "above_tolerance",
            reason=reason,
            initial=self.initial,
            residual=best.residual,
            initial_moments=rotor.moments,
            final_moments=best.moments,
            corrections=corrections,
            steps=_steps(passes, places),
            solid=best.solid,
            measured=best.measured,
            tools=tuple(best.tools[k].moved(rotor.anatomy.rotor_to_file) for k in order),
            initial_doubt=self.initial_doubt,
            doubt=doubt,
            made=tuple(cuts[k] for k in order),
            notes=self.chosen.notes + unused + remarks(corrections, rotor.anatomy, self.methods),
            relaxations=remedies,
        )

    def _why(self, plan: Plan, residual: Unbalance) -> tuple[str, tuple[Relaxation, ...]]:
        """Return the reason why the tolerance is not reached, and all remedies."""
        above = Above(self.rotor, self.tolerance, self.methods, self.chosen, self.initial, self.prefer)
        return why_above(above, plan, residual, self.advise, self.progress)


def _steps(passes: Sequence[tuple[Plan, Pass]], first: Iterable[int]) -> tuple[Step, ...]:
    """Return the steps of the passes, depths in the order of the places ``first``, then all other cuts."""
    order = list(
        dict.fromkeys([*map(int, first), *(k for plan, _ in passes for k in range(len(plan.depths_mm)))])
    )
    return tuple(
        Step(
            number,
            tuple(float(depth) for depth in plan.depths_mm[order] if depth > 0.0),
            plan.predicted.magnitude_g_mm,
            done.residual.magnitude_g_mm,
        )
        for number, (plan, done) in enumerate(passes, 1)
    )


def left_as_it_is(rotor: Rotor, outcome: Outcome, reason: str | None, steps: Sequence[Step] = ()) -> Result:
    """Return the end of a run that cuts nothing."""
    unbalance, doubt = Unbalance.of(rotor.moments + rotor.loads), rotor.doubt(rotor.moments)
    return Result(
        outcome=outcome,
        reason=reason,
        initial=unbalance,
        residual=unbalance,
        initial_moments=rotor.moments,
        final_moments=rotor.moments,
        corrections=(),
        steps=tuple(steps),
        solid=None,
        measured=None,
        initial_doubt=doubt,
        doubt=doubt,
    )


def _corrections(
    cuts: Sequence[Cut], depths_mm: Array, as_measured: Sequence[Correction | None] = ()
) -> tuple[Correction, ...]:
    """Return the cuts that are made, each with its change per millimetre of depth.

    ``as_measured`` has those that were measured by themselves, None for the others; empty where none was.
    """
    chosen = made_cuts(cuts, depths_mm)
    corrections = []
    for (cut, depth), own in zip(chosen, as_measured or [None] * len(chosen), strict=True):
        each = cut.correction(depth) if own is None else own
        corrections.append(each if each.rate is not None else replace(each, rate=cut.rate(depth)))
    return tuple(corrections)


def _in_turn(
    rotor: Rotor, candidates: Candidates, done: Pass
) -> tuple[tuple[Correction, ...], list[Overlap]]:
    """Return the corrections of a pass, metal of two cuts counted with the first, and those overlaps."""
    measured_cuts = done.measured.taken  # empty where triangles were measured
    corrections = _corrections(candidates.cuts, done.depths_mm, measured_cuts)
    chosen = np.flatnonzero(done.depths_mm > 0.0).tolist()
    place = {k: n for n, k in enumerate(chosen)}
    both = [
        Overlap(place[pair.first], place[pair.second])
        for pair in candidates.overlaps
        if pair.first in place and pair.second in place
    ]
    if measured_cuts and all(measured_cuts):  # measured in turn already
        return corrections, both
    if not both and done.metal is None:
        return corrections, both
    cuts = [(candidates.cuts[k], float(done.depths_mm[k])) for k in chosen]
    in_turn = taken_in_turn(rotor.solid, rotor.anatomy, rotor.density_g_mm3, cuts, corrections, both)
    return (in_turn if done.metal is None else taken_of_scan(rotor, done.metal, cuts, in_turn)), both


def planned(
    rotor: Rotor, tolerance: Tolerance, methods: Sequence[Limits], prefer: Prefer = "simple"
) -> tuple[tuple[Correction, ...], Unbalance]:
    """Return the planned cuts and the residual unbalance that they would leave, without cutting.

    Raises
    ------
    CorrectionError
        If a correction cannot be set up as asked.
    """
    now = rotor.moments + rotor.loads
    best = best_offer(rotor, tolerance, methods, Unbalance.of(now), prefer)
    cuts, depths = best.candidates.cuts, best.plan.depths_mm
    holes = _corrections(cuts, depths)
    order = setup_order(holes, [cut for cut, _ in made_cuts(cuts, depths)])
    return tuple(holes[k] for k in order), best.plan.predicted
