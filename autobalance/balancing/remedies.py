"""Reason why a tolerance is not reached, and its remedies, each planned before it is named."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

from autobalance.balancing.cut_pass import cut_and_measure, made_cuts
from autobalance.balancing.measuring import in_memory, refuse_lost_crank
from autobalance.balancing.offers import BestOffer, best_offer, workpiece
from autobalance.balancing.rotor import Rotor
from autobalance.correction import Limits, kind_of
from autobalance.correction.contract import Prefer
from autobalance.crank.faces import find_faces
from autobalance.errors import CorrectionError, SolidError
from autobalance.planning.depths import Plan
from autobalance.planning.relaxation import Attempt, Relaxation, lighter, relaxations
from autobalance.planning.shortfall import Shortfall, explain_shortfall, factor_relaxations
from autobalance.planning.too_light import heavier, too_light_g_mm, too_light_text
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import LIMITS_SOUGHT, Notify, Skipped, skippable


@dataclass(frozen=True, eq=False)
class Above:
    """A crank that stays above its tolerance, with the methods requested and the candidates."""

    rotor: Rotor
    tolerance: Tolerance
    methods: tuple[Limits, ...]
    chosen: BestOffer
    initial: Unbalance
    prefer: Prefer = "simple"


def why_above(
    above: Above, plan: Plan, residual: Unbalance, advise: bool, progress: Notify
) -> tuple[str, tuple[Relaxation, ...]]:
    """Return the reason why the tolerance is not reached and, with ``advise``, all remedies."""
    rotor, candidates = above.rotor, above.chosen.candidates
    work = workpiece(rotor, above.tolerance, above.initial)
    light_g_mm = None if plan.depths_mm.any() else too_light_g_mm(work)
    shortfall = Shortfall(
        residual,
        above.tolerance,
        Unbalance.of(rotor.loads_per_factor),
        rotor.factor,
        candidates.cuts,
        plan.depths_mm,
        plan.binding,
        _web_places_mm(rotor),
        "" if light_g_mm is None else too_light_text(light_g_mm),
    )
    attempt = Attempt(
        work,
        above.chosen.methods,
        above.methods,
        candidates,
        above.initial,
        above.tolerance,
        progress=progress,
    )
    bound = attempt.bound
    if not advise:
        return explain_shortfall(shortfall, bound=bound), ()
    if bound > 1.0:
        progress(f"no plan leaves less than {bound:.3g} times the permissible value")
    progress(LIMITS_SOUGHT)
    remedies: list[Relaxation] = []
    factor, stopped = None, False
    try:
        with skippable():
            for each in _remedies(above, attempt, light_g_mm is not None):
                remedies.append(each)
            factor = _factor_tried(above, shortfall, attempt)
    except Skipped:
        stopped = True
    text = explain_shortfall(shortfall, [each.text for each in remedies], bound, factor)
    if stopped:
        text += "; the search for limits that would suffice was stopped by Ctrl-C"
    elif attempt.left_out:
        text += "; further changes were not tried, since each takes long on this crank"
    return text, (*remedies, *(() if factor is None else (factor,)))


def _remedies(above: Above, attempt: Attempt, is_light: bool) -> Iterator[Relaxation]:
    """Yield the relaxations that hold when they are run, of each kind the one with the least metal first."""
    run = partial(_as_run, above, attempt)
    found = _least_metal_first(map(run, relaxations(attempt, more_of_the_same=not is_light)))
    yield from found
    if is_light:
        yield from _least_metal_first(heavier(attempt, found, run))
    elif not found:
        yield from _least_metal_first(map(run, lighter(attempt)))


def _least_metal_first(found: Iterable[Relaxation | None]) -> list[Relaxation]:
    """Return the relaxations that there are; the one that takes the least metal comes first."""
    return sorted(filter(None, found), key=lambda relaxed: round(relaxed.metal_g or 0.0, 6))


def _as_run(above: Above, attempt: Attempt, relaxed: Relaxation) -> Relaxation | None:
    """Return a relaxation with what a run of it leaves and takes; None where it fails then."""
    rotor = above.rotor
    if not relaxed.methods:
        return relaxed
    attempt.progress(f"planning {relaxed.text}")
    if not rotor.faces and any(kind_of(limits).needs_faces for limits in relaxed.methods):
        faces = attempt.work.faces or tuple(find_faces(rotor.solid.mesh, rotor.anatomy))
        rotor = replace(rotor, faces=faces)
    try:
        best = best_offer(rotor, above.tolerance, relaxed.methods, above.initial, above.prefer)
        if best.plan.share > 1.0 or not _is_crank_after(rotor, above.tolerance, best):
            return None
    except (CorrectionError, SolidError):
        return None
    cuts = zip(best.candidates.cuts, best.plan.depths_mm.tolist(), strict=True)
    metal = sum(abs(cut.effect(depth).mass_g) for cut, depth in cuts if depth > 0.0)
    return replace(relaxed, used_share=best.plan.share, metal_g=float(metal))


def _is_crank_after(rotor: Rotor, tolerance: Tolerance, best: BestOffer) -> bool:
    """Return whether the crank is found, within tolerance, once a plan is carried out.

    Only added metal may hide journals and pins; a plan that only removes metal is not checked.

    Raises
    ------
    SolidError
        If the crank is not found any more, or the metal cannot be added.
    """
    cuts, depths = best.candidates.cuts, best.plan.depths_mm
    if not any(cut.adds_metal for cut, _ in made_cuts(cuts, depths)):
        return True
    done = cut_and_measure(rotor, tolerance, cuts, depths, in_memory)
    refuse_lost_crank(rotor, done.solid)
    return done.share <= 1.0


def _factor_tried(above: Above, shortfall: Shortfall, attempt: Attempt) -> Relaxation | None:
    """Return the first change of the balance factor at which the job's own methods suffice, planned again."""
    ways = (_planned_at(above, shortfall, attempt, way) for way in factor_relaxations(shortfall))
    return next(filter(None, ways), None)


def _planned_at(above: Above, shortfall: Shortfall, attempt: Attempt, way: Relaxation) -> Relaxation | None:
    """Return a change of the balance factor with its plan's residual; None if no plan is good enough."""
    (change,) = way.changes
    moved = shortfall.per_factor.scaled(change.proposed - change.present)
    initial = above.initial + moved
    share = above.tolerance.used_share(initial)
    if share <= 1.0:  # the crank as it is
        return replace(way, used_share=share, metal_g=0.0)
    work = workpiece(above.rotor, above.tolerance, initial)
    anew = replace(attempt, work=work, residual=initial)
    candidates = anew.offer_with(*attempt.methods)
    if candidates is None or not anew.may_do(candidates):
        return None
    plan = anew.plan(candidates)
    cuts = zip(candidates.cuts, plan.depths_mm.tolist(), strict=True)
    metal = sum(abs(cut.effect(depth).mass_g) for cut, depth in cuts if depth > 0.0)
    return None if plan.share > 1.0 else replace(way, used_share=plan.share, metal_g=float(metal))


def _web_places_mm(rotor: Rotor) -> tuple[float, float] | None:
    """Return z at the middles of the outermost webs, where metal can be added; None with one web."""
    z = [0.5 * (web.z_min_mm + web.z_max_mm) for web in rotor.anatomy.webs]
    return (z[0], z[-1]) if len(z) > 1 else None
