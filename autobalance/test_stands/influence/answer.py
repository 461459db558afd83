"""The report of `influence`, and its text and plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np

from autobalance.declare import Angle, NotNegative, Pair, Positive, record
from autobalance.report import plots
from autobalance.report.balance.headline import OUTCOMES
from autobalance.report.display_units import DisplayUnits
from autobalance.report.plots import Plot
from autobalance.report.records.answers import Head
from autobalance.report.tables import table
from autobalance.toml_files.document import toml_value

# The report of `influence`.


Place = int | str
Reading = Annotated[Pair, "amplitude and phase, in the sense in which the file counts phases"]


@record
class SplitWeight:
    """A weight at one of the angles if there are places."""

    angle_deg: Angle
    g_mm: NotNegative


@record
class PlaneWeight:
    """A weight to add in a plane."""

    plane: Place
    g_mm: NotNegative
    angle_deg: Angle


@record
class PlaneCorrection(PlaneWeight):
    """A weight to add in a plane, or to take away opposite to it."""

    remove_angle_deg: Angle
    g: NotNegative | None
    radius_mm: Positive | None
    split: Sequence[SplitWeight] | None


@record
class ResidualReadings:
    """The readings that the weights leave."""

    readings: Sequence[Reading]
    worst: NotNegative
    rms: NotNegative


@record
class InfluenceReport(Head):
    """Influence coefficients, the weights to add and what they leave."""

    command: Literal["influence"] = "influence"
    input: Mapping[str, Any]
    goal: Literal["least_squares", "least_worst"]
    planes: Sequence[Place]
    influence: Sequence[Sequence[Reading]]
    condition: NotNegative
    corrections: Sequence[PlaneCorrection]
    add_to_left: Sequence[PlaneWeight] | None
    initial: Sequence[Reading]
    residual: ResidualReadings
    outcome: Literal["within_tolerance", "above_tolerance"] | None
    reason: str | None
    warnings: Sequence[str]


# Influence coefficients and the weights that correct, as lines to read.


GOALS = {"least_squares": "least squares", "least_worst": "smallest worst reading"}


def influence_text(report: InfluenceReport, units: DisplayUnits) -> str:
    """Return the weights to add in each plane, and the readings before and after."""
    parts = [
        f"{len(report.initial)} readings, {len(report.planes)} planes, {GOALS[report.goal]}; "
        f"condition {report.condition:.3g}",
        _corrections(report.corrections, units),
        _readings(report),
    ]
    if report.add_to_left is not None:
        rows: list[Sequence[str]] = [("With the trials left on", "add", "at")]
        rows += [
            (
                f"  {each.plane}",
                units.of_unbalance(each.g_mm),
                units.heavy_at(each.g_mm, each.angle_deg, 2),
            )
            for each in report.add_to_left
        ]
        parts.insert(2, table(rows))
    if report.outcome is not None:
        parts.append(OUTCOMES[report.outcome] + (f": {report.reason}" if report.reason else ""))
    return "\n\n".join(parts)


def _corrections(corrections: Sequence[PlaneCorrection], units: DisplayUnits) -> str:
    rows: list[Sequence[str]] = [("Plane", "add", "at", "or take off at", "weight")]
    for each in corrections:
        grams, radius_mm = each.g, each.radius_mm
        weight = ""
        if grams is not None and radius_mm is not None:
            weight = f"{units.of_mass(grams)} at {units.of_length(radius_mm)}"
        rows.append(
            (
                f"  {each.plane}",
                units.of_unbalance(each.g_mm),
                units.heavy_at(each.g_mm, each.angle_deg, 2),
                units.heavy_at(each.g_mm, each.remove_angle_deg, 2),
                weight,
            )
        )
        rows += [
            ("    fitted", units.of_unbalance(piece.g_mm), f"{piece.angle_deg:.2f}°", "", "")
            for piece in each.split or ()
        ]
    return table(rows)


def _readings(report: InfluenceReport) -> str:
    rows: list[Sequence[str]] = [("Reading", "before", "after")]
    pairs = zip(report.initial, report.residual.readings, strict=True)
    rows += [
        (f"  {number}", f"{before[0]:.4g} ∠ {before[1]:.1f}°", f"{after[0]:.4g} ∠ {after[1]:.1f}°")
        for number, (before, after) in enumerate(pairs, 1)
    ]
    residual = report.residual
    return f"{table(rows)}\n  worst {residual.worst:.4g}, rms {residual.rms:.4g}"


# Plots of influence coefficients: readings as vectors, before and after the weights.


def readings_plot(report: InfluenceReport) -> dict[str, Plot]:
    """Return the readings of ``influence``, before and after, as vectors in a polar plot."""
    curves = [
        _vectors("before", report.initial),
        _vectors("after", report.residual.readings),
    ]
    labels = ("amplitude · cos(phase) [unit of the readings]", "amplitude · sin(phase)")
    return {"influence-readings": plots.polar("Readings before and after", labels, curves)}


def _vectors(name: str, readings: Sequence[Pair]) -> plots.Curve:
    """Return lines from the origin to each reading and back, as one path."""
    ends = np.array([amplitude * np.exp(1j * np.radians(phase)) for amplitude, phase in readings])
    path = np.stack([np.zeros_like(ends), ends], axis=1).ravel()
    return plots.Curve(name, path.real, path.imag)


# The unbalance by trial weights as the TOML file for ``recut``.


def unbalance_toml(report: InfluenceReport) -> str:
    """Return the unbalance from ``influence`` as a reading, heavy where its weights are removed."""
    reading = report.input["reading"]
    lines = ["# The unbalance that trial weights and influence coefficients found."]
    if reading["serial"] is not None:
        lines.append(f"serial = {toml_value(reading['serial'])}")
    if reading["speed_rpm"] is not None:
        lines.append(f"speed_rpm = {reading['speed_rpm']!r}")
    if reading["bob_weights_g"] is not None:
        lines.append(f"bob_weights_g = [{', '.join(repr(each) for each in reading['bob_weights_g'])}]")
    lines += [
        f"attached_fitted = {'true' if reading['attached_fitted'] else 'false'}",
        f"urr_percent = {reading['urr_percent']!r}",
        f"umar_g_mm = {reading['umar_g_mm']!r}",
        f"rotation = {toml_value(reading['rotation'])}",
        f"zero_deg = {reading['zero_deg']!r}",
        'reads = "heavy"',
    ]
    for number, weight in enumerate(report.corrections):
        lines += ["", "[[plane]]"]
        if reading["at"] is not None:
            lines.append(f"at = {toml_value(reading['at'][number])}")
        if reading["z_mm"] is not None:
            lines.append(f"z_mm = {reading['z_mm'][number]!r}")
        lines += [f"g_mm = {weight.g_mm!r}", f"angle_deg = {weight.remove_angle_deg!r}"]
    return "\n".join(lines) + "\n"
