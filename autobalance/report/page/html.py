"""``report.html`` and the history of a serial number: self-contained pages."""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from autobalance.balancing.sections import section, sections_in
from autobalance.declare import present
from autobalance.report.balance import kinds
from autobalance.report.balance.headline import relaxation_lines
from autobalance.report.balance.zero import Zero, remarks
from autobalance.report.display_units import (
    ON_SCREEN,
    PAGE_UNITS,
    PAGE_ZERO_DEG,
    UnitSystem,
    heavy_at,
    in_units,
)
from autobalance.report.job_header import external_words, page_header, stage_words, turning_words
from autobalance.report.metal import Piece
from autobalance.report.page.templates import cell, force_rows, rendered, span
from autobalance.report.page.view import view_data
from autobalance.report.pictures import polar
from autobalance.report.pictures.polar import stages_figure
from autobalance.report.records.balance import Tolerance
from autobalance.report.records.balanced import BalancedReport, without_folder
from autobalance.report.records.stage import Stage
from autobalance.rigid_rotor.tolerance import TolerancePlane
from autobalance.solid.mesh.mesh import Mesh
from autobalance.wording import at

# ``report.html``: one self-contained page with the verdict, the numbers, and the crank to turn.


COUNTS_AS = {
    "rotating_g": "rotating",
    "reciprocating_g": "reciprocating",
    "crankpin_g": "on the crankpin",
}


def page(
    report: BalancedReport,
    body: Mesh,
    pieces: Sequence[Piece] = (),
    still: bytes | None = None,
    view_note: str | None = None,
    units: UnitSystem = "metric",
    surface: bytes | None = None,
) -> str:
    """Return the whole page.

    Parameters
    ----------
    report : BalancedReport
    body : Mesh
        The crank as it is now (corrected, or untouched if nothing was cut), file coordinates [mm].
    pieces : sequence of Piece
        The metal that was removed.
    still : bytes or None
        A PNG of the crank: for paper, and if the browser has no WebGL.
    view_note : str or None
        What to say of the view: that it was decimated.
    units : {"metric", "inch"}
    surface : bytes or None
        A PNG of a scan's surface in the colours of its distance from what it should be.

    Returns
    -------
    str
        HTML that needs no other file and asks for none.
    """
    zero = Zero.of(report)
    token, from_zero = PAGE_UNITS.set(ON_SCREEN[units]), PAGE_ZERO_DEG.set(zero.angle_deg)
    try:
        view, packed = view_data(report, body, pieces)
        return rendered(
            "report.html",
            report=report,
            at=partial(at, report.values),
            cell=partial(cell, report.values),
            span=partial(span, report.values),
            header=page_header(report),
            **_verdict(report),
            **_numbers(report),
            **_inputs(report),
            zero=zero,
            polars=polar.figures(report, zero.sign),
            forces=force_rows(report.values),
            sections=[section(key).page(found) for key, found in sections_in(report.of_addons)],
            external_words=external_words(report) if report.external else "",
            size=lambda vector: math.hypot(*vector),
            **_corrections(report, zero),
            depths_mm=sorted(abs(item.depth_mm) for item in report.corrections),
            remarks=remarks(report),
            turning=turning_words(report),
            surface=base64.b64encode(surface).decode() if surface else "",
            still=base64.b64encode(still).decode() if still else "",
            view=view,
            view_note=view_note,
            view_mesh=base64.b64encode(packed).decode(),
        )
    finally:
        PAGE_UNITS.reset(token)
        PAGE_ZERO_DEG.reset(from_zero)


def _verdict(report: BalancedReport) -> dict[str, Any]:
    """Return the page's head and foot: files, versions, outcome and verdict."""
    return {
        "file": report.file_name,
        "part": report.part_name,
        "job_file": without_folder(report.given.file or ""),
        "stage": stage_words(report),
        "outcome": report.outcome_words,
        "verdict_class": report.verdict_class,
        "verdict": report.verdict,
        "relaxations": relaxation_lines(report),
        "written": present(report.written.solid),
        "libraries": [
            (name, text) for name, text in vars(report.autobalance).items() if name != "version" and text
        ],
    }


def _numbers(report: BalancedReport) -> dict[str, Any]:
    """Return the figures of the table of unbalance and beside it, the largest uncertainty first."""
    residual, tolerance = report.residual, report.tolerance
    shares = residual.uncertainty_shares_g_mm or {}
    return {
        "counts_uncertainty": tolerance.counts_uncertainty,
        "shares": {"resultant": None} | dict(tolerance.shares(residual)),
        "removed_g": sum(item.removed_mass_g for item in report.corrections),
        "uncertainty_shares": sorted(
            ((name, value) for name, value in shares.items() if value > 0.0), key=lambda pair: -pair[1]
        ),
        "unstated": present(residual.uncertainty_unstated) or (),
    }


def _inputs(report: BalancedReport) -> dict[str, Any]:
    """Return the weights of the parts and of the bob-weights."""
    return {
        "parts_g": [
            (part.replace("_", " "), counts_as, grams)
            for key, counts_as in COUNTS_AS.items()
            for part, grams in report.given.engine.weights_g(key).items()
        ]
        + [(f"oil in throw {oil.throw}", "on the crankpin", oil.on_crankpin_g) for oil in report.oil],
        "bob_weights": report.engine.bob_weights,
    }


def _corrections(report: BalancedReport, zero: Zero) -> dict[str, Any]:
    """Return the words of what was done, and the rows of the cuts and of the pads."""
    rows = list(_rows(report, zero))
    cuts, pads = ([row for row in rows if row["adds"] is adds] for adds in (False, True))
    made = "cut and added" if cuts and pads else "added" if pads else "cut"
    counted = kinds.counted(report.corrections)
    return {"cuts": cuts, "pads": pads, "done": f"What was {made}: {counted}" if rows else "Nothing was cut"}


def _rows(report: BalancedReport, zero: Zero) -> Iterator[dict[str, Any]]:
    for place, item in enumerate(report.corrections):
        size = in_units(item.of_kind.size(item.item), PAGE_UNITS.get())
        yield {
            "place": place,
            "adds": item.of_kind.adds_metal,
            "height_mm": abs(item.depth_mm),
            "added_g": abs(item.removed_mass_g),
            "number": item.number,
            "noun": item.of_kind.noun,
            "details": ", ".join(part for part in (kinds.place(zero.counted(item)), size) if part),
            "effect_g_mm": math.hypot(*item.unbalance_change_g_mm),
            "heavy_at": heavy_at(item.unbalance_change_g_mm),
        }


# The history of a serial number: every stage on one page.


OUTCOMES = {
    "within_tolerance": "within tolerance",
    "already_within_tolerance": "within tolerance, no further cut",
    "above_tolerance": "ABOVE TOLERANCE",
}


def history_page(report: BalancedReport, dates: Sequence[str] = (), units: UnitSystem = "metric") -> str:
    """Return a page in HTML that shows all stages of a report of ``recut``.

    Parameters
    ----------
    report : BalancedReport
    dates : sequence of str
        Of the stages, in order; "" or left out: none is shown.
    units : {"metric", "inch"}
    """
    zero = Zero.of(report)
    token, from_zero = PAGE_UNITS.set(ON_SCREEN[units]), PAGE_ZERO_DEG.set(zero.angle_deg)
    try:
        return _page(report, zero, [*dates, *[""] * (len(report.stages) - len(dates))])
    finally:
        PAGE_UNITS.reset(token)
        PAGE_ZERO_DEG.reset(from_zero)


def _page(report: BalancedReport, zero: Zero, dates: Sequence[str]) -> str:
    stages, tolerance = report.stages, report.tolerance
    serials = sorted({str(each.serial) for each in stages if each.serial is not None})
    return rendered(
        "history.html",
        title="History" + (f" of {', '.join(serials)}" if serials else ""),
        header=page_header(report),
        is_good=not stages or stages[-1].outcome != "above_tolerance",
        stages=list(zip(stages, dates, strict=True)),
        tolerance=tolerance,
        zero=zero,
        outcomes=OUTCOMES,
        polars=list(_polars(stages, dates, tolerance)),
        doubts=[(stage.stage, each) for stage in stages for each in stage.suspects],
    )


def _polars(stages: Sequence[Stage], dates: Sequence[str], tolerance: Tolerance) -> Iterator[str]:
    """Yield plots of the resultant and of each plane: readings and residuals of each stage, with dates."""
    limits: list[tuple[str, int | None, Tolerance | TolerancePlane]] = [("Resultant", None, tolerance)]
    limits += [(f"Plane {plane.name}", k, plane) for k, plane in enumerate(tolerance.planes)]
    days = "; ".join(f"stage {each.stage}: {date}" for each, date in zip(stages, dates, strict=True) if date)
    for name, k, limit in limits:
        points = []
        for stage in stages:
            for entry, what in ((stage.reading, "read"), (stage.predicted, "left")):
                if entry is not None and (k is None or k < len(entry.planes)):
                    vector = (entry if k is None else entry.planes[k]).unbalance_g_mm
                    points.append((f"{stage.stage} {what}", vector))
        yield stages_figure(html.escape(name), points, limit.permissible_g_mm, html.escape(days))
