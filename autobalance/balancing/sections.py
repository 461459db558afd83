"""Parts of the main report that add-ons compute of the crank before and after its cuts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from autobalance import registry
from autobalance.balancing.measured import Crank
from autobalance.declare import decoded, described
from autobalance.errors import AutobalanceError
from autobalance.job import Job
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.runtime import Notify
from autobalance.solid.csg.solid import Solid
from autobalance.value_classes import dataclass


class State(NamedTuple):
    """The crank as it was measured, and the solid and moments that it has at one end of the run."""

    job: Job
    crank: Crank
    solid: Solid
    moments: Moments


@dataclass(frozen=True)
class ReportSection:
    """A part of the report: ``record`` declares its content, ``meaning`` describes it.

    ``begun`` computes the quantities of the crank before; with it ``ended`` makes the record of the crank
    after. ``text`` and ``page`` show a record, on the terminal and as (template, values). ``unchecked`` is
    the reason why ``verify`` cannot compute it again, empty if it can. ``require`` raises if an extra is
    missing.
    """

    record: type
    meaning: str
    begun: Callable[[State], Any]
    ended: Callable[[Any, State, Notify], Any]
    text: Callable[[Any], str]
    page: Callable[[Any], tuple[str, Mapping[str, Any]]]
    unchecked: Callable[[Job], str] = lambda _: ""
    require: Callable[[], None] = lambda: None


def section(key: str) -> ReportSection:
    """Return the section that the report has under a key."""
    found: ReportSection = registry.loaded(registry.RUN_SECTIONS[key].place)
    return found


def of_job(job: Job) -> Iterator[tuple[str, ReportSection]]:
    """Yield key and section of those that a job asks for by one of its tables."""
    for key, each in registry.RUN_SECTIONS.items():
        if each.table in job.raw:
            yield key, section(key)


def begun(state: State) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the values that a job's sections need of the uncut crank, and a warning of each left out."""
    found: dict[str, Any] = {}
    warnings = []
    for key, each in of_job(state.job):
        try:
            found[key] = each.begun(state)
        except AutobalanceError as error:
            warnings.append(f"{key.replace('_', ' ')} are left out: {error}")
    return found, tuple(warnings)


def ended(found: Mapping[str, Any], state: State, notify: Notify) -> dict[str, Any]:
    """Return the records of the sections that were begun, of the crank after its cuts."""
    return {key: section(key).ended(each, state, notify) for key, each in found.items()}


def sections_in(report: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield key and record of each section of a report as written."""
    for key in registry.RUN_SECTIONS:
        if report.get(key):
            yield key, decoded(section(key).record, report[key])


def section_types() -> dict[str, Any]:
    """Return the record of each section by its key in the report."""
    found = {key: section(key) for key in registry.RUN_SECTIONS}
    return {key: described(each.record, each.meaning) for key, each in found.items()}
