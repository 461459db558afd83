"""The report as JSON values: every key of the interface, ``None`` where a thing does not apply, never NaN."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from autobalance.balancing.record import Record
from autobalance.declare import encoded
from autobalance.report.records.report import Report

Values = dict[str, Any]


def report(record: Record) -> Values:
    """Return the report of a run as JSON values, keys in the order of the interface."""
    values: Values = encoded(Report.of(record))
    return values


def dumps(values: Mapping[str, Any]) -> str:
    """Return a report as JSON text; raises ValueError for NaN and infinity.

    Bytes of a file's name that are not UTF-8 become JSON's escapes of lone surrogates, and read back as such.
    """
    text = json.dumps(values, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode("utf-8", "backslashreplace").decode()


def showable(values: Values) -> Values:
    """Return a report for pages, with question marks for bytes of a file's name that are not UTF-8."""
    text = json.dumps(values, ensure_ascii=False)
    shown = text.encode("utf-8", "replace").decode()
    shown_values: Values = values if shown == text else json.loads(shown)
    return shown_values


def schema() -> Values:
    """Return the JSON Schema (draft 2020-12) of reports."""
    from autobalance.report.records.written import written_schema

    return written_schema()
