"""A job for ``recut``, with separate defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from autobalance.correction import KINDS
from autobalance.job.balance import LISTED, planned_anew
from autobalance.job.model import CrankReadings
from autobalance.job.read import Job, parse

USUAL_PREFERENCE = "simple"
"""Secondary objective of `balance` if a job sets no objective."""


def for_recut(job: Job, correction: Mapping[str, Any] | None) -> Job:
    """Return the job of a further stage, with the reading's ``[correction]``, if any, in place of the job's.

    Earlier set-ups are used first (``prefer = "same_setup"``), and existing holes may be deepened, unless the
    table sets otherwise. A report has ``"simple"`` if its job had no setting.
    """
    table = dict(job.raw["correction"] if correction is None else correction)
    if table.get("prefer", USUAL_PREFERENCE) == USUAL_PREFERENCE and (
        correction is None or "prefer" not in correction
    ):
        table["prefer"] = "same_setup"
    if table.get("method") in (LISTED, [LISTED]):
        table = planned_anew(table)
    method = table.get("method", [])
    for name in [method] if isinstance(method, str) else method:
        if name in KINDS and any(each.name == "deepen" for each in fields(KINDS[name].limits)):
            own = table.get(name) or {}
            table[name] = {**own, "deepen": True} if own.get("deepen") is None else own
    again = parse({**job.raw, "correction": table}, job.path, crank_given=True)
    # a scale, a micrometer and a scanner saw the crank before it was cut
    crankshaft = replace(job.crankshaft, readings=CrankReadings(), scan=None)
    # with external parts that were solved, and the oil of the crank as it came
    engine = replace(again.engine, attached=job.engine.attached, oil=job.engine.oil)
    return replace(again, settings=job.settings, crankshaft=crankshaft, engine=engine)
