"""Every cut drawn again by the CAD kernel from the report's keys alone, and held against what is listed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad.files import read_step_file
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import common, cut, explored, fused, properties
from tests.coarse import COARSE, ROUGH, coarse_facets
from tests.generated import single_step
from tests.jobs import main, without_advice

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed"),
]

DENSITY_G_MM3 = 7.85e-3
JOB = """
[crankshaft]
file = "{file}"
density_kg_m3 = 7850.0
[engine.rotating_g]
big_end = 300.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = {factor}
grade = 6.3
speed_rpm = 9000
[correction]
{correction}
"""
CORRECTIONS = {
    "drill": ('method = "drill"\n[correction.drill]\ndiameters_mm = [10.0]', 0.14),
    "axial": ('method = "drill"\n[correction.drill]\ndirection = "axial"\ndiameters_mm = [10.0]', 0.14),
    "slug": ('method = "slug"\n[correction.slug]\ndiameters_mm = [12.0]\nlengths_mm = [8.0, 12.0]', 0.3),
    "mill": ('method = "mill"', 0.14),
    "turn": ('method = "turn"', 0.14),
    "shoulder": ('method = "shoulder"\nfaces = "auto"', 0.14),
    "add": ('method = "add"', 0.3),
}


@pytest.fixture(scope="module")
def crank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("redrawn") / "crank.step"
    path.write_bytes(single_step())
    return path


def point(values: Any) -> Any:
    from OCP.gp import gp_Pnt

    return gp_Pnt(*(float(value) for value in values))


def revolved(corners: list[tuple[float, float]], start: Any, axis: Any) -> Any:
    """The body of a profile in (radius, length along the axis) about an axis from a point."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.gp import gp_Ax1, gp_Dir

    axis = np.asarray(axis, dtype=float)
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    outline = BRepBuilderAPI_MakePolygon()
    for radius, length in corners:
        outline.Add(point(np.asarray(start) + radius * across + length * axis))
    outline.Close()
    face = BRepBuilderAPI_MakeFace(outline.Wire()).Face()
    return BRepPrimAPI_MakeRevol(face, gp_Ax1(point(start), gp_Dir(*axis.tolist()))).Shape()


def wire(loop: list[dict[str, Any]], z: float) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir

    built = BRepBuilderAPI_MakeWire()
    for segment in loop:
        if "line" in segment:
            one, other = segment["line"]
            built.Add(BRepBuilderAPI_MakeEdge(point([*one, z]), point([*other, z])).Edge())
            continue
        arc = segment["arc"]
        begin, end = sorted(math.radians(arc[key]) for key in ("from_deg", "to_deg"))
        axes = gp_Ax2(point([*arc["centre"], z]), gp_Dir(0.0, 0.0, 1.0), gp_Dir(1.0, 0.0, 0.0))
        built.Add(BRepBuilderAPI_MakeEdge(gp_Circ(axes, arc["radius_mm"]), begin, end).Edge())
    return built.Wire()


def prism(loops: list[Any], low: float, high: float) -> Any:
    """What lies in an odd number of loops, between two heights."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Dir, gp_Pln, gp_Vec

    plane = gp_Pln(point([0.0, 0.0, low]), gp_Dir(0.0, 0.0, 1.0))
    bodies = [
        BRepPrimAPI_MakePrism(
            BRepBuilderAPI_MakeFace(plane, wire(loop, low)).Face(), gp_Vec(0.0, 0.0, high - low)
        ).Shape()
        for loop in loops
    ]
    found = None
    for body in sorted(bodies, key=lambda each: -abs(properties(each).mass_g)):
        inside = found is not None and abs(properties(common(found, body)).mass_g) > 1e-6
        found = body if found is None else cut(found, [body]) if inside else fused([found, body])
    return found


def pocket(item: dict[str, Any]) -> list[dict[str, Any]]:
    """The outline of a pocket as a CAD user would draw it."""
    c, inner, outer = (item[key] for key in ("corner_radius_mm", "inner_radius_mm", "outer_radius_mm"))
    a, b = (math.radians(item[key]) for key in ("start_deg", "end_deg"))
    b = a + (b - a) % (2.0 * math.pi)
    far, near = outer - c, inner + c
    lean, bend = math.asin(c / far), math.asin(c / near)

    def at(radius: float, angle: float) -> list[float]:
        return [radius * math.cos(angle), radius * math.sin(angle)]

    def arc(centre: list[float], radius: float, begin: float, end: float) -> dict[str, Any]:
        return {
            "arc": {
                "centre": centre,
                "radius_mm": radius,
                "from_deg": math.degrees(begin),
                "to_deg": math.degrees(end),
            }
        }

    def foot(radius: float, angle: float, edge: float) -> list[float]:
        """Where the straight side at an angle touches the corner circle centred at (radius, angle)."""
        centre, along = np.array(at(radius, angle)), np.array(at(1.0, edge))
        return [float(value) for value in (centre @ along) * along]

    q = 0.5 * math.pi
    return [
        arc(at(far, a + lean), c, a - q, a + lean),
        arc([0.0, 0.0], outer, a + lean, b - lean),
        arc(at(far, b - lean), c, b - lean, b + q),
        {"line": [foot(far, b - lean, b), foot(near, b - bend, b)]},
        arc(at(near, b - bend), c, b + q, b - bend + 2.0 * q),
        arc([0.0, 0.0], inner, a + bend, b - bend),
        arc(at(near, a + bend), c, a + bend + 2.0 * q, a + 3.0 * q),
        {"line": [foot(near, a + bend, a), foot(far, a + lean, a)]},
    ]


def redrawn(item: dict[str, Any]) -> Any:
    """The body of a cut in the rotor frame."""
    kind = item["kind"]
    if kind in ("drill", "slug"):
        r, depth = 0.5 * item["diameter_mm"], item["depth_mm"]
        corners = [(0.0, -item["entry_lift_mm"]), (r, -item["entry_lift_mm"]), (r, depth)]
        if item["point_mm"] < 1e-9:
            corners.append((0.0, depth))
        else:
            corners.append((0.0, depth + item["point_mm"]))
        return revolved(corners, item["position_mm"], item["inward"])
    if kind == "mill":
        ends = sorted((item["face_z_mm"], item["face_z_mm"] - item["side"] * item["depth_mm"]))
        return prism([pocket(item)], *ends)
    if kind == "turn":
        low, high, r, far = (
            item[key] for key in ("z_from_mm", "z_to_mm", "new_radius_mm", "outer_radius_mm")
        )
        return revolved([(r, low), (far, low), (far, high), (r, high)], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    begun = item["face_height_mm"] + item.get("entry_lift_mm", 0.0)
    ends = sorted(item["side"] * height for height in (begun, item["new_height_mm"]))
    return prism(item["outline"], *ends)


@pytest.fixture(scope="module", params=CORRECTIONS)
def run(crank: Path, request: pytest.FixtureRequest) -> tuple[dict[str, Any], Any, Any]:
    folder = crank.parent / request.param
    folder.mkdir()
    correction, factor = CORRECTIONS[request.param]
    job = folder / "job.toml"
    job.write_text(JOB.format(file="../crank.step", correction=correction, factor=factor), encoding="utf-8")
    fineness = ROUGH if request.param in ("mill", "shoulder", "add") else COARSE  # round in facets
    with coarse_facets(fineness), without_advice():
        assert main(["balance", str(job), "-o", str(folder / "out"), "--no-report"]) in (0, 4)
    report = json.loads((folder / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["corrections"]
    if request.param != "slug":  # its size is read off the facets, which must be finer for that
        with coarse_facets(fineness):
            assert main(["verify", str(folder / "out" / "report.json")]) in (0, 4)
    bodies = [
        read_step_file(path.read_bytes()).bodies[0].body for path in (crank, folder / "out" / "balanced.step")
    ]
    return report, bodies[0], bodies[1]


def in_rotor(body: Any, report: dict[str, Any]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf

    motion = gp_Trsf()
    matrix = np.array(report["frame"]["file_to_rotor"])
    motion.SetValues(*(float(value) for value in matrix[:3].ravel()))
    return BRepBuilderAPI_Transform(body, motion, True).Shape()


def test_each_cut_can_be_drawn_again_from_the_report(run: tuple[dict[str, Any], Any, Any]) -> None:
    report, before, _ = run
    crank = in_rotor(before, report)
    residual = np.array(report["initial"]["unbalance_g_mm"])
    pressed_in = np.zeros(2)
    gone: list[Any] = []
    for item in report["corrections"]:
        tool = redrawn(item)
        adds = item["depth_mm"] < 0.0
        metal = cut(tool, [crank, *gone]) if adds else common(crank, cut(tool, gone))
        found = properties(metal)
        gone.append(tool)
        sign = 1.0 if adds else -1.0
        assert -sign * found.mass_g == pytest.approx(item["removed_volume_mm3"], rel=1e-5)
        residual += sign * DENSITY_G_MM3 * found.first_g_mm[:2]
        if item["kind"] == "slug":
            pressed_in += item["slug_mass_g"] * np.array(item["slug_centre_mm"][:2])
    off = np.linalg.norm(residual + pressed_in - np.array(report["residual"]["unbalance_g_mm"]))
    assert off <= 0.01 * report["tolerance"]["permissible_g_mm"]


def test_what_is_listed_is_what_was_taken(run: tuple[dict[str, Any], Any, Any]) -> None:
    report, before, after = run
    change: Moments = properties(in_rotor(after, report)) - properties(in_rotor(before, report))
    items = report["corrections"]
    volume = -sum(item["removed_volume_mm3"] for item in items)
    assert volume == pytest.approx(change.mass_g, rel=1e-6)
    slugs = [item for item in items if item["kind"] == "slug"]
    slug_g = sum(item["slug_mass_g"] for item in slugs)
    mass = -sum(item["removed_mass_g"] for item in items) - slug_g
    assert mass == pytest.approx(DENSITY_G_MM3 * change.mass_g, rel=1e-6)
    unbalance = np.sum([item["unbalance_change_g_mm"] for item in items], axis=0)
    for item in slugs:
        unbalance -= item["slug_mass_g"] * np.array(item["slug_centre_mm"][:2])
    size = sum(math.hypot(*item["unbalance_change_g_mm"]) for item in items)
    np.testing.assert_allclose(unbalance, DENSITY_G_MM3 * change.first_g_mm[:2], atol=1e-6 * size)


@pytest.mark.parametrize("run", ["mill", "turn"], indirect=True)
def test_what_a_pass_predicted_is_held_against_what_it_took(
    run: tuple[dict[str, Any], Any, Any], crank: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Predicted on facets, taken of true surfaces: both agree within a twentieth of what is moved."""
    report, _, _ = run
    (step,) = report["steps"]
    moved = sum(math.hypot(*item["unbalance_change_g_mm"]) for item in report["corrections"])
    assert 1e-6 * moved < abs(step["predicted_g_mm"] - step["measured_g_mm"]) < 0.05 * moved
    false = {**report, "steps": [{**step, "predicted_g_mm": step["predicted_g_mm"] + 0.2 * moved}]}
    edited = crank.parent / report["corrections"][0]["kind"] / "out" / "edited.json"
    edited.write_text(json.dumps(false), encoding="utf-8")
    with coarse_facets(ROUGH if "mill" in str(edited) else COARSE):
        assert main(["verify", str(edited)]) == 3
    assert "steps[1].predicted_g_mm is " in capsys.readouterr().err


def test_places_are_told_in_the_files_coordinates(run: tuple[dict[str, Any], Any, Any]) -> None:
    report, _, after = run
    frame = np.array(report["frame"]["file_to_rotor"])
    kinds = {item["kind"] for item in report["corrections"]}
    for number, item in enumerate(report["corrections"], 1):
        assert item["label"].startswith(f"cut {number}: ")
        place = frame @ np.array([*item["file_position_mm"], 1.0])
        np.testing.assert_allclose(place[:3], item["position_mm"], atol=1e-9)
        axis = frame[:3, :3] @ np.array(item["file_axis"])
        assert np.linalg.norm(axis) == pytest.approx(1.0)
        if "inward" in item:
            np.testing.assert_allclose(axis, item["inward"], atol=1e-9)
            r, depth = 0.5 * item["diameter_mm"], item["depth_mm"] + item["entry_lift_mm"]
            expected = math.pi * r * r * (depth + item["point_mm"] / 3.0)
            assert item["tool_volume_mm3"] == pytest.approx(expected, rel=1e-9)
        assert item["tool_volume_mm3"] > 0.0
        named = {face["id"] for face in report["faces"]}
        assert item["face"] is None or item["face"] in named
    assert ("slug" in kinds) == ("final_with_slugs" in report)
    if "slug" in kinds:
        assert report["outputs"]["solid_holds_slugs"] is False
        mass = report["outputs"]["solid"]["mass_g"] + sum(
            item["slug_mass_g"] for item in report["corrections"]
        )
        assert report["final_with_slugs"]["mass_g"] == pytest.approx(mass, rel=1e-9)
    assert len(explored(after, "SOLID")) == 1
