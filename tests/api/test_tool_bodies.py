"""The bodies of tools: as large as what they cut, in arrays that other programs may write to."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from tests import jobs


@pytest.fixture(scope="module")
def lowered(tmp_path_factory: pytest.TempPathFactory) -> ab.BalanceResult:
    """Return the bundled crank balanced by its counterweights' faces."""
    job = jobs.whole_job(tmp_path_factory.mktemp("in"), method='"shoulder"')
    return ab.balance(ab.read_job(job))


def test_a_shoulders_tool_is_no_larger_than_the_crank(lowered: ab.BalanceResult) -> None:
    low, high = np.sort(lowered.before.vertices_mm, axis=0)[[0, -1]]
    tools = lowered.tools()
    assert tools
    for tool in tools:
        assert (tool.vertices_mm.min(axis=0) > low - 1.5).all()
        assert (tool.vertices_mm.max(axis=0) < high + 1.5).all()
        taken = lowered.report["corrections"][tool.correction]["removed_volume_mm3"]
        assert taken < tool.volume_mm3 < 5.0 * taken


def test_other_programs_may_write_to_the_arrays(lowered: ab.BalanceResult) -> None:
    manifold = pytest.importorskip("manifold3d")
    for tool in lowered.tools():
        assert tool.vertices_mm.flags.writeable
        body = manifold.Manifold(manifold.Mesh64(tool.vertices_mm, tool.triangles.astype(np.uint64)))
        assert body.volume() == pytest.approx(tool.volume_mm3, rel=1e-9)


def test_outlines_have_the_reports_names(lowered: ab.BalanceResult) -> None:
    webs = zip(lowered.crank.webs, lowered.report["crank"]["webs"], strict=True)
    for web, entry in webs:
        if entry["outline"] is None:
            assert web.outline is None
            continue
        assert web.outline is not None
        assert web.outline.rim_radius_mm == pytest.approx(entry["outline"]["rim_radius_mm"], abs=1e-3)
        assert web.outline.fan_angle_deg == pytest.approx(entry["outline"]["fan_angle_deg"], abs=0.05)
        assert web.outline.skew_deg == pytest.approx(entry["outline"]["skew_deg"], abs=0.05)
        assert web.outline.fan_angle_deg == min(math.degrees(web.outline.fan_angle_rad), 360.0)


def test_the_ending_of_opencascade_is_brep() -> None:
    from autobalance.solid.formats.registry import format_of, needs_unit

    assert needs_unit(Path("crank.brp")) == needs_unit(Path("crank.brep"))
    assert format_of(Path("crank.brp")) is format_of(Path("crank.brep"))
