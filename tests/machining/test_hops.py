"""Rapids from one loop to the next, over what stands between them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autobalance.correction.machining import AreaOperation
from autobalance.crank.anatomy import Anatomy
from autobalance.machining.area_moves import Listed, MachinedCrank, hops, strip, top_mm
from autobalance.machining.input import Go, read_machine_tool
from autobalance.machining.planner import Planner
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from tests import nc_jobs

PLATE = Solid.box(np.array([-90.0, -20.0, 0.0]), np.array([90.0, 20.0, 20.0]))
POST = Solid.box(np.array([-8.0, -8.0, 10.0]), np.array([8.0, 8.0, 60.0]))
CLEAR_MM = 5.0


def part(solid: Solid, region: Region) -> MachinedCrank:
    """A plate whose top is lowered in some places."""
    item = {"number": 1, "kind": "shoulder", "web": 1, "angle_deg": 0.0, "depth_mm": 1.0}
    cut = Listed(item, AreaOperation(region, 1, 20.0, 1.0, None))
    nothing = Unbalance(np.zeros(2), np.zeros(2))
    tolerance = Tolerance(16.0, 600.0, 1000.0, 25.0, (), "static")
    anatomy = Anatomy(np.eye(4), (), (), (), 0.0)
    return MachinedCrank(
        "plate", Path("report.json"), "", solid, solid, anatomy, 7.85e-3, tolerance, nothing, (cut,)
    )


@pytest.mark.parametrize("post", [True, False])
def test_rapids_between_loops_clear_what_stands_there(post: bool) -> None:
    """Beside a post of 40 mm; a rapid of a v6's shoulder went through its shaft, and was refused."""
    solid = PLATE + POST if post else PLATE
    places = [Region.rectangle([x - 15.0, -18.0], [x + 15.0, 18.0]) for x in (-70.0, 70.0)]
    values = nc_jobs.machine(zero={"angle": 0.0, "z_mm": 0.0})
    values["tool"] = [{**tool, "stick_out_mm": 100.0} for tool in values["tool"]]
    machine = read_machine_tool(values)
    machine = replace(machine, zero=replace(machine.zero, clearance_mm=CLEAR_MM))
    (setup,) = Planner(part(solid, places[0] + places[1]), machine).plan().setups
    radius = setup.tools[0].radius_mm
    across = list(hops(setup.blocks))
    assert any(begin[0] * end[0] < 0.0 for begin, end in across)
    over = max(top_mm(solid, strip(*ends, radius + CLEAR_MM - 0.01)) for ends in across)
    assert over == (60.0 if post else 20.0)
    retract = [block.z for block in setup.blocks if isinstance(block, Go) and block.z is not None]
    assert max(retract[:-1]) >= over + CLEAR_MM
    assert max(retract[:-1]) <= over + CLEAR_MM + 1.0
