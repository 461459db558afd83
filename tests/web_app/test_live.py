"""What the page shows as one types and drags: that it is what the functions say."""

import copy
import json
import math
import re
import subprocess
import sys
import tempfile
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.browser.live import kinds
from autobalance.browser.meshes import along_a_curve, crank_mesh, creases, packed
from autobalance.browser.prediction import linear_model, predicted, preview
from autobalance.browser.work import MESH, MODEL, SOLID_READ_SHARE, VERBS, RunFolders, _material
from autobalance.crank.recognition.candidates import cylinder_candidates
from autobalance.errors import JobError
from autobalance.paper.svg_pen import section_drawings, web_drawings
from autobalance.report.balance.zero import Zero, with_design_radii
from autobalance.report.records.balanced import BalancedReport
from tests import jobs
from tests.web_app import small

DRAFTED = jobs.BUNDLED / "drafted"
KINDS = {"f4": "<f4", "u4": "<u4", "u2": "<u2", "u1": "u1"}


def tables(**correction: Any) -> dict[str, Any]:
    read = tomllib.loads((DRAFTED / "factor-0.28.toml").read_text("utf-8"))
    return {**read, "correction": correction or read["correction"]}


@cache
def crank() -> ab.Crank:
    return ab.read_crank(DRAFTED / "crank.stl", unit="mm", density_kg_m3=7850.0, crankpin_in_file=False)


@cache
def drilled() -> ab.BalanceResult:
    values = tables(method="drill", drill={"max_holes": 8, "diameters_mm": [8.0], "depth_step_mm": 0.0})
    values["balance"]["factor"] = 0.75
    return ab.balance(ab.Job.from_dict(values), crank())


def unpacked(data: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    length = int.from_bytes(data[:4], "little")
    head = json.loads(data[4 : 4 + length])
    arrays = {
        name: np.frombuffer(data, KINDS[kind], count, 4 + length + place)
        for name, (place, count, kind) in head["arrays"].items()
    }
    return head, arrays


# --- prediction -------------------------------------------------------------------------------------------


def test_what_was_cut_is_predicted_as_it_was_measured() -> None:
    result = drilled()
    model = linear_model(result)
    found = predicted(model, [cut.depth_mm for cut in model.cuts])
    residual = result.report["residual"]
    assert found.unbalance_g_mm == pytest.approx(residual["unbalance_g_mm"], abs=1e-9)
    for plane, own in zip(found.planes, residual["planes"], strict=True):
        assert plane.unbalance_g_mm == pytest.approx(own["unbalance_g_mm"], abs=1e-6)
    assert found.inertia_change_kg_mm2 == pytest.approx(result.report["inertia_change_kg_mm2"], abs=1e-9)
    removed = sum(cut["removed_mass_g"] for cut in result.report["corrections"])
    assert found.mass_change_g == pytest.approx(-removed, rel=1e-4)


def test_a_depth_is_predicted_to_second_order() -> None:
    """The error of a linear model falls with the square of the step."""
    result = drilled()
    model = linear_model(result)
    assert result.record.balanced is not None
    made = result.record.balanced.result.made
    depths = [depth for _, depth in made]
    errors = []
    for step in (-0.8, -0.4):
        found = predicted(model, [depths[0] + step, *depths[1:]])
        change = made[0][0].effect(depths[0] + step) - made[0][0].effect(depths[0])
        truly = complex(*result.report["residual"]["unbalance_g_mm"]) + complex(*change.first_g_mm[:2])
        errors.append(abs(complex(*found.unbalance_g_mm) - truly))
    assert errors[1] < 0.3 * errors[0] or errors[0] < 1e-6


def test_a_hole_that_is_turned_takes_its_vector_along() -> None:
    model = linear_model(drilled())
    depths = [cut.depth_mm for cut in model.cuts]
    still, turned = (predicted(model, depths, [angle, *[0.0] * (len(depths) - 1)]) for angle in (0.0, 30.0))
    was = complex(*model.cuts[0].effect.unbalance_g_mm)
    moved = complex(*turned.unbalance_g_mm) - complex(*still.unbalance_g_mm)
    assert moved == pytest.approx(was * (np.exp(1j * np.pi / 6.0) - 1.0), abs=1e-9)
    assert turned.mass_change_g == still.mass_change_g
    assert turned.worst_share > 1.0 > still.worst_share


@pytest.mark.parametrize(
    ("depths", "turns", "said"),
    [
        ([1.0], [], "must be a list of"),
        ("deep", [], "must be a list of"),
        ([True], [], "must be a list of"),
        (None, [200.0], "turns_deg"),
        (99.0, [], "must be 0 to"),
        (float("nan"), [], "expected numbers"),
    ],
)
def test_what_cannot_be_cut_is_not_predicted(depths: Any, turns: list[float], said: str) -> None:
    model = linear_model(drilled())
    now = [cut.depth_mm for cut in model.cuts]
    given = now if depths is None else [depths, *now[1:]] if isinstance(depths, float) else depths
    with pytest.raises(JobError, match=said):
        predicted(model, given, [*turns, *[0.0] * (len(now) - 1)] if turns else [])


@cache
def on_small(method: str) -> tuple[ab.Job, ab.BalanceResult]:
    correction = small.DRILLED["correction"] if method == "drill" else {"method": method}
    values = {**small.DRILLED, "correction": correction}
    if method == "shoulder":
        values["balance"] = small.job()["balance"]
    folder = Path(tempfile.mkdtemp())
    small.crank(folder)
    asked = ab.Job.from_dict(values, folder=folder)
    return asked, ab.balance(asked)


def listed(
    result: ab.BalanceResult, depths: list[float], turns: list[float], diameters: list[float | None]
) -> list[dict[str, Any]]:
    """Return the cuts of a result as the page lists them once they were dragged."""
    made = []
    for cut, depth, turn, diameter in zip(
        result.report["corrections"], depths, turns, diameters, strict=True
    ):
        moved = {**cut, "depth_mm": depth, "diameter_mm": diameter}
        if turn:
            moved = {key: value for key, value in moved.items() if key not in ("position_mm", "entry_mm")}
            x, y, z = cut["inward"]
            inward = complex(x, y) * complex(np.exp(1j * np.radians(turn)))
            moved |= {"angle_deg": cut["angle_deg"] + turn, "inward": [inward.real, inward.imag, z]}
        made.append(moved)
    return made


def mass_change_g(report: Any) -> float:
    return -float(sum(cut["removed_mass_g"] for cut in report["corrections"]))


def test_a_hole_by_another_drill_is_predicted_as_it_is_then_measured() -> None:
    """Of the shop's drills: 10 and 14 beside the 12 that was planned."""
    drills: dict[str, Any] = {"diameters_mm": [8.0, 12.0, 14.0, 25.0], "max_holes": 2, "max_drills": 1}
    values = {**small.DRILLED, "correction": {"method": "drill", "drill": drills}}
    folder = Path(tempfile.mkdtemp())
    small.crank(folder)
    asked = ab.Job.from_dict(values, folder=folder)
    result = ab.balance(asked)
    model = linear_model(result)
    own = [cut.diameter_mm for cut in model.cuts]
    depths = [cut.depth_mm for cut in model.cuts]
    other = next(each.diameter_mm for each in model.cuts[0].drills if each.diameter_mm != own[0])
    assert 25.0 not in {each.diameter_mm for each in model.cuts[0].drills}  # twice as wide
    diameters = [other, *own[1:]]
    told = predicted(model, depths, [], diameters)
    drills["max_drills"] = 2  # the one that was moved has another
    asked = ab.Job.from_dict(values, folder=folder)
    made = ab.balance(asked, cuts=listed(result, depths, [0.0, 0.0], diameters)).report
    change = mass_change_g(made) - model.mass_change_g
    assert change == pytest.approx(told.mass_change_g - model.mass_change_g, rel=0.05)
    found = np.array(made["residual"]["unbalance_g_mm"]) - result.report["residual"]["unbalance_g_mm"]
    want = np.array(told.unbalance_g_mm) - result.report["residual"]["unbalance_g_mm"]
    assert found == pytest.approx(want, abs=0.05 * float(np.linalg.norm(want)))
    with pytest.raises(JobError, match=r"diameters_mm\[1\] is 25.0; expected one of 8"):
        predicted(model, depths, [], [25.0, *own[1:]])


@pytest.mark.parametrize("method", ["drill", "shoulder", "mill"])
def test_a_handle_stands_where_the_next_metal_goes(method: str) -> None:
    """What one more millimetre takes away has its middle at the floor of the cut."""
    for cut in linear_model(on_small(method)[1]).cuts:
        floor = np.array(cut.begin_mm) + cut.depth_mm * np.array(cut.deeper)
        middle = np.array(cut.rate.unbalance_g_mm) / cut.rate.mass_g
        assert floor[:2] == pytest.approx(middle, abs=4.0), cut.label  # a drill's point is longer
        z = cut.rate.moment_g_mm2[0] / cut.rate.unbalance_g_mm[0]
        assert floor[2] == pytest.approx(z, abs=1e-3), cut.label
        assert np.linalg.norm(cut.deeper) == pytest.approx(1.0)


def test_what_was_dragged_is_cut_and_measured() -> None:
    asked, result = on_small("drill")
    model = linear_model(result)
    depths = [cut.depth_mm for cut in model.cuts]
    diameters = [cut.diameter_mm for cut in model.cuts]
    same = ab.balance(asked, cuts=listed(result, depths, [0.0, 0.0], diameters)).report
    assert same["residual"]["unbalance_g_mm"] == pytest.approx(
        result.report["residual"]["unbalance_g_mm"], abs=1e-3
    )
    assert same["outcome"] == "within_tolerance"
    deeper = [depths[0] + 1.0, *depths[1:]]
    other = ab.balance(asked, cuts=listed(result, deeper, [0.0, 20.0], diameters)).report
    told = predicted(model, deeper, [0.0, 20.0])
    found = np.array(other["residual"]["unbalance_g_mm"])
    change = np.linalg.norm(found - result.report["residual"]["unbalance_g_mm"])
    # the hole that is turned enters a rim of 24 facets elsewhere, up to 0.5 mm further in or out
    assert found == pytest.approx(np.array(told.unbalance_g_mm), abs=0.04 * float(change))
    assert mass_change_g(other) == pytest.approx(told.mass_change_g, rel=0.03)
    assert other["inertia_change_kg_mm2"] == pytest.approx(told.inertia_change_kg_mm2, rel=0.03)
    assert other["outcome"] == "above_tolerance"


def test_each_hole_stands_on_the_wheel_of_its_web_at_the_angle_of_the_table() -> None:
    """Crankpin 1 is up, the wheel counts from the keyway: as the sheet draws and says it."""
    _, result = on_small("drill")
    material = _material(result)
    values = copy.deepcopy(dict(material.report))
    values["crank"]["datums"]["angle"] = {"of": "keyway", "angle_deg": 100.25}
    report = with_design_radii(BalancedReport.read(values))
    made, zero = {str(each.number): each for each in report.corrections}, Zero.of(report)
    seen = []
    for web in web_drawings(report, material.drawings, "metric"):
        circles = re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"', web.svg)
        middle, wheel = complex(float(circles[0][0]), float(circles[0][1])), float(circles[0][2])

        def angle(x: str, y: str, middle: complex = middle) -> float:
            away = middle - complex(float(x), float(y))
            return math.degrees(math.atan2(away.real, away.imag)) % 360.0

        ends = re.findall(r'd="M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)"', web.svg)
        ticks = [
            angle(x, y)
            for u, v, x, y in ends
            if abs(abs(complex(float(u), float(v)) - middle) - wheel) < 0.01
            and abs((angle(u, v) - angle(x, y) + 180.0) % 360.0 - 180.0) < 0.1
        ]
        (named,) = re.findall(r'<text x="([\d.]+)" y="([\d.]+)"[^>]*><tspan[^>]*>0</tspan>', web.svg)
        wanted = min(ticks, key=lambda tick: abs((tick - angle(*named) + 180.0) % 360.0 - 180.0))
        assert wanted == pytest.approx(zero.angle_deg, abs=0.1)
        marks = [(x, y) for x, y, r in circles if r == "0.450"]
        for label, mark in zip(web.labels, marks, strict=True):
            for number in label.split(", "):  # alike in two webs
                told = zero.ccw(made[number].angle_deg)
                assert (angle(*mark) - wanted) % 360.0 == pytest.approx(told, abs=0.1)
                seen.append(number)
    assert sorted(seen) == sorted(made)


def test_sections_are_those_of_the_sheet_in_their_scale() -> None:
    """The whole crank first: as long and as high on the page as its section is, each cut hatched once."""
    _, result = on_small("drill")
    material = _material(result)
    report = with_design_radii(BalancedReport.read(material.report))
    whole, *through = section_drawings(report, material.drawings, "metric")
    assert {each.kind for each in (whole, *through)} == {"section"}
    assert [each.title.partition(",")[0] for each in through] == [
        each.title.partition(",")[0] for each in web_drawings(report, material.drawings, "metric")
    ]
    outline = re.search(r'<path d="([^"]+)" fill-rule="evenodd"', whole.svg)
    assert outline is not None
    places = np.array([[float(v) for v in pair.split()] for pair in re.split("[MLZ]+", outline[1]) if pair])
    wide, high = np.ptp(places, axis=0)
    solid = np.concatenate(material.drawings.lengthwise)
    assert wide / high == pytest.approx(np.ptp(solid[:, 0]) / np.ptp(solid[:, 1]), rel=1e-3)
    for each in through:
        assert each.svg.count("<clipPath") == len(each.labels) > 0


# --- as one types -----------------------------------------------------------------------------------------


def test_the_preview_is_what_balance_begins_with() -> None:
    report = ab.balance(ab.Job.from_dict(tables()), crank()).report
    found = preview(json.loads(ab.inspect(crank()).json()), tables(), Path())
    assert found["bob_weights"] == [
        {key: pytest.approx(each[key]) for key in ("throw", "mass_g", "fit_g")}
        for each in report["engine"]["bob_weights"]
    ]
    assert found["balance_factor"]["makers"] is None
    before = tomllib.loads((DRAFTED / "factor-original.toml").read_text("utf-8"))
    own = preview(json.loads(ab.inspect(crank()).json()), before, Path())["balance_factor"]
    assert own["makers"] == own["target"] == pytest.approx(0.638, abs=5e-4)
    assert found["balance_factor"]["initial"] == pytest.approx(report["balance_factor"]["initial"], rel=1e-9)
    assert found["initial"]["unbalance_g_mm"] == pytest.approx(
        report["initial"]["unbalance_g_mm"], rel=1e-9, abs=1e-6
    )
    for plane, own in zip(found["initial"]["planes"], report["initial"]["planes"], strict=True):
        assert plane["magnitude_g_mm"] == pytest.approx(own["magnitude_g_mm"], rel=1e-9)
    for plane, own in zip(found["tolerance"]["planes"], report["tolerance"]["planes"], strict=True):
        assert plane["name"] == own["name"]
        assert plane["permissible_g_mm"] == pytest.approx(own["permissible_g_mm"], rel=1e-9)


def test_another_density_changes_the_preview_as_it_would_the_crank() -> None:
    values = tables()
    values["crankshaft"]["density_kg_m3"] = 7000.0
    found = preview(json.loads(ab.inspect(crank()).json()), values, Path())
    lighter = ab.read_crank(DRAFTED / "crank.stl", unit="mm", density_kg_m3=7000.0, crankpin_in_file=False)
    own = ab.balance(ab.Job.from_dict(values), lighter).report["initial"]
    assert found["initial"]["magnitude_g_mm"] == pytest.approx(own["magnitude_g_mm"], rel=1e-9)


# --- what would suffice -----------------------------------------------------------------------------------


def test_every_relaxation_that_is_proposed_suffices() -> None:
    values = tables(method="shoulder", shoulder={"max_depth_mm": 2.0, "faces": ["w1-a", "w2-d"]})
    report = ab.balance(ab.Job.from_dict(values), crank()).report
    assert report["outcome"] == "above_tolerance"
    found = report["relaxations"]
    assert len(found) >= 2
    for each in found:
        again = json.loads(json.dumps(values))
        for change in each["changes"]:
            *keys, last = change["key"].split(".")
            table = again
            for key in keys:
                table = table.setdefault(key, {})
            assert change["present"] in (table.get(last), again["balance"]["factor"])
            table[last] = change["proposed"]
        made = ab.balance(ab.Job.from_dict(again), crank()).report
        assert made["outcome"] == "within_tolerance", each
        assert made["relaxations"] == []
        if each["tried"]:
            removed = sum(cut["removed_mass_g"] for cut in made["corrections"])
            assert removed == pytest.approx(each["metal_g"], rel=0.02)


def test_every_kind_tells_its_keys() -> None:
    told = {each["name"]: [key["key"] for key in each["keys"]] for each in json.loads(json.dumps(kinds()))}
    assert {"shoulder", "turn", "drill", "slug", "add", "mill"} <= set(told)
    assert "max_holes" in told["drill"]


# --- seen early -------------------------------------------------------------------------------------------


def test_a_solid_can_be_looked_at_before_it_is_recognised(tmp_path: Path) -> None:
    small.crank(tmp_path)
    place = RunFolders(tmp_path, tmp_path / "runs", tmp_path / "own")
    seen: dict[str, tuple[str, int]] = {}

    def tell(words: str, share: float) -> None:
        if share >= SOLID_READ_SHARE and (place.own / MESH).exists():
            head, arrays = unpacked((place.own / MESH).read_bytes())
            seen[words] = head["frame"], len(arrays["triangles"]) // 3

    VERBS["inspect"]({"job": {"crankshaft": small.job()["crankshaft"]}}, place, tell)
    count = len(ab.read_crank(tmp_path / small.NAME, unit="mm").triangles)
    assert seen["recognising"] == ("file", count)
    assert seen["drawing"] == ("file", count)
    assert unpacked((place.own / MESH).read_bytes())[0]["frame"] == "rotor"
    assert sorted(path.name for path in place.own.iterdir()) == [MESH, MODEL]


def test_of_a_solid_that_is_refused_nothing_is_left_to_look_at(tmp_path: Path) -> None:
    corners = jobs.corners_of(small.crank(tmp_path))
    jobs.write_stl(tmp_path / small.NAME, corners[1:])  # open
    place = RunFolders(tmp_path, tmp_path / "runs", tmp_path / "own")
    with pytest.raises(ab.AutobalanceError):
        VERBS["inspect"]({"job": {"crankshaft": small.job()["crankshaft"]}}, place, lambda *_: None)
    assert not (place.own / MESH).exists()


# --- meshes -----------------------------------------------------------------------------------------------


def test_a_crank_is_sent_with_the_part_of_every_triangle() -> None:
    inspected = ab.inspect(crank())
    measured = crank().measured
    mesh, anatomy = measured.source.solid.mesh, measured.anatomy
    others = cylinder_candidates(mesh, anatomy.file_to_rotor[2, :3])
    head, arrays = unpacked(crank_mesh(mesh, anatomy, inspected.faces, others))
    corners = arrays["corners"].reshape(-1, 3)
    at = corners[arrays["triangles"].reshape(-1, 3)].astype(float)
    areas = 0.5 * np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1)
    volume = np.einsum("ij,ij->i", at[:, 0], np.cross(at[:, 1], at[:, 2])).sum() / 6.0
    assert volume == pytest.approx(crank().volume_mm3, rel=1e-5)
    for place, part in enumerate(head["parts"], 1):
        mine = areas[arrays["part"] == place].sum()
        if part["kind"] == "face":
            face = next(each for each in inspected.report["faces"] if each["id"] == part["id"])
            assert mine == pytest.approx(face["area_mm2"], rel=0.02), part
        if part["kind"] == "main_journal":
            assert mine == pytest.approx(np.pi * part["diameter_mm"] * part["width_mm"], rel=0.02)
    assert not [part for part in head["parts"] if part["kind"] == "cylinder"]


def test_cylinders_are_found_where_none_was_asked_for() -> None:
    solid = ab.read_crank(jobs.BUNDLED / "straight" / "crank-with-pin.stl", unit="mm", density_kg_m3=7850.0)
    mesh = solid.measured.source.solid.mesh
    found = sorted(round(each.diameter_mm, 2) for each in cylinder_candidates(mesh))
    for pin in (*solid.main_journals, solid.throws[0].crankpin):
        assert round(pin.diameter_mm, 2) in found


def test_a_cube_has_twelve_edges() -> None:
    import trimesh

    box = trimesh.creation.box((1.0, 2.0, 3.0))
    drawn = creases(np.array(box.vertices), np.array(box.faces, dtype=np.int64))
    lengths = np.linalg.norm(drawn[:, 3:] - drawn[:, :3], axis=1)
    assert sorted(lengths.tolist()) == pytest.approx([1.0] * 4 + [2.0] * 4 + [3.0] * 4)


def test_neighbours_on_the_curve_are_near_each_other() -> None:
    points = np.random.default_rng(3).random((4096, 3))
    order = along_a_curve(points)
    assert sorted(order.tolist()) == list(range(4096))
    runs = points[order].reshape(-1, 64, 3)
    assert np.ptp(runs, axis=1).prod(axis=1).mean() < 0.05 * np.ptp(points, axis=0).prod()


def test_arrays_in_a_buffer_begin_at_multiples_of_four() -> None:
    head, arrays = unpacked(
        packed({"a": "é"}, {"one": np.array([1, 2, 3], "u1"), "two": np.array([1.5], "<f4")})
    )
    assert (head["a"], arrays["one"].tolist(), arrays["two"].tolist()) == ("é", [1, 2, 3], [1.5])


@pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX")
def test_what_a_run_starts_is_deaf_to_ctrl_c_from_the_first() -> None:
    """What multiprocessing starts before the first process lets a thread hear again."""
    said = subprocess.run(
        [
            sys.executable,
            "-c",
            "import signal; from multiprocessing import resource_tracker;"
            "from autobalance.browser.runs import _deaf_to_ctrl_c; _deaf_to_ctrl_c();"
            "resource_tracker.ensure_running();"
            "print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert said.stdout == "True\n"
