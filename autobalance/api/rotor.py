"""``autobalance.rotor``: a shaft on bearings, its critical speeds, modes, response and balancing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.api.result import Plots, Values, VerbResult, report_head
from autobalance.dynamics.balancing_procedures import advice
from autobalance.dynamics.critical_speeds import CriticalSpeed, critical_speeds
from autobalance.dynamics.modal_balancing import modal_correction
from autobalance.dynamics.rotor_preparation import PreparedRotor, prepared
from autobalance.dynamics.run_up import run_up
from autobalance.dynamics.stiffness_map import undamped_map
from autobalance.dynamics.unbalance_response import sag, unbalance_response
from autobalance.dynamics.whirl_modes import WhirlMode, modes_at, refined
from autobalance.errors import JobError
from autobalance.job.rotor_file import RotorRequest, read_rotor
from autobalance.report import rotor_values

if TYPE_CHECKING:
    from autobalance.dynamics.beam_rotor import BeamRotor

BEYOND = 10.0
"""Critical speeds are looked for up to so many times a single speed."""


@dataclass(frozen=True, eq=False, repr=False)
class RotorResult(VerbResult):
    """What ``rotor`` found."""

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people."""
        from autobalance.report.rotor_text import rotor_text

        return rotor_text(self.report)

    def plots(self) -> Plots:
        """Return Campbell diagram, shapes, response and, where they were asked for, map and run-up."""
        from autobalance.report.rotor_plots import rotor_plots

        return rotor_plots(self.report)


def rotor(source: str | Path | Mapping[str, Any]) -> RotorResult:
    """Compute a rotor: critical speeds, damped modes, unbalance response, sag, modal balancing.

    Parameters
    ----------
    source : path or dict
        A rotor file, or a dict of its structure.

    Returns
    -------
    RotorResult

    Raises
    ------
    JobError
        If the file says something unknown or impossible.
    """
    return analysed(read_rotor(source))


def analysed(request: RotorRequest) -> RotorResult:
    """Compute what a request asks."""
    speeds = request.speeds_rad_s
    upper = float(speeds[-1]) if len(speeds) > 1 else BEYOND * float(speeds[0])
    planes = request.balancing.planes_m if request.balancing else ()
    modes = max(request.max_modes, 2 * request.balancing.modes + 2 if request.balancing else 0)
    ready = prepared(request.rotor, max(upper, _run_up_top(request)), modes, (*request.probes_m, *planes))
    criticals = critical_speeds(ready, upper)
    return RotorResult(
        {
            **report_head("rotor"),
            "input": request.filled,
            **rotor_values.mass_values(ready),
            **rotor_values.critical_values(criticals),
            "modes": rotor_values.mode_values(ready, _listed(ready, float(speeds[0]), request.max_modes)),
            "campbell": [
                rotor_values.campbell_row(
                    float(speed), modes_at(ready.reduced, float(speed), request.max_modes)
                )
                for speed in speeds
            ],
            "response": rotor_values.response_values(
                request.probes_m, unbalance_response(ready.matrices, speeds, request.probes_m)
            ),
            "static": rotor_values.sag_values(request.rotor, sag(ready.matrices, float(speeds[0]))),
            "balancing": _balanced(request, ready),
            "advice": rotor_values.advice_values(advice(float(speeds[-1]), criticals)),
            "stiffness_map": _mapped(request, request.rotor, upper),
            "run_up": _run(request, ready),
        }
    )


def _listed(ready: PreparedRotor, speed_rad_s: float, count: int) -> list[WhirlMode]:
    return refined(ready.reduced, speed_rad_s, modes_at(ready.reduced, speed_rad_s, count))


def _campbell_row(ready: PreparedRotor, speed_rad_s: float, count: int) -> Values:
    return rotor_values.campbell_row(speed_rad_s, modes_at(ready.reduced, speed_rad_s, count))


def _balanced(request: RotorRequest, ready: PreparedRotor) -> list[Values]:
    asked = request.balancing
    if asked is None:
        return []
    there = [(each.z_m, each.phasor_kg_m) for each in request.rotor.unbalances]
    try:
        added = modal_correction(ready.reduced, asked.planes_m, asked.modes, asked.rigid, there)
    except ValueError as error:
        raise JobError(f"balancing: {error}") from None
    return rotor_values.correction_values(asked.planes_m, added)


def _mapped(request: RotorRequest, given: BeamRotor, upper_rad_s: float) -> list[Values]:
    asked = request.stiffness_map
    if asked is None:
        return []
    stiffness = np.geomspace(asked.low_n_m, asked.high_n_m, asked.points)
    rows: list[list[CriticalSpeed]] = undamped_map(given, stiffness, upper_rad_s, request.max_modes)
    return [
        {"k_n_m": float(k), **rotor_values.critical_values(row)}
        for k, row in zip(stiffness, rows, strict=True)
    ]


def _run_up_top(request: RotorRequest) -> float:
    return 0.0 if request.run_up is None else max(request.run_up.start_rad_s, request.run_up.end_rad_s)


def _run(request: RotorRequest, ready: PreparedRotor) -> list[Values]:
    asked = request.run_up
    if asked is None:
        return []
    motion = run_up(
        ready.reduced, asked.start_rad_s, asked.end_rad_s, asked.time_s, request.probes_m, asked.points
    )
    return rotor_values.run_up_values(request.probes_m, motion)
