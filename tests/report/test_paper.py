"""The sheet's pages on random plans: nothing lost, nothing over anything else, nothing outside the frame."""

from __future__ import annotations

import io
import math
import re
import shutil
import subprocess
from itertools import pairwise, product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from pypdf import PdfReader

from autobalance.declare import decoded
from autobalance.paper.cuts import spread, spread_between, spread_on_circle
from autobalance.paper.drawing import Drawings, WebDrawing
from autobalance.paper.making import makings
from autobalance.paper.plates import SCALES, Plate, plates, scale_for
from autobalance.paper.rim_strips import LAP_MM, Strip, cheeks, strips, templates, tile_range, tiles_of
from autobalance.paper.sheet import pdf
from autobalance.paper.tolerances import ERROR_SHARE, USUAL_ACCURACY, press_fit, tolerances
from autobalance.paper.web_view import WebView
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import FROM_CRANKPIN, Zero, with_design_radii
from autobalance.report.display_units import ON_PAPER
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.wording import degrees
from tests import plans, worst_cuts

needs_poppler = pytest.mark.skipif(
    shutil.which("pdftotext") is None, reason="not installed: poppler-utils (script/test-tools)"
)
CASES = (
    (1, "A4", "inch", plans.KINDS),
    (12, "Letter", "metric", plans.KINDS),
    (50, "A4", "metric", plans.KINDS),
    (120, "Letter", "inch", plans.KINDS),
    (50, "A4", "inch", ("drill",)),
)
POINTS_PER_MM = 72.0 / 25.4
EDGE_MM = 5.0
TOUCH = 0.3
"""By how much the boxes that fonts state may come into each other [points]: descents of a line above."""


WITH_KEYWAY = (12, 120)


def datums(web_z_mm: float, end_z_mm: float) -> dict[str, Any]:
    """Return a keyway, and two faces that can be touched."""
    keyway = {
        "end": "-z",
        "angle_deg": 100.25,
        "width_mm": 6.0,
        "depth_mm": 3.5,
        "shaft_diameter_mm": 24.0,
        "z_min_mm": -60.0,
        "z_max_mm": -40.0,
    }
    return {
        "keyways": [keyway],
        "flanges": [],
        "angle": {"of": "keyway", "angle_deg": 100.25},
        "faces": [
            {"of": "web", "name": "+z face of web 4", "z_mm": web_z_mm},
            {"of": "end", "name": "face at the +z end", "z_mm": end_z_mm},
        ],
    }


@pytest.fixture(
    scope="module", params=CASES, ids=lambda case: f"{case[0]}-{case[1]}-{case[2]}-{len(case[3])}"
)
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, ...]:
    count, paper, units, names = request.param
    report = plans.plan(count, names, seed=count)
    if count in WITH_KEYWAY:
        report["crank"]["datums"] = datums(30.0, 90.0)
    data = pdf(BalancedReport.read(report), plans.drawings_of(report), paper, units, "2026-01-31")
    path = tmp_path_factory.mktemp("paper") / "sheet.pdf"
    path.write_bytes(data)
    return report, path, units, [page.extract_text() for page in PdfReader(path).pages]


def written(value: float, units: str, of: str) -> str:
    """Return a number as the sheet has it."""
    per, digits = {
        ("metric", "length"): (1.0, 3),
        ("metric", "diameter"): (1.0, 2),
        ("metric", "mass"): (1.0, 2),
        ("inch", "length"): (1.0 / 25.4, 4),
        ("metric", "place"): (1.0, 2),
        ("inch", "place"): (1.0 / 25.4, 3),
        ("inch", "diameter"): (1.0 / 25.4, 3),
        ("inch", "mass"): (1.0 / 28.349523125, 4),
    }[units, of]
    return f"{value * per:.{digits}f}"


def test_one_line_a_cut_holds_every_number(case: tuple[Any, ...]) -> None:
    report, _, units, pages = case
    lines = "\n".join(pages).replace("−", "-").splitlines()
    for item in report["corrections"]:
        found = [line for line in lines if re.match(rf"\s*{item['number']}\s", line)]
        assert len(found) == 1
        (line,) = found
        comes = item["kind"] == "add"
        depth, mass = item["depth_mm"], item["removed_mass_g"]
        wanted = [
            "Pad" if comes else item["kind"],
            f"web {item['web']}",
            written(item.get("entry_radius_mm", item["radius_mm"]), units, "place"),
            written(item["z_mm"], units, "place"),
            written(abs(depth) if comes else depth, units, "length"),
            written(abs(mass) if comes else mass, units, "mass"),
        ]
        if item["kind"] != "turn":
            wanted += [f"{item['angle_deg']:.1f}°", f"{(360.0 - item['angle_deg']) % 360.0:.1f}°"]
        if "diameter_mm" in item:
            wanted.append(written(item["diameter_mm"], units, "diameter"))
        if item.get("point_mm"):
            wanted.append(written(depth + item["point_mm"], units, "length"))
        for text in wanted:
            assert re.search(rf"(?<![\d.]){re.escape(text)}(?!\d)", line), (text, line)
        assert not comes or "build up" in line


def test_what_a_kind_needs_stands_on_the_sheet_too(case: tuple[Any, ...]) -> None:
    report, _, units, pages = case
    zero = Zero.of(BalancedReport.read(report))
    text = " ".join(" ".join(pages).split())
    for item in report["corrections"]:
        for key in ("wall_left_mm", "depth_left_mm", "length_mm", "inner_radius_mm", "outer_radius_mm",
                    "rim_radius_mm", "new_radius_mm", "face_z_mm"):  # fmt: skip
            if key in item:
                assert written(item[key], units, "length") in text, (key, item)
        for key in ("start_deg", "end_deg"):
            if key in item:
                assert degrees(zero.ccw(item[key])) in text
        if item["kind"] == "slug":
            assert written(item["slug_mass_g"], units, "mass") in text
            assert f"{item['centrifugal_load_N']:.0f} N" in text
    assert ("H7/s6" in text) == any(item["kind"] == "slug" for item in report["corrections"])
    for words in ("Tolerances: angle, position, depth, diameter", "Degree wheel: zero", "Readings after"):
        assert words in text


@needs_poppler
def test_no_text_lies_over_another_and_all_is_within_the_page(case: tuple[Any, ...]) -> None:
    _, path, _, _ = case
    done = subprocess.run(["pdftotext", "-bbox", path, "-"], capture_output=True, check=True).stdout
    root = ElementTree.fromstring(re.sub(rb'\sxmlns="[^"]+"', b"", done, count=1))
    pages = root.findall(".//page")
    assert pages
    for number, page in enumerate(pages, 1):
        wide, high = float(page.get("width", 0)), float(page.get("height", 0))
        words = [str(word.text) for word in page.findall("word")]
        box = np.array(
            [
                [float(word.get(key, 0)) for key in ("xMin", "yMin", "xMax", "yMax")]
                for word in page.findall("word")
            ]
        )
        assert (
            min(box[:, :2].min(), wide - box[:, 2].max(), high - box[:, 3].max()) >= EDGE_MM * POINTS_PER_MM
        )
        assert " ".join(words).find(f"page {number} of {len(pages)}") >= 0
        assert "crank.stl" in words
        wider = np.minimum(box[:, None, 2], box[None, :, 2]) - np.maximum(box[:, None, 0], box[None, :, 0])
        higher = np.minimum(box[:, None, 3], box[None, :, 3]) - np.maximum(box[:, None, 1], box[None, :, 1])
        over = np.argwhere(np.triu((wider > TOUCH) & (higher > TOUCH), 1))
        assert not len(over), (number, [(words[i], words[j]) for i, j in over[:5]])


@needs_poppler
def test_no_ink_within_5_mm_of_the_edge(case: tuple[Any, ...], tmp_path: Path) -> None:
    _, path, _, _ = case
    subprocess.run(["pdftoppm", "-gray", "-r", "50.8", path, tmp_path / "p"], check=True)  # 2 pixels a mm
    found = sorted(tmp_path.glob("p*.pgm"))
    assert found
    for each in found:
        data = each.read_bytes()
        head = re.match(rb"P5\s+(\d+)\s+(\d+)\s+255\s", data)
        assert head is not None
        image = np.frombuffer(data, np.uint8, offset=head.end()).reshape(int(head[2]), int(head[1]))
        border = np.ones(image.shape, dtype=bool)
        border[10:-11, 10:-11] = False
        assert image[border].min() > 200
        assert image[~border].min() < 100


# --- what can be touched ---------------------------------------------------------------------------------


def pages_of(report: dict[str, Any], **options: Any) -> list[str]:
    data = pdf(BalancedReport.read(report), plans.drawings_of(report), **options)
    return [page.extract_text() for page in PdfReader(io.BytesIO(data)).pages]


def beside(pages: list[str], number: int) -> str:
    """Return what stands beside the drawing of a cut, until the next one."""
    text = "\n".join(pages[1:])
    found = re.search(rf"^(?:cut|pad) {number}\b(.*?)(?=^(?:cuts?|pad) |\Z)", text, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found.group(1)


def test_all_angles_count_from_the_keyway_and_z_from_a_cheek_that_no_cut_moves() -> None:
    report = plans.plan(7, seed=3)
    lowered = next(item for item in report["corrections"] if item["kind"] == "shoulder")
    report["crank"]["datums"] = datums(lowered["face_height_mm"], 90.0)
    pages = pages_of(report)
    words = " ".join(" ".join(pages).split())
    assert (
        "zero is the middle of keyway K (6.00 mm wide, at the -z end); crankpin 1 is at 259.8° ccw" in words
    )
    from_cheek = cheeks(BalancedReport.read(report))
    webs = {web["number"]: web for web in report["crank"]["webs"]}
    for item in report["corrections"]:
        said = beside(pages, item["number"])
        cheek = from_cheek[item["web"]]
        web = webs[item["web"]]
        assert cheek.z_mm in (web["z_min_mm"], web["z_max_mm"])
        away = written(abs(item["position_mm"][2] - cheek.z_mm), "metric", "length")
        assert f"{away} {cheek.letter}" in said
        if item["kind"] == "shoulder":
            assert abs(cheek.z_mm) != item["face_height_mm"]
        if item["kind"] != "turn":
            angle = (item["angle_deg"] - 100.25) % 360.0
            assert f"{angle:.1f}°" in said
            assert f"{360.0 - angle:.1f}°" in said
            assert f"{item['angle_deg']:.1f}°" not in said


def test_the_zero_can_be_crankpin_1_and_the_keyway_stands_in_brackets_then() -> None:
    report = plans.plan(5, seed=3)
    report["crank"]["datums"] = datums(30.0, 90.0)
    pages = pages_of(report, zero="crankpin")
    words = " ".join(" ".join(pages).split())
    assert "zero is crankpin 1; keyway K" in words
    assert "in brackets from keyway K" in words
    for item in report["corrections"]:
        if item["kind"] != "turn":
            assert f"{item['angle_deg']:.1f}°" in beside(pages, item["number"])
            assert f"{(item['angle_deg'] - 100.25) % 360.0:.1f}°" not in words


# --- plates -----------------------------------------------------------------------------------------------


def hole(number: int, web: int, angle_deg: float, up: bool, depth: float = 10.0) -> dict[str, Any]:
    """Return an axial hole in the cheek of a web."""
    low, high = plans.WEBS[web - 1]
    item: dict[str, Any] = plans.plan(1, ("drill",), seed=1)["corrections"][0]
    turn = math.radians(angle_deg)
    return item | {
        "number": number,
        "web": web,
        "direction": "axial",
        "inward": [0.0, 0.0, -1.0 if up else 1.0],
        "position_mm": [34.0 * math.cos(turn), 34.0 * math.sin(turn), high if up else low],
        "entry_radius_mm": 34.0,
        "angle_deg": angle_deg,
        "z_mm": high if up else low,
        "diameter_mm": 8.0,
        "point_mm": 2.4,
        "depth_mm": depth,
    }


def shown(items: list[dict[str, Any]]) -> list[Plate]:
    report = plans.plan(1)
    report["corrections"] = items
    read = BalancedReport.read(report)
    return plates(plans.drawings_of(report), read.corrections, read.crank.webs)


def test_webs_that_look_alike_are_drawn_once() -> None:
    (plate,) = shown([hole(1, 1, 150.0, True), hole(2, 2, 150.2, True, 10.4)])
    assert plate.title == "Webs 1 and 2, seen from the +z end"
    assert plate.labels() == ["1, 2"]
    assert plate.twins[0].words == "web 2 as it stands"
    (plate,) = shown([hole(1, 1, 150.0, True), hole(2, 4, 210.0, False)])
    assert plate.webs == [1, 4]
    assert plate.twins[0].words == "web 4 mirrored"


def test_webs_that_differ_are_drawn_each() -> None:
    for other in (hole(2, 2, 170.0, True), hole(2, 2, 150.0, True, 14.0), hole(2, 2, 150.0, False),
                  hole(2, 2, 150.0, True) | {"diameter_mm": 10.0}):  # fmt: skip
        assert [plate.webs for plate in shown([hole(1, 1, 150.0, True), other])] == [[1], [2]]


def test_what_enters_from_below_is_drawn_as_seen_from_there() -> None:
    above, below = shown([hole(1, 1, 150.0, True), hole(2, 1, 200.0, False)])
    assert (above.from_below, below.from_below) == (False, True)
    assert [item.number for item in below.items] == [2]
    views = [
        WebView(
            BalancedReport.read({"crank": {"throws": []}}),
            plate,
            FROM_CRANKPIN,
            ON_PAPER["metric"],
            120.0,
            120.0,
        )
        for plate in (above, below)
    ]
    for view in views:
        view.cx = view.cy = 0.0
    ((x, _),) = views[0].to_page(np.array([[0.0, 30.0]]))
    ((mirrored, _),) = views[1].to_page(np.array([[0.0, 30.0]]))
    assert x == -mirrored < 0.0


def test_alike_holes_at_even_steps_are_said_once() -> None:
    items = [hole(k + 1, 1, 130.0 + 10.0 * k, True) for k in range(10)]
    report = plans.plan(1)
    report["corrections"] = items
    words = " ".join(" ".join(pages_of(report)).split())
    assert "Drill 10 × ⌀8.00, 10.000 deep, at 130.0° … 220.0° every 10.0°" in words
    assert "cuts 1-10" in words
    items[4]["depth_mm"] = 9.0
    words = " ".join(" ".join(pages_of(report)).split())
    assert "Drill 10 ×" not in words
    assert "Drill dia 8.00, axial, 9.000 deep" in words


def test_few_holes_take_two_pages() -> None:
    report = plans.plan(1)
    report["corrections"] = [
        hole(k + 1, 1 + k // 3, 150.0 + 30.0 * (k % 3) + 5.0 * (k // 3), True) for k in range(6)
    ]
    for paper in ("A4", "Letter"):
        assert len(pages_of(report, paper=paper)) == 2


# --- templates --------------------------------------------------------------------------------------------


def test_no_letter_is_smaller_than_9_points(case: tuple[Any, ...]) -> None:
    _, path, _, _ = case
    sizes: set[float] = set()

    def note(text: str, _current: Any, matrix: Any, _font: Any, size: float) -> None:
        if text.strip():
            sizes.add(round(size * float(np.hypot(*matrix[:2])), 3))

    for page in PdfReader(path).pages:
        page.extract_text(visitor_text=note)
    assert min(sizes) >= 9.0


def test_holes_of_a_rim_have_the_rims_own_radius_and_are_said_once() -> None:
    report = plans.plan(1)
    entries = (47.99, 47.97, 48.0, 47.5)  # the last is not in the rim
    report["corrections"] = [hole(k + 1, 2, 150.0 + 20.0 * k, True) for k in range(4)]
    for item, entry in zip(report["corrections"], entries, strict=True):
        turn = np.radians(item["angle_deg"])
        place = [entry * np.cos(turn), entry * np.sin(turn), item["position_mm"][2]]
        item |= {"entry_radius_mm": entry, "position_mm": place, "direction": "radial"}
        item["inward"] = [-float(np.cos(turn)), -float(np.sin(turn)), 0.0]
    report["crank"]["facet_error"] = {"sag_mm": 0.04}
    for web in report["crank"]["webs"]:
        web["outline"] = {"rim_radius_mm": 48.0}
    shown = with_design_radii(BalancedReport.read(report)).corrections
    assert [item.shown_radius_mm for item in shown] == [48.0, 48.0, 48.0, 47.5]
    assert [np.hypot(*item.position_mm[:2]) for item in shown] == pytest.approx([48.0, 48.0, 48.0, 47.5])
    assert [making.label for making in makings(shown, FROM_CRANKPIN, {}, ON_PAPER["metric"])] == [
        "cuts 1-3",
        "cut 4",
    ]
    assert with_design_radii(
        BalancedReport.read({**report, "crank": {**report["crank"], "facet_error": None}})
    ).corrections[1].shown_radius_mm == pytest.approx(47.97)


def test_smaller_views_save_pages() -> None:
    """They took eleven, most of them half empty."""
    report = plans.plan(46, ("drill",))
    data = pdf(BalancedReport.read(report), plans.drawings_of(report))
    assert len(PdfReader(io.BytesIO(data)).pages) == 8


def test_a_hole_in_a_flat_side_has_a_flat_template_laid_on_its_corners() -> None:
    report = plans.plan(1, ("drill",))
    side = np.array([[-30.0, -30.0], [40.0, -30.0], [40.0, 30.0], [-30.0, 30.0]])
    item = report["corrections"][0] | {
        "web": 1, "inward": [0.0, -1.0, 0.0], "position_mm": [5.0, 30.0, -34.0], "diameter_mm": 8.0,
        "direction": "radial", "angle_deg": math.degrees(math.atan2(30.0, 5.0)),
        "entry_radius_mm": math.hypot(5.0, 30.0),
    }  # fmt: skip
    report["corrections"] = [item]
    round_, flat = templates(BalancedReport.read(report), Drawings((WebDrawing(1, [side]),), []))
    assert not round_
    (found,) = flat
    assert found.long_mm == pytest.approx(70.0)
    assert found.along_mm == pytest.approx((35.0,))  # from the corner that comes first counter-clockwise
    turn = np.linspace(0.0, 2.0 * math.pi, 129)[:-1]
    disc = math.hypot(5.0, 30.0) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    round_, flat = templates(BalancedReport.read(report), Drawings((WebDrawing(1, [disc]),), []))
    assert (len(round_), flat) == (1, [])
    rim = np.radians(7.5 * (np.arange(48) + 0.5))  # sides of 11 mm, which sag by 0.2 mm
    report["corrections"] = [
        item | {"position_mm": [0.0, 86.0, -34.0], "diameter_mm": 4.0, "entry_radius_mm": 86.0}
    ]
    coarse = 86.0 / math.cos(math.radians(3.75)) * np.stack([np.cos(rim), np.sin(rim)], axis=1)
    round_, flat = templates(BalancedReport.read(report), Drawings((WebDrawing(1, [coarse]),), []))
    assert (len(round_), flat) == (1, [])


def test_each_strip_reaches_an_edge_a_pins_line_or_the_keyway() -> None:
    report = plans.plan(30, ("drill",), seed=5)
    report["crank"]["datums"] = datums(30.0, 90.0)
    for web in report["crank"]["webs"]:
        web["outline"] = {"rim_radius_mm": plans.RIM, "fan_angle_deg": 150.0, "thickness_mm": 20.0}
    found = strips(BalancedReport.read(report))
    assert found
    for strip in found:
        assert strip.marks
        for name, angle in strip.marks:
            assert strip.first_deg <= angle <= strip.last_deg
            assert name in {"edge of the arc", "line of crankpin 1", "keyway K"}
            assert angle % 360.0 in {105.0, 255.0, 0.0, 180.0, 100.25}


# --- tolerances -------------------------------------------------------------------------------------------


def test_tolerances_together_use_at_most_half_of_what_the_verdict_leaves() -> None:
    """Against the unbalance of a cylinder: each error's change of it, from the closed form."""
    report = plans.plan(3, ("drill",), seed=3)
    report["tolerance"]["judge"] = "static"
    left = report["tolerance"]["permissible_g_mm"] - report["residual"]["magnitude_g_mm"]
    for item in report["corrections"]:
        item["inward"], item["point_mm"] = [0.0, 0.0, 1.0], 0.0
        u = cylinder_g_mm(item)
        turn = math.radians(item["angle_deg"])
        away = -np.array([math.cos(turn), math.sin(turn)])
        item["removed_mass_g"] = u / math.hypot(*item["position_mm"][:2])
        item["unbalance_change_g_mm"] = (u * away).tolist()
        item["unbalance_per_mm_g_mm"] = (u / item["depth_mm"] * away).tolist()
    found = tolerances(BalancedReport.read(report))
    assert found is not None
    (values,) = found.by_kind.values()
    assert set(values) == set(USUAL_ACCURACY)
    each: list[float] = []
    for item in report["corrections"]:
        u, turn = cylinder_g_mm(item), math.radians(item["angle_deg"])
        place = np.array(item["position_mm"][:2])
        angle = math.radians(values["angle_deg"])
        each.append(2.0 * u * math.sin(0.5 * angle))
        out = place / np.hypot(*place) * values["position_mm"]
        each.append(u * (np.hypot(*(place + out)) / np.hypot(*place) - 1.0))
        each.append(cylinder_g_mm(item, depth=values["depth_mm"]) - u)
        each.append(cylinder_g_mm(item, diameter=values["diameter_mm"]) - u)
    assert ERROR_SHARE * 0.85 < sum(each) / left <= ERROR_SHARE * 1.005  # cut to two digits
    assert found.worst == pytest.approx(sum(each) / left, rel=5e-3)
    assert found.independent == pytest.approx(math.hypot(*each) / left, rel=5e-3)


def test_cut_again_with_all_errors_at_their_limits_the_worst_way_round() -> None:
    """Each of three holes off in angle, place, depth and diameter at once, towards many directions."""
    report, crank = plans.plan(3, ("drill",), seed=5), plans.crank()
    items, permitted, left = report["corrections"], report["tolerance"], report["residual"]
    for item in items:
        worst_cuts.state_effects(item, crank)
    found = tolerances(BalancedReport.read(report))
    assert found is not None
    (values,) = found.by_kind.values()
    planes = permitted["planes"]
    heights = [plane["z_mm"] for plane in planes]
    limits = [permitted["permissible_g_mm"], *(plane["permissible_g_mm"] for plane in planes)]
    residuals = [each["magnitude_g_mm"] for each in (left, *left["planes"])]
    nominal = worst_cuts.measured(crank, items)
    errors = worst_cuts.errors(items, values, crank, heights)
    used = []
    for k, turn in product(range(3), np.arange(8) * math.pi / 4.0):
        wrong = worst_cuts.made(items, errors, k, turn)
        off = math.hypot(*worst_cuts.in_planes(worst_cuts.measured(crank, wrong) - nominal, heights)[k])
        used.append(off / (limits[k] - residuals[k]))
        assert residuals[k] + off <= limits[k]
    assert (
        0.6 * ERROR_SHARE < max(used) <= 1.01 * ERROR_SHARE
    )  # cut to two digits; errors of one hole add as vectors


def cylinder_g_mm(item: dict[str, Any], depth: float = 0.0, diameter: float = 0.0) -> float:
    radius = math.hypot(*item["position_mm"][:2])
    volume = math.pi / 4.0 * (item["diameter_mm"] + diameter) ** 2 * (item["depth_mm"] + depth)
    return float(plans.STEEL * volume * radius)


def test_a_verdict_that_leaves_nothing_gives_no_tolerance() -> None:
    report = plans.plan(2)
    report["residual"]["magnitude_g_mm"] = 2.0 * report["tolerance"]["permissible_g_mm"]
    assert tolerances(BalancedReport.read(report)) is None
    assert b"%PDF" in pdf(BalancedReport.read(report), None)


@pytest.mark.parametrize("diameter", [2.0, 6.0, 12.0, 25.4, 60.0])
def test_press_fits_always_hold(diameter: float) -> None:
    fit = press_fit(diameter)
    least, most = fit.slug_mm[0] - fit.bore_mm[1], fit.slug_mm[1] - fit.bore_mm[0]
    assert 0.0 < least < most < 0.01 * diameter + 0.02


# --- places of labels, scales, strips ---------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_spread_labels_keep_apart_and_in_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wanted = rng.uniform(0.0, 30.0, 12).tolist()
    for found in (spread(wanted, 4.0), spread_between(wanted, 4.0, 0.0, 60.0)):
        assert np.diff(np.sort(found)).min() >= 4.0 - 1e-9
        assert np.argsort(found).tolist() == np.argsort(wanted).tolist()
    around = np.mod(spread_on_circle(rng.uniform(-8.0, 8.0, 30).tolist(), 0.2), 2.0 * math.pi)
    gaps = np.diff(np.append(np.sort(around), np.sort(around)[0] + 2.0 * math.pi))
    assert gaps.min() >= 0.2 - 1e-9


def test_scales_are_those_of_the_standard() -> None:
    for scale, name in SCALES:
        a, b = map(float, name.split(":"))
        assert scale == pytest.approx(a / b)
        assert str(int(max(a, b)))[0] in "125"
    assert scale_for(3000.0, 10.0, 180.0, 100.0) == (0.05, "1:20")


def test_each_radius_has_a_strip_of_its_own_whose_lengths_lap() -> None:
    report = plans.plan(160, ("drill",), seed=9)
    radial = [item for item in report["corrections"] if item["direction"] == "radial"]
    for k, item in enumerate(radial):
        item["entry_radius_mm"] = 48.0 if k % 2 else 130.0
    found = strips(BalancedReport.read(report))
    assert sorted(item.number for strip in found for item in strip.items) == sorted(
        item["number"] for item in radial
    )
    for strip in found:
        assert {item.shown_radius_mm for item in strip.items} == {strip.radius_mm}
        ends = [tile_range(strip, tile, 180.0) for tile in range(tiles_of(strip, 180.0))]
        assert ends[0][0] == 0.0
        assert ends[-1][1] == pytest.approx(strip.long_mm)
        for one, two in pairwise(ends):
            assert one[1] - two[0] == pytest.approx(LAP_MM)
        for low, high in ends:  # no stub without a hole
            assert any(low <= along(strip, item) <= high for item in strip.items)
    assert max(tiles_of(strip, 180.0) for strip in found) > 1


def along(strip: Strip, item: Cut) -> float:
    """Return how far along a strip a hole stands, from the end that is printed first [mm]."""
    turned = strip.first_deg + (item.angle_deg - strip.first_deg) % 360.0
    return math.radians(strip.last_deg - turned) * strip.radius_mm


def test_a_report_of_an_assembly_shows_its_stages() -> None:
    report = plans.plan(1)
    total = dict(report["residual"], magnitude_g_mm=7.25, angle_deg=12.5)
    stage = {
        "stage": 1, "name": "Flywheel", "shaft": "crank", "mass_g": 3000.0, "part_g_mm": [1.5, 2.5],
        "runout_g_mm": [0.5, 0.25], "key_g_mm": [0.0, 0.125], "sum": total, "permissible_g_mm": 9.5,
        "within": True, "corrections": [{"z_mm": 40.0, "g_mm": 7.25, "angle_deg": 12.5}], "left": [0.0, 0.0],
    }  # fmt: skip
    text = " ".join(
        page.extract_text()
        for page in PdfReader(
            io.BytesIO(pdf(BalancedReport.read({**report, "assembly": [stage]}), None))
        ).pages
    )
    for words in ("Assembly", "Flywheel", "3000.00", "7.25", "9.50", "within", "12.5°", "40.000"):
        assert words in text


def test_the_angle_of_added_metal_is_that_of_its_place() -> None:
    for item, (x, y) in product(plans.plan(6)["corrections"], [(-1.0, 0.0)]):
        if item["kind"] == "add":
            item["position_mm"] = [30.0 * x, y, 0.0]
            assert kinds.angle_deg(decoded(Cut, {**item, "angle_deg": 180.0}, partly=True)) == 180.0
            del item["angle_deg"]  # an earlier version lacks it
            assert kinds.angle_deg(decoded(Cut, item, partly=True)) == 180.0


def test_a_hole_that_is_there_needs_no_template_and_has_its_whole_depth() -> None:
    report = plans.plan(1)
    radial = {"direction": "radial", "inward": [0.0, -1.0, 0.0], "position_mm": [0.0, 48.0, -34.0]}
    fresh = hole(1, 1, 90.0, True) | radial
    report["corrections"] = [fresh, fresh | {"number": 2, "deepened_from_mm": 7.5, "depth_mm": 2.0}]
    round_, _ = templates(BalancedReport.read(report))
    assert [[item.number for item in strip.items] for strip in round_] == [[1]]
    text = " ".join(" ".join(pages_of(report)).split())
    assert "deepen the existing hole of 7.500: 9.500 in all" in text
    assert "A hole that is there already: depth from where its full diameter ended." in text


def test_the_part_keeps_its_name_when_it_is_cut_again() -> None:
    report = plans.plan(1)
    report["input"]["file"] = "../balanced.stl"
    report["job"]["crankshaft"] = {**report["job"]["crankshaft"], "file": "cranks/no-7.stl"}
    assert "PART balanced.stl" in " ".join(" ".join(pages_of(report)).split())
    stages = [{"stage": 2, "reading": report["initial"]}]
    text = " ".join(" ".join(pages_of(report | {"stages": stages})).split())
    assert "PART no-7.stl" in text
    assert "no-7.stl · job.toml · stage 2 from balanced.stl" in text
