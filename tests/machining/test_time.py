"""Fifty holes on a hundred thousand triangles: planned, written, read again and simulated in seconds."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autobalance.correction.machining import HoleOperation, angle_deg
from autobalance.drawn_cranks.design import PRESETS
from autobalance.machining.area_moves import Listed, MachinedCrank
from autobalance.machining.input import read_machine_tool
from autobalance.machining.run import nc_run
from autobalance.machining.simulator import operation_body
from autobalance.solid.csg.solid import union
from tests import nc_jobs
from tests.generated import generated_crank

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]
HOLES = 50
DEPTH_MM = 12.0
WITHIN_S = 10.0


def drilled_through_and_through(part: MachinedCrank) -> MachinedCrank:
    """A six in line with holes side by side in the rim of every counterweight, instead of a part's crank."""
    crank = generated_crank(PRESETS["inline-6"], seed=3, segments=156)
    anatomy = crank.truth
    before = crank.solid.moved(anatomy.file_to_rotor)
    assert before.triangle_count > 1e5
    assert crank.design.counterweight is not None
    rim = crank.design.counterweight.radius_mm
    operations = []
    for lean in np.radians([0.0, 12.0, -12.0, 24.0, -24.0]):
        for web in anatomy.webs:
            z = 0.5 * (web.z_min_mm + web.z_max_mm)
            throw = min(anatomy.throws, key=lambda each: abs(each.crankpin.centre_mm[2] - z))
            x, y = throw.direction
            angle = math.atan2(-y, -x) + lean
            out = np.array([math.cos(angle), math.sin(angle), 0.0])
            entry = rim * out + np.array([0.0, 0.0, z])
            operations.append(HoleOperation(entry, -out, 6.0, 118.0, DEPTH_MM, 2.0))
    operations = operations[:HOLES]
    bodies = [operation_body(each) for each in operations]
    cuts = tuple(
        Listed(
            {
                "number": number,
                "kind": "drill",
                "depth_mm": DEPTH_MM,
                "angle_deg": angle_deg(operation),
                "removed_volume_mm3": (before & body).volume_mm3,
            },
            operation,
        )
        for number, (operation, body) in enumerate(zip(operations, bodies, strict=True), 1)
    )
    return replace(part, before=before, after=before - union(bodies), anatomy=anatomy, cuts=cuts)


@pytest.mark.timing
def test_fifty_holes_are_simulated_in_ten_seconds(tmp_path: Path) -> None:
    part = drilled_through_and_through(nc_jobs.part_of(nc_jobs.balanced(tmp_path / "crank", "radial")))
    drill = nc_jobs.tool(1, "drill", diameter_mm=6.0, peck_mm=4.0)
    machine = read_machine_tool(nc_jobs.machine(tool=[drill]))
    begun = time.process_time()
    run = nc_run(part, machine)
    assert time.process_time() - begun < WITHIN_S
    assert len(run.taken_g) == HOLES
    assert (run.gouged_mm3, run.left_mm3) == (0.0, 0.0)
    assert abs(run.mass_difference_g) < 1e-3
