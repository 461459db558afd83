"""Passes of a plan, and changes of a job that would make its tolerance reachable, as a report has them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from autobalance.correction.contract import Limits
from autobalance.declare import UNWRITTEN, NotNegative, Ordinal, derived
from autobalance.value_classes import dataclass

UNITS = {"_kg_m3": "kg/m³", "_mm": "mm", "_deg": "°"}


@dataclass(frozen=True)
class Step:
    """A pass: predicted and measured.

    ``depths_mm`` has one entry a correction, in the order of the result's corrections; magnitudes are those
    of the resultant [g·mm], predicted of the plan and measured on the cut solid.
    """

    step: Ordinal
    depths_mm: Sequence[NotNegative]
    predicted_g_mm: NotNegative
    measured_g_mm: NotNegative


@dataclass(frozen=True)
class JobChange:
    """A key of the job that a relaxation changes."""

    key: Annotated[str, "dotted, as --set takes it"]
    present: Annotated[Any, "null: the job has no such table"]
    proposed: Any

    @derived
    def unit(self) -> str | None:
        """Return the unit of its values."""
        return next((unit for ending, unit in UNITS.items() if self.key.endswith(ending)), None)


@dataclass(frozen=True)
class Relaxation:
    """Changes of the job that together make the tolerance reachable.

    ``methods`` are the job's limits with the changes; empty where these are other keys.
    """

    text: str
    changes: Sequence[JobChange]
    used_share: Annotated[NotNegative, "largest judged value then, over its permissible value"]
    metal_g: Annotated[NotNegative | None, "metal that it takes then; null: the cuts stay as they are"]
    tried: Annotated[bool, "a new plan was made with the changes; false: follows from the residual"] = True
    methods: Annotated[tuple[Limits, ...], UNWRITTEN] = ()
