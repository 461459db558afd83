"""Kinds of correction: one class in one file each, registered here by one line."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from autobalance.correction import add, drill, mill, shoulder, slug, turn
from autobalance.correction.apart import between_kinds
from autobalance.correction.contract import Apart, Correction, Count, Cut, Limits, SharedDepth, Variety
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.overlap import Overlap
from autobalance.correction.registry import KINDS, face_depths_mm, finishing, kind_of, mixes, register
from autobalance.crank.anatomy import Anatomy

__all__ = [
    "KINDS",
    "Limits",
    "face_depths_mm",
    "finishing",
    "joined",
    "kind_of",
    "mixes",
    "offer",
    "register",
    "search_levels",
]

register(shoulder.KIND)
register(turn.KIND)
register(drill.KIND)
register(slug.KIND)
register(add.KIND)
register(mill.KIND)


def search_levels(limits: Limits) -> int:
    return kind_of(limits).search_levels


def offer(work: Workpiece, limits: Limits, search_level: int) -> Candidates:
    return kind_of(limits).offer(work, limits, search_level)


def remarks(
    corrections: Sequence[Correction], anatomy: Anatomy, methods: Sequence[Limits]
) -> tuple[str, ...]:
    """Return the checks of a plan's corrections that need a person, one line each."""
    of_kinds = {kind_of(limits).name: limits for limits in methods}
    return tuple(
        line
        for name, limits in of_kinds.items()
        for line in kind_of(limits).remarks(
            [each for each in corrections if each.kind == name], anatomy, limits
        )
    )


def joined(parts: Sequence[Candidates]) -> Candidates:
    """Return the candidates of several kinds as one, with rules that keep their cuts apart."""
    cuts: list[Cut] = []
    kinds: list[int] = []
    shared: list[SharedDepth] = []
    apart: list[Apart] = []
    counts: list[Count] = []
    varieties: list[Variety] = []
    overlaps: list[Overlap] = []
    for number, part in enumerate(parts):
        shift = len(cuts)
        shared += [_shifted(pair, shift) for pair in part.shared]
        apart += [_shifted(pair, shift) for pair in part.apart]
        overlaps += [_shifted(pair, shift) for pair in part.overlaps]
        counts += [replace(rule, members=tuple(k + shift for k in rule.members)) for rule in part.counts]
        varieties += [
            replace(rule, groups=tuple(tuple(k + shift for k in group) for group in rule.groups))
            for rule in part.varieties
        ]
        cuts += part.cuts
        kinds += [number] * len(part.cuts)
    apart += between_kinds(cuts, kinds)
    same_depth = len(parts) == 1 and parts[0].same_depth
    notes = tuple(dict.fromkeys(note for part in parts for note in part.notes))
    return Candidates(
        tuple(cuts),
        tuple(shared),
        same_depth,
        tuple(apart),
        tuple(counts),
        tuple(varieties),
        notes,
        tuple(overlaps),
        equal=len(parts) == 1 and parts[0].equal,
    )


_Pair = TypeVar("_Pair", SharedDepth, Apart, Overlap)


def _shifted(pair: _Pair, shift: int) -> _Pair:
    return replace(pair, first=pair.first + shift, second=pair.second + shift)
