"""The report of `forces`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from autobalance.declare import ABSENT, LOOSE, Absent, NotNegative, Positive, record
from autobalance.engines.forces.factor_advice import FactorAdvice
from autobalance.engines.mounts.mounted_engine import MountedAnalysis
from autobalance.report.records.answers import JobReport
from autobalance.running_gear.roll import InertiaLoads, Roll, ShakingForce
from autobalance.running_gear.whole_engine import DeadCentres, FirstOrderCounterweight, ForceOrder


@record
class WithShafts:
    """The engine with the job's balance shafts: orders of force, and the roll couple −dH/dt with theirs."""

    orders: Sequence[ForceOrder]
    greatest_roll_besides_torque_n_m: NotNegative


@record
class EngineState:
    """Forces and loads with the crank as it is, or balanced.

    ``force`` and ``loads`` leave balance shafts out; ``with_shafts`` has the orders with the job's shafts.
    """

    name: str
    balance_factor: float | None
    force: ShakingForce
    with_shafts: WithShafts | Absent = ABSENT
    loads: InertiaLoads


@record
class ForcesReport(JobReport):
    """Shaking forces, loads and factors."""

    command: Literal["forces"] = "forces"
    present: Annotated[float | None, "balance factor of the crank as it is; null: its throws cancel"]
    speed_rpm: Positive
    moments_about_z_mm: float
    cylinders: Sequence[DeadCentres]
    first_order_counterweight: FirstOrderCounterweight
    roll: Roll
    states: Sequence[EngineState]
    factors: FactorAdvice
    mounts: Annotated[MountedAnalysis, LOOSE] | Absent = ABSENT
    warnings: Sequence[str]
