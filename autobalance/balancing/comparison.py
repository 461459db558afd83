"""Every kind of correction, and the useful mixes, on one crank, like for like."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Annotated

from autobalance import correction
from autobalance.balancing.loop import Result, balance
from autobalance.balancing.measuring import in_memory, on_true_surfaces
from autobalance.balancing.offers import Offers, workpiece
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.balancing.web_metal import THINNED_SHARE, least_share, web_metal
from autobalance.correction import Limits
from autobalance.correction.contract import Correction, Prefer, setting_of
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.crank.anatomy import Anatomy
from autobalance.declare import UNWRITTEN, Count, KgMm2, NotNegative, Ordinal
from autobalance.errors import CorrectionError
from autobalance.planning.milp import greatest_multiple
from autobalance.planning.milp import least_share as bound_share
from autobalance.planning.too_light import too_light_g_mm
from autobalance.quantities import Text, g, mm, said
from autobalance.rigid_rotor.tolerance import Outcome, Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import Notify
from autobalance.value_classes import dataclass

MOST_CAPACITY = 64.0
"""Multiples of the initial unbalance beyond which capacity is plenty."""
EQUAL_SHARE = 1e-3
"""Share by which two figures must differ to count as better or worse."""


@dataclass(frozen=True, eq=False)
class ComparedRow:
    """Result of one kind or mix of corrections.

    Attributes
    ----------
    method : tuple of str
    outcome : Outcome or None
        None where the kind cannot be set up on this crank, for the ``reason``.
    residual_share : float or None
        Largest judged residual ÷ its permissible value.
    residual_g_mm : float or None
        Magnitude of the resultant.
    mass_change_g, inertia_change_g_mm2 : float or None
        Of the rotor, slugs included; negative: removed.
    metal_moved_g : float or None
        Metal taken, added or pressed in, each counted positive.
    cuts : int
        Holes, slugs, faces and rims to make.
    different_cuts : int
        Cuts of different settings or depths.
    depths_mm : tuple of float
        One a cut; below 0 for metal added.
    wall_left_mm : float or None
        Smallest metal left beside the cuts: see ``wall_left_mm``.
    capacity : float or None
        The multiple of the initial unbalance that these limits can still correct, at most; None too where it
        is plenty, more than ``MOST_CAPACITY``.
    rank : int or None
        Among the rows within tolerance.
    beaten_by : tuple of str
        Names of the rows that are nowhere worse and somewhere better.
    adds_to_heavy : bool
        Whether metal is built up on a crank that is too heavy somewhere, where a shop takes it off.
    """

    method: tuple[str, ...]
    outcome: Outcome | None
    reason: str | None
    residual_share: NotNegative | None = None
    residual_g_mm: NotNegative | None = None
    mass_change_g: float | None = None
    metal_moved_g: NotNegative | None = None
    inertia_change_g_mm2: KgMm2 | None = None
    cuts: Count = 0
    different_cuts: Count = 0
    depths_mm: tuple[float, ...] = ()
    wall_left_mm: float | None = None
    web_metal_share: Annotated[
        NotNegative | None, "minimum share of its metal between crankpin and main journal that a web keeps"
    ] = None
    capacity: NotNegative | None = None
    capacity_is_plenty: bool = False
    rank: Ordinal | None = None
    beaten_by: tuple[str, ...] = ()
    adds_to_heavy: Annotated[bool, UNWRITTEN] = False

    @property
    def name(self) -> str:
        """The kinds as one word: ``turn+drill``."""
        return "+".join(self.method)

    def beats(self, other: ComparedRow) -> bool:
        """Return whether this is within tolerance and nowhere worse than another, and somewhere better.

        Metal moved, change of inertia, number of cuts, smallest wall left and metal left in the webs count;
        metal built up on a heavy crank beats none taken off.
        """
        if self.outcome != "within_tolerance":
            return False
        if other.outcome != "within_tolerance":
            return True
        if self.adds_to_heavy and not other.adds_to_heavy:
            return False
        pairs = list(zip(self._costs(), other._costs(), strict=True))
        slack = [EQUAL_SHARE * max(abs(a), abs(b)) if math.isfinite(a + b) else 0.0 for a, b in pairs]
        return all(a <= b + s for (a, b), s in zip(pairs, slack, strict=True)) and any(
            a < b - s for (a, b), s in zip(pairs, slack, strict=True)
        )

    def _costs(self) -> tuple[float, ...]:
        wall = math.inf if self.wall_left_mm is None else self.wall_left_mm
        kept = 1.0 if self.web_metal_share is None else self.web_metal_share
        return (
            self.metal_moved_g or 0.0,
            abs(self.inertia_change_g_mm2 or 0.0),
            float(self.cuts),
            -wall,
            -kept,
        )


def compare(
    rotor: Rotor,
    tolerance: Tolerance,
    limits: Mapping[str, Limits],
    prefer: Prefer = "simple",
    mixes: Sequence[tuple[str, ...]] | None = None,
    progress: Notify = lambda _: None,
    done: Callable[[Sequence[ComparedRow]], None] = lambda _: None,
) -> list[ComparedRow]:
    """Balance one crank by each kind and mix in turn.

    Parameters
    ----------
    rotor, tolerance
        As for ``loop.balance``.
    limits : mapping of str to Limits
        The limits of each kind, by its name.
    mixes : sequence of tuples of str, optional
        Names of the kinds to mix; default each kind alone, then with those that reach what it cannot.
    done : callable
        Called with all rows so far after each.
    """
    rows: list[ComparedRow] = []
    offers = _once()
    measure = in_memory if rotor.exact is None else on_true_surfaces
    for methods in correction.mixes() if mixes is None else mixes:
        progress(f"trying {'+'.join(methods)}")
        chosen = [limits[name] for name in methods]
        if len(methods) > 1 and (least := _refuted(rotor, tolerance, chosen, offers)) is not None:
            progress(f"{'+'.join(methods)} leave {least:.3g} times the permissible value at least")
            continue
        try:
            result = balance(rotor, tolerance, chosen, measure, prefer=prefer, advise=False, offers=offers)
        except CorrectionError as error:
            rows.append(ComparedRow(methods, None, str(error)))
            done(rows)
            continue
        if len(methods) > 1 and {each.kind for each in result.corrections} < set(methods):
            continue  # a kind, or a smaller mix, would be listed twice
        capacity = _capacity(rotor, tolerance, chosen, result, offers)
        rows.append(_row(methods, rotor, tolerance, result, capacity))
        done(rows)
    return rows


def _refuted(rotor: Rotor, tolerance: Tolerance, chosen: Sequence[Limits], offers: Offers) -> float | None:
    """Return the least share of the permissible value that a mix leaves if no plan of it is within.

    None where one may be. A kind without a place, or at the reach of its search, is left to planning.
    """
    initial = Unbalance.of(rotor.moments + rotor.loads)
    work = workpiece(rotor, tolerance, initial)
    try:
        parts = [offers(work, each, correction.search_levels(each) - 1) for each in chosen]
    except CorrectionError:
        return None
    candidates = correction.joined(parts)
    if any(cut.limit_is_reach for cut in candidates.cuts):
        return None
    least = bound_share(initial, tolerance, candidates)
    return least if least > 1.0 else None


def _once() -> Offers:
    """Return a cache of each kind's candidates, valid for one rotor and tolerance."""
    known: dict[tuple[int, int, float], Candidates] = {}

    def offers(work: Workpiece, limits: Limits, search_level: int) -> Candidates:
        key = (id(limits), search_level, work.look)
        if key not in known:
            known[key] = correction.offer(work, limits, search_level)
        return known[key]

    return offers


def judged(rows: Sequence[ComparedRow], prefer: Prefer) -> tuple[list[ComparedRow], list[ComparedRow]]:
    """Return the rows with their ranks and what beats each, and those within tolerance, the best first."""
    order = {row.name: rank for rank, row in enumerate(ranked(rows, prefer), 1)}
    done = [replace(row, rank=order.get(row.name), beaten_by=beaten_by(row, rows)) for row in rows]
    return done, sorted((row for row in done if row.rank is not None), key=lambda row: row.rank or 0)


def beaten_by(row: ComparedRow, rows: Sequence[ComparedRow]) -> tuple[str, ...]:
    """Return the names of the rows that beat one."""
    return tuple(other.name for other in rows if other.beats(row))


def ranked(rows: Sequence[ComparedRow], prefer: Prefer) -> list[ComparedRow]:
    """Return the rows within tolerance, the best first, as a job prefers.

    Metal is taken off a heavy crank before any is built up on it. Equal rows: first those that do not thin a
    web behind its crankpin, then those of the least metal.
    """

    def key(row: ComparedRow) -> tuple[float, ...]:
        moved, inertia = row.metal_moved_g or 0.0, row.inertia_change_g_mm2 or 0.0
        first: Mapping[Prefer, tuple[float, ...]] = {
            "simple": (row.different_cuts, row.cuts),
            "same_setup": (row.different_cuts, row.cuts),
            "least_metal": (moved,),
            "fewest_holes": (row.cuts,),
            "least_inertia_change": (abs(inertia),),
            "most_inertia_removed": (inertia,),
        }
        thins = row.web_metal_share is not None and row.web_metal_share < THINNED_SHARE
        return (row.adds_to_heavy, *first[prefer], thins, moved)

    good = [row for row in rows if row.outcome in ("within_tolerance", "already_within_tolerance")]
    return sorted(good, key=key)


WORDS: Mapping[Prefer, str] = {
    "simple": "fewest different cuts, then fewest cuts, then the least metal",
    "same_setup": "fewest different cuts, then fewest cuts, then the least metal",
    "least_metal": "least metal",
    "fewest_holes": "fewest cuts, then the least metal",
    "least_inertia_change": "least change of inertia",
    "most_inertia_removed": "most inertia removed",
}


def why_recommended(order: Sequence[ComparedRow], rows: Sequence[ComparedRow], prefer: Prefer) -> str:
    """Return the reason why the first of the ranked rows is recommended, beside the next one."""
    if not order:
        near = [row for row in rows if row.residual_share is not None]
        if not near:
            return "no kind of correction has a place on this crank"
        best = min(near, key=lambda row: row.residual_share or 0.0)
        nearest = f"{best.name} comes nearest, to {best.residual_share:.3g} times the permissible unbalance"
        return f"none is within tolerance; {nearest}"
    first = order[0]
    if first.outcome == "already_within_tolerance":
        return "the crank is within tolerance; no cut is needed"
    text = said("{}: {}; ranked by {}", first.name, _figures(first), WORDS[prefer])
    if any(row.adds_to_heavy for row in order) and not first.adds_to_heavy:
        text += ", metal taken off before metal added"
    if len(order) > 1:
        text += said("; next is {}: {}", order[1].name, _figures(order[1]))
    return text


def _figures(row: ComparedRow) -> Text:
    cuts = f"{row.cuts} cut{'' if row.cuts == 1 else 's'}, {row.different_cuts} different"
    wall = "" if row.wall_left_mm is None else said(", {} of wall left", mm(row.wall_left_mm, ".1f"))
    thin = "" if row.web_metal_share is None else f", {100.0 * row.web_metal_share:.0f} % of webs' metal kept"
    return said("{}, {} moved{}{}", cuts, g(row.metal_moved_g or 0.0, ".1f"), wall, thin)


def _row(
    methods: tuple[str, ...], rotor: Rotor, tolerance: Tolerance, result: Result, capacity: float
) -> ComparedRow:
    change = result.final_moments - result.initial_moments
    adds = any(correction.KINDS[each.kind].adds_metal for each in result.corrections)
    is_light = too_light_g_mm(workpiece(rotor, tolerance, result.initial)) is not None
    return ComparedRow(
        methods,
        result.outcome,
        result.reason,
        residual_share=tolerance.used_share(result.residual),
        residual_g_mm=result.residual.magnitude_g_mm,
        mass_change_g=float(change.mass_g),
        inertia_change_g_mm2=change.polar_inertia_g_mm2,
        metal_moved_g=float(sum(moved_g(c, rotor.density_g_mm3) for c in result.corrections)),
        cuts=len(result.corrections),
        different_cuts=len({(setting_of(cut), round(depth, 6)) for cut, depth in result.made}),
        depths_mm=tuple(float(c.depth_mm) for c in result.corrections),
        wall_left_mm=wall_left_mm(result.corrections, rotor.anatomy),
        web_metal_share=least_share(web_metal(rotor.solid, result.solid, rotor.anatomy)),
        capacity=None if math.isinf(capacity) else capacity,
        capacity_is_plenty=math.isinf(capacity),
        adds_to_heavy=adds and not is_light,
    )


def moved_g(cut: Correction, density_g_mm3: float) -> float:
    keys = correction.KINDS[cut.kind].pressed_in
    pressed_in_g = 0.0 if keys is None else float(cut.details[keys[0]])
    return abs(cut.removed_volume_mm3) * density_g_mm3 + pressed_in_g


def wall_left_mm(corrections: Sequence[Correction], anatomy: Anatomy) -> float | None:
    """Return the least metal left beside corrections, as each kind measures it; None: none is weakened.

    Holes and slugs: the wall measured around them. Lowered faces: the rest of the web's thickness. Turned
    rims: the metal outside of the crankpins. Added metal weakens nothing.
    """
    by_kind = {name: [cut for cut in corrections if cut.kind == name] for name in correction.KINDS}
    walls = [correction.KINDS[name].wall_left_mm(cut, anatomy) for name, cut in by_kind.items() if cut]
    return min((wall for wall in walls if wall is not None), default=None)


def _capacity(
    rotor: Rotor, tolerance: Tolerance, chosen: Sequence[Limits], result: Result, offers: Offers
) -> float:
    """Return the largest multiple of the initial unbalance that may be corrected; 1 is just this one.

    A coarse grid of places holds nearly as many holes as a fine one, but may miss the direction of a small
    unbalance: where that was corrected, the fine grid is tried too.
    """
    work = workpiece(rotor, tolerance, result.initial, look=MOST_CAPACITY)
    is_met = tolerance.used_share(result.residual) <= 1.0
    coarse, fine = _efforts(chosen, coarse=True), _efforts(chosen, coarse=False)
    multiple = 0.0
    for search_levels in (coarse, fine) if is_met and coarse != fine else (coarse,):
        parts = []
        for limits, least in zip(chosen, search_levels, strict=True):
            for search_level in dict.fromkeys((least, correction.search_levels(limits) - 1)):
                try:
                    parts.append(offers(work, limits, search_level))
                    break
                except CorrectionError:
                    continue
        multiple = greatest_multiple(result.initial, tolerance, correction.joined(parts), MOST_CAPACITY)
        if multiple >= 1.0:
            break
    if is_met:
        multiple = max(multiple, 1.0)
    return math.inf if multiple >= MOST_CAPACITY else multiple


def _efforts(chosen: Sequence[Limits], *, coarse: bool) -> list[int]:
    """Return the search level for each kind: the largest, or the least where places lie on a grid."""
    return [
        0 if coarse and correction.kind_of(limits).has_axis else correction.search_levels(limits) - 1
        for limits in chosen
    ]
