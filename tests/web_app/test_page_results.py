"""A result on the page: its cuts dragged in the model, its section, its plots; a view in a notebook."""

import base64
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.report.balance.zero import with_design_radii
from autobalance.report.records.balanced import BalancedReport
from tests.report.browser import Browser
from tests.web_app import small
from tests.web_app.page import (
    BROWSER,
    anew,
    at,
    job_text,
    latest,
    load,
    nothing_wrong,
    numbers,
    predicted,
    put,
    seen,
    seen_again,
    text_of,
    until,
)
from tests.web_app.serving import Served

pytestmark = BROWSER
ALONG = """
const [cut, towards] = arguments, view = document.getElementById("model").view;
const hand = document.querySelector(`.handle[data-cut="${cut.number}"]`).getBoundingClientRect();
const at = cut.begin_mm.map((v, k) => v + cut.depth_mm * cut.deeper[k]);
const turned = [at[0] - 0.01 * at[1], at[1] + 0.01 * at[0], at[2]];
const to = towards === "depth" ? at.map((v, k) => v + cut.deeper[k]) : turned;
const [a, b] = [view.placed(at), view.placed(to)], d = [b[0] - a[0], b[1] - a[1]];
return [hand.x + hand.width / 2, hand.y + hand.height / 2, d[0] / Math.hypot(...d), d[1] / Math.hypot(...d)];
"""
SAYS = "document.getElementById('dragged-says')"
TOGETHER = "document.querySelector('[data-testid=together]').click()"
BACK = "document.getElementById('undo-dragged').click()"


@pytest.fixture
def cuts(page: Browser, project: Served) -> list[dict[str, Any]]:
    """Open the tab with the result, and return its cuts."""
    page.click_on(at("tab-see"))
    until(page, "return !document.getElementById('handles').hidden")
    until(
        page, "return [...document.querySelectorAll('.handle')].filter(each => each.style.left).length === 2"
    )
    page.run(TOGETHER)  # each cut on its own
    run = latest(project, "balance")["id"]
    found: list[dict[str, Any]] = project.ask(f"/api/runs/{run}/model").json["cuts"]
    return found


def drag(page: Browser, cut: dict[str, Any], towards: str, by: float) -> None:
    """Take hold of a cut's handle and pull it so many pixels along its depth, or about the axis."""
    x, y, across, down = page.run(ALONG, cut, towards)
    moves: list[dict[str, Any]] = [
        {"type": "pointerMove", "duration": 0, "x": round(x), "y": round(y)},
        {"type": "pointerDown", "button": 0},
    ]
    for share in (0.3, 1.0):
        to = {"x": round(x + share * by * across), "y": round(y + share * by * down)}
        moves.append({"type": "pointerMove", "duration": 20, **to})
    moves.append({"type": "pointerUp", "button": 0})
    page.call("POST", "/actions", {"actions": [{"type": "pointer", "id": "hand", "actions": moves}]})


def dragged(page: Browser) -> dict[str, list[float]]:
    """Return depths and turns as the sliders beside the model show them."""
    sliders = "[...document.querySelectorAll('#drags input[type=range]')]"
    found: list[float] = page.run(f"return {sliders}.map(each => Number(each.value))")
    return {"depths_mm": found[0::2], "turns_deg": found[1::2]}


def test_a_hole_that_is_dragged_in_the_model_is_predicted_then_cut_and_measured(
    page: Browser, project: Served, cuts: list[dict[str, Any]]
) -> None:
    run = latest(project, "balance")
    report = run["report"]
    still = predicted(page, "predictions")
    assert still[0] == pytest.approx(report["residual"]["magnitude_g_mm"], abs=1e-9)
    drag(page, cuts[0], "depth", 10.0)
    until(page, "return !document.getElementById('dragged').hidden")
    drag(page, cuts[1], "turn", 30.0)
    asked = dragged(page)
    assert asked["depths_mm"][0] > cuts[0]["depth_mm"] + 0.5
    assert asked["depths_mm"][1] == pytest.approx(cuts[1]["depth_mm"], abs=0.05)
    assert asked["turns_deg"][0] == 0.0
    assert abs(asked["turns_deg"][1]) > 2.0
    own = project.ask(f"/api/runs/{run['id']}/predict", asked).json
    until(page, f"return !{SAYS}.ariaBusy && {SAYS}.dataset.within === 'false'")
    shown = predicted(page, "dragged-says")
    assert shown == predicted(page, "predictions")
    assert shown[0] == pytest.approx(own["magnitude_g_mm"], rel=0.05)  # sliders stand on their own steps
    page.run(BACK)
    until(page, f"return document.getElementById('dragged').hidden && !{SAYS}.ariaBusy")
    assert predicted(page, "predictions") == pytest.approx(still)
    page.run("document.getElementById('undo').click()")
    assert dragged(page) == asked
    page.run("document.getElementById('undo').click()")
    assert dragged(page)["turns_deg"] == [0.0, 0.0]
    page.run("document.getElementById('redo').click()")
    assert dragged(page) == asked

    page.click_on(at("try-dragged"))
    made = ran_after(page, project, run["id"])
    try:
        shows_as_dragged(page, project, made, asked, shown)
    finally:
        project.ask(f"/api/runs/{made['id']}", method="DELETE")


def ran_after(page: Browser, project: Served, before: str) -> dict[str, Any]:
    """Wait until the page shows a result other than that of before; return it."""
    script = "return document.querySelector('#download-report')?.href.includes(arguments[0]) === false"
    until(page, script, before)
    made = latest(project, "balance")
    assert made["state"] == "done"
    assert made["id"] != before
    return made


def shows_as_dragged(
    page: Browser, project: Served, made: dict[str, Any], asked: dict[str, list[float]], shown: list[float]
) -> None:
    """Hold a result to its cuts as they were dragged: in the report, the job and on papers."""
    report, listed = made["report"], project.ask("/api/project").json["job"]["correction"]
    assert [each["depth_mm"] for each in report["corrections"]] == pytest.approx(asked["depths_mm"], abs=0.06)
    assert report["corrections"][1]["angle_deg"] == pytest.approx(180.0 + asked["turns_deg"][1], abs=0.5)
    assert report["residual"]["magnitude_g_mm"] == pytest.approx(shown[0], rel=0.1)
    assert numbers(page)["residual.magnitude_g_mm"] == report["residual"]["magnitude_g_mm"]
    assert listed["method"] == "listed"
    assert [each["depth_mm"] for each in listed["cut"]] == [
        each["depth_mm"] for each in report["corrections"]
    ]
    assert re.search(r"\d\.\d{7}", project.ask("/api/project").json["job_text"]) is None
    holes = project.ask(f"/api/runs/{made['id']}/papers/holes.csv").body.decode()
    assert f"{listed['cut'][0]['depth_mm']:.2f}" in holes
    assert page.run("return document.querySelector('[data-testid=verdict]').dataset.tone") != "stale"
    assert page.run("return document.querySelectorAll('a[data-file=\"sheet.pdf\"]').length") == 1
    page.click_on("#panel-see [data-testid=plan-freely]")
    until(page, "return document.querySelector('[data-testid=verdict]').dataset.tone === 'stale'")
    assert project.ask("/api/project").json["job"]["correction"] == small.DRILLED["correction"]


def test_another_drill_of_the_shop_is_chosen_and_its_walls_are_said_to_be_unchecked(
    page: Browser, cuts: list[dict[str, Any]]
) -> None:
    until(page, "return document.getElementById('drag-box').open = true")
    walls = "return document.querySelectorAll('.walls').length"
    assert page.run(walls) == 0
    own = cuts[0]["diameter_mm"]
    (other,) = {12.0, 13.0} - {own}
    put(page, drill_1=f"{other:g}")
    assert page.run(walls) == 2
    until(page, f"return !{SAYS}.ariaBusy && {SAYS}.textContent.includes('⌀ {other:.2f} mm')")
    page.run(BACK)
    assert page.run(walls) == 0


def test_what_is_alike_in_both_webs_moves_at_once(page: Browser, cuts: list[dict[str, Any]]) -> None:
    page.run(TOGETHER)
    page.press(".handle[data-cut='1']", "\ue013\ue014")
    asked = dragged(page)
    assert asked["depths_mm"][0] == asked["depths_mm"][1] > cuts[0]["depth_mm"]
    assert asked["turns_deg"] == [1.0, 1.0]
    assert page.run("return document.querySelector('#dragged-says .turned').textContent").endswith(
        "tolerance"
    )
    page.run(TOGETHER)
    page.press(".handle[data-cut='1']", "\ue014")
    assert dragged(page)["turns_deg"] == [2.0, 1.0]


def test_a_handle_is_worked_by_keys_and_by_its_slider(page: Browser, cuts: list[dict[str, Any]]) -> None:
    up, right, escape = "\ue013", "\ue014", "\ue00c"
    page.press(".handle[data-cut='1']", up + up + right)
    asked = dragged(page)
    step = cuts[0]["depth_step_mm"] or cuts[0]["max_depth_mm"] / 100.0
    assert asked["depths_mm"][0] == pytest.approx(cuts[0]["depth_mm"] + 2.0 * step, abs=step)
    assert asked["turns_deg"] == [1.0, 0.0]
    hand = "document.querySelector('.handle')"
    assert page.run(f"return {hand}.role") == "slider"
    assert page.run(f"return {hand}.getAttribute('aria-valuetext')").endswith("turned 1.0°")
    page.press(".handle[data-cut='1']", escape)
    until(page, "return document.getElementById('dragged').hidden")
    page.run("document.getElementById('drag-box').open = true")
    page.run(
        "const slider = document.querySelector('#drags input[type=range]'); slider.value = 3;"
        "slider.dispatchEvent(new Event('input', { bubbles: true }))"
    )
    until(page, "return !document.getElementById('dragged').hidden")
    assert page.run(f"return Number({hand}.getAttribute('aria-valuenow'))") == pytest.approx(3.0, abs=step)


def test_numbers_of_a_cut_are_typed_as_its_slider_moves_it(
    page: Browser, project: Served, cuts: list[dict[str, Any]]
) -> None:
    """Depth, angle from the job's zero and drill, by the keyboard alone; each field says what it was."""
    enter, down = "\ue007", "\ue015"
    note = "return document.getElementById(arguments[0]).textContent"
    all_of_it = "const field = document.querySelector(arguments[0]); field.focus(); field.select()"

    def typed(field: str, text: str) -> None:
        page.run(all_of_it, f"#gripped-{field}")
        page.press(f"#gripped-{field}", text)

    page.run("document.querySelector(`.handle[data-cut='1']`).focus()")
    until(page, "return document.getElementById('gripped-stop')")
    assert page.run(note, "gripped-stop-note") == "no change"
    typed("stop", "5,5")
    assert dragged(page)["depths_mm"][0] == pytest.approx(5.5, abs=0.06)  # a slider stands on its own steps
    assert page.run(note, "gripped-stop-note") == f"was {cuts[0]['depth_mm']:.2f}"
    angle = latest(project, "balance")["report"]["corrections"][0]["angle_deg"]
    typed("angle", f"{angle + 7.3:.1f}{enter}")
    assert page.run(note, "gripped-angle-note") == f"was {angle:.1f}°"
    until(page, f"return !{SAYS}.ariaBusy && {SAYS}.textContent.includes('{angle + 7.3:.1f}° P1↺, 5.50 mm')")
    asked = {"depths_mm": [5.5, cuts[1]["depth_mm"]], "turns_deg": [7.3, 0.0]}
    own = project.ask(f"/api/runs/{latest(project, 'balance')['id']}/predict", asked).json
    assert predicted(page, "dragged-says")[0] == pytest.approx(own["magnitude_g_mm"], rel=1e-6)
    typed("stop", "99")  # is refused, and nothing moves
    assert page.run(note, "gripped-stop-note") == f"0 to {cuts[0]['max_depth_mm']:.2f} mm"
    assert page.run("return document.getElementById('gripped-stop').ariaInvalid") == "true"
    typed("angle", f"{angle + 90.0:.1f}")
    assert page.run(note, "gripped-angle-note") == f"{angle - 60.0:.1f}° to {angle + 60.0:.1f}°"
    assert dragged(page)["turns_deg"][0] == pytest.approx(7.3, abs=0.26)
    page.press("#gripped-stop", down)
    assert dragged(page)["depths_mm"][0] < 5.45
    own_drill, (other,) = cuts[0]["diameter_mm"], {12.0, 13.0} - {cuts[0]["diameter_mm"]}
    typed("drill", f"{other:g}{enter}")
    assert page.run(note, "gripped-drill-note") == f"was {own_drill:.2f}"
    typed("drill", "3")
    assert page.run(note, "gripped-drill-note") == "Drills of the shop: 12.00; 13.00."
    page.run(BACK)
    until(page, "return document.getElementById('dragged').hidden")


@pytest.mark.looks
def test_the_list_of_cuts_says_where_and_turns_the_view_to_each(page: Browser, project: Served) -> None:
    made = with_design_radii(BalancedReport.read(latest(project, "balance")["report"])).corrections
    where = (
        "const row = document.querySelectorAll('#cuts tr.turns')[arguments[0]];"
        "row.cells[0].firstChild.click();"
        "const view = document.getElementById('model').view;"
        "const away = view.camera.position.clone().sub(view.controls.target).normalize();"
        "const selected = row.getAttribute('aria-selected');"
        "return [[...row.cells].map(each => each.textContent), away.toArray(), selected]"
    )
    for place, cut in enumerate(made):
        cells, away, selected = page.run(where, place)
        assert cells[0] == str(cut.number)
        where_it_is = f"Drilled hole⌀{cut.only_hole.diameter_mm:.2f}, z {cut.z_mm:.2f}"
        assert cells[1].partition("✓")[0] == where_it_is.replace(
            "-", "\u2212"
        )  # with its tick, once it is cut
        assert cells[2] == f"{cut.angle_deg:.1f}° P1↺"
        assert float(cells[3]) == pytest.approx(cut.shown_radius_mm, abs=0.00501)
        assert cells[4].startswith(f"{cut.depth_mm:.3f}")
        assert -sum(a * b for a, b in zip(away, cut.only_hole.inward, strict=True)) > 0.8
        assert selected == "true"


@pytest.mark.looks
def test_a_section_cuts_away_what_is_beyond_its_plane(page: Browser) -> None:
    page.click_on(at("tab-see"))
    page.click_on(at("tool-section"))
    put(page, section="z", section_at=40)
    place = float(
        re.search(
            r"z = ([-−0-9.]+) mm", page.run("return document.getElementById('section-says').textContent")
        )[1].replace("−", "-")  # type: ignore[index]
    )
    heights = """
    const view = document.getElementById("model").view, box = view.box.getBoundingClientRect(), found = [];
    view.use("crank");
    for (let i = 1; i < 30; i++) for (let k = 1; k < 30; k++) {
      const hit = view.pick(box.x + box.width * i / 30, box.y + box.height * k / 30);
      if (hit) found.push(hit.point[2]);
    }
    view.use("result");
    return found;
    """
    cut = until(page, heights)
    assert len(cut) > 20
    assert max(cut) <= place + 0.1
    page.click_on(at("tool-section"))
    assert max(until(page, heights)) > place + 5.0


CYCLE = {"bore_mm": 76.8, "compression_ratio": 13.0, "heat_J": 600.0, "firing_order": [1]}
STRENGTH = {"pin_fillet_mm": 2.0, "material": {"tensile_MPa": 900.0}}
CRANK = {**small.DRILLED["crankshaft"], "density_pm_kg_m3": 20.0}
ANALYSED = {**small.DRILLED, "crankshaft": CRANK, "cycle": CYCLE, "strength": STRENGTH}


@pytest.fixture
def analysed(window: Browser, project: Served) -> Iterator[Browser]:
    """The page with a job that has all that analyses need, loaded once for all of them."""
    if not seen_again(window, project, ANALYSED):
        anew(window, project)
        load(window, project)
        project.ask("/api/job", ANALYSED, "PUT")
        window.run("window.dispatchEvent(new Event('focus'))")  # the job was changed elsewhere
        job_text(window, "bore_mm = 76.8")
        seen(window, project)
    with nothing_wrong(window, project):
        yield window


@pytest.mark.parametrize(
    ("verb", "some"),
    [
        ("cycle", {"pressure-over-angle", "torque-orders"}),
        ("torsion", {"torsion-modes"}),
        ("strength", {"fillet-stress", "crankpin-safety"}),
        ("study", {"study-histogram", "study-causes"}),
        ("shafts", set()),
        ("parts", set()),
        ("factor", set()),
        ("grade", set()),
        ("forces", {"orders", "force-polar"}),  # last, for it changes the job
    ],
)
def test_analyses_of_the_job_are_computed_and_drawn(
    analysed: Browser, project: Served, verb: str, some: set[str]
) -> None:
    page = analysed
    page.click_on(at("tab-analyse"))
    page.click_on(at(f"question-{verb}"))
    assert page.run("return document.querySelectorAll('[data-testid=missing] input').length") == 0
    reads = {"cycle": "bore_mm", "torsion": "bore_mm"}.get(verb)
    if reads:  # the keys that it reads are fields beside its button
        until(page, f"return document.querySelector('#analysis-reads [id$={reads}]')")
    if verb == "study":
        put(page, study_option_samples=200)
    page.click_on(at("analyse"))
    until(page, f"return document.getElementById('analysis-{verb}')")
    run = latest(project, verb)
    pictures = {name.removesuffix(".svg") for name in run["files"] if name.endswith(".svg")}
    assert some <= pictures
    until(
        page,
        f"const all = [...document.querySelectorAll('#analysis-{verb} img')];"
        "for (const each of all) each.loading = 'eager';"
        "return all.length === arguments[0] && all.every(each => each.naturalWidth > 100)",
        len(pictures),
    )
    shown = page.run(f"return [...document.querySelectorAll('#analysis-{verb} img')].map(each => each.alt)")
    assert page.run(f"return document.querySelector('#analysis-{verb} pre').textContent").strip()
    assert set(shown) == {name.replace("-", " ") for name in pictures}
    assert run["report"]["command"] == verb
    card = f"document.querySelector('[data-testid=question-{verb}]')"
    assert page.run(f"return {card}.dataset.is") == "done"
    assert re.search(r"\d", page.run(f"return {card}.querySelector('.says').textContent"))
    if verb == "forces":
        force = run["report"]["states"][-1]["force"]["greatest_n"]
        assert page.run(f"return {card}.querySelector('.says').textContent") == f"{force:.0f} N largest force"
        # of an earlier job once a weight is another
        put(page, factor=0.31)
        until(page, f"return {card}.dataset.is === 'old'", most_s=20.0)


def test_a_question_asks_only_for_what_is_missing(unopened: Browser, project: Served) -> None:
    for told in project.ask("/api/runs").json["runs"]:
        if told["verb"] not in ("inspect", "balance"):  # answers of tests before
            assert project.ask(f"/api/runs/{told['id']}", method="DELETE").status == 200
    engine = {key: value for key, value in small.DRILLED["engine"].items() if key != "rod_length_mm"}
    project.ask("/api/job", {**small.DRILLED, "engine": engine}, "PUT")
    page = load(unopened, project)
    page.click_on(at("tab-analyse"))
    says = "return document.querySelector('[data-testid=question-{}] .says').textContent"
    assert page.run(says.format("shafts")).lower() == "needs: rod length"
    assert page.run(says.format("strength")).lower() == "needs: rod length, bore, compression ratio …"
    assert page.run(says.format("parts")) == "not run"
    page.click_on(at("question-shafts"))
    asked = "return [...document.querySelectorAll('[data-testid=missing] input')].map(each => each.id)"
    assert page.run(asked) == ["need-engine-rod_length_mm"]
    assert page.run("return document.getElementById('analyse').disabled")
    assert text_of(page, "state-line").lower().endswith("needs: rod length")
    _field(page, "need-engine-rod_length_mm", "110")
    until(page, "return !document.getElementById('analyse').disabled")
    assert page.run(asked) == ["need-engine-rod_length_mm"]  # not from under the hand
    assert page.run(says.format("forces")) == "not run"
    page.click_on(at("question-study"))
    assert page.run(asked) == ["need-crankshaft-density_pm_kg_m3"]


def test_a_rotor_is_typed_as_fields_and_as_text_and_drawn(page: Browser, project: Served) -> None:
    page.click_on(at("tab-analyse"))
    page.click_on(at("question-rotor"))
    until(page, "return document.getElementById('rotor-general-speed_rpm')?.value === '0; 9000'")
    _field(page, "rotor-general-speed_rpm", "0; 3000")
    text = "return document.getElementById('rotor-text')?.textContent"  # not there while it is edited
    until(page, f"{text}?.includes('speed_rpm = [0, 3000]')")
    page.run("document.getElementById('rotor-edit').click()")
    edited = until(page, "return document.getElementById('rotor-toml')?.value").replace(
        "length_mm = 1000", "length_mm = 800"
    )
    page.run(
        "document.getElementById('rotor-toml').value = arguments[0]",
        edited.replace("z_mm = 1000", "z_mm = 800"),
    )
    page.run("document.getElementById('rotor-take').click()")
    until(page, f"{text}?.includes('length_mm = 800')")
    page.click_on(at("analyse"))
    until(page, "return document.querySelector('#analysis-rotor img')")
    assert latest(project, "rotor")["report"]["command"] == "rotor"
    page.click_on(at("question-orders"))  # what is missing is said where it can be seen
    page.click_on(at("analyse"))
    assert "record is missing" in until(page, "return document.getElementById('error').textContent")


def _field(page: Browser, name: str, value: str) -> None:
    page.run(
        "const field = document.getElementById(arguments[0]); field.value = arguments[1];"
        "field.dispatchEvent(new Event('input', { bubbles: true }))",
        name,
        value,
    )


SHEET = """
const done = arguments[0], n = 160, corners = new Float32Array(3 * (n + 1) ** 2), rows = [];
for (let i = 0; i <= n; i++) for (let k = 0; k <= n; k++) {
  corners.set([i / n, k / n, 0.1 * Math.sin(6 * i / n)], 3 * (i * (n + 1) + k));
  const a = i * (n + 1) + k;
  if (i < n && k < n) rows.push(a, a + 1, a + n + 1, a + 1, a + n + 2, a + n + 1);
}
import("/static/coarse.js").then(({ coarsened }) => {
  const found = coarsened(corners, new Uint32Array(rows)), few = rows.slice(0, 300);
  let area = 0;
  for (let k = 0; k < found.length; k += 3) {
    const [a, b, c] = [0, 1, 2].map(e => [corners[3 * found[k + e]], corners[3 * found[k + e] + 1]]);
    area += ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2;
  }
  done([rows.length / 3, found.length / 3, area, coarsened(corners, few) === few]);
});
"""


@pytest.mark.looks
def test_a_view_that_is_drawn_slowly_turns_as_a_coarse_copy(page: Browser) -> None:
    """Under software rendering every view is: the whole comes back when it rests."""
    before, after, area, same = page.call("POST", "/execute/async", {"script": SHEET, "args": []})
    assert before > 50_000
    assert 2_000 < after < 0.2 * before
    assert abs(area) == pytest.approx(1.0, rel=0.05)
    assert same
    view = "document.getElementById('model').view"
    drawn = f"return [{view}.sets.crank.fine[0].visible, {view}.sets.crank.coarse?.visible ?? false]"
    assert page.run(f"{view}.held = true; {view}.turned(); {drawn}") == [False, True]
    page.run(f"{view}.controls.dispatchEvent({{ type: 'end' }})")
    until(page, f"return {view}.sets.crank.fine[0].visible && !{view}.sets.crank.coarse.visible")


def test_the_view_in_a_notebook_draws_without_the_app(window: Browser, tmp_path: Path) -> None:
    pytest.importorskip("anywidget")
    crank = ab.read_crank(small.crank(tmp_path), unit="mm", density_kg_m3=7850.0)
    widget = ab.app(crank)
    assert (widget.kind, len(widget.data) > 10_000) == ("crank", True)
    page = tmp_path / "notebook.html"
    data = base64.b64encode(widget.data).decode()
    module = str(widget._esm).replace("</script", r"<\/script")
    page.write_text(
        f"<div id=here></div><script type=module>{module}\n"
        f"const raw = Uint8Array.from(atob('{data}'), each => each.charCodeAt(0));"
        "const model = { get: name => name === 'data' ? new DataView(raw.buffer) : 'crank' };"
        "render({ model, el: document.getElementById('here') });</script>",
        encoding="utf-8",
    )
    window.open(page)
    view = "document.querySelector('.autobalance-view')"
    until(window, f"return {view}?.dataset.state === 'ready'", most_s=30.0)
    assert window.run(f"return Number({view}.dataset.triangles)") == len(
        crank.measured.source.solid.mesh.triangles
    )


@pytest.mark.looks
def test_cuts_stand_by_set_up_and_web_and_each_web_is_drawn_as_on_the_sheet(
    page: Browser, project: Served
) -> None:
    page.click_on(at("tab-see"))
    made = {each["number"]: each for each in latest(project, "balance")["report"]["corrections"]}
    groups = page.run(
        "return [...document.querySelectorAll('#cuts tbody')].map(each => [each.dataset.setup,"
        "each.dataset.web, [...each.querySelectorAll('[data-cut]')].map(cut => Number(cut.dataset.cut))])"
    )
    assert sorted(number for *_, numbers in groups for number in numbers) == sorted(made)
    for side, web, own in groups:
        assert {str(made[number]["web"]) for number in own} == {web}
        assert side == "R"
    page.click_on(at("view-webs"))
    drawn = until(
        page,
        "return [...document.querySelectorAll('[data-testid=web-drawn]')].map(each => [each.dataset.labels,"
        "[...each.querySelectorAll('circle')].map(c => ['cx', 'cy', 'r'].map(a => c.getAttribute(a)))])",
    )
    seen = set()
    for labels, circles in drawn:
        (cx, cy), *_ = [(float(x), float(y)) for x, y, _ in circles]  # the wheel
        marks = [(float(x), float(y)) for x, y, r in circles if r == "0.450"]
        for label, (x, y) in zip(json.loads(labels), marks, strict=True):
            angle = math.degrees(math.atan2(cx - x, cy - y)) % 360.0  # crankpin 1 is up, counter-clockwise
            for number in map(int, label.split(", ")[:1]):
                assert angle == pytest.approx(made[number]["angle_deg"] % 360.0, abs=0.1)
            seen |= set(map(int, label.split(", ")))
    assert seen == set(made)
    page.click_on("#views button")
    assert page.run("return document.getElementById('webs').hidden")
