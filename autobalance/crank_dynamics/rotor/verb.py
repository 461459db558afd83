"""``autobalance.rotor``: a shaft on bearings, its critical speeds, modes, response and balancing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.crank_dynamics.rotor.answer import RotorReport
from autobalance.crank_dynamics.rotor.balancing import AddedUnbalance, advice, modal_correction
from autobalance.crank_dynamics.rotor.critical_speeds import (
    Criticals,
    PreparedRotor,
    StiffnessRow,
    critical_speeds,
    prepared,
    undamped_map,
)
from autobalance.crank_dynamics.rotor.input import RotorRequest, read_rotor
from autobalance.crank_dynamics.rotor.unbalance_response import RunUpMotion, run_up, sag, unbalance_response
from autobalance.crank_dynamics.rotor.whirl_modes import campbell, modes_at, refined
from autobalance.errors import JobError, UsageError
from autobalance.report.plots import Plots
from autobalance.solid.formats.table import endings
from autobalance.units import STEEL_KG_M3
from autobalance.value_classes import dataclass
from autobalance.verbs.crank import Crank, read_crank
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.crank_dynamics.rotor.beam_rotor import BeamRotor

SPEED_RPM = 3000.0
"""Defaults for a crank."""
SPEED_MULTIPLE = 10.0
"""Critical speeds are looked for up to so many times a single speed."""


@dataclass(frozen=True, eq=False, repr=False)
class RotorResult(VerbResult):
    """Result of ``rotor``."""

    content: RotorReport

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people."""
        from autobalance.crank_dynamics.rotor.answer import rotor_text

        return rotor_text(self.content)

    def plots(self) -> Plots:
        """Return Campbell diagram, shapes, response and, where they were requested, map and run-up."""
        from autobalance.crank_dynamics.rotor.answer import rotor_plots

        return Plots(rotor_plots(self.content))


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
        Rotor file (shaft, discs, bearings, unbalances), or a crank's solid, from which the equivalent
        straight rotor is made. Or a dict of its structure, or a crank as an object. The other parameters are
        for cranks.
    unit : str or None
        Unit of length of a crank's file, mm, cm, m or inch, if its format carries no unit; None: the
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
    UsageError If parameters of a crank are used with a rotor file. JobError If the file has an unknown key or
    an impossible value.
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
            raise UsageError(f"{name} is for a crank; set it in the rotor file")
    return analysed(read_rotor(source))


def _of_crank(crank: Crank, speed_rpm: float | None, bearing_n_m: float | None) -> RotorResult:
    """Compute the straight rotor in a crank's place."""
    from autobalance.crank_dynamics.rotor.from_crank import straight_rotor

    if bearing_n_m is not None and not 0.0 <= bearing_n_m < math.inf:
        raise UsageError(f"--bearing is {bearing_n_m:g}; must be ≥ 0")
    if speed_rpm is not None and not 0.0 <= speed_rpm < math.inf:
        raise UsageError(f"--speed-rpm is {speed_rpm:g}; must be ≥ 0")
    straight = straight_rotor(crank.measured, SPEED_RPM if speed_rpm is None else speed_rpm, bearing_n_m)
    result = analysed(read_rotor(straight.file))
    content = replace(result.content, equivalent=straight.equivalent, notes=[straight.equivalent.worth])
    return RotorResult(content)


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
            mass=ready.mass,
            criticals=Criticals.of(criticals),
            modes=[each.shaped(ready.matrices) for each in listed],
            campbell=campbell(ready.reduced, speeds, request.max_modes),
            response=unbalance_response(ready.matrices, speeds, request.probes_m),
            static=sag(ready.matrices, lowest),
            balancing=_balanced(request, ready),
            advice=advice(float(speeds[-1]), criticals),
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
    return [AddedUnbalance.of(z, complex(each)) for z, each in zip(balancing.planes_m, added, strict=True)]


def _mapped(request: RotorRequest, rotor_now: BeamRotor, upper_rad_s: float) -> list[StiffnessRow]:
    stiffness_map = request.stiffness_map
    if stiffness_map is None:
        return []
    stiffness = np.geomspace(*stiffness_map.k_n_m, stiffness_map.points)
    return undamped_map(rotor_now, stiffness, upper_rad_s, request.max_modes)


def _run(request: RotorRequest, ready: PreparedRotor) -> list[RunUpMotion]:
    stated = request.run_up
    if stated is None:
        return []
    return run_up(
        ready.reduced, stated.from_rad_s, stated.to_rad_s, stated.time_s, request.probes_m, stated.points
    )
