"""The report of `rotor`: mm, rpm, Hz, µm and degrees; None where a thing does not apply."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.crank_dynamics.rotor.balancing import AddedUnbalance, BalancingAdvice
from autobalance.crank_dynamics.rotor.critical_speeds import Criticals, RotorMass, StiffnessRow
from autobalance.crank_dynamics.rotor.from_crank import EquivalentShaft
from autobalance.crank_dynamics.rotor.unbalance_response import Response, RunUpMotion, Static
from autobalance.crank_dynamics.rotor.whirl_modes import CampbellRow, ShapedMode
from autobalance.declare import ABSENT, INLINE, Absent, record
from autobalance.report.records.answers import Head


@record
class RotorReport(Head):
    """A shaft on bearings: its critical speeds, modes, response and balancing."""

    command: Literal["rotor"] = "rotor"
    input: Mapping[str, Any]
    mass: Annotated[RotorMass, INLINE]
    criticals: Annotated[Criticals, INLINE]
    modes: Sequence[ShapedMode]
    campbell: Sequence[CampbellRow]
    response: Sequence[Response]
    static: Static
    balancing: Sequence[AddedUnbalance]
    advice: BalancingAdvice
    stiffness_map: Sequence[StiffnessRow]
    run_up: Sequence[RunUpMotion]
    equivalent: EquivalentShaft | Absent = ABSENT
    notes: Sequence[str] | Absent = ABSENT
