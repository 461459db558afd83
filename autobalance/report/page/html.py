"""``report.html``: one self-contained page with the verdict, the numbers, and the crank to turn."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

from autobalance.report.balance import kinds
from autobalance.report.balance.relaxation_text import relaxation_lines
from autobalance.report.balance.text import remarks
from autobalance.report.display_units import ON_SCREEN, UnitSystem, in_units
from autobalance.report.engine_words import turning_words
from autobalance.report.job_header import html_header, stage_words
from autobalance.report.metal import Piece
from autobalance.report.page.cells import cell, span
from autobalance.report.page.external import external
from autobalance.report.page.forces import forces, loads_with_gas
from autobalance.report.page.inputs import inputs
from autobalance.report.page.view import view_data
from autobalance.report.page_units import PAGE_UNITS, inertia_unit, length, mass, unbalance
from autobalance.report.pictures import polar
from autobalance.solid.mesh.mesh import Mesh
from autobalance.wording import (
    at,
    counts_uncertainty,
    escape,
    file_name,
    judged_shares,
    number,
    outcome_words,
    verdict,
    whole_degrees,
)

Report = Mapping[str, Any]

SOURCE = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
TICK = '<svg viewBox="0 0 24 24" fill="none" stroke="currentColor" stroke-width="3" aria-hidden="true">'
MARKS = {
    True: TICK
    + '<circle cx="12" cy="12" r="10.3" stroke-width="2.2"/><path d="M7 12.4l3.4 3.4L17 9"/></svg>',
    False: TICK + '<circle cx="12" cy="12" r="10.3" stroke-width="2.2"/><path d="M8 8l8 8M16 8l-8 8"/></svg>',
}


@cache
def _asset(name: str) -> str:
    return (resources.files("autobalance.report") / "assets" / name).read_text(encoding="utf-8")


def _script(name: str) -> str:
    """Return a script that cannot end its own element."""
    return _asset(name).replace("</script", r"<\/script")


def page(
    report: Report,
    body: Mesh,
    pieces: Sequence[Piece] = (),
    still: bytes | None = None,
    view_note: str | None = None,
    units: UnitSystem = "metric",
) -> str:
    """Return the whole page.

    Parameters
    ----------
    report : mapping
        The report as written to JSON.
    body : Mesh
        The crank as it is now (corrected, or untouched where nothing was cut), file coordinates [mm].
    pieces : sequence of Piece
        The metal that was removed.
    still : bytes or None
        A PNG of the crank: for paper, and where the browser has no WebGL.
    view_note : str or None
        What to say of the view: that it was decimated.
    units : {"metric", "inch"}

    Returns
    -------
    str
        HTML that needs no other file and asks for none.
    """
    token = PAGE_UNITS.set(ON_SCREEN[units])
    try:
        return _page(report, body, pieces, still, view_note)
    finally:
        PAGE_UNITS.reset(token)


def _page(
    report: Report, body: Mesh, pieces: Sequence[Piece], still: bytes | None, view_note: str | None
) -> str:
    name = escape(file_name(report))
    good = report["outcome"] != "above_tolerance"
    scripts = "".join(f"<script>{_script(file)}</script>" for file in SCRIPTS)
    sections = [
        _numbers(report),
        _cuts(report, body, pieces, still, view_note),
        _planes(report),
        external(report),
        _passes(report),
        forces(report),
        loads_with_gas(report),
        inputs(report),
    ]
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{SOURCE}">
<title>{outcome_words(report)} – {name}</title>
<style>{_asset("page.css")}</style>
</head>
<body>
<a class="skip" href="#cuts">Skip to what was cut</a>
<header class="top">
{html_header(report)}
<p class="kicker"><b>Balance report</b><span>{name}</span>{_job_name(report)}{_stage(report)}</p>
<div class="verdict {"good" if good else "bad"}">
<h1>{MARKS[good]}<span data-path="outcome">{outcome_words(report)}</span></h1>
<p>{_said(verdict(report))}</p>
{_reason(report)}
</div>
</header>
<main>
{"".join(sections)}
</main>
{_footer(report)}
{scripts}
</body>
</html>
"""


SCRIPTS = ("three.min.js", "view.js")


def _said(text: str) -> str:
    """Return prose of the report in the page's units."""
    return escape(in_units(text, PAGE_UNITS.get()))


def _job_name(report: Report) -> str:
    name = str(at(report, "job.file") or "").replace("\\", "/").rpartition("/")[2]
    return f"<span>{escape(name)}</span>" if name else ""


def _stage(report: Report) -> str:
    return f"<span>{escape(stage_words(report))}</span>" if stage_words(report) else ""


def _notes(report: Report) -> str:
    """Return kinds without a place, drills that were not used, and the like; nothing where all is said."""
    items = "".join(f"<li>{_said(remark)}</li>" for remark in remarks(report))
    return f'<ul class="notes">{items}</ul>' if items else ""


def _reason(report: Report) -> str:
    if not report.get("reason"):
        return ""
    ways = "".join(f"<li>{_said(line)}</li>" for line in relaxation_lines(report))
    ways = f'<ul class="reason">{ways}</ul>' if ways else ""
    return f'<p class="reason">{_said(report["reason"])}</p>{ways}'


# --- the numbers -------------------------------------------------------------------------------------------


def _numbers(report: Report) -> str:
    shares = dict(judged_shares(report))
    rows = [_row(report, "Resultant", "initial", "residual", "tolerance", shares.get("resultant"))]
    for k, plane in enumerate(report["tolerance"]["planes"]):
        label = f"Plane {plane['name']} <span class=soft>z = {length(plane['z_mm'], 1)} {PAGE_UNITS.get().length}</span>"
        paths = (f"initial.planes.{k}", f"residual.planes.{k}", f"tolerance.planes.{k}")
        rows.append(_row(report, label, *paths, shares.get(plane["name"])))
    judged = "the resultant and both planes" if report["tolerance"]["judge"] == "dynamic" else "the resultant"
    counted = ", with its uncertainty" if counts_uncertainty(report) else ""
    return f"""<section aria-labelledby="h-numbers"><h2 id="h-numbers" class="sr">Numbers</h2><div class="split">
<div class="scroll"><table>
<caption>Unbalance in {PAGE_UNITS.get().unbalance}. The verdict is on {judged}, measured on the written file{counted}.</caption>
<thead><tr><th scope="col"></th><th scope="col">Before</th><th scope="col">After<small>± off by</small></th>
<th scope="col">Permitted</th><th scope="col">Used</th></tr></thead>
<tbody>{"".join(rows)}</tbody></table></div>
<dl class="facts">{_facts(report)}</dl>
</div></section>"""


def _row(report: Report, label: str, before: str, after: str, permitted: str, share: float | None) -> str:
    bar = ""
    if share is not None:
        width = f"{min(100.0, 100.0 * share):.1f}%"
        over = ' class="over"' if share > 1.0 else ""
        bar = f'{number(100.0 * share, 1)} %<span class="used" aria-hidden="true"><i{over} style="width:{width}"></i></span>'
    return (
        f'<tr><th scope="row">{label}</th>{cell(report, before + ".magnitude_g_mm")}'
        f"<td>{span(report, after + '.magnitude_g_mm').replace('<span', '<span class=strong', 1)}"
        f"{_doubt(report, after)}</td>"
        f"{cell(report, permitted + '.permissible_g_mm')}<td>{bar or 'not judged'}</td></tr>"
    )


def _doubt(report: Report, path: str) -> str:
    if at(report, f"{path}.uncertainty_g_mm") is None:
        return ""
    return f"<small class=off>± {span(report, path + '.uncertainty_g_mm')}</small>"


def _facts(report: Report) -> str:
    removed = sum(item["removed_mass_g"] for item in report["corrections"])
    word, amount = ("added", -removed) if removed < 0.0 else ("removed", removed)
    facts = [
        (f"Mass {word}", f'<span data-sum="removed_mass_g">{mass(amount)}</span> {PAGE_UNITS.get().mass}'),
        ("Polar inertia", f"{span(report, 'inertia_change_kg_mm2', 3, sign=True)} {inertia_unit()}"),
        ("Balance factor", _factor(report)),
        ("Uncertainty", _uncertainty(report)),
    ]
    return "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in facts)


def _factor(report: Report) -> str:
    if at(report, "balance_factor.final") is None:
        return "none: the throws cancel out"
    initial, final = span(report, "balance_factor.initial", 4), span(report, "balance_factor.final", 4)
    return f"{initial} → {final}<small>target {span(report, 'balance_factor.target', 4)}</small>"


def _uncertainty(report: Report) -> str:
    value = at(report, "residual.uncertainty_g_mm")
    if value is None:
        return "–"
    shares = _uncertainty_shares(report)
    listed = ", ".join(f"{escape(name.replace('_', ' '))} {unbalance(share)}" for name, share in shares)
    if silent := at(report, "residual.uncertainty_unstated"):
        listed += f"{'; ' if listed else ''}not stated: {escape(', '.join(silent))}"
    return f"± {span(report, 'residual.uncertainty_g_mm')} {PAGE_UNITS.get().unbalance}" + (
        f"<small>{listed}</small>" if listed else ""
    )


def _uncertainty_shares(report: Report) -> list[tuple[str, float]]:
    """Return name and amount of each share of the uncertainty, the largest first."""
    shares = at(report, "residual.uncertainty_shares_g_mm") or {}
    return sorted(((str(k), float(v)) for k, v in shares.items() if v > 0.0), key=lambda pair: -pair[1])


# --- what was cut ------------------------------------------------------------------------------------------


def _cuts(
    report: Report, body: Mesh, pieces: Sequence[Piece], still: bytes | None, view_note: str | None
) -> str:
    data, packed = view_data(report, body, pieces)
    safe = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    image = base64.b64encode(still).decode() if still else ""
    picture = (
        f'<img class="still" alt="The crank, removed metal in colour" src="data:image/png;base64,{image}">'
    )
    note = f" {escape(view_note)}" if view_note else ""
    lead = (
        "Select a row and the part lights up; click the part and its row is marked. Angles are counter-clockwise "
        f"from crankpin 1, seen from +z.{turning_words(report)}{note}"
    )
    return f"""<section id="cuts" aria-labelledby="h-cuts"><h2 id="h-cuts">{_cuts_title(report)}</h2>
<p class="lead">{lead}</p>
<div class="bench">
<div class="stage" id="stage">{picture if still else ""}
<canvas id="canvas" tabindex="0" role="img" aria-label="The crank in three dimensions. Arrow keys turn it, plus and minus zoom, 0 resets the view. The table lists every correction."></canvas>
<div class="tags" id="tags" aria-hidden="true"></div>
{_key(data)}<p class="hint" aria-hidden="true">Drag to turn · wheel to zoom · right-drag to move</p>
<p class="key" id="no3d" hidden>This browser shows no 3D view; the picture stands in for it.</p>
</div>
<div class="list">{_cut_table(report)}{_notes(report)}</div>
{_toolbar(bool(pieces))}
</div>
<p class="sr" id="said" role="status" aria-live="polite"></p>
<script type="application/json" id="view-data">{safe}</script>
<script type="text/plain" id="view-mesh">{base64.b64encode(packed).decode()}</script>
</section>"""


def _cuts_title(report: Report) -> str:
    count = len(report["corrections"])
    if count == 0:
        return "Nothing was cut"
    return f"What was cut: {count} correction{'s' if count > 1 else ''}"


def _key(data: Mapping[str, Any]) -> str:
    depths = sorted(abs(item["depth_mm"]) for item in data["corrections"])
    if not depths:
        return ""
    same = number(depths[0], 2) == number(depths[-1], 2)
    ramp = (
        f'<span class="ramp one"></span>{length(depths[0], 2)} {PAGE_UNITS.get().length}'
        if same
        else f'{length(depths[0], 2)}<span class="ramp"></span>{length(depths[-1], 2)} {PAGE_UNITS.get().length}'
    )
    return f'<div class="key" aria-hidden="true"><div>depth {ramp}</div></div>'


def _cut_table(report: Report) -> str:
    if not report["corrections"]:
        return "<p class=soft style='padding:12px 4px'>The file is untouched.</p>"
    rows = []
    for k, item in enumerate(report["corrections"]):
        details = ", ".join(
            part for part in (kinds.place(item), in_units(kinds.size(item), PAGE_UNITS.get())) if part
        )
        rows.append(
            f'<tr tabindex="0" aria-selected="false" data-part="{item["number"]}">'
            f'<td><span class="badge">{item["number"]}</span></td>'
            f'<td class="what">{escape(kinds.noun(item))}<small>{escape(details)}</small></td>'
            f"{cell(report, f'corrections.{k}.depth_mm', 3)}{cell(report, f'corrections.{k}.removed_mass_g')}"
            f"<td>{unbalance(math.hypot(*item['unbalance_change_g_mm']), 1)}<small class=soft> "
            f"{whole_degrees(item['unbalance_change_g_mm'])}</small></td></tr>"
        )
    u = PAGE_UNITS.get()
    return f"""<table role="grid" aria-label="Corrections"><thead><tr><th scope="col">No</th>
<th scope="col" class="words">Cut</th><th scope="col">Depth<small>{u.length}</small></th>
<th scope="col">Mass<small>{u.mass}</small></th><th scope="col">Effect<small>{u.unbalance}</small></th></tr></thead>
<tbody>{"".join(rows)}</tbody></table>"""


def _toolbar(has_pieces: bool) -> str:
    metal = """<fieldset><legend>Removed metal</legend>
<label><input type="radio" name="metal" id="metal-on" checked>in place</label>
<label><input type="radio" name="metal" id="metal-off">taken away</label></fieldset>"""
    hidden = "" if has_pieces else " hidden"
    return f"""<div class="tools"><div{hidden}>{metal}</div>
<fieldset><legend>Show</legend><label><input type="checkbox" id="show-planes" checked>axis and planes</label>
<label><input type="checkbox" id="show-vectors" checked>unbalance</label>
<label><input type="checkbox" id="show-labels" checked>numbers</label></fieldset>
<fieldset><legend>Section</legend><select id="section" aria-label="Section across">
<option value="none">none</option><option value="z">z</option><option value="x">x</option>
<option value="y">y</option></select>
<input type="range" id="section-at" min="0" max="100" value="50" aria-label="Place of the section">
<output id="section-text"></output></fieldset>
<fieldset><legend>View</legend><button type="button" data-view="oblique">Oblique</button>
<button type="button" data-view="side">Side</button><button type="button" data-view="end">End</button></fieldset></div>"""


# --- planes, passes, forces --------------------------------------------------------------------------------


def _planes(report: Report) -> str:
    return f"""<section aria-labelledby="h-planes"><h2 id="h-planes">Heavy side, before and after</h2>
<p class="lead">Each arrow points to the heavy side. The dashed circle is what is permitted; “after” is drawn to its
scale, the dotted circle around its tip is the uncertainty.</p>
<div class="plots">{"".join(polar.figures(report))}</div></section>"""


def _passes(report: Report) -> str:
    if not report["steps"]:
        return ""
    permitted, u = report["tolerance"]["permissible_g_mm"], PAGE_UNITS.get()
    rows = []
    for k, step in enumerate(report["steps"]):
        depths = ", ".join(length(depth, 3) for depth in step["depths_mm"])
        rows.append(
            f'<tr><th scope="row">{step["step"]}</th><td class="words">{depths}</td>'
            f"{cell(report, f'steps.{k}.predicted_g_mm', 3)}{cell(report, f'steps.{k}.measured_g_mm', 3)}"
            f"<td>{number(100.0 * step['measured_g_mm'] / permitted, 1)} %</td></tr>"
        )
    return f"""<section aria-labelledby="h-passes"><h2 id="h-passes">Passes</h2>
<p class="lead">Each pass plans on predictions, cuts the solid, and measures what was written.</p>
<div class="scroll"><table><thead><tr><th scope="col">Pass</th><th scope="col" class="words">Depths<small>{u.length}</small></th>
<th scope="col">Predicted<small>{u.unbalance}</small></th><th scope="col">Measured<small>{u.unbalance}</small></th>
<th scope="col">Of permitted</th></tr></thead>
<tbody>{"".join(rows)}</tbody></table></div></section>"""


def _footer(report: Report) -> str:
    versions = report["autobalance"]
    solid = at(report, "outputs.solid")
    written = (
        f"<p>Written: {escape(solid['file'])}, sha256 <code>{escape(solid['sha256'])}</code></p>"
        if solid
        else ""
    )
    others = ", ".join(f"{escape(k)} {escape(v)}" for k, v in versions.items() if k != "version" and v)
    return f"""<footer><p>Read: {escape(file_name(report))}, sha256 <code>{escape(report["input"]["sha256"])}</code></p>
{written}<p>autobalance {escape(versions["version"])} with {others}. This page holds everything it shows and asks the network
for nothing. The 3D view is drawn by three.js (MIT licence, © its authors).</p></footer>"""
