"""The crank on a machine: its metal, and the heights that a set-up has to keep."""

from __future__ import annotations

import math

import numpy as np

from autobalance.correction.machining import AreaOperation
from autobalance.machining.area_moves import Area
from autobalance.machining.input import MachineTool
from autobalance.machining.part import Part
from autobalance.machining.setups import SetupName, inverse, placement, zero_of
from autobalance.machining.stock import Stock
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid

SLIVER_MM = 0.02


class Workspace:
    """A part on a machine: the metal still there, in the axes of each set-up."""

    def __init__(self, part: Part, machine: MachineTool) -> None:
        self.machine = machine
        self.zero = zero_of(machine, part.anatomy)
        self.stock = Stock(part.before, part.anatomy)

    def over(self, name: SetupName, region: Region, height: float) -> Solid:
        """Return the metal over a region above a height, in the set-up's axes."""
        if region.is_empty:
            return Solid.nothing()
        low, high = region.bounds
        top = self.top(name) + 1.0
        if height >= top:
            return Solid.nothing()
        near = self.stock.near(placement(name, self.zero), np.array([*low, height]), np.array([*high, top]))
        return near if near.is_empty else near & Solid.prism(region, height, top)

    def part_at(self, metal: Solid, name: SetupName) -> str:
        frame = placement(name, self.zero)
        return self.stock.part_at(frame[:3, :3] @ metal.moments(1.0).centre_mm + frame[:3, 3])

    def flat(self, name: SetupName, region: Region) -> Region:
        return region.turned(inverse(placement(name, self.zero))[:2, :2])

    def height(self, name: SetupName, z_mm: float) -> float:
        return (z_mm - self.zero.z_mm) * (-1.0 if name == "B" else 1.0)

    def area(self, name: SetupName, operation: AreaOperation) -> Area:
        floor = self.flat(name, operation.region)
        top = self.height(name, operation.top_z_mm)
        bottom = top - operation.depth_mm
        low, high = floor.bounds
        far = max((tool.diameter_mm for tool in self.machine.tools if tool.kind == "end_mill"), default=0.0)
        near = self.stock.near(
            placement(name, self.zero),
            np.array([*(low - 3.0 * far - 5.0), bottom + SLIVER_MM]),
            np.array([*(high + 3.0 * far + 5.0), self.top(name) + 1.0]),
        )
        own = Solid.prism(floor.grown(SLIVER_MM), bottom - 1.0, top + 2.0 * SLIVER_MM)
        standing = (near - own).shadow() if not near.is_empty else Region.of([])
        standing = standing.grown(-0.5 * SLIVER_MM).grown(0.5 * SLIVER_MM)
        finish = min(self.machine.zero.finish_mm, operation.depth_mm)
        return Area(floor, standing, top, bottom + finish, operation.is_walled)

    @property
    def top_anywhere(self) -> float:
        low, high = self.stock.ends_mm
        return max(self.stock.greatest_radius_mm, abs(high - self.zero.z_mm), abs(low - self.zero.z_mm))

    def top(self, name: SetupName) -> float:
        """Return the height of the crank's top in an upright set-up."""
        low, high = self.stock.ends_mm
        return max(self.height(name, low), self.height(name, high))

    def safe_mm(self, name: SetupName) -> float:
        """Return the height over everything: in R over all that turns by, in L as a diameter."""
        clear = self.machine.zero.clearance_mm
        if name in ("T", "B"):
            return math.ceil(self.top(name) + clear)
        over = math.ceil(self.stock.greatest_radius_mm + clear)
        return float(over if name == "R" else 2 * over)
