"""The report of `torsion`: kg·mm², Hz, mrad, N·m, MPa; None where a thing does not apply."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.crank_dynamics.torsion.dampers import DamperFigures
from autobalance.crank_dynamics.torsion.figures import (
    AbsorberSize,
    Damping,
    ThrowFigures,
    TorsionModeFigures,
    TrainFigures,
)
from autobalance.crank_dynamics.torsion.run_up import RunUpFigures
from autobalance.crank_dynamics.torsion.strains import CriticalOrder, OrderPeak, OrderResponse
from autobalance.declare import ABSENT, OMITTED, Absent, Hertz, record
from autobalance.report.records.answers import Head


@record
class TorsionReport(Head):
    """Torsional vibration of a crank, or of a chain."""

    command: Literal["torsion"] = "torsion"
    job_set: Sequence[str] | Absent = ABSENT
    input: Annotated[Mapping[str, Any], "job or chain, defaults filled in"]
    model: TrainFigures
    damping: Damping
    excited: bool
    natural_frequencies_rad_s: Sequence[Hertz]
    modes: Sequence[TorsionModeFigures]
    critical: Sequence[CriticalOrder]
    peaks: Sequence[OrderPeak]
    response: Sequence[OrderResponse]
    pendulum: AbsorberSize | None
    dampers: Sequence[DamperFigures]
    fem_natural_frequencies_rad_s: Sequence[Hertz] | Absent | None = ABSENT
    throws: Annotated[Sequence[ThrowFigures], "of a job's crank"] | Absent = ABSENT
    run_up: Annotated[RunUpFigures | None, OMITTED] = None
    warnings: Sequence[str] | Absent = ABSENT
