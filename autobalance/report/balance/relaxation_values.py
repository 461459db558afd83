"""What would reach the tolerance where the limits of a job do not, key by key, as JSON values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from autobalance.planning.relaxation import Change, Relaxation
    from autobalance.report.records import balance as balance_records

UNITS = {"_kg_m3": "kg/m³", "_mm": "mm", "_deg": "°"}


def relaxation_values(relaxation: Relaxation) -> balance_records.Relaxation:
    """Return a relaxation with each key of the job that it changes."""
    return {
        "text": relaxation.text,
        "changes": [_change(each) for each in relaxation.changes],
        "used_share": relaxation.used_share,
        "metal_g": relaxation.metal_g,
        "tried": relaxation.tried,
    }


def _change(change: Change) -> balance_records.JobChange:
    return {
        "key": change.key,
        "present": _plain(change.present),
        "proposed": _plain(change.proposed),
        "unit": next((unit for ending, unit in UNITS.items() if change.key.endswith(ending)), None),
    }


def _plain(value: Any) -> Any:
    return [_plain(each) for each in value] if isinstance(value, tuple) else value
