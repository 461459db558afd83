"""The page in a real browser: what it shows, what it asks for, what a click does."""

from __future__ import annotations

import copy
import json
import math
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.paper.drawing import listed_metal
from autobalance.report.balance.kinds import angle_deg
from autobalance.report.metal import Piece, pieces_of
from autobalance.report.page.html import page
from autobalance.report.page.view import Shown, coarse_pieces
from autobalance.report.records.balance import Plane
from autobalance.report.records.balanced import BalancedReport
from autobalance.rigid_rotor.tolerance import TolerancePlane
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Shared
from autobalance.solid.csg.solid import Solid
from autobalance.wording import at, number, signed
from tests import jobs, plans
from tests.report.browser import Browser, browser, missing

needs_browser = pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()} (script/test-tools)")
READY = "return document.getElementById('stage').classList.contains('live')"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    jobs.balanced(jobs.bundled_job(folder), folder / "out")
    return folder / "out"


@pytest.fixture(scope="module")
def report(written: Path) -> dict[str, Any]:
    return jobs.report_of(written)


@pytest.fixture(scope="module")
def window(written: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as found:
        found.resize(1280, 1000)
        found.open(written / "report.html")
        yield found


@pytest.mark.slow
@needs_browser
def test_the_page_draws_itself_and_asks_for_nothing(window: Browser) -> None:
    assert window.run(READY)
    assert [entry for entry in window.log("browser") if entry["level"] in ("SEVERE", "WARNING")] == []
    assert window.requests() == []
    assert window.run("return performance.getEntriesByType('resource').length") == 0


@pytest.mark.slow
@needs_browser
def test_every_number_shown_is_the_reports(window: Browser, report: dict[str, Any]) -> None:
    shown = window.run(
        "return [...document.querySelectorAll('[data-path]')]"
        ".map(e => [e.dataset.path, e.dataset.digits, e.textContent])"
    )
    assert len(shown) > 25
    for path, digits, text in shown:
        value = at(report, path)
        if path == "outcome":
            assert text == "Within tolerance"
        else:
            assert text in (number(value, int(digits)), signed(value, int(digits))), path
    paths = {path for path, _, _ in shown}
    assert {"residual.magnitude_g_mm", "residual.planes.1.magnitude_g_mm", "corrections.1.depth_mm"} <= paths


@pytest.mark.slow
@needs_browser
def test_a_click_on_a_row_lights_the_part_and_a_click_on_the_part_marks_the_row(window: Browser) -> None:
    marked = (
        "return [...document.querySelectorAll('tr[aria-selected=true]')].map(r => Number(r.dataset.part))"
    )
    window.run("document.getElementById('stage').scrollIntoView({block: 'center'})")
    window.click_on("tr[data-part='1']")
    assert window.run(marked) == [1]
    assert window.run("return autobalance.isLit(1)") is True
    assert window.run("return autobalance.isLit(2)") is False
    assert window.run("return document.getElementById('said').textContent").startswith(
        "Correction 1: Shoulder"
    )
    window.run("document.getElementById('stage').scrollIntoView({block: 'center'})")
    for metal in ("metal-on", "metal-off"):
        window.click_on(f"#{metal}")
        window.click_on("tr[data-part='2']")  # turns the view to it
        place = window.run("return autobalance.whereIs(2)")
        assert place is not None
        window.click_on("tr[data-part='1']")
        window.click_on("tr[data-part='2']")
        window.click_on("tr[data-part='2']")
        assert window.run(marked) == []
        window.click(*place)
        assert window.run(marked) == [2]
        assert window.run("return autobalance.isLit(2)") is True
        window.click_on("tr[data-part='1']")
        assert window.run(marked) == [1]
    window.click_on("#metal-on")


@pytest.mark.slow
@needs_browser
def test_it_works_from_the_keyboard(window: Browser) -> None:
    marked = (
        "return [...document.querySelectorAll('tr[aria-selected=true]')].map(r => Number(r.dataset.part))"
    )
    window.run("document.activeElement.blur(); document.querySelector('tr[data-part=\"1\"]').focus()")
    window.press("tr[data-part='2']", "\ue00c")  # Escape: nothing is chosen
    assert window.run(marked) == []
    window.press("tr[data-part='2']", "\ue007")  # Enter
    assert window.run(marked) == [2]
    before = window.screenshot()
    window.press("#canvas", "\ue014\ue014\ue014")  # right arrow: the crank turns
    assert window.screenshot() != before


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_sticks_out_of_the_window(window: Browser, width: int) -> None:
    window.resize(width, 900)
    wide = window.run("return [document.documentElement.scrollWidth, window.innerWidth]")
    window.resize(1280, 1000)
    assert wide[0] <= wide[1]


TAGS = """
const t = [...document.querySelectorAll('.tag')].filter(n => !n.hidden && n.style.visibility !== 'hidden')
  .map(n => n.getBoundingClientRect());
let over = 0;
for (let i = 0; i < t.length; i++) for (let j = 0; j < i; j++)
  if (t[i].left < t[j].right - 1 && t[j].left < t[i].right - 1 && t[i].top < t[j].bottom - 1
      && t[j].top < t[i].bottom - 1) over++;
return [t.length, over];
"""


@pytest.mark.slow
@needs_browser
def test_with_many_cuts_the_view_turns_to_the_chosen_one_and_labels_give_way(
    window: Browser, tmp_path: Path, written: Path
) -> None:
    many, crank = plans.plan(80, ("drill", "mill", "slug"), seed=2), plans.crank()
    many["outputs"] = {"solid": None}
    metal = listed_metal(BalancedReport.read(many), crank)
    pieces = []
    for k, item in enumerate(many["corrections"]):
        pieces.append(Piece.of(Shared(metal[item["number"]], small=-1), k, adds=False))
    (tmp_path / "many.html").write_text(page(BalancedReport.read(many), crank.mesh, pieces), encoding="utf-8")
    for width in (1280, 390):
        window.resize(width, 900)
        window.open(tmp_path / "many.html")
        assert window.run(READY)
        for part in (1, 40, 79):
            row = f"document.querySelector('tr[data-part=\"{part}\"]')"
            window.run(f"{row}.scrollIntoView({{block: 'center'}}); {row}.click()")
            window.run("return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            assert window.run(f"return autobalance.faces({part})")
            shown, over = window.run(TAGS)
            assert shown >= 3
            assert over == 0
            frame = window.run("const r = document.getElementById('stage').getBoundingClientRect();"
                               "return [r.top, r.bottom]")  # fmt: skip
            assert frame[1] > 0.0
            assert frame[0] < 900.0
    window.resize(1280, 1000)
    window.open(written / "report.html")


HOSTILE = "<script>alert(1)</script>\"&'</script><!--"


def hostile(report: dict[str, Any]) -> dict[str, Any]:
    """Return a report in which every free name is an attack."""
    changed: dict[str, Any] = json.loads(json.dumps(report))
    changed["input"]["file"] = HOSTILE.replace("/", "") + ".stl"
    changed["input"]["repairs"] = [HOSTILE]
    changed["job"]["file"] = HOSTILE.replace("/", "") + ".toml"
    changed["job"]["engine"]["rotating_g"] = {HOSTILE: 95.0}
    changed["corrections"][0]["face"] = HOSTILE
    changed["outcome"], changed["reason"] = "above_tolerance", HOSTILE
    changed["autobalance"]["numpy"] = HOSTILE
    return changed


def a_box() -> Solid:
    return Solid.box(np.array([-20.0, -20.0, -30.0]), np.array([20.0, 20.0, 30.0]))


def test_names_are_escaped_everywhere(report: dict[str, Any]) -> None:
    clean = page(BalancedReport.read(report), a_box().mesh)
    dirty = page(BalancedReport.read(hostile(report)), a_box().mesh)
    assert dirty.count("<script") == clean.count("<script")
    assert dirty.count("</script") == clean.count("</script")
    assert "&lt;script&gt;alert(1)" in dirty


@pytest.mark.slow
@needs_browser
def test_a_part_called_script_shows_as_text(
    window: Browser, report: dict[str, Any], tmp_path: Path, written: Path
) -> None:
    (tmp_path / "page.html").write_text(
        page(BalancedReport.read(hostile(report)), a_box().mesh), encoding="utf-8"
    )
    window.open(tmp_path / "page.html")
    assert HOSTILE in window.run("return document.body.innerText")
    assert window.run(READY)
    assert [entry for entry in window.log("browser") if entry["level"] == "SEVERE"] == []
    window.open(written / "report.html")


def test_the_page_is_one_file_that_names_no_address(written: Path) -> None:
    text = (written / "report.html").read_text(encoding="utf-8")
    assert len(text.encode()) < 5e6
    without_engine = text.split("<script>")[0] + "".join(text.split("</script>")[-1:])
    for sign in ("http:", "https:", ' src="/', "@import", "url("):
        assert sign not in without_engine


def test_the_still_picture_is_a_png_of_the_promised_size(written: Path) -> None:
    for name in ("crank-before.png", "crank-after.png"):
        data = (written / name).read_bytes()
        assert data.startswith(b"\x89PNG")
        assert struct.unpack(">II", data[16:24]) == (1120, 760)
    assert (written / "crank-before.png").read_bytes() != (written / "crank-after.png").read_bytes()


def test_forces_stand_on_the_page_where_the_report_has_them(report: dict[str, Any]) -> None:
    text = page(BalancedReport.read(report), a_box().mesh)
    before, after = (report["forces"][key]["orders"][0] for key in ("before", "after"))
    for key in ("force_x_n", "force_y_n"):
        for state, value in (("before", before[key]), ("after", after[key])):
            assert f'data-path="forces.{state}.orders.0.{key}" data-digits="1">{number(value, 1)}<' in text
    assert "h-forces" not in page(BalancedReport.read({**report, "forces": None}), a_box().mesh)


def test_orders_that_are_zero_have_no_row(report: dict[str, Any]) -> None:
    text = page(BalancedReport.read(report), a_box().mesh)
    for k, order in enumerate(report["forces"]["before"]["orders"]):
        for key, value in order.items():
            largest = max(abs(value or 0.0), abs(report["forces"]["after"]["orders"][k][key] or 0.0))
            if key in {"force_x_n", "force_y_n", "greatest_force_n"}:
                shown = f'data-path="forces.before.orders.{k}.{key}"' in text
                assert shown == (largest >= 0.05)


def test_notes_stand_under_the_cuts(report: dict[str, Any]) -> None:
    text = page(BalancedReport.read({**report, "notes": ["no drill of 14 mm is used"]}), a_box().mesh)
    assert text.index('class="list"') < text.index("no drill of 14 mm is used")


def test_a_fine_view_is_decimated_and_says_so_numbers_never(report: dict[str, Any]) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    ring = Solid.revolved(np.stack([30.0 + 10.0 * np.cos(angle), 10.0 * np.sin(angle)], axis=1), 100)
    one = {**report, "corrections": report["corrections"][:1]}
    slice_off = Solid.box(np.array([-50.0, -50.0, 8.0]), np.array([50.0, 50.0, 12.0]))
    left = ring - slice_off
    shown = Shown.of(BalancedReport.read(one), ring, left, [slice_off], most=5000)
    assert 500 < len(shown.body.triangles) <= 5000
    assert shown.note is not None
    assert f"{len(left.mesh.triangles):,}".replace(",", "\u202f") in shown.note
    np.testing.assert_allclose(shown.body.bounds, left.bounds, atol=0.5)  # still the same shape, cut
    (piece,) = shown.pieces
    assert piece.mesh.bounds[0, 2] == pytest.approx(8.0)
    assert shown.note in page(BalancedReport.read(report), shown.body, shown.pieces, view_note=shown.note)
    as_it_is = Shown.of(BalancedReport.read(one), ring, left, [slice_off])
    assert (as_it_is.body, as_it_is.note) == (left.mesh, None)


def test_fine_removed_metal_is_decimated_for_the_page(report: dict[str, Any]) -> None:
    disc = Solid.prism(Region.circle(40.0, 4000), 0.0, 10.0)
    tool = Solid.prism(Region.circle(41.0, 4000), 8.0, 11.0)
    one = {**report, "corrections": report["corrections"][:1]}
    fine = pieces_of(BalancedReport.read(one), disc, [tool])
    count = len(fine[0].mesh.triangles)
    size = disc.mesh.diagonal_mm
    assert coarse_pieces(BalancedReport.read(one), fine, size, count) is fine
    coarse = coarse_pieces(BalancedReport.read(one), fine, size, count // 4)
    assert 0 < len(coarse[0].mesh.triangles) <= count // 4
    assert coarse[0].correction == 0
    np.testing.assert_allclose(np.ptp(coarse[0].mesh.vertices, axis=0), [80.0, 80.0, 2.0], rtol=1e-3)


@pytest.mark.slow
def test_the_page_counts_its_angles_from_the_sheets_zero(report: dict[str, Any]) -> None:
    """It had 136.5° for a hole of which sheet, list and terminal said 46.5° from the keyway."""
    keyed = copy.deepcopy(report)
    keyed["crank"]["datums"]["angle"] = {"of": "keyway", "angle_deg": 100.25}
    plain, turned = (page(BalancedReport.read(each), a_box().mesh, []) for each in (report, keyed))
    assert "from crankpin 1, seen from +z" in plain
    assert "from keyway K, seen from +z" in turned
    for cut in BalancedReport.read(report).corrections:
        angle = angle_deg(cut)
        assert angle is not None
        assert f", {angle:.1f}°" in plain
        assert f", {(angle - 100.25) % 360.0:.1f}°" in turned
    x, y = report["initial"]["unbalance_g_mm"]
    heavy = math.degrees(math.atan2(y, x))
    assert f" at {(heavy - 100.25) % 360.0:.1f}°" in turned
    tips = [re.search(r'tip before" cx="([\d.]+)" cy="([\d.]+)"', each) for each in (plain, turned)]
    (x0, y0), (x1, y1) = ((float(tip[1]), float(tip[2])) for tip in tips if tip is not None)
    before, after = (math.degrees(math.atan2(100.0 - x, 100.0 - y)) for x, y in ((x0, y0), (x1, y1)))
    assert (before - after - 100.25 + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.05)


def test_a_polar_plot_points_to_the_heavy_side() -> None:
    from autobalance.report.pictures.polar import MIDDLE, PERMITTED, RIM, Vector, drawn, figure

    def state(x: float, y: float, off: float | None = None) -> Plane:
        size = math.hypot(x, y)
        return Plane(name="A", unbalance_g_mm=[x, y], magnitude_g_mm=size, uncertainty_g_mm=off)

    made = figure("Resultant", state(0.0, 10.0), state(1.0, 0.0, 0.4), TolerancePlane("A", 0.0, 4.0))
    # 90° is left: crankpin 1 is up, counter-clockwise; what does not fit ends at the rim, with a break mark
    assert f'class="p-before" d="M100 100L{MIDDLE - RIM:.2f} {MIDDLE:.2f}M' in made
    # 0° is up, at a quarter of the permitted circle, which has one size; its uncertainty is a circle about it
    assert f'class="p-after" d="M100 100L{MIDDLE:.2f} {MIDDLE - PERMITTED / 4.0:.2f}"' in made
    assert (
        f'class="p-unc" cx="{MIDDLE:.2f}" cy="{MIDDLE - PERMITTED / 4.0:.2f}" r="{PERMITTED / 10.0:.2f}"'
        in made
    )
    assert "before 10.00 at 90.0°" in made
    nothing = figure("Resultant", state(0.0, 10.0), state(1e-9, 0.0), TolerancePlane("A", 0.0, 4.0))
    assert "<dt>after</dt><dd>0.00</dd>" in nothing
    turned = drawn(4.0, [Vector((0.0, 4.0), "read")], 90.0, "K", (0.0, 2.0))
    assert f'cx="{MIDDLE:.2f}" cy="{MIDDLE - PERMITTED:.2f}" r="4.5"' in turned  # the zero is up
    assert f'class="p-path" d="M{MIDDLE:.2f} {MIDDLE - PERMITTED / 2.0:.2f}L' in turned
    assert ">0° K<" in turned


def test_notes_stand_on_the_page_as_text(report: dict[str, Any]) -> None:
    text = page(BalancedReport.read({**report, "notes": ["slug: no place", "<b>"]}), a_box().mesh)
    assert '<ul class="notes"><li>slug: no place</li><li>&lt;b&gt;</li></ul>' in text
    assert 'class="notes"' not in page(BalancedReport.read({**report, "notes": []}), a_box().mesh)
