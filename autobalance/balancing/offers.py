"""Candidates of a job's kinds of correction on a rotor, and remedies where they fall short."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from autobalance import correction
from autobalance.balancing.measuring import cut_and_measure, in_memory, made_cuts, refuse_lost_crank
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction import Limits, kind_of
from autobalance.correction.contract import Prefer, clear_of_roughness, setting_of
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.crank.anatomy import Anatomy
from autobalance.crank.faces import find_faces
from autobalance.errors import CorrectionError, SolidError
from autobalance.planning.cut_curves import Task, part_of, usual
from autobalance.planning.depths import AIM_SHARE, Plan, worthwhile
from autobalance.planning.reject_worse import harmless, is_harmless, same_setups
from autobalance.planning.relaxation import Attempt, Relaxation, lighter, relaxations
from autobalance.planning.too_light import (
    Shortfall,
    explain_shortfall,
    factor_relaxations,
    heavier,
    too_light_g_mm,
    too_light_text,
)
from autobalance.planning.whole_cuts import WHOLE_CUTS_SHARE, choose, is_enough, least_step_mm, rank, settable
from autobalance.quantities import g, g_mm, joined, mm, said
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Budget, Unbalance
from autobalance.runtime import LIMITS_SOUGHT, Notify, Skipped, skippable
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Candidates of a job's kinds of correction on a rotor: ever more, until a plan is good enough.


Offers = Callable[[Workpiece, Limits, int], Candidates]

MAX_SEARCHES = 8
"""Most looks for metal, each four times deeper than the last."""
HARDLY_MORE = 1.25
"""Ratio to the least residual that a plan without a new set-up may leave, if no plan leaves little."""
MAX_EXPLAINED_DRILLS = 6
"""Largest number of unused drills for which a separate plan is computed."""


@dataclass(frozen=True, eq=False)
class BestOffer:
    """Candidates, a plan of them, the methods that have a place, and notes on the other methods."""

    candidates: Candidates
    plan: Plan
    methods: tuple[Limits, ...]
    notes: tuple[str, ...]


def best_offer(
    rotor: Rotor,
    tolerance: Tolerance,
    methods: Sequence[Limits],
    initial: Unbalance,
    prefer: Prefer,
    offers: Offers = correction.offer,
) -> BestOffer:
    """Return the first candidates whose plan is good enough, else those whose plan comes nearest.

    A kind that has no place at its last search level is left out, with a note.

    Raises
    ------
    CorrectionError
        If no kind has a place: the error of the first.
    """
    best: BestOffer | None = None
    errors: dict[int, CorrectionError] = {}
    kept = [clear_of_roughness(limits, rotor.anatomy) for limits in methods]
    doubt = rotor.doubt(rotor.moments) if prefer == "same_setup" else None
    simpler: list[BestOffer] = []
    for search_level in range(max(correction.search_levels(limits) for limits in methods)):
        look = 1.0
        for _ in range(MAX_SEARCHES):
            work = workpiece(rotor, tolerance, initial, look)
            parts, placed, errors = _parts(work, methods, kept, search_level, offers)
            if not parts:
                break
            candidates = correction.joined(parts)
            nothing = [m for m, part in zip(placed, parts, strict=True) if not part.cuts and len(methods) > 1]
            notes = (*_left_out(methods, errors, nothing), *candidates.notes)
            tiers = (
                _without_new_setup(rotor, tolerance, initial, candidates) if prefer == "same_setup" else ()
            )
            for part, plan in tiers:
                if _leaves_little(initial, plan.predicted, tolerance, doubt):
                    return BestOffer(part, plan, tuple(placed), notes)
                if tolerance.is_met_by(plan.predicted, doubt):
                    simpler.append(BestOffer(part, plan, tuple(placed), notes))
            plan = choose(initial, tolerance, candidates, prefer=prefer)
            if best is None or plan.share < best.plan.share * (1.0 - AIM_SHARE):
                best = BestOffer(candidates, plan, tuple(placed), notes)
            at_end = [
                cut.limit_is_reach and depth >= cut.max_depth_mm - 1e-9
                for cut, depth in zip(candidates.cuts, plan.depths_mm, strict=True)
            ]
            if is_enough(plan, candidates) or not any(at_end):
                break
            look *= 4.0
        if best is not None and is_enough(best.plan, best.candidates):
            break
    if best is None:
        raise next(iter(errors.values()))
    for each in simpler:  # where no plan leaves little, one without a new set-up that leaves hardly more
        if each.plan.share <= HARDLY_MORE * best.plan.share and is_harmless(
            initial, each.plan.predicted, tolerance
        ):
            return each
    plan = harmless(initial, tolerance, best.candidates, best.plan)
    plan = worthwhile(initial, tolerance, best.candidates, plan)
    coarse = settable(initial, tolerance, best.candidates, plan)
    notes = (*best.notes, *_too_fine(best.candidates, plan, coarse), *_unequal(best.candidates, coarse))
    return replace(best, plan=coarse, notes=notes)


def _parts(
    work: Workpiece, methods: Sequence[Limits], kept: Sequence[Limits], search_level: int, offers: Offers
) -> tuple[list[Candidates], list[Limits], dict[int, CorrectionError]]:
    """Return the candidates of each kind, the methods that have any place, and the reasons for the others."""
    parts, placed, errors = [], [], {}
    for number, limits in enumerate(methods):
        level = min(search_level, correction.search_levels(limits) - 1)
        try:
            parts.append(offers(work, kept[number], level))
            placed.append(limits)
        except CorrectionError as error:
            errors[number] = error
    return parts, placed, errors


def _without_new_setup(
    rotor: Rotor, tolerance: Tolerance, initial: Unbalance, candidates: Candidates
) -> Iterator[tuple[Candidates, Plan]]:
    """Yield the plans in old places with their tools, then with these tools anywhere."""
    task = Task(initial, tolerance, candidates, "same_setup", AIM_SHARE, *usual(candidates))
    for again in same_setups(candidates.cuts, rotor.earlier):
        part = part_of(task, again).candidates
        plan = choose(initial, tolerance, part, prefer="same_setup")
        yield part, settable(initial, tolerance, part, plan)


def _leaves_little(before: Unbalance, after: Unbalance, tolerance: Tolerance, doubt: Budget | None) -> bool:
    """Return whether a plan without a new set-up is worth it: no judged value is worse, and all are small.

    Small is a quarter of the permissible unbalance in addition to the reading's uncertainty: the next spin
    has that uncertainty too, and the shop's own drift is added.
    """
    rows = tolerance.judged(after, None if doubt is None else doubt.total)
    return is_harmless(before, after, tolerance) and all(
        row.residual_g_mm <= WHOLE_CUTS_SHARE * (row.permissible_g_mm - row.doubt_g_mm) for row in rows
    )


def _unequal(candidates: Candidates, plan: Plan) -> tuple[str, ...]:
    """Return a note where cuts that were to be equal are not."""
    pairs = zip(candidates.cuts, plan.depths_mm.tolist(), strict=True)
    different = {(setting_of(cut), round(depth, 6)) for cut, depth in pairs if depth > 0.0}
    if not candidates.equal or len(different) < 2:
        return ()
    return (
        f"no equal cuts at the positions keep the tolerance: the plan has {len(different)} different ones",
    )


def _too_fine(candidates: Candidates, plan: Plan, coarse: Plan) -> tuple[str, ...]:
    """Return a note on depths below ``min_step_mm``, which are left out, and the residual without them."""
    names = [
        said("{} by {}", cut.label, mm(depth, ".2g"))
        for cut, depth in zip(candidates.cuts, plan.depths_mm.tolist(), strict=True)
        if 0.0 < depth < least_step_mm(cut)
    ]
    if not names:
        return ()
    return (
        said(
            "{}: less than min_step_mm, left out; that leaves {} instead of {}",
            joined(", ", names),
            g_mm(coarse.predicted.magnitude_g_mm, ".3g"),
            g_mm(plan.predicted.magnitude_g_mm, ".3g"),
        ),
    )


def _left_out(
    methods: Sequence[Limits], errors: dict[int, CorrectionError], nothing: Sequence[Limits]
) -> list[str]:
    def name(limits: Limits) -> str:
        return correction.kind_of(limits).name

    refused = [f"{name(methods[number])} is left out: {error}" for number, error in errors.items()]
    empty = [f"{name(limits)} is left out: it finds no place on the side to be changed" for limits in nothing]
    return refused + empty


def why_not_used(
    candidates: Candidates, plan: Plan, initial: Unbalance, tolerance: Tolerance, prefer: Prefer
) -> tuple[str, ...]:
    """Return a note for each drill that was offered, fits and is not used: the plan with it alone."""
    if not plan.depths_mm.any():
        return ()
    task = Task(initial, tolerance, candidates, prefer, AIM_SHARE, *usual(candidates))
    plan_rank = rank(task, plan)
    unused = [
        group
        for rule in candidates.varieties
        for group in rule.groups
        if group and not plan.depths_mm[list(group)].any()
    ]
    return tuple(_why(task, group, plan_rank) for group in unused[:MAX_EXPLAINED_DRILLS])


def _why(task: Task, group: Sequence[int], plan_rank: tuple[int, int, float]) -> str:
    part = part_of(task, group)
    alone = choose(task.residual, task.tolerance, part.candidates, prefer=task.prefer)
    different, cuts, metal = rank(part, alone)
    name = _in_mm(setting_of(task.cuts[group[0]]))
    if not is_enough(alone, part.candidates):
        share = f"{alone.share:.3g}"
        return said("{} is not used: alone it leaves {} times the permissible value", name, share)
    ours = said("the plan: {}, {} and {}", plan_rank[0], plan_rank[1], g(plan_rank[2], ".1f"))
    kinds = f"{different} different cut{'' if different == 1 else 's'}"
    theirs = said("{}, {} in all, {}", kinds, cuts, g(metal, ".1f"))
    return said("{} is not used: alone it takes {} ({})", name, theirs, ours)


def _in_mm(name: str) -> str:
    """Return the name of a setting; one that ends in a diameter with its unit."""
    before, space, last = name.rpartition(" ")
    sign = "⌀" if last.startswith("⌀") else ""
    if not name[-1:].isdigit() or "No." in name:
        return name
    try:
        return said("{}{}{}{}", before, space, sign, mm(float(last.removeprefix(sign)), "g"))
    except ValueError:
        return f"{name} mm"


def workpiece(rotor: Rotor, tolerance: Tolerance, initial: Unbalance, look: float = 1.0) -> Workpiece:
    """Return a rotor's crank as the kinds of correction see it, with the unbalance to be moved."""
    return Workpiece(
        rotor.solid,
        rotor.anatomy,
        rotor.faces,
        rotor.density_g_mm3,
        heavy_vectors(initial, tolerance, rotor.anatomy),
        look,
        tolerance.service_speed_rad_s,
        rotor.earlier,
    )


def heavy_vectors(
    unbalance: Unbalance, tolerance: Tolerance, anatomy: Anatomy
) -> tuple[tuple[float, Array], tuple[float, Array]]:
    """Return the unbalance as vectors at the first and the last web: where metal can be taken.

    A static verdict, or a crank with one web, takes half of the resultant at each. Eccentrics have no webs:
    the first and the last of them count.
    """
    middles = [0.5 * (web.z_min_mm + web.z_max_mm) for web in anatomy.webs] or [
        float(throw.crankpin.centre_mm[2]) for throw in anatomy.throws
    ]
    z0, z1 = middles[0], middles[-1]
    if tolerance.judge == "static" or z0 == z1:
        half = 0.5 * unbalance.resultant_g_mm
        return (z0, half), (z1, half)
    a, b = unbalance.in_planes(z0, z1)
    return (z0, a), (z1, b)


# Reason why a tolerance is not reached, and its remedies, each planned before it is named.


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
