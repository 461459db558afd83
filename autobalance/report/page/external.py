"""The section of ``report.html`` on external balance: what damper, flexplate or flywheel carry."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from autobalance.report.engine_words import external_words
from autobalance.report.page.cells import cell
from autobalance.report.page_units import PAGE_UNITS, unbalance
from autobalance.wording import escape, whole_degrees

Report = Mapping[str, Any]


def external(report: Report) -> str:
    """Return the section; nothing of cranks that are balanced alone."""
    if not report.get("external"):
        return ""
    rows = []
    for k, part in enumerate(report["external"]):
        x, y = part["change_g_mm"]
        rows.append(
            f'<tr><th scope="row">{escape(part["name"])}</th>{cell(report, f"external.{k}.z_mm", 1)}'
            f"{cell(report, f'external.{k}.magnitude_g_mm')}{cell(report, f'external.{k}.angle_deg', 1)}"
            f"<td>{unbalance((x * x + y * y) ** 0.5)}<small class=soft> {whole_degrees([x, y])}</small></td>"
            f"{cell(report, f'external.{k}.pm_g_mm')}</tr>"
        )
    u = PAGE_UNITS.get()
    return f"""<section aria-labelledby="h-external"><h2 id="h-external">External balance</h2>
<p class="lead">{escape(external_words(report))}</p>
<div class="scroll"><table><thead><tr><th scope="col">Part</th><th scope="col">z<small>{u.length}</small></th>
<th scope="col">Carries<small>{u.unbalance}</small></th><th scope="col">Heavy at<small>°</small></th>
<th scope="col">To add<small>{u.unbalance}</small></th><th scope="col">May be off by<small>± {u.unbalance}</small></th></tr></thead>
<tbody>{"".join(rows)}</tbody></table></div></section>"""
