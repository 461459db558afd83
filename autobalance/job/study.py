"""Read ``[study]``: how a ± is drawn, and what else is uncertain about a crank that is made."""

from __future__ import annotations

from dataclasses import fields

from autobalance.job.model import Distribution, Sampling, StudyOptions
from autobalance.job.toml.table import NOT_NEGATIVE, Rule, Table

WANDER = Rule(lambda x: 0.0 <= x <= 45.0, "must be 0 to 45")


def read_study(root: Table) -> StudyOptions:
    """Return the table ``[study]`` of a job, defaults where it says nothing."""
    table = root.table("study", [field.name for field in fields(StudyOptions)])
    return StudyOptions(
        distribution=table.optional("distribution", Distribution, default="normal"),
        sampling=table.optional("sampling", Sampling, default="random"),
        position_pm_mm=table.optional("position_pm_mm", float, NOT_NEGATIVE, default=0.0),
        wander_pm_deg=table.optional("wander_pm_deg", float, WANDER, default=0.0),
        journal_pm_mm=table.optional("journal_pm_mm", float, NOT_NEGATIVE, default=0.0),
        measurement=table.optional("measurement", bool, default=False),
    )
