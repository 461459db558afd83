"""The report of `influence`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import Angle, NotNegative, Pair, Positive, record
from autobalance.report.records.answers import Head

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
