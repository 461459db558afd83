"""``ab.schema``: the JSON Schema of a file that the program reads or writes, for editors and checks."""

from __future__ import annotations

from typing import Any

from autobalance import registry
from autobalance.errors import UsageError

Values = dict[str, Any]

READ_FILES = (
    *("job", "reading", "trials", "machine", "machine-tool-file", "crank-file", "bearing-file"),
    *("rotor-file", "chain-file", "drive-file", "bench-file", "engine-bench-file", "fem-file", "design-file"),
)
"""TOML files that are read."""
NAMES = (*READ_FILES, *("report", "inspect", "recut"), *registry.REPORTS)
"""Files that have a schema: what is read first, then what is written."""
DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schema(name: str) -> Values:
    """Return the JSON Schema (draft 2020-12) of a kind of file.

    Parameters
    ----------
    name : str
        One of ``NAMES``: TOML files as they are parsed, reports as JSON.

    Raises
    ------
    UsageError
        If there is none of that name.

    Examples
    --------
    >>> schema("trials")["required"]
    ['initial', 'trial']
    """
    if name not in NAMES:
        raise UsageError(f"schema {name!r} does not exist; choose one of {', '.join(NAMES)}")
    if name == "job":
        from autobalance.job.tables import job_schema

        return job_schema()
    if name in READ_FILES:
        from autobalance.job.reading import forms_of
        from autobalance.toml_files.keys import json_schema

        title = f"{name.removesuffix('-file').upper()}.toml of autobalance"
        return json_schema(title, *forms_of(name).values())
    if name in registry.REPORTS:
        return _of_record(registry.loaded(registry.REPORTS[name]))
    return _report(name)


def _report(name: str) -> Values:
    from autobalance.report.balance.values import schema as report_schema

    whole = report_schema()
    if name == "report":
        return whole
    properties = {**whole["properties"], "command": {"const": name}}
    return {**whole, "title": f"Report of autobalance {name}", "properties": properties}


def _of_record(record: Any) -> Values:
    from autobalance.declare.schema import schema_of

    head = {"title": f"Report of autobalance {record.command}", **getattr(record, "SCHEMA_HEAD", {})}
    return schema_of(record, {"$schema": DRAFT, **head}, [])
