"""The history of a serial number: every stage on one page."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

from autobalance.report.job_header import html_header

Values = Mapping[str, Any]

STYLE = (
    "body{font-family:sans-serif;margin:2em;color:#111}table{border-collapse:collapse}"
    "th,td{border:1px solid #999;padding:.3em .6em;text-align:right}th{background:#eee}"
    ".logo{height:40px}.work div{display:flex;gap:.5em}.work dd{margin:0}"
    "td:first-child,th:first-child{text-align:left}.within{font-weight:bold}"
)
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
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{STYLE}</style></head><body>{html_header(report)}<h1>{html.escape(title)}</h1>"
        f"<p>Judged {html.escape(tolerance['judge'])}: {permitted}. Angles count counter-clockwise "
        "seen from +z, "
        "from crankpin 1; they point to the heavy side.</p>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
        + (f"<h2>Doubts</h2><ul>{notes}</ul>" if notes else "")
        + "</body></html>\n"
    )


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
