"""The history of a serial number: every stage on one page."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from autobalance.report.job_header import html_header
from autobalance.report.pictures.polar import stages_figure
from autobalance.report.style import page_style

Values = Mapping[str, Any]

OUTCOMES = {
    "within_tolerance": "within tolerance",
    "already_within_tolerance": "within tolerance, no further cut",
    "above_tolerance": "ABOVE TOLERANCE",
}
HEADINGS = (
    "Stage",
    "Read",
    "Expected",
    "Deviation",
    "Cuts",
    "Taken off",
    "Predicted after",
    "Outcome",
    "Bob-weights",
    "Speed",
)


def history_page(report: Values) -> str:
    """Return a page in HTML that shows all stages of a report of ``recut``."""
    stages = report["stages"]
    serials = sorted({str(each["serial"]) for each in stages if each["serial"] is not None})
    title = "History" + (f" of {', '.join(serials)}" if serials else "")
    tolerance = report["tolerance"]
    permitted = f"permitted {tolerance['permissible_g_mm']:.2f} g·mm"
    for plane in tolerance["planes"]:
        permitted += f", plane {plane['name']} {plane['permissible_g_mm']:.2f} g·mm"
    head = "".join(f"<th>{each}</th>" for each in HEADINGS)
    rows = "".join(_row(stage) for stage in stages)
    notes = "".join(
        f"<li>Stage {stage['stage']}: {html.escape(each['key'])}: {html.escape(each['says'])} "
        f"({each['difference_g_mm']:.3g} g·mm apart, {each['left_g_mm']:.3g} left)</li>"
        for stage in stages
        for each in stage["suspects"]
    )
    good = stages[-1]["outcome"] != "above_tolerance" if stages else True
    doubts = f"<section><h2>Doubts</h2><ul>{notes}</ul></section>" if notes else ""
    state = "good" if good else "bad"
    words = f"Judged {html.escape(tolerance['judge'])}: {permitted}. Angles count counter-clockwise "
    return "\n".join(
        [
            '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">',
            f"<title>{html.escape(title)}</title><style>{page_style()}</style></head><body>",
            f'<header class="top">{html_header(report)}<div class="verdict {state}">',
            f"<h1>{html.escape(title)}</h1><p>{words}seen from +z, from crankpin 1; they point",
            " to the heavy side.</p></div></header>",
            '<main><section><h2>Stages</h2><div class="scroll"><table>',
            f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div></section>",
            '<section><h2>Heavy side, stage by stage</h2><div class="plots">',
            f"{''.join(_polars(stages, tolerance))}</div></section>{doubts}</main></body></html>\n",
        ]
    )


def _polars(stages: Sequence[Values], tolerance: Values) -> Iterator[str]:
    """Return a plot of the resultant and of each plane: what was read and left at each stage."""
    limits: list[tuple[str, int | None, Values]] = [("Resultant", None, tolerance)]
    limits += [(f"Plane {plane['name']}", k, plane) for k, plane in enumerate(tolerance["planes"])]
    for name, k, limit in limits:
        points = []
        for stage in stages:
            for key, what in (("reading", "read"), ("predicted", "left")):
                found = stage[key]
                if found is not None and (k is None or k < len(found["planes"])):
                    vector = (found if k is None else found["planes"][k])["unbalance_g_mm"]
                    points.append((f"{stage['stage']} {what}", vector))
        yield stages_figure(html.escape(name), points, limit["permissible_g_mm"])


def _row(stage: Values) -> str:
    name = f'<a href="{html.escape(stage["report"], quote=True)}">{stage["stage"]}</a>'
    speed = "" if stage["speed_rpm"] is None else f"{stage['speed_rpm']:g} rpm"
    cells = (
        name,
        _unbalance(stage["reading"]),
        _unbalance(stage["expected"]),
        _unbalance(stage["deviation"]),
        str(stage["corrections"]),
        f"{stage['removed_mass_g']:.2f} g",
        _unbalance(stage["predicted"]),
        OUTCOMES[stage["outcome"]],
        ", ".join(f"{each:.2f} g" for each in stage["bob_weights_g"]),
        speed,
    )
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _unbalance(values: Values | None) -> str:
    if values is None:
        return ""
    doubt = values["uncertainty_g_mm"]
    off = "" if doubt is None else f" ± {doubt:.2f}"
    lines = [f"{values['magnitude_g_mm']:.2f}{off} g·mm at {values['angle_deg']:.1f}°"]
    lines += [f"{plane['name']} {plane['magnitude_g_mm']:.2f} g·mm" for plane in values["planes"]]
    return "<br>".join(lines)
