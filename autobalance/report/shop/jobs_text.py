"""An archive of jobs as a table, its series, and as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

from autobalance.report.display_units import DisplayUnits
from autobalance.report.tables import table
from autobalance.wording import percent

VERDICTS = {
    "within_tolerance": "within",
    "already_within_tolerance": "within already",
    "above_tolerance": "ABOVE",
}
COLUMNS = (
    *("date", "customer", "engine", "serial", "stage", "before_g_mm", "after_g_mm", "permissible_g_mm"),
    *("share_before", "share_after", "place_before", "place_after", "outcome", "report"),
)


def jobs_text(values: Mapping[str, Any], units: DisplayUnits) -> str:
    """Return the jobs, one a line, the latest last, then the series."""
    if not values["jobs"]:
        what = "" if values["find"] is None else f" with {values['find']!r}"
        return f"{values['folder']}: no report of balance or recut{what} in this folder or below it"
    words = ("customer", "engine", "serial")
    rows: list[tuple[str, ...]] = [
        ("Date", *words, "stage", "before, of permitted", "after, of permitted", "verdict", "report")
    ]
    for job in values["jobs"]:
        shares = (
            f"{percent(job[f'share_{when}'])} in {job[f'place_{when}'].removeprefix('the ')}"
            for when in ("before", "after")
        )
        rows.append(
            (
                job["date"],
                *(job[key] or "" for key in words),
                str(job["stage"]),
                *shares,
                VERDICTS[job["outcome"]],
                job["report"],
            )
        )
    parts = [table(rows), *(_series(each, units) for each in values["series"])]
    return "\n\n".join(parts)


def _series(series: Mapping[str, Any], units: DisplayUnits) -> str:
    name = series["engine"] or "jobs that name no engine"
    head = f"{name}: {series['jobs']} jobs, {series['within']} within"
    rows: list[tuple[str, ...]] = [
        (head, "mean before", "at", "scatter", "mean after", "capability", "drift")
    ]
    for plane in series["planes"]:
        of = units.of_unbalance
        drift = "" if plane["drift_g_mm"] is None else of(plane["drift_g_mm"])
        if plane["drift_in_errors"] is not None:
            drift += f" ({plane['drift_in_errors']:.1f} standard errors)"
        rows.append(
            (
                f"  plane {plane['plane']}",
                of(plane["mean_before_g_mm"]),
                f"{plane['mean_before_deg']:.1f}°",
                of(plane["scatter_before_g_mm"]),
                of(plane["mean_after_g_mm"]),
                "" if plane["capability"] is None else f"{plane['capability']:.2f}",
                drift,
            )
        )
    drifting = [plane["plane"] for plane in series["planes"] if plane["drifts"]]
    return table(rows) + (f"\n  plane {' and '.join(drifting)} drifts" if drifting else "")


def jobs_csv(values: Mapping[str, Any]) -> bytes:
    """Return the jobs as CSV, one a row."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(values["jobs"])
    return text.getvalue().encode()
