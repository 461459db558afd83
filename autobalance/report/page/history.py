"""The history of a serial number: every stage on one page."""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence

from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import ON_SCREEN, UnitSystem
from autobalance.report.job_header import page_header
from autobalance.report.page.templates import rendered
from autobalance.report.page_units import PAGE_UNITS, PAGE_ZERO_DEG
from autobalance.report.pictures.polar import stages_figure
from autobalance.types import Values

OUTCOMES = {
    "within_tolerance": "within tolerance",
    "already_within_tolerance": "within tolerance, no further cut",
    "above_tolerance": "ABOVE TOLERANCE",
}


def history_page(report: Values, dates: Sequence[str] = (), units: UnitSystem = "metric") -> str:
    """Return a page in HTML that shows all stages of a report of ``recut``.

    Parameters
    ----------
    report : mapping
        The report as written to JSON.
    dates : sequence of str
        Of the stages, in order; "" or left out: none is shown.
    units : {"metric", "inch"}
    """
    zero = Zero.of(report)
    token, from_zero = PAGE_UNITS.set(ON_SCREEN[units]), PAGE_ZERO_DEG.set(zero.angle_deg)
    try:
        return _page(report, zero, [*dates, *[""] * (len(report["stages"]) - len(dates))])
    finally:
        PAGE_UNITS.reset(token)
        PAGE_ZERO_DEG.reset(from_zero)


def _page(report: Values, zero: Zero, dates: Sequence[str]) -> str:
    stages, tolerance = report["stages"], report["tolerance"]
    serials = sorted({str(each["serial"]) for each in stages if each["serial"] is not None})
    return rendered(
        "history.html",
        title="History" + (f" of {', '.join(serials)}" if serials else ""),
        header=page_header(report),
        is_good=not stages or stages[-1]["outcome"] != "above_tolerance",
        stages=list(zip(stages, dates, strict=True)),
        tolerance=tolerance,
        zero=zero,
        outcomes=OUTCOMES,
        polars=list(_polars(stages, dates, tolerance)),
        doubts=[(stage["stage"], each) for stage in stages for each in stage["suspects"]],
    )


def _polars(stages: Sequence[Values], dates: Sequence[str], tolerance: Values) -> Iterator[str]:
    """Yield plots of the resultant and of each plane: readings and residuals of each stage, with dates."""
    limits: list[tuple[str, int | None, Values]] = [("Resultant", None, tolerance)]
    limits += [(f"Plane {plane['name']}", k, plane) for k, plane in enumerate(tolerance["planes"])]
    days = "; ".join(
        f"stage {each['stage']}: {date}" for each, date in zip(stages, dates, strict=True) if date
    )
    for name, k, limit in limits:
        points = []
        for stage in stages:
            for key, what in (("reading", "read"), ("predicted", "left")):
                entry = stage[key]
                if entry is not None and (k is None or k < len(entry["planes"])):
                    vector = (entry if k is None else entry["planes"][k])["unbalance_g_mm"]
                    points.append((f"{stage['stage']} {what}", vector))
        yield stages_figure(html.escape(name), points, limit["permissible_g_mm"], html.escape(days))
