"""Keys of each file that the program reads beside a job, by the name of its schema."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

from autobalance.declare import Key
from autobalance.job.files.design_keys import DESIGN_KEYS, START_TABLES
from autobalance.job.tables import job_tables

DECLARATIONS: Mapping[str, str] = {
    "reading": "files.reading:READING_KEYS",
    "trials": "files.trials:TRIALS_KEYS",
    "machine": "files.machine:MACHINE_KEYS",
    "machine-tool-file": "files.machine_tool:MACHINE_TOOL_KEYS",
    "crank-file": "files.crank_keys:CRANK_FORMS",
    "bearing-file": "files.bearing_keys:BEARING_FORMS",
    "rotor-file": "files.rotor:ROTOR",
    "chain-file": "files.torsion:CHAIN",
    "drive-file": "drive:DRIVE_KEYS",
    "bench-file": "files.bench:BENCH_KEYS",
    "engine-bench-file": "files.engine_bench:ENGINE_BENCH_KEYS",
    "fem-file": "files.fem:FEM_KEYS",
    "design-file": "files.design_keys:DESIGN_KEYS",
}
"""Name → module of ``job`` and its declaration; a name alone is the verb's that reads it."""


def forms_of(name: str) -> Mapping[str, tuple[Key, ...]]:
    """Return the keys at the top level of a file, by its form; most have one, without a name."""
    module, declaration = DECLARATIONS[name].split(":")
    declared = getattr(import_module(f"autobalance.job.{module}"), declaration)
    if isinstance(declared, Mapping):
        return declared
    if declared is DESIGN_KEYS:
        declared = (*(key for key in job_tables() if key.name in START_TABLES), *declared)
    return {"": declared}
