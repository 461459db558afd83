"""The drawing for CAD, opened again and measured."""

from __future__ import annotations

import io
import math
from itertools import pairwise
from typing import Any

import ezdxf
import numpy as np
import pytest
from ezdxf.document import Drawing

from autobalance.paper.dxf import LAYERS, dxf
from autobalance.report.records.balanced import BalancedReport
from autobalance.solid.csg.region import Region
from tests import plans

CLOSE = 1e-9


def query(where: Any, what: str) -> list[Any]:
    return list(where.query(what))


@pytest.fixture(scope="module")
def made() -> tuple[dict[str, Any], Any, bytes]:
    report = plans.plan(30, seed=4)
    drawings = plans.drawings_of(report)
    return report, drawings, dxf(BalancedReport.read(report), drawings)


@pytest.fixture(scope="module")
def document(made: tuple[dict[str, Any], Any, bytes]) -> Drawing:
    return ezdxf.read(io.StringIO(made[2].decode("utf-8")))  # type: ignore[attr-defined]


def test_it_is_a_sound_file_of_2013_in_millimetres(made: Any, document: Drawing) -> None:
    assert not document.audit().errors
    assert (document.dxfversion, document.header["$INSUNITS"]) == ("AC1027", 4)
    assert set(LAYERS) <= {layer.dxf.name for layer in document.layers}
    assert made[2] == dxf(BalancedReport.read(made[0]), made[1])


def test_each_block_is_inserted_once_at_scale_1_unturned(made: Any, document: Drawing) -> None:
    webs = {item["web"] for item in made[0]["corrections"]}
    inserts = list(query(document.modelspace(), "INSERT"))
    assert sorted(each.dxf.name for each in inserts) == sorted([*(f"WEB_{web}" for web in webs), "SECTION"])
    for each in inserts:
        assert (each.dxf.xscale, each.dxf.yscale, each.dxf.rotation) == (1.0, 1.0, 0.0)
    spans = [_span(document, each) for each in inserts]
    for (_, right), (left, _) in pairwise(spans):
        assert right < left
    assert len(query(document.modelspace(), 'DIMENSION[layer=="DIMENSIONS"]')) == 2 * len(inserts)


def _span(document: Drawing, insert: Any) -> tuple[float, float]:
    xs = [x for line in query(document.blocks[insert.dxf.name], "LWPOLYLINE") for x, *_ in line.get_points()]
    return insert.dxf.insert.x + min(xs), insert.dxf.insert.x + max(xs)


def test_cuts_are_where_the_report_has_them(made: Any, document: Drawing) -> None:
    report, drawings, _ = made
    shadows = {number: each for web in drawings.webs for number, each in web.cuts.items()}
    for item in report["corrections"]:
        block = document.blocks[f"WEB_{item['web']}"]
        place = np.array(item["position_mm"][:2])
        assert str(item["number"]) in {text.dxf.text for text in query(block, 'TEXT[layer=="TEXT"]')}
        if item.get("direction") == "axial" and "diameter_mm" in item:
            circles = query(block, 'CIRCLE[layer=="CUTS"]')
            near = min(circles, key=lambda each: math.dist(each.dxf.center.vec2, place))
            assert math.dist(near.dxf.center.vec2, place) < CLOSE
            assert 2.0 * near.dxf.radius == pytest.approx(item["diameter_mm"], abs=CLOSE)
        elif item.get("inward") is not None:
            lines = query(block, 'LINE[layer=="CENTRE"]')
            near = min(lines, key=lambda each: math.dist(each.dxf.start.vec2, place))
            assert math.dist(near.dxf.start.vec2, place) < CLOSE
            end = place + item["depth_mm"] * np.array(item["inward"][:2])
            assert math.dist(near.dxf.end.vec2, end) < CLOSE
        else:
            area = Region.of(shadows[item["number"]]).area_mm2
            found = query(block, 'LWPOLYLINE[layer=="CUTS"]')
            assert all(each.closed for each in found)
            assert any(_area(each) >= area - 1e-6 for each in found)


def _area(line: Any) -> float:
    x, y = np.array([point[:2] for point in line.get_points()]).T
    return abs(0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def test_the_outline_and_the_section_keep_their_measures(document: Drawing) -> None:
    outline = query(document.blocks["WEB_1"], 'LWPOLYLINE[layer=="OUTLINE"]')
    reach = max(math.hypot(x, y) for line in outline for x, y, *_ in line.get_points())
    assert reach == pytest.approx(plans.RIM, abs=1e-6)
    points = np.array(
        [
            p[:2]
            for line in query(document.blocks["SECTION"], 'LWPOLYLINE[layer=="OUTLINE"]')
            for p in line.get_points()
        ]
    )
    np.testing.assert_allclose(points.min(axis=0), [-60.0, -plans.RIM], atol=0.05)
    np.testing.assert_allclose(points.max(axis=0), [90.0, 36.0], atol=0.05)


def test_radial_holes_are_outlines_on_the_rim_rolled_out(made: Any, document: Drawing) -> None:
    report = made[0]
    radial = [cut for cut in report["corrections"] if cut.get("direction") == "radial"]
    circles = query(document.modelspace(), 'CIRCLE[layer=="CUTS"]')
    assert radial
    assert len(circles) == len(radial)
    out = max(cut["entry_radius_mm"] for cut in radial)
    first = radial[0]
    start = min(
        each.dxf.center.x - math.radians(first["angle_deg"]) * out
        for each in circles
        if abs(each.dxf.center.y - first["z_mm"]) < CLOSE
    )
    for cut, circle in zip(radial, circles, strict=True):
        assert circle.dxf.center.x - start == pytest.approx(math.radians(cut["angle_deg"]) * out, abs=CLOSE)
        assert circle.dxf.center.y == pytest.approx(cut["z_mm"], abs=CLOSE)
        assert 2.0 * circle.dxf.radius == pytest.approx(cut["diameter_mm"], abs=CLOSE)
