"""Changes of a job's limits that would make its tolerance reachable: computed, not guessed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from autobalance import correction
from autobalance.correction.contract import Cut, Limits
from autobalance.correction.kind import Candidates, Kind, Workpiece
from autobalance.correction.relaxing import MoreCuts, Otherwise, Relaxing, WiderLimits
from autobalance.crank.faces import find_faces
from autobalance.declare import UNWRITTEN, NotNegative, Ordinal, derived
from autobalance.errors import CorrectionError
from autobalance.planning.depths import Plan, judged_rows
from autobalance.planning.milp import least_share
from autobalance.planning.whole_cuts import choose
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import Notify
from autobalance.value_classes import dataclass

# Passes of a plan, and changes of a job that would make its tolerance reachable, as a report has them.


UNITS = {"_kg_m3": "kg/m³", "_mm": "mm", "_deg": "°"}


@dataclass(frozen=True)
class Step:
    """A pass: predicted and measured.

    ``depths_mm`` has one entry a correction, in the order of the result's corrections; magnitudes are those
    of the resultant [g·mm], predicted of the plan and measured on the cut solid.
    """

    step: Ordinal
    depths_mm: Sequence[NotNegative]
    predicted_g_mm: NotNegative
    measured_g_mm: NotNegative


@dataclass(frozen=True)
class JobChange:
    """A key of the job that a relaxation changes."""

    key: Annotated[str, "dotted, as --set takes it"]
    present: Annotated[Any, "null: the job has no such table"]
    proposed: Any

    @derived
    def unit(self) -> str | None:
        """Return the unit of its values."""
        return next((unit for ending, unit in UNITS.items() if self.key.endswith(ending)), None)


@dataclass(frozen=True)
class Relaxation:
    """Changes of the job that together make the tolerance reachable.

    ``methods`` are the job's limits with the changes; empty where these are other keys.
    """

    text: str
    changes: Sequence[JobChange]
    used_share: Annotated[NotNegative, "largest judged value then, over its permissible value"]
    metal_g: Annotated[NotNegative | None, "metal that it takes then; null: the cuts stay as they are"]
    tried: Annotated[bool, "a new plan was made with the changes; false: follows from the residual"] = True
    methods: Annotated[tuple[Limits, ...], UNWRITTEN] = ()


EXTRA_CUTS = 6
"""Largest number of further cuts tried."""
HALVINGS = 4
MAX_SEARCHES = 4
"""Searches for metal at most, each four times deeper."""
MOST_OFFERS = 24
"""Searches for cuts with other limits, at most: of a large crank each takes a second or two."""
MOST_PLANNED = 1000
"""Cuts in all plans tried for advice, at most: a number, so that advice is the same on every machine. A
cross-plane V8 with four drills plans 80 to 512 at a time, each in one to three seconds."""
MOST_LIGHTER = 2
"""Other kinds proposed that take metal off, at most."""
NAMED_RELAXATIONS = 3
"""Relaxations named, at most."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """Inputs of a plan that fell short; ``asked`` are all of the job's limits, placed or not.

    ``looks`` are the limits with which cuts were searched since, ``planned`` the numbers of cuts in the plans
    made since. ``left_out`` lists the attempts that were skipped. ``progress`` receives the current attempt.
    """

    work: Workpiece
    methods: tuple[Limits, ...]
    asked: tuple[Limits, ...]
    candidates: Candidates
    residual: Unbalance
    tolerance: Tolerance
    looks: list[Sequence[Limits]] = field(default_factory=list)
    planned: list[int] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    progress: Notify = lambda _: None

    @cached_property
    def bound(self) -> float:
        """Lower bound of the share that plans of the job's own cuts leave: seconds on a large crank."""
        return least_share(self.residual, self.tolerance, self.candidates)

    def plan(self, candidates: Candidates) -> Plan:
        """Return a plan that reaches the tolerance, however heavy, else the one that comes nearest."""
        self.planned.append(len(candidates.cuts))
        return choose(self.residual, self.tolerance, candidates, any_will_do=True)

    def may_do(self, candidates: Candidates) -> bool:
        """Return whether other cuts may suffice: there is room to plan them, and no bound rules them out."""
        if not candidates.cuts or self.is_too_much(len(candidates.cuts)):
            return False
        return least_share(self.residual, self.tolerance, candidates) <= 1.0

    def is_too_much(self, count: int) -> bool:
        """Return whether a plan of so many cuts is more than `MOST_PLANNED` allows, and note it then.

        To be asked before cuts are searched: on a V8 with 943 holes to choose from each search and each bound
        that came to nothing took two to three seconds.
        """
        if sum(self.planned) + count <= MOST_PLANNED:
            return False
        self.left_out.append(f"a plan of {count} cuts")
        return True

    def offer_with(self, *methods: Limits, coarse: bool = False) -> Candidates | None:
        """Return candidates of other limits at their last search level (or first: ``coarse``); None: no cuts.

        None too after `MOST_OFFERS` searches: advice is not worth minutes.
        As in planning itself, the search for metal goes deeper while cuts end only at its reach.
        """
        last = [0 if coarse else correction.search_levels(limits) - 1 for limits in methods]
        work = self.work
        try:
            for _ in range(MAX_SEARCHES):
                if len(self.looks) >= MOST_OFFERS:
                    self.left_out.append("a search for cuts")
                    return None
                self.looks.append(methods)
                candidates = correction.joined(
                    [
                        correction.offer(work, m, search_level)
                        for m, search_level in zip(methods, last, strict=True)
                    ]
                )
                if not any(cut.limit_is_reach for cut in candidates.cuts) or self.may_do(candidates):
                    break
                work = replace(work, look=4.0 * work.look)
        except CorrectionError:
            return None
        return candidates


def relaxations(tried: Attempt, more_of_the_same: bool = True) -> list[Relaxation]:
    """Return changes of single limits that suffice, the one that takes the least metal first.

    Without ``more_of_the_same``, more cuts and deeper ones are passed over: they act the wrong way.
    """
    relaxations_found = []
    for number, limits in enumerate(tried.methods):
        for way in correction.kind_of(limits).relaxing(limits):
            if not more_of_the_same and isinstance(way, MoreCuts | WiderLimits):
                continue
            tried.progress(f"trying {_words(limits, way)}")
            relaxed = _relaxed(tried, number, way)
            relaxations_found += [] if relaxed is None else [relaxed]
    relaxations_found += _remedies(tried)
    return sorted(relaxations_found, key=lambda relaxed: round(relaxed.metal_g or 0.0, 6))[:NAMED_RELAXATIONS]


def _words(limits: Limits, way: Relaxing) -> str:
    """Return a way to relax limits in a few words, for the progress."""
    name = correction.kind_of(limits).name
    return f"{name}: {way.text}" if isinstance(way, Otherwise) else f"another {name}.{way.key}"


RemedyText = tuple[str, tuple[JobChange, ...]]


def _changes(limits: Limits, changed: Mapping[str, Any]) -> tuple[JobChange, ...]:
    table = f"correction.{correction.kind_of(limits).name}"
    return tuple(JobChange(f"{table}.{key}", getattr(limits, key), value) for key, value in changed.items())


def _relaxed(tried: Attempt, number: int, way: Relaxing) -> Relaxation | None:
    if isinstance(way, MoreCuts):
        return _more(tried, tried.methods[number], way)
    if tried.is_too_much(len(tried.candidates.cuts)):  # wider limits leave no fewer
        return None
    if isinstance(way, WiderLimits):
        return _wider(tried, number, way)
    methods = list(tried.methods)
    methods[number] = replace(methods[number], **way.changed)
    remedy = way.text, _changes(tried.methods[number], way.changed)
    return _if_enough(tried, tried.offer_with(*methods), lambda _: remedy, methods)


def _if_enough(
    tried: Attempt,
    candidates: Candidates | None,
    describe: Callable[[Plan], RemedyText],
    methods: Sequence[Limits],
) -> Relaxation | None:
    if candidates is None or not tried.may_do(candidates):
        return None
    plan = tried.plan(candidates)
    if plan.share > 1.0:
        return None
    cuts = zip(candidates.cuts, plan.depths_mm, strict=True)
    metal = sum(abs(cut.effect(float(depth)).mass_g) for cut, depth in cuts if depth > 0.0)
    return Relaxation(*describe(plan), plan.share, float(metal), methods=tuple(methods))


def _more(tried: Attempt, limits: Limits, more: MoreCuts) -> Relaxation | None:
    """Return the relaxation by the least number of further cuts, on each web or on all; else None."""
    if not tried.candidates.counts:
        return None

    def offer(count: int) -> Candidates:
        counts = [
            replace(rule, most=rule.most + count) if rule.limit.startswith(more.key) else rule
            for rule in tried.candidates.counts
        ]
        return replace(tried.candidates, counts=tuple(counts))

    def suffice(count: int) -> bool:
        return tried.may_do(offer(count)) and tried.plan(offer(count)).share <= 1.0

    if not suffice(EXTRA_CUTS):
        return None
    least = next((count for count in range(1, EXTRA_CUTS) if suffice(count)), EXTRA_CUTS)
    changed = {more.key: more.now + least}
    remedy = more.say(least), _changes(limits, changed)
    methods = [replace(each, **changed) if each is limits else each for each in tried.methods]
    return _if_enough(tried, offer(least), lambda _: remedy, methods)


def _wider(tried: Attempt, number: int, wider: WiderLimits) -> Relaxation | None:
    """Return the relaxation by the least share, 0 to 1, of a change of one method's limits; else None."""

    def with_share(share: float) -> list[Limits]:
        methods = list(tried.methods)
        methods[number] = replace(methods[number], **wider.changed(share))
        return methods

    def relaxed(share: float) -> Relaxation | None:
        changed, methods = wider.changed(share), with_share(share)
        remedy = wider.say(changed), _changes(tried.methods[number], changed)
        return _if_enough(tried, tried.offer_with(*methods), lambda _: remedy, methods)

    best = relaxed(1.0)
    if best is None:
        return None
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        here = relaxed(middle)
        low, high, best = (low, middle, here) if here is not None else (middle, high, best)
    return best


def _remedies(tried: Attempt) -> Iterator[Relaxation]:
    """Yield relaxations by single cuts of a usual size, of kinds that the job does not place."""
    present = [correction.kind_of(limits) for limits in tried.methods]
    for kind in correction.KINDS.values():
        if kind in present or kind.remedy is None or not _may_help(tried, kind):
            continue
        tried.progress(f"trying {kind.name} as well")
        candidates = tried.offer_with(kind.remedy, coarse=True)
        if candidates is None:
            continue
        first = len(tried.candidates.cuts)
        both = correction.joined([tried.candidates, candidates])

        def describe(
            plan: Plan, kind: Kind[Any] = kind, candidates: Candidates = candidates, first: int = first
        ) -> RemedyText:
            chosen = [
                cut for cut, depth in zip(candidates.cuts, plan.depths_mm[first:], strict=True) if depth > 0.0
            ]
            return _remedy(tried, kind, chosen[0]) if chosen else ("other depths", ())

        relaxed = _if_enough(tried, both, describe, ())
        if relaxed is not None:
            keys = _own_keys(relaxed.changes, kind.name)
            limits = kind.limits(**keys) if keys else kind.remedy
            yield replace(relaxed, methods=(*tried.methods, limits))


def _always(remedy: RemedyText) -> Callable[[Plan], RemedyText]:
    return lambda _: remedy


def _own_keys(changes: Sequence[JobChange], name: str) -> dict[str, Any]:
    """Return the proposed keys of a kind's own table."""
    table = f"correction.{name}."
    return {
        change.key.removeprefix(table): change.proposed for change in changes if change.key.startswith(table)
    }


def lighter(tried: Attempt) -> Iterator[Relaxation]:
    """Yield relaxations by kinds that take metal off all around, of those that the job does not name.

    They are tried alone, then with the job's own.
    """
    work = tried.work
    if not work.faces:
        work = replace(work, faces=tuple(find_faces(work.solid.mesh, work.anatomy)))
    tried = replace(tried, work=work, looks=[], planned=[])  # of all advice, this is the likeliest
    names = tuple(correction.kind_of(limits).name for limits in tried.asked)
    kinds = [
        kind
        for kind in correction.KINDS.values()
        if not (kind.name in names or kind.adds_metal or kind.has_axis)
    ]
    found = 0
    for others in ((), tried.methods):
        for kind in kinds:
            limits = kind.limits()
            method = (kind.name, *(correction.kind_of(each).name for each in others))
            tried.progress(f"trying {' and '.join(method)}")
            own = tried.offer_with(limits)
            if own is None:
                continue
            candidates = correction.joined([own, tried.candidates]) if others else own
            text = f"{kind.noun.lower()}s {'as well' if others else 'instead'} (method {', '.join(method)})"
            remedy = text, (JobChange("correction.method", names, method),)
            relaxed = _if_enough(tried, candidates, _always(remedy), (limits, *others))
            if relaxed is not None:
                yield relaxed
                found += 1
            if found == MOST_LIGHTER:
                return
        if found:
            return


def _may_help(tried: Attempt, kind: Kind[Any]) -> bool:
    """Return whether a kind's remedy might make up the least residual of the cuts available.

    A change of the unbalance at a height z of the crank moves each judged vector by ``rows`` · (1, z) of it.
    """
    frame, (low, high) = tried.work.anatomy.file_to_rotor, tried.work.solid.bounds
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    z, reach = float(frame[2, :3] @ middle + frame[2, 3]), float(np.abs(frame[2, :3]) @ half)
    rows = judged_rows(tried.tolerance)
    levers = np.abs(rows[::2, 0, None] + rows[::2, 2, None] * np.array([z - reach, z + reach]))
    moved = kind.remedy_most_g_mm(tried.work) * float(levers.max())
    return tried.bound - moved <= 1.0


def _remedy(tried: Attempt, kind: Kind[Any], cut: Cut) -> RemedyText:
    names = [correction.kind_of(limits).name for limits in tried.asked]
    keys = kind.remedy_keys(cut).items()
    changes = [JobChange(f"correction.{kind.name}.{key}", None, value) for key, value in keys]
    if kind.name not in names:
        changes.insert(0, JobChange("correction.method", tuple(names), (*names, kind.name)))
    return kind.remedy_text(cut), tuple(changes)
