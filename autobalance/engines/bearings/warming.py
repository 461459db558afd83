"""Heat of bearings over time, lumped: C dT/dt = friction's power − G (T − ambient) − ρ c Q (T − inlet)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from autobalance.types import Array

RELATIVE, ABSOLUTE_K = 1e-9, 1e-9
"""Tolerances of a step of the integration."""
HOTTEST_C = 600.0
"""Temperature up to which a steady state is sought."""


@dataclass(frozen=True)
class HeatPath:
    """Heat capacity and conductance of bearings.

    Attributes
    ----------
    capacity_J_K : float
        C, of all that warms with the bearings.
    conductance_W_K : float
        G, to the ambient.
    ambient_C : float
    flow_W_K : float
        ρ c Q of oil that flows through and leaves as warm as the bearing.
    inlet_C : float
        Temperature at which that oil comes.
    """

    capacity_J_K: float
    conductance_W_K: float
    ambient_C: float
    flow_W_K: float = 0.0
    inlet_C: float = 0.0

    def lost_W(self, celsius: float) -> float:
        """Return the power that leaves at a temperature [°C]."""
        return self.conductance_W_K * (celsius - self.ambient_C) + self.flow_W_K * (celsius - self.inlet_C)


@dataclass(frozen=True)
class Stage:
    """A time at one speed: duration [s], and the friction's power [W] by the temperature [°C]."""

    duration_s: float
    power_W: Callable[[float], float]


@dataclass(frozen=True, eq=False)
class Warming:
    """Temperature over time, and the heat made and lost since the start, all (n,)."""

    time_s: Array
    celsius: Array
    made_J: Array
    lost_J: Array
    capacity_J_K: float

    @property
    def energy_error(self) -> float:
        """Heat made less lost and stored at the end, over the heat made; 0 if none was."""
        stored = self.capacity_J_K * float(self.celsius[-1] - self.celsius[0])
        missing = abs(float(self.made_J[-1] - self.lost_J[-1]) - stored)
        return missing / float(self.made_J[-1]) if self.made_J[-1] > 0.0 else 0.0

    def at(self, time_s: float) -> float:
        """Return the temperature at a time, straight between the times kept [°C]."""
        return float(np.interp(time_s, self.time_s, self.celsius))


def warming(path: HeatPath, stages: Sequence[Stage], start_C: float, step_s: float | None = None) -> Warming:
    """Return the temperature through stages, one after the other.

    Parameters
    ----------
    path : HeatPath
    stages : sequence of Stage
        At least one.
    start_C : float
    step_s : float, optional
        Largest step between the times kept; None: the ends of the stages alone.
    """
    kept, begin, state = [np.array([0.0, start_C, 0.0, 0.0])], 0.0, np.array([start_C, 0.0, 0.0])
    for stage in stages:

        def rates(_: float, y: Array, stage: Stage = stage) -> list[float]:
            made, lost = stage.power_W(float(y[0])), path.lost_W(float(y[0]))
            return [(made - lost) / path.capacity_J_K, made, lost]

        steps = 1 if step_s is None else max(1, int(np.ceil(stage.duration_s / step_s)))
        times = np.linspace(0.0, stage.duration_s, steps + 1)
        # of the sums of heat no more is wanted than of the temperature that they change
        tolerances = [ABSOLUTE_K, *2 * [ABSOLUTE_K * path.capacity_J_K]]
        solved = solve_ivp(
            rates, (0.0, stage.duration_s), state, "LSODA", times, rtol=RELATIVE, atol=tolerances
        )
        if not solved.success:
            raise ArithmeticError(f"the bearings' temperature cannot be followed: {solved.message}")
        kept += [np.array([begin + t, *y]) for t, y in zip(times[1:], solved.y.T[1:], strict=True)]
        begin, state = begin + stage.duration_s, solved.y[:, -1]
    time, celsius, made, lost = np.array(kept).T
    return Warming(time, celsius, made, lost, path.capacity_J_K)


def steady_temperature_C(path: HeatPath, power_W: Callable[[float], float]) -> float | None:
    """Return the temperature at which all of the power leaves; None where it would pass ``HOTTEST_C``.

    Friction falls as oil warms, so there is one.
    """

    def excess(celsius: float) -> float:
        return path.lost_W(celsius) - power_W(celsius)

    coldest = min(path.ambient_C, path.inlet_C) if path.flow_W_K else path.ambient_C
    if not excess(HOTTEST_C) > 0.0:
        return None
    return float(brentq(excess, coldest, HOTTEST_C, xtol=1e-12, rtol=1e-14))
