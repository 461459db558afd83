"""One file per kind of correction: parameters, limits, tool body, effect."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeVar

from autobalance.correction import add, drill, shoulder, slug, turn
from autobalance.correction.add import AddCut, AddLimits
from autobalance.correction.drill import DrillCut, DrillLimits
from autobalance.correction.hole import keep_apart
from autobalance.correction.kind import Apart, Count, Cut, Offer, SharedDepth, Workpiece
from autobalance.correction.shoulder import ShoulderCut, ShoulderLimits
from autobalance.correction.slug import FillCut, SlugCut, SlugLimits
from autobalance.correction.turn import TurnCut, TurnLimits

Limits = ShoulderLimits | TurnLimits | DrillLimits | SlugLimits | AddLimits
"""The limits of any one kind of correction."""


class _Kind(Protocol):
    """What a kind's module offers."""

    EFFORTS: int

    def offer(self, work: Workpiece, limits: Any, effort: int) -> Offer: ...


_KINDS: dict[type, _Kind] = {
    ShoulderLimits: shoulder,
    TurnLimits: turn,
    DrillLimits: drill,
    SlugLimits: slug,
    AddLimits: add,
}


def efforts(limits: Limits) -> int:
    """Return how many ever wider offers the kind of these limits can make."""
    return _KINDS[type(limits)].EFFORTS


def offer(work: Workpiece, limits: Limits, effort: int) -> Offer:
    """Return the cuts that the kind of these limits offers on a workpiece."""
    return _KINDS[type(limits)].offer(work, limits, effort)


def joined(offers: Sequence[Offer]) -> Offer:
    """Return the offers of several kinds as one, with rules that keep them out of each other's way.

    Holes and slugs keep the greater of their walls between them. Any other two kinds share no web: each was
    measured on metal that the other would take.
    """
    cuts: list[Cut] = []
    kinds: list[int] = []
    shared: list[SharedDepth] = []
    apart: list[Apart] = []
    counts: list[Count] = []
    for number, part in enumerate(offers):
        shift = len(cuts)
        shared += [_shifted(pair, shift) for pair in part.shared]
        apart += [_shifted(pair, shift) for pair in part.apart]
        counts += [replace(rule, members=tuple(k + shift for k in rule.members)) for rule in part.counts]
        cuts += part.cuts
        kinds += [number] * len(part.cuts)
    if len(offers) > 1:
        apart += _between_kinds(cuts, kinds)
    return Offer(
        tuple(cuts), tuple(shared), len(offers) == 1 and offers[0].same_depth, tuple(apart), tuple(counts)
    )


_Pair = TypeVar("_Pair", SharedDepth, Apart)


def _shifted(pair: _Pair, shift: int) -> _Pair:
    return replace(pair, first=pair.first + shift, second=pair.second + shift)


def _between_kinds(cuts: Sequence[Cut], kinds: Sequence[int]) -> list[Apart]:
    bores = [k for k, cut in enumerate(cuts) if isinstance(cut, DrillCut | SlugCut)]
    walls = [cut.limits.min_wall_mm for cut in cuts if isinstance(cut, DrillCut | SlugCut)]
    found = []
    for pair in keep_apart(
        [cut.hole for cut in cuts if isinstance(cut, DrillCut | SlugCut)],
        [cuts[k].max_depth_mm for k in bores],
        max(walls, default=0.0),
    ):
        first, second = bores[pair.first], bores[pair.second]
        if kinds[first] != kinds[second]:
            found.append(Apart(first, second, pair.most_mm))
    webs = [_webs_of(cut) for cut in cuts]
    holes = set(bores)
    for i, one in enumerate(webs):
        for j in range(i + 1, len(cuts)):
            if kinds[i] != kinds[j] and not (i in holes and j in holes) and one & webs[j]:
                found.append(Apart(i, j, -1.0))
    return found


def _webs_of(cut: Cut) -> set[int]:
    if isinstance(cut, DrillCut | SlugCut):
        return {cut.web}
    if isinstance(cut, FillCut):
        return {cut.hole.web}
    if isinstance(cut, TurnCut):
        return set(cut.webs)
    if isinstance(cut, ShoulderCut | AddCut):
        return set() if cut.face.web is None else {cut.face.web}
    return set()
