"""Declarations of all tables of a job, each from the module that reads it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from autobalance.declare import Key
from autobalance.job.balance import BALANCE
from autobalance.job.header import JOB, SHOP
from autobalance.job.layout import SHAFTS
from autobalance.job.limits import correction_key
from autobalance.job.read_crankshaft import CRANKSHAFT
from autobalance.job.read_engine import ENGINE, ORIGINAL
from autobalance.job.study import STUDY
from autobalance.job.toml.keys import json_schema

OF_TORSION = (
    *("torsion", "excitation", "pendulum", "speed_rpm", "points"),
    *("gear", "branch", "coupling", "damper"),
)
OF_FEW = ("cycle", "assembly", "drive", "mounts", "mount", "strength", "bearings", *OF_TORSION)
"""Tables that few jobs hold; their declarations load what they are about."""
TOP_KEYS = (
    *("crankshaft", "engine", "original", "balance", "correction", "shafts", "study", "job", "shop"),
    *OF_FEW,
)
"""Keys of the top level of a job."""


def job_tables(held: Mapping[str, Any] | None = None) -> tuple[Key, ...]:
    """Return the declarations of a job's tables.

    Of those that few jobs hold, and of the kinds of correction, only what is in ``held``; None: all.
    """
    names = TOP_KEYS if held is None else held
    tables = None if held is None else held.get("correction")
    correction = correction_key(tables if isinstance(tables, Mapping) else None)
    return (CRANKSHAFT, ENGINE, ORIGINAL, BALANCE, correction, SHAFTS, STUDY, JOB, SHOP, *_of_few(names))


def _of_few(held: Collection[str]) -> tuple[Key, ...]:
    keys: list[Key] = []
    if "cycle" in held:
        from autobalance.job.cycle import CYCLE

        keys.append(CYCLE)
    if "assembly" in held:
        from autobalance.job.assembly import ASSEMBLY

        keys.append(ASSEMBLY)
    if "drive" in held:
        from autobalance.job.drive import DRIVE

        keys.append(DRIVE)
    if "mounts" in held or "mount" in held:
        from autobalance.job.mounts import MOUNT, MOUNTS

        keys += [MOUNTS, MOUNT]
    if "strength" in held:
        from autobalance.job.strength import STRENGTH

        keys.append(STRENGTH)
    if "bearings" in held:
        from autobalance.job.bearings import BEARINGS

        keys.append(BEARINGS)
    if any(key in held for key in OF_TORSION):
        from autobalance.job.torsion import OF_A_JOB

        keys += OF_A_JOB
    return tuple(keys)


def key_at(path: str) -> Key:
    """Return the declaration of a job's key, by its dotted path; of a free name, what all such names are.

    Raises
    ------
    KeyError
        If there is none.
    """
    keys: tuple[Key, ...] = job_tables()
    declared = None
    for step in path.split("."):
        name = step.partition("[")[0]
        named = declared.named if declared is not None else None
        declared = named or next((key for key in keys if key.name == name), None)
        if declared is None:
            raise KeyError(path)
        keys = (*declared.keys, *(key for form in declared.forms for key in form.keys))
    assert declared is not None
    return declared


def job_schema() -> dict[str, Any]:
    """Return the JSON Schema of a job as TOML is parsed."""
    return json_schema("job", job_tables())
