"""Cranks in one engine, side by side: what each does to acceleration, bearing loads and output torque."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated

import numpy as np

from autobalance.balancing.engine_from_job import as_measured
from autobalance.balancing.measured import Crank
from autobalance.declare import NEWTONS, Floats, NewtonMetres, NotNegative, Positive
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.factors import MainLoads
from autobalance.engines.cycle.firing import firing_engine
from autobalance.engines.cycle.firing_engine import FiringEngine
from autobalance.engines.cycle.free_run import FreeRun, free_run
from autobalance.job import Job
from autobalance.running_gear.whole_engine import Engine
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class VariantFigures:
    """An engine with one crank at one speed.

    Attributes
    ----------
    acceleration_rad_s2 : float
        (gas − friction)/J, means, without load [rad/s²].
    greatest_main_n, mean_main_n : float
        Largest and mean magnitude of the mains' loads over the cycle [N].
    greatest_mains_n : (m,) float
        Largest magnitude of each [N].
    torque_mean_n_m, torque_greatest_n_m, torque_least_n_m : float
        Of gas − friction + inertia at the angles of the grid [N·m].
    fluctuation : float or None
        Of the speed under a constant load; None where the crank would stop.
    """

    speed_rpm: Positive
    acceleration_rad_s2: float
    greatest_main_n: Annotated[NotNegative, NEWTONS]
    mean_main_n: Annotated[NotNegative, NEWTONS]
    greatest_mains_n: Annotated[Floats, NEWTONS]
    torque_mean_n_m: NewtonMetres
    torque_greatest_n_m: NewtonMetres
    torque_least_n_m: NewtonMetres
    friction_mean_n_m: NewtonMetres
    power_W: float
    fluctuation: float | None


@dataclass(frozen=True, eq=False)
class VariantCurves:
    """Torque over the cycle at the last speed, and the run-up, of one variant."""

    name: str
    angle_deg: Array
    torque_N_m: Array
    run: FreeRun | None


@dataclass(frozen=True, eq=False)
class FiringVariant:
    """A job's engine with one crank in it, of a separate unbalance or an ideal one of a factor."""

    job: Job
    crank: Crank
    factor: float | None

    def firing(self, speed_rad_s: float) -> FiringEngine:
        """Return the engine at a speed, which only heat through its walls depends on."""
        return firing_engine(self.job, self.crank.anatomy, speed_rad_s, lambda: self._engine)

    @cached_property
    def _engine(self) -> Engine:
        return as_measured(self.job, self.crank)

    def point(self, speed_rpm: float) -> tuple[VariantFigures, Array, CycleAnalysis]:
        """Return figures and torque [N·m] at a speed, and the analysis whose gas and inertia they have."""
        speed_rad_s = speed_rpm * RAD_S_PER_RPM
        analysis = CycleAnalysis(self.firing(speed_rad_s), speed_rad_s)
        firing, grid = analysis.firing, analysis.grid
        sizes = MainLoads.of(firing).sizes_n(self.factor, speed_rad_s)
        lever = firing.friction.main_lever_mm(firing.main_diameters_mm)
        friction = lever @ sizes * N_M_PER_N_MM + firing.piston_friction_n_m(speed_rad_s)
        lost = float(grid.mean(friction))
        uneven, torque = analysis.uneven_speed, analysis.gas_n_m - friction + analysis.inertia_n_m
        mean = firing.gas_mean_n_m - lost + analysis.inertia_mean_n_m
        greatest = sizes.max(axis=1)
        figures = VariantFigures(
            speed_rpm=speed_rpm,
            acceleration_rad_s2=(firing.gas_mean_n_m - lost)
            / (analysis.mean_inertia_g_mm2 * N_M_PER_G_MM2_S2),
            greatest_main_n=float(greatest.max()),
            mean_main_n=float(np.mean(grid.mean(sizes))),
            greatest_mains_n=greatest,
            torque_mean_n_m=mean,
            torque_greatest_n_m=float(torque.max()),
            torque_least_n_m=float(torque.min()),
            friction_mean_n_m=lost,
            power_W=mean * speed_rad_s,
            fluctuation=None if uneven is None else uneven.fluctuation,
        )
        return figures, torque, analysis

    def run_up(self, start_rad_s: float, end_rad_s: float) -> FreeRun | None:
        """Return the run from one speed to another without load."""
        return free_run(self.firing(end_rad_s), self.factor, start_rad_s, end_rad_s)
