"""``autobalance.rotor``: a shaft on bearings, its critical speeds, modes, response and balancing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.api.crank import Crank, read_crank
from autobalance.api.result import VerbResult
from autobalance.dynamics.balancing_procedures import advice
from autobalance.dynamics.critical_speeds import CriticalSpeed, critical_speeds
from autobalance.dynamics.modal_balancing import modal_correction
from autobalance.dynamics.rotor_preparation import PreparedRotor, prepared
from autobalance.dynamics.run_up import run_up
from autobalance.dynamics.stiffness_map import undamped_map
from autobalance.dynamics.unbalance_response import sag, unbalance_response
from autobalance.dynamics.whirl_modes import modes_at, refined
from autobalance.errors import JobError, UsageError
from autobalance.job.files.rotor import RotorRequest, read_rotor
from autobalance.report.plot_files import Plots
from autobalance.report.records.rotor import (
    AddedUnbalance,
    BalancingAdvice,
    CampbellRow,
    Criticals,
    EquivalentShaft,
    RotorMass,
    RotorReport,
    RunUp,
    ShapedMode,
    Static,
    StiffnessRow,
    ThrowStiffness,
    added_unbalances,
    responses,
    run_ups,
)
from autobalance.solid.formats.table import endings
from autobalance.units import STEEL_KG_M3

if TYPE_CHECKING:
    from autobalance.dynamics.beam_rotor import BeamRotor

SPEED_RPM = 3000.0
"""Of a crank, where nothing is said."""
SPEED_MULTIPLE = 10.0
"""Critical speeds are looked for up to so many times a single speed."""


@dataclass(frozen=True, eq=False, repr=False)
class RotorResult(VerbResult):
    """Result of ``rotor``."""

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people."""
        from autobalance.report.rotor.rotor_text import rotor_text

        return rotor_text(self.report)

    def plots(self) -> Plots:
        """Return Campbell diagram, shapes, response and, where they were asked for, map and run-up."""
        from autobalance.report.rotor.rotor_plots import rotor_plots

        return Plots(rotor_plots(self.report))


def rotor(
    source: str | Path | Mapping[str, Any] | Crank,
    *,
    unit: str | None = None,
    density_kg_m3: float | None = None,
    speed_rpm: float | None = None,
    bearing_n_m: float | None = None,
) -> RotorResult:
    """Compute a rotor: critical speeds, damped modes, unbalance response, sag, modal balancing.

    Parameters
    ----------
    source : path, dict or Crank
        Rotor file (shaft, discs, bearings, unbalances), or a crank's solid, of which the equivalent straight
        rotor is made. Or a dict of its structure, or a crank as an object. The other parameters are for
        cranks.
    unit : str or None
        Unit of length of a crank's file, mm, cm, m or inch, where its format carries none; None: the
        format's.
    density_kg_m3 : float or None
        Density of a crank [kg/m³]; None: 7850.
    speed_rpm : float or None
        Highest speed of a crank [rpm]; None: 3000.
    bearing_n_m : float or None
        Stiffness of each main bearing of a crank [N/m], 0 for a crank free in space; None: pinned mains.

    Returns
    -------
    RotorResult

    Raises
    ------
    UsageError
        If parameters of a crank stand beside a rotor file.
    JobError
        If the file says something unknown or impossible.
    """
    if isinstance(source, Crank):
        return _of_crank(source, speed_rpm, bearing_n_m)
    if not isinstance(source, Mapping) and Path(source).suffix.lower() in endings():
        density = STEEL_KG_M3 if density_kg_m3 is None else density_kg_m3
        return _of_crank(read_crank(source, unit=unit, density_kg_m3=density), speed_rpm, bearing_n_m)
    options = {
        "--unit": unit,
        "--density-kg-m3": density_kg_m3,
        "--speed-rpm": speed_rpm,
        "--bearing": bearing_n_m,
    }
    for name, value in options.items():
        if value is not None:
            raise UsageError(f"{name} is for a crank; a rotor file says it itself")
    return analysed(read_rotor(source))


def _of_crank(crank: Crank, speed_rpm: float | None, bearing_n_m: float | None) -> RotorResult:
    """Compute the straight rotor in a crank's place."""
    from autobalance.machine_models.rotor_from_crank import MEANING, N_M2_PER_N_MM2, straight_rotor

    if bearing_n_m is not None and not 0.0 <= bearing_n_m < math.inf:
        raise UsageError(f"--bearing is {bearing_n_m:g}; must be ≥ 0")
    if speed_rpm is not None and not 0.0 <= speed_rpm < math.inf:
        raise UsageError(f"--speed-rpm is {speed_rpm:g}; must be ≥ 0")
    straight = straight_rotor(crank.measured, SPEED_RPM if speed_rpm is None else speed_rpm, bearing_n_m)
    result = analysed(read_rotor(straight.file))
    equivalent = EquivalentShaft(
        worth=MEANING,
        z_of_start_mm=straight.z_of_start_mm,
        throws=[
            ThrowStiffness(
                number=number,
                in_plane_N_m2=N_M2_PER_N_MM2 * each.in_plane_n_mm2,
                across_N_m2=N_M2_PER_N_MM2 * each.across_n_mm2,
                used_N_m2=N_M2_PER_N_MM2 * each.mean_n_mm2,
            )
            for number, each in enumerate(straight.throws, 1)
        ],
    )
    return RotorResult(replace(result.content, equivalent=equivalent, notes=[MEANING]))


def analysed(request: RotorRequest) -> RotorResult:
    """Return the analysis of a request."""
    speeds = request.speeds_rad_s
    upper = float(speeds[-1]) if len(speeds) > 1 else SPEED_MULTIPLE * float(speeds[0])
    planes = request.balancing.planes_m if request.balancing else ()
    modes = max(request.max_modes, 2 * request.balancing.modes + 2 if request.balancing else 0)
    ends = [] if request.run_up is None else [request.run_up.from_rad_s, request.run_up.to_rad_s]
    ready = prepared(request.rotor, max([upper, *ends]), modes, (*request.probes_m, *planes))
    criticals = critical_speeds(ready, upper)
    lowest = float(speeds[0])
    listed = refined(ready.reduced, lowest, modes_at(ready.reduced, lowest, request.max_modes))
    return RotorResult(
        RotorReport(
            input=request.filled,
            mass=RotorMass.of(ready),
            criticals=Criticals.of(criticals),
            modes=[ShapedMode.of(ready, each) for each in listed],
            campbell=[
                CampbellRow.of(float(speed), modes_at(ready.reduced, float(speed), request.max_modes))
                for speed in speeds
            ],
            response=responses(
                request.probes_m, unbalance_response(ready.matrices, speeds, request.probes_m)
            ),
            static=Static.of(request.rotor, sag(ready.matrices, float(speeds[0]))),
            balancing=_balanced(request, ready),
            advice=BalancingAdvice.of(advice(float(speeds[-1]), criticals)),
            stiffness_map=_mapped(request, request.rotor, upper),
            run_up=_run(request, ready),
        )
    )


def _balanced(request: RotorRequest, ready: PreparedRotor) -> list[AddedUnbalance]:
    balancing = request.balancing
    if balancing is None:
        return []
    there = [(each.z_m, each.phasor_kg_m) for each in request.rotor.unbalances]
    try:
        added = modal_correction(ready.reduced, balancing.planes_m, balancing.modes, balancing.rigid, there)
    except ValueError as error:
        raise JobError(f"balancing: {error}") from None
    return added_unbalances(balancing.planes_m, added)


def _mapped(request: RotorRequest, rotor_now: BeamRotor, upper_rad_s: float) -> list[StiffnessRow]:
    stiffness_map = request.stiffness_map
    if stiffness_map is None:
        return []
    stiffness = np.geomspace(*stiffness_map.k_n_m, stiffness_map.points)
    rows: list[list[CriticalSpeed]] = undamped_map(rotor_now, stiffness, upper_rad_s, request.max_modes)
    return [
        StiffnessRow(k_n_m=float(k), criticals=Criticals.of(row))
        for k, row in zip(stiffness, rows, strict=True)
    ]


def _run(request: RotorRequest, ready: PreparedRotor) -> list[RunUp]:
    stated = request.run_up
    if stated is None:
        return []
    motion = run_up(
        ready.reduced, stated.from_rad_s, stated.to_rad_s, stated.time_s, request.probes_m, stated.points
    )
    return run_ups(request.probes_m, motion)
