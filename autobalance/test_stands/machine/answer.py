"""The report of `machine`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from autobalance.declare import Angle, Degrees, NotNegative, Pair, Positive, Size, Triple, record
from autobalance.report.records.answers import Head
from autobalance.test_stands.machine.balancing_machine import StaticStand


@record
class PlaneVector:
    """Unbalance in a plane."""

    name: str
    unbalance_g_mm: Pair
    g_mm: NotNegative
    angle_deg: Angle


@record
class MachinePlane:
    """Reading, or true unbalance, in a plane; without a place on a static stand."""

    schema_name: ClassVar[str] = "plane_reading"

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
    planes: Annotated[Sequence[MachinePlane], Size(most=2)]
    kind: Literal["balanced", "static", "couple", "quasi_static", "dynamic"]
    principal_axis_rad: Degrees | None


@record
class SensorReading:
    """Reading of a sensor of the machine."""

    name: str
    z_mm: float
    force_N: NotNegative | None
    displacement_um: NotNegative | None
    moment_N_m: NotNegative | None
    angle_deg: Angle


@record
class PlaneNode:
    """Place at which a plane's unbalance moves the axis least."""

    plane: str
    z_mm: float


@record
class LeftUnbalance:
    """Residual unbalance where a reading is followed to the letter."""

    planes: Sequence[PlaneVector]
    magnitude_g_mm: NotNegative


@record
class MachineRun:
    """A spin of the rotor."""

    planes: Sequence[MachinePlane]
    left: LeftUnbalance


@record
class MachineCorrection:
    """Correction of the first reading: the amount to take off at the heavy side."""

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
    """Scatter of the readings over the runs."""

    g_mm: Sequence[PlaneSpread]


@record
class MachineReport(Head):
    """Readings of a balancing machine on a rotor of known unbalance, and the residual after them."""

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
