"""The crank before and after its cuts, as a verified report has them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.correction import KINDS
from autobalance.correction.machining import Operation
from autobalance.crank.anatomy import Anatomy
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.solid import Solid


@dataclass(frozen=True, eq=False)
class Listed:
    """A correction as the report lists it, and how it is cut: an operation, why not, or None for no cut."""

    item: Mapping[str, Any]
    operation: Operation | str | None

    @property
    def number(self) -> int:
        """Number in the report."""
        return int(self.item["number"])

    @property
    def pressed_in(self) -> Moments:
        """Moments of the slug that goes in."""
        keys = KINDS[self.item["kind"]].pressed_in
        if keys is None:
            return Moments.zero()
        return Moments.point(float(self.item[keys[0]]), np.array(self.item[keys[1]], dtype=np.float64))


@dataclass(frozen=True, eq=False)
class Part:
    """The crank to machine; solids are in the rotor frame, masses in g."""

    name: str
    report: Path
    sha256: str
    before: Solid
    after: Solid
    anatomy: Anatomy
    density_g_mm3: float
    tolerance: Tolerance
    residual: Unbalance
    cuts: tuple[Listed, ...]


def listed(item: Mapping[str, Any]) -> Listed:
    """Return a correction with its operation."""
    return Listed(item, KINDS[item["kind"]].machining(item))
