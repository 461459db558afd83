"""The report of `strength`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from autobalance.crank_dynamics.strength.fillets_from_job import FilletRow, LeastSafety
from autobalance.crank_dynamics.strength.oil_bores import FilletState, OilBoreRow
from autobalance.crank_dynamics.strength.throw_stress import ThrowFillets
from autobalance.crank_dynamics.torsion.vibration_torques import TorsionalVibration
from autobalance.declare import ABSENT, OMITTED, Absent, Positive, record
from autobalance.report.records.answers import Head, JobEcho


@record
class StrengthAtSpeed:
    """Fillet with the lowest safety at a speed, with the torque that torsional vibration adds there.

    ``m53_factor``: the lowest acceptability by IACS UR M53 of any fillet.
    """

    speed_rpm: Positive
    torsional_vibration: TorsionalVibration
    least: LeastSafety | None
    m53_factor: float | None


@record
class StrengthReport(Head):
    """Stress and safety of the fillets of crankpins and main journals over the cycle."""

    command: Literal["strength"] = "strength"
    job_set: Sequence[str] | Absent = ABSENT
    input: JobEcho
    report: str | None
    speed_rpm: Positive
    torsional_vibration: TorsionalVibration
    fillets: Sequence[FilletRow]
    least: LeastSafety | None
    oil_bores: Sequence[OilBoreRow]
    before: FilletState | None
    fem: ThrowFillets | None
    sweep: Annotated[Sequence[StrengthAtSpeed] | None, OMITTED] = None
    left_out: Annotated[Sequence[str], "what stresses and safeties do not know of"]
    warnings: Sequence[str]
