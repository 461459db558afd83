"""The page's part on what went in: weights, tolerance, crank."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from autobalance.report.page.cells import span
from autobalance.report.page_units import PAGE_UNITS, inertia_unit, length, mass
from autobalance.wording import at, degrees, escape, number, weights

Report = Mapping[str, Any]


def inputs(report: Report) -> str:
    return f"""<section aria-labelledby="h-inputs"><h2 id="h-inputs">What went in</h2><div class="split" style="margin-top:12px">
<div class="scroll">{_weights(report)}</div><dl class="facts">{_crank_facts(report)}</dl></div></section>"""


def _weights(report: Report) -> str:
    rows = []
    for key, name in (
        ("rotating_g", "rotating"),
        ("reciprocating_g", "reciprocating"),
        ("crankpin_g", "on the crankpin"),
    ):
        for part, grams in weights(report, key).items():
            rows.append(
                f'<tr><th scope="row">{escape(part.replace("_", " "))}</th><td class="words soft">{name}</td>'
                f"<td>{mass(grams)}</td></tr>"
            )
    for bob in at(report, "engine.bob_weights") or []:
        rows.append(
            f'<tr><th scope="row">Bob-weight, throw {bob["throw"]}</th><td class="words soft">on a balancing machine</td>'
            f"<td class=strong>{mass(bob['mass_g'])}{_grams(bob['mass_g'])}</td></tr>"
        )
    return f"""<table><caption>Weights in {PAGE_UNITS.get().mass}, of one connecting rod and one crankpin</caption>
<thead><tr><th scope="col">Part</th><th scope="col" class="words">Counts as</th><th scope="col">{PAGE_UNITS.get().mass}</th></tr></thead>
<tbody>{"".join(rows)}</tbody></table>"""


def _grams(value_g: float) -> str:
    """Return a bob-weight in grams too, where the page has ounces."""
    return "" if PAGE_UNITS.get().is_metric else f"<small>{number(value_g)} g</small>"


def _crank_facts(report: Report) -> str:
    tolerance, u = report["tolerance"], PAGE_UNITS.get()
    throws = ", ".join(
        f"{length(t['crank_radius_mm'])} {u.length} at {degrees(t['angle_deg'])}"
        for t in at(report, "crank.throws") or []
    )
    facts = [
        ("Grade and speed", f"G {tolerance['grade_mm_s']:g} at {number(tolerance['speed_rpm'], 0)} rpm"),
        ("Rotor mass", f"{span(report, 'tolerance.rotor_mass_g')} {u.mass}"),
        ("Crank as in the file", f"{span(report, 'crank.mass_g')} {u.mass}"),
        ("Polar inertia before", f"{span(report, 'crank.polar_inertia_kg_mm2', 3)} {inertia_unit()}"),
        ("Throws", throws or "–"),
        ("Counterweight m·r′", _product(report)),
        ("Triangles in the file", number(at(report, "input.triangles"), 0)),
        ("Repairs", escape("; ".join(at(report, "input.repairs") or []) or "none needed")),
    ]
    return "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in facts if value)


def _product(report: Report) -> str:
    if at(report, "counterweight.product_g_mm.initial") is None:
        return ""
    path = "counterweight.product_g_mm"
    return f"{span(report, path + '.initial', 1)} → {span(report, path + '.final', 1)} {PAGE_UNITS.get().unbalance}"
