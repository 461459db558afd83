"""Numbers and names as people read them: fixed digits, real minus signs, escaped text."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping
from typing import Any

from autobalance.quantities import Text, g_mm, said
from autobalance.units import wrapped_deg

OUTCOMES = {
    "within_tolerance": "Within tolerance",
    "already_within_tolerance": "Already within tolerance",
    "above_tolerance": "Above tolerance",
}
NOT_PROVEN = ", not proven"
NO_VALUE = "–"


def outcome_words(report: Mapping[str, Any]) -> str:
    """Return the outcome of a report, and whether its uncertainty leaves it unproven.

    Examples
    --------
    >>> outcome_words({"outcome": "within_tolerance", "proven": False})
    'Within tolerance, not proven'
    """
    return OUTCOMES[outcome_of(report)] + (NOT_PROVEN if is_unproven(report) else "")


def outcome_of(report: Mapping[str, Any]) -> str:
    """Return the outcome of the crank, as it is shown: after earlier stages it was not within from the first.

    Examples
    --------
    >>> outcome_of({"outcome": "already_within_tolerance", "stages": [{"stage": 1}, {"stage": 2}]})
    'within_tolerance'
    """
    outcome = str(report["outcome"])
    is_first = not report.get("stages")
    return outcome if is_first or outcome != "already_within_tolerance" else "within_tolerance"


def is_unproven(report: Mapping[str, Any]) -> bool:
    """Return whether a residual that is within tolerance may, with its uncertainty, be above it."""
    return report["outcome"] != "above_tolerance" and report.get("proven") is False


def verdict_class(report: Mapping[str, Any]) -> str:
    """Return the class of a verdict: ``good``, ``open`` where it is not proven, or ``bad``.

    Examples
    --------
    >>> verdict_class({"outcome": "within_tolerance", "proven": False})
    'open'
    """
    if report["outcome"] == "above_tolerance":
        return "bad"
    return "open" if is_unproven(report) else "good"


def escape(text: object) -> str:
    """Return text escaped for HTML, quotes too."""
    return html.escape(str(text), quote=True)


def number(value: float | None, digits: int = 2) -> str:
    """Return a number with fixed decimals and thin spaces between thousands; a dash for None.

    Examples
    --------
    >>> number(12445.664, 1), number(-0.001), number(None)
    ('12\u202f445.7', '0.00', '–')
    """
    if value is None or not math.isfinite(value):
        return "–"
    text = f"{abs(value):,.{digits}f}".replace(",", "\u202f")
    negative = value < 0.0 and any(c in "123456789" for c in text)
    return f"−{text}" if negative else text


def bare(value: float) -> str:
    """Return a number with three decimals at most, without zeros at its end.

    Examples
    --------
    >>> bare(11.90625), bare(12.0)
    ('11.906', '12')
    """
    return f"{value:.3f}".rstrip("0").rstrip(".")


def percent(share: float) -> str:
    """Return a share in percent, to three digits; whole from 100 % on.

    Examples
    --------
    >>> percent(0.0421), percent(0.977), percent(159.3)
    ('4.21 %', '97.7 %', '15\u202f930 %')
    """
    value = 100.0 * share
    return f"{number(value, 0 if value >= 99.95 else 1 if value >= 9.995 else 2)} %"


def signed(value: float | None, digits: int = 2) -> str:
    """Return a number with its sign, plus too; zero without a sign."""
    text = number(value, digits)
    positive = value is not None and value > 0.0 and any(c in "123456789" for c in text)
    return f"+{text}" if positive else text


def angle_deg(vector: Any) -> float:
    """Return the direction of a vector in the xy plane, 0 to below 360 [deg]."""
    return wrapped_deg(math.degrees(math.atan2(vector[1], vector[0])))


def degrees(value_deg: float, digits: int = 1) -> str:
    """Return an angle with fixed decimals, from 0 to below 360 as it is shown.

    Examples
    --------
    >>> degrees(359.97), degrees(-0.5)
    ('0.0°', '359.5°')
    """
    return f"{round(value_deg % 360.0, digits) % 360.0:.{digits}f}°"


def listed_numbers(numbers: Iterable[int]) -> str:
    """Return numbers in runs.

    Examples
    --------
    >>> listed_numbers([1, 2, 3, 7])
    '1-3, 7'
    """
    runs: list[list[int]] = []
    for each in sorted(numbers):
        if runs and each == runs[-1][1] + 1:
            runs[-1][1] = each
        else:
            runs.append([each, each])
    return ", ".join(f"{first}" if first == last else f"{first}-{last}" for first, last in runs)


def at(report: Mapping[str, Any], path: str) -> Any:
    """Return the value at a dotted path, ``planes.0.z_mm``; None where the path ends early."""
    here: Any = report
    for key in path.split("."):
        if isinstance(here, list):
            here = here[int(key)] if int(key) < len(here) else None
        else:
            here = here.get(key) if isinstance(here, Mapping) else None
    return here


def file_name(report: Mapping[str, Any]) -> str:
    """Return the name of the crank's file, without its folder."""
    return str(report["input"]["file"]).replace("\\", "/").rpartition("/")[2]


def part_name(report: Mapping[str, Any]) -> str:
    """Return the part's name in the job, else that of the crank's original file, of the first stage."""
    if own := at(report, "job.job.part"):
        return str(own)
    first = at(report, "job.crankshaft.file") if report.get("stages") else None
    return file_name({"input": {"file": first}} if first else report)


def weights(report: Mapping[str, Any], group: str) -> dict[str, float]:
    """Return the weights of a group of parts, ``rotating_g``, as the job names them [g]."""
    named = at(report, f"job.engine.{group}") or {}
    return {str(name): grams(weight) for name, weight in named.items()}


def oil_on_crankpin_g(report: Mapping[str, Any], throw: int) -> float:
    """Return the oil that is part of a throw's bob-weight [g]; 0 without oil."""
    return sum(float(each["on_crankpin_g"]) for each in report.get("oil") or () if each["throw"] == throw)


def grams(weight: Any) -> float:
    """Return a weight of a job: a number, or a table with its ± beside it [g]."""
    return float(weight["g"] if isinstance(weight, Mapping) else weight)


def place_of(correction: Mapping[str, Any]) -> str:
    """Return the place of a correction in a few words: ``web 2, face w2-a``."""
    parts = []
    webs = correction.get("webs") or ([correction["web"]] if correction.get("web") is not None else [])
    if webs:
        parts.append(("webs " if len(webs) > 1 else "web ") + ", ".join(str(web) for web in webs))
    if correction.get("face") is not None:
        parts.append(f"face {correction['face']}")
    return ", ".join(parts) or "–"


def verdict(report: Mapping[str, Any]) -> Text:
    """Return the verdict in two or three sentences."""
    residual, tolerance = report["residual"], report["tolerance"]
    shares = judged_shares(report)
    name, share = max(shares, key=lambda pair: pair[1])
    where = "" if name == "resultant" else f" (in plane {name})"
    what = "With its uncertainty it" if counts_uncertainty(report) else "It"
    amounts = (g_mm(each, ",.2f") for each in (residual["magnitude_g_mm"], tolerance["permissible_g_mm"]))
    limits = f"G {tolerance['grade_mm_s']:g} at {number(tolerance['speed_rpm'], 0)} rpm"
    return (
        said("The residual unbalance is {}; {} is permitted by ", *amounts)
        + f"{limits}. {what} uses {number(100.0 * share, 1)} % of the permissible unbalance{where}."
        + (" " + _unproven_words(report) if is_unproven(report) else "")
    )


def _unproven_words(report: Mapping[str, Any]) -> str:
    """Return the reason why a residual within tolerance is not proven: another reading, or uncertainty."""
    reason = report.get("reason")
    return said("Not proven: {}.", reason) if reason else "With its uncertainty it exceeds that: not proven."


def counts_uncertainty(report: Mapping[str, Any]) -> bool:
    """Return whether the uncertainty counts in the verdict."""
    return bool(report["tolerance"].get("margin", "none") != "none")


def _judged(residual: Mapping[str, Any], tolerance: Mapping[str, Any]) -> float:
    doubt = residual["uncertainty_g_mm"] if tolerance.get("margin", "none") != "none" else 0.0
    return float(residual["magnitude_g_mm"] + (doubt or 0.0))


def worst_judged(report: Mapping[str, Any], of: str = "residual") -> tuple[str, float, float]:
    """Return the place, size and permissible value of the judged unbalance nearest to its limit [g·mm].

    The place is "the resultant" or "plane A"; ``of`` is ``initial`` or ``residual``.
    """
    unbalance, tolerance = report[of], report["tolerance"]
    rows = [("the resultant", unbalance["magnitude_g_mm"], tolerance["permissible_g_mm"])]
    if tolerance["judge"] == "dynamic":
        rows += [
            (f"plane {plane['name']}", here["magnitude_g_mm"], plane["permissible_g_mm"])
            for here, plane in zip(unbalance["planes"], tolerance["planes"], strict=True)
        ]
    return max(rows, key=lambda row: row[1] / row[2])


def judged_shares(report: Mapping[str, Any]) -> list[tuple[str, float]]:
    """Return each judged residual's name and its share of the permissible residual unbalance."""
    residual, tolerance = report["residual"], report["tolerance"]
    shares = [("resultant", _judged(residual, tolerance) / tolerance["permissible_g_mm"])]
    if tolerance["judge"] == "dynamic":
        for residual_here, plane in zip(residual["planes"], tolerance["planes"], strict=True):
            shares.append((plane["name"], _judged(residual_here, tolerance) / plane["permissible_g_mm"]))
    return shares
