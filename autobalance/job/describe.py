"""A job as plain values for the report: in the job file's own words, defaults filled in."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

from autobalance.crank.anatomy import PinHint
from autobalance.job.model import Crankshaft
from autobalance.job.read import Job
from autobalance.job.scan_keys import described_holes, described_readings
from autobalance.units import G_PER_MM3_PER_KG_M3


def describe(job: Job) -> dict[str, Any]:
    """Return the job as JSON values; None for an optional key that is missing.

    Everything has the units of the job file, so that ``parse`` takes it back once ``file`` and the Nones are
    dropped.
    """
    filled = copy.deepcopy(dict(job.filled))
    for key in job.lacks:
        table, _, name = key.partition(".")
        filled[table][name] = None
    return {"file": str(job.path.resolve()), "crankshaft": _crankshaft(job), **filled}


def _crankshaft(job: Job) -> dict[str, Any]:
    """Return the present table; a crank that is an object is in its place."""
    crank, hints, raw = job.crankshaft, job.crankshaft.overrides, job.raw.get("crankshaft", {})
    weighed = crank.weighed
    densities = {"density_kg_m3": crank.density_g_mm3, "density_pm_kg_m3": crank.density_pm_g_mm3}
    return {
        "file": raw.get("file", None if crank.file is None else str(crank.file)),
        "unit": crank.unit,
        **{
            key: None if density is None else _as_said(raw.get(key), density / G_PER_MM3_PER_KG_M3)
            for key, density in densities.items()
        },
        **_scan(crank, raw),
        **({} if weighed.scan_accuracy_mm is None else {"scan_accuracy_mm": weighed.scan_accuracy_mm}),
        **described_readings(weighed.readings),
        **described_holes(weighed.holes),
        "crankpin_in_file": crank.crankpin_in_file,
        "axis_point_mm": _listed(hints.axis_point_mm),
        "axis_direction": _listed(hints.axis_direction),
        "crankpins": None if hints.crankpins is None else [_pin(pin) for pin in hints.crankpins],
        "main_journals": None if hints.main_journals is None else [_pin(pin) for pin in hints.main_journals],
        "body": crank.body,
    }


def _scan(crank: Crankshaft, raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys that name the crank's scan, where its drawing is cut."""
    if crank.scan is None:
        return {}
    return {"scan_file": raw.get("scan_file", str(crank.scan.file)), "scan_unit": crank.scan.unit}


def _as_said(stated: float | None, now: float) -> float:
    """Return a number in the job's own digits, where it still has the job's value."""
    return float(stated) if stated is not None and math.isclose(stated, now, rel_tol=1e-12) else now


def _pin(pin: PinHint) -> dict[str, Any]:
    return {
        "centre_mm": _listed(pin.centre_mm),
        "diameter_mm": pin.diameter_mm,
        "width_mm": pin.width_mm,
    }


def _listed(values: Any) -> list[float] | None:
    return None if values is None else [float(value) for value in values]
