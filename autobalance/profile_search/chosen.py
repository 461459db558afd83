"""Choice of the designs to write: the front, as far as it holds when measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from autobalance.errors import SolidError
from autobalance.profile_search.candidates import Candidate, SearchResult, front, least_violated, spread_over
from autobalance.profile_search.envelope import violation
from autobalance.profile_search.refine import refined
from autobalance.profile_search.strength_model import Analysed
from autobalance.profile_search.written import WrittenDesign, written

TRIED_MOST = 20
"""Largest number of designs that are written in the search for some that keep every constraint."""


@dataclass(frozen=True, eq=False)
class Chosen:
    """Designs to be written.

    Attributes
    ----------
    designs : sequence of WrittenDesign
    kept : bool
        Whether they keep every constraint when measured; else there is one design, the least violated.
    found : SearchResult
        Including the analyses of the written designs.
    told_errors : mapping
        Largest error of the model at the written designs, before it knew these; by name, as shares.
    """

    designs: tuple[WrittenDesign, ...]
    kept: bool
    found: SearchResult
    told_errors: dict[str, float]


def with_refined(findings: SearchResult) -> SearchResult:
    """Return the findings, with the best candidate of each objective refined by gradients and added."""
    problem, every = findings.problem, list(findings.candidates)
    for objective in range(len(problem.design.search.objectives)):
        best = min(every, key=lambda each: (each.violation, each.objectives[objective]))
        every.append(refined(problem, best, objective))
    return replace(findings, candidates=tuple(every))


def chosen(findings: SearchResult) -> Chosen:
    """Return the designs to be written, and whether they keep every constraint when measured.

    The front comes first. Where finite elements are wanted, its results improve the model, and the front by
    the better model is measured in turn, until all of it was measured. Where no design keeps every
    constraint, designs from all over the feasible ones follow, and at last the least violated one measured.
    """
    tried = _Tried(findings)
    while True:
        numbers = tried.wanted()
        new = [number for number in numbers if number not in tried.made][: TRIED_MOST - len(tried.made)]
        if not new:
            break
        tried.write(new)
        if tried.kept(numbers) and tried.found.problem.model is None:
            break
    kept = tried.kept(numbers) or tried.kept(list(tried.made))
    if not kept and not tried.made:
        tried.write_least_violated()
        kept = tried.kept(list(tried.made))
    designs = kept or [min(tried.made.values(), key=lambda each: violation(each.constraints))]
    return Chosen(tuple(designs), bool(kept), tried.found, tried.told_errors)


class _Tried:
    """Written designs by their index among the candidates."""

    def __init__(self, findings: SearchResult) -> None:
        self.found = findings
        self.made: dict[int, WrittenDesign] = {}
        self.told_errors: dict[str, float] = {}
        self._failed: dict[int, SolidError] = {}

    def wanted(self) -> list[int]:
        """Return the indices of the designs to write by present knowledge."""
        every, count = self.found.candidates, self.found.problem.design.search.designs
        left = [
            number
            for number, each in enumerate(every)
            if number not in self._failed
            and (self.made[number].feasible if number in self.made else each.violation <= 0.0)
        ]
        if not left:
            return []
        seen = [every[number] for number in left]
        confirmed = not self.made or any(each.feasible for each in self.made.values())
        among = front(seen) if confirmed or self.found.problem.model is not None else range(len(seen))
        return [left[place] for place in spread_over(seen, list(among), min(count, TRIED_MOST))]

    def kept(self, numbers: Sequence[int]) -> list[WrittenDesign]:
        """Return the written designs among ``numbers`` that keep every constraint when measured."""
        return [self.made[number] for number in numbers if number in self.made and self.made[number].feasible]

    def write(self, numbers: Sequence[int]) -> None:
        """Write and measure designs, and judge all candidates again by the results."""
        problem, analysed = self.found.problem, []
        for number in numbers:
            candidate = self.found.candidates[number]
            try:
                design = written(problem, candidate.variables)
            except SolidError as error:
                self._failed[number] = error
                continue
            self.made[number] = design
            if design.strengths:
                analysed.append(Analysed(design.variables, design.strengths))
                self._compare(design)
        if analysed:
            self.found = self.found.with_known(analysed)
        refine = self.found.problem.design.search.refine
        if analysed and refine and not all(self.made[n].feasible for n in numbers if n in self.made):
            self.found = with_refined(self.found)

    def write_least_violated(self) -> None:
        """Write the least violated design that can be written."""
        order: list[Candidate] = list(least_violated(self.found.candidates))
        places = {id(each): number for number, each in enumerate(self.found.candidates)}
        for candidate in order[:TRIED_MOST]:
            self.write([places[id(candidate)]])
            if self.made:
                return
        raise next(iter(self._failed.values()))

    def _compare(self, design: WrittenDesign) -> None:
        model = self.found.problem.model
        if model is None:
            return
        for name, predicted in model.predicted(design.variables).items():
            off = abs(predicted / design.strengths[name] - 1.0)
            self.told_errors[name] = max(off, self.told_errors.get(name, 0.0))
