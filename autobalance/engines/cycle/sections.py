"""Parts of a cycle's report that add-ons compute beside it, as in a crank that bends."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from autobalance import registry
from autobalance.balancing.measured import Crank
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.job import Job
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class CycleSection:
    """A part of the report of a cycle: ``record`` declares what is in it.

    ``computed`` computes it, ``answer`` makes the record, ``text`` shows the record, ``plots`` draw the
    result by name, and ``doubts`` yields the reasons to distrust the model. ``wanted`` is whether a job has
    it; it is never true for a section that an option requests.
    """

    record: type
    computed: Callable[[CycleAnalysis, Job, Crank], Any]
    answer: Callable[[Any, CycleAnalysis], Any]
    text: Callable[[Any], str]
    plots: Callable[[CycleAnalysis, Any], Mapping[str, Any]]
    doubts: Callable[[CycleAnalysis, Job, Any], Iterator[str]]
    wanted: Callable[[Job], bool] = lambda _: True


def cycle_section(key: str) -> CycleSection:
    """Return the section that the report has under a key."""
    found: CycleSection = registry.loaded(registry.CYCLE_SECTIONS[key].place)
    return found


def sections_of(job: Job, asked: Collection[str]) -> dict[str, CycleSection]:
    """Return the sections of a job's cycle by key: those that an option requests, and the job's own."""
    found = {
        key: cycle_section(key)
        for key, place in registry.CYCLE_SECTIONS.items()
        if place.table or key in asked
    }
    return {key: each for key, each in found.items() if key in asked or each.wanted(job)}


def cycle_section_types() -> dict[str, Any]:
    """Return the record of each section by its key in the report."""
    return {key: cycle_section(key).record for key in registry.CYCLE_SECTIONS}
