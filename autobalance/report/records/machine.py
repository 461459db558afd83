"""The report of `machine`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.records import Angle, Bound, Degrees, NotNegative, Pair, Positive, Triple, record
from autobalance.report.records.head import Head


@record
class PlaneVector:
    """Unbalance in a plane."""

    name: str
    unbalance_g_mm: Pair
    g_mm: NotNegative
    angle_deg: Angle


@record
class PlaneReading:
    """What is read in a plane, or is there; no place: on a static stand."""

    name: str
    z_mm: float | None
    unbalance_g_mm: Pair
    g_mm: NotNegative
    angle_deg: Angle


@record
class SpunRotorFigures:
    """The rotor as it is."""

    mass_g: Positive
    centre_of_mass_mm: Triple
    unbalance_g_mm: Pair
    moment_g_mm2: Pair
    magnitude_g_mm: NotNegative
    planes: Annotated[Sequence[PlaneReading], Bound("maxItems", 2)]
    kind: Literal["balanced", "static", "couple", "quasi_static", "dynamic"]
    principal_axis_rad: Degrees | None


@record
class SensorReading:
    """What a sensor of the machine feels."""

    name: str
    z_mm: float
    force_N: NotNegative | None
    displacement_um: NotNegative | None
    moment_N_m: NotNegative | None
    angle_deg: Angle


@record
class PlaneNode:
    """Where a plane's unbalance moves the axis least."""

    plane: str
    z_mm: float


@record
class StaticStand:
    """What a static stand shows."""

    rolls: bool
    least_g_mm: NotNegative
    rest_within_rad: Degrees | None
    roll_time_s: NotNegative | None


@record
class LeftUnbalance:
    """What is left where a reading is followed to the letter."""

    planes: Sequence[PlaneVector]
    magnitude_g_mm: NotNegative


@record
class MachineRun:
    """A spin of the rotor."""

    planes: Sequence[PlaneReading]
    left: LeftUnbalance


@record
class MachineCorrection:
    """What to take off for the first reading, at the heavy side."""

    plane: str
    g_mm: NotNegative
    angle_deg: Angle
    depth_mm: NotNegative | None


@record
class PlaneSpread:
    """Mean and standard deviation of what a plane reads; None from a single run."""

    name: str
    mean: NotNegative
    standard_deviation: NotNegative | None


@record
class MachineNoise:
    """How far the readings of the runs scatter."""

    g_mm: Sequence[PlaneSpread]


@record
class MachineReport(Head):
    """What a balancing machine reads on a rotor of known unbalance, and what that leaves."""

    command: Literal["machine"] = "machine"
    input: Mapping[str, Any]
    rotor: SpunRotorFigures
    sensors: Sequence[SensorReading] | None
    nodes: Sequence[PlaneNode] | None
    static: StaticStand | None
    runs: Sequence[MachineRun]
    corrections: Sequence[MachineCorrection]
    noise: MachineNoise
    bob_weights_g: Sequence[float] | None
    serial: str | None
    warnings: Sequence[str]
