"""The bench's bearings as they warm: temperature and torque over a course of speeds, fitted to readings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from autobalance.declare import RPM, NotNegative, Positive, record
from autobalance.engines.bearings.fed_states import (
    HeatPath,
    SpeedStage,
    Warming,
    steady_temperature_C,
    warming,
)
from autobalance.test_stands.bench.keys import Fitted
from autobalance.test_stands.bench.rotor import (
    BenchBearings,
    DryBearings,
    mean_load_N,
    unbalance_force_N,
)
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass

Moment = Callable[[float, float], float]
"""Friction [N·m] by speed [rad/s] and temperature [°C]."""
CONFIDENCE = 0.95
FIXED_WITHIN = 2.0
"""Factor of the 95 % range beyond which readings do not fix a value."""
MOST_DECADES = 3.0
"""Largest change of a fitted value from its first one, in powers of ten."""
STEPS_OF_A_COURSE = 400


@dataclass(frozen=True)
class TimedReading:
    """A torque measured at a time of the course; ``pm_N_m`` is its uncertainty, 95 %."""

    time_s: float
    torque_N_m: float
    pm_N_m: float | None


@dataclass(frozen=True, eq=False)
class BearingHeat:
    """The ``[heat]`` table: the heat's path, the course of (seconds, rpm) and its readings.

    ``friction_factor`` times the friction of the bearings' model is that of the bearings.
    """

    path: HeatPath
    start_C: float
    course: tuple[tuple[float, float], ...]
    friction_factor: float
    fit: tuple[Fitted, ...]
    readings: tuple[TimedReading, ...]
    viscosity: Callable[[float], float] | None
    """Viscosity by temperature, in the unit of the bearings; None if friction does not depend on it."""


@record
class HeatStage:
    """A stage of the course at its end; ``drop_percent``: of the torque since it began."""

    time_s: NotNegative
    speed_rad_s: Annotated[NotNegative, RPM]
    temperature_C: float
    torque_N_m: float
    power_W: float
    drop_percent: float | None
    steady_C: float | None
    steady_N_m: float | None


@record
class HeatReading:
    """A reading beside the model."""

    time_s: NotNegative
    torque_N_m: float
    model_N_m: float
    temperature_C: float
    difference_N_m: float


@record
class FittedValue:
    """A fitted value with its 95 % range; ``fixed``: whether the readings keep it within a factor of two."""

    name: Literal["capacity_J_K", "conductance_W_K", "friction_factor"]
    value: Positive
    pm: NotNegative | None
    least: NotNegative | None
    greatest: NotNegative | None
    fixed: bool


@record
class HeatOfBench:
    """Temperature and torque of the bearings over the course, and what the readings say of the heat's path.

    ``correlation`` is between the logarithms of the fitted values, in their order; ``time_constant_s`` C/G.
    """

    capacity_J_K: Positive
    conductance_W_K: Positive
    friction_factor: Positive
    time_constant_s: Positive
    stages: Sequence[HeatStage]
    readings: Sequence[HeatReading]
    fitted: Sequence[FittedValue]
    correlation: Sequence[Sequence[float]] | None
    scatter_N_m: NotNegative | None
    energy_error: NotNegative
    not_fixed: Sequence[str]


@dataclass(frozen=True, eq=False)
class HeatRun:
    """The bearings through the course; speed [rad/s] and torque [N·m] at the times of ``warming``."""

    warming: Warming
    speed_rad_s: Array
    torque_N_m: Array
    answer: HeatOfBench

    def csv(self) -> bytes:
        """Return the course over time as CSV."""
        columns = (
            self.warming.time_s,
            self.speed_rad_s / RAD_S_PER_RPM,
            self.warming.celsius,
            self.torque_N_m,
        )
        rows = [",".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist()]
        return ("\n".join(["time_s,speed_rpm,temperature_C,torque_N_m", *rows]) + "\n").encode()


def heat_run(heat: BearingHeat, bearings: BenchBearings, weight_N: float, unbalance_g_mm: float) -> HeatRun:
    """Return the bearings through the course, after the requested fit."""
    moment = _moment(heat, bearings, weight_N, unbalance_g_mm)
    fitted = _HeatFit(heat, moment).found() if heat.fit else None
    best = heat if fitted is None else fitted.heat
    whole = sum(seconds for seconds, _ in best.course)
    run = _followed(best, moment, whole / STEPS_OF_A_COURSE)
    ends = np.cumsum([seconds for seconds, _ in best.course])
    speeds = np.array([rpm * RAD_S_PER_RPM for _, rpm in best.course])
    stage = np.minimum(np.searchsorted(ends, run.time_s - 1e-9), len(ends) - 1)
    pairs = zip(speeds[stage], run.celsius, strict=True)
    torques = np.array([best.friction_factor * moment(float(s), float(c)) for s, c in pairs])
    answer = HeatOfBench(
        capacity_J_K=best.path.capacity_J_K,
        conductance_W_K=best.path.conductance_W_K,
        friction_factor=best.friction_factor,
        time_constant_s=best.path.capacity_J_K / best.path.conductance_W_K,
        stages=_stages(best, moment, run, ends, speeds),
        readings=_readings(best, moment),
        fitted=[] if fitted is None else fitted.values,
        correlation=None if fitted is None else fitted.correlation,
        scatter_N_m=None if fitted is None else fitted.scatter_N_m,
        energy_error=run.energy_error,
        not_fixed=[] if fitted is None else fitted.not_fixed,
    )
    return HeatRun(run, speeds[stage], torques, answer)


def _moment(heat: BearingHeat, bearings: BenchBearings, weight_N: float, unbalance_g_mm: float) -> Moment:
    """Return the friction of the bearings' model by speed and temperature, at the mean load over a turn."""

    def moment(speed_rad_s: float, celsius: float) -> float:
        load = mean_load_N(weight_N, unbalance_force_N(unbalance_g_mm, speed_rad_s))
        own = bearings
        if heat.viscosity is not None and not isinstance(own, DryBearings):
            own = own.with_viscosity(heat.viscosity(celsius))
        return own.moment_N_m(load, speed_rad_s / RAD_S_PER_RPM)

    return moment


def _followed(heat: BearingHeat, moment: Moment, step_s: float | None) -> Warming:
    def power(speed_rad_s: float) -> Callable[[float], float]:
        return lambda celsius: heat.friction_factor * moment(speed_rad_s, celsius) * speed_rad_s

    stages = [SpeedStage(seconds, power(rpm * RAD_S_PER_RPM)) for seconds, rpm in heat.course]
    return warming(heat.path, stages, heat.start_C, step_s)


def _at(heat: BearingHeat, moment: Moment, times_s: Sequence[float]) -> tuple[Array, Array]:
    """Return temperature and torque at times; one at the end of a stage is of that stage."""
    pieces: list[tuple[float, float]] = []
    begin = 0.0
    for seconds, rpm in heat.course:
        inside = sorted({time for time in times_s if begin < time < begin + seconds})
        marks = [begin, *inside, begin + seconds]
        pieces += [(high - low, rpm) for low, high in pairwise(marks)]
        begin += seconds
    run = _followed(replace(heat, course=tuple(pieces)), moment, None)
    places = [int(np.argmin(np.abs(run.time_s - time))) for time in times_s]
    celsius = run.celsius[places]
    speeds = [pieces[max(place - 1, 0)][1] * RAD_S_PER_RPM for place in places]
    torques = [
        heat.friction_factor * moment(speed, float(warm)) for speed, warm in zip(speeds, celsius, strict=True)
    ]
    return celsius, np.array(torques)


def _stages(heat: BearingHeat, moment: Moment, run: Warming, ends: Array, speeds: Array) -> list[HeatStage]:
    stages, before = [], heat.start_C
    for end, speed in zip(ends.tolist(), speeds.tolist(), strict=True):
        warm = float(run.celsius[int(np.argmin(np.abs(run.time_s - end)))])

        def torque(celsius: float, speed: float = speed) -> float:
            return heat.friction_factor * moment(speed, celsius)

        first, last = torque(before), torque(warm)

        def power(celsius: float, speed: float = speed) -> float:
            return heat.friction_factor * moment(speed, celsius) * speed

        steady = steady_temperature_C(heat.path, power)
        stages.append(
            HeatStage(
                time_s=end,
                speed_rad_s=speed,
                temperature_C=warm,
                torque_N_m=last,
                power_W=last * speed,
                drop_percent=100.0 * (1.0 - last / first) if speed > 0.0 and first > 0.0 else None,
                steady_C=steady,
                steady_N_m=None if steady is None else torque(steady),
            )
        )
        before = warm
    return stages


def _readings(heat: BearingHeat, moment: Moment) -> list[HeatReading]:
    if not heat.readings:
        return []
    celsius, torque = _at(heat, moment, [each.time_s for each in heat.readings])
    return [
        HeatReading(
            time_s=each.time_s,
            torque_N_m=each.torque_N_m,
            model_N_m=float(own),
            temperature_C=float(warm),
            difference_N_m=each.torque_N_m - float(own),
        )
        for each, own, warm in zip(heat.readings, torque, celsius, strict=True)
    ]


# --- the fit ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Found:
    heat: BearingHeat
    values: list[FittedValue]
    correlation: list[list[float]] | None
    scatter_N_m: float | None
    not_fixed: list[str]


KEYS: Mapping[Fitted, Literal["capacity_J_K", "conductance_W_K", "friction_factor"]] = {
    "capacity": "capacity_J_K",
    "conductance": "conductance_W_K",
    "friction": "friction_factor",
}


@dataclass(frozen=True, eq=False)
class _HeatFit:
    """Least squares over the logarithms of what is fitted, weighed by the readings' uncertainty."""

    heat: BearingHeat
    moment: Moment

    def with_factors(self, logs: Array) -> BearingHeat:
        factor = {name: math.exp(float(log)) for name, log in zip(self.heat.fit, logs, strict=True)}
        path = self.heat.path
        return replace(
            self.heat,
            path=replace(
                path,
                capacity_J_K=path.capacity_J_K * factor.get("capacity", 1.0),
                conductance_W_K=path.conductance_W_K * factor.get("conductance", 1.0),
            ),
            friction_factor=self.heat.friction_factor * factor.get("friction", 1.0),
        )

    def found(self) -> _Found:
        readings = self.heat.readings
        times = [each.time_s for each in readings]
        measured = np.array([each.torque_N_m for each in readings])
        stated = [each.pm_N_m for each in readings]
        known = all(each is not None for each in stated)
        sigma = np.array([0.5 * (each or 0.0) for each in stated]) if known else np.ones(len(readings))

        def residuals(logs: Array) -> Array:
            return np.asarray((_at(self.with_factors(logs), self.moment, times)[1] - measured) / sigma)

        most = MOST_DECADES * math.log(10.0)
        count = len(self.heat.fit)
        best = least_squares(residuals, np.zeros(count), bounds=(-most, most), diff_step=[1e-5], xtol=1e-10)
        free = len(readings) - count
        left = float(best.fun @ best.fun)
        scatter = math.sqrt(left / free) if free > 0 and not known else None
        spread = self._spread(np.asarray(best.jac), 1.0 if known else scatter)
        heat = self.with_factors(best.x)
        width = None
        if spread is not None:
            quantile = 2.0 if known else float(student.ppf(0.5 * (1.0 + CONFIDENCE), free))
            width = quantile * np.sqrt(np.diag(spread))
        rows = self._values(heat, width, [abs(float(each)) > 0.99 * most for each in best.x])
        correlation = None
        if spread is not None and count > 1:
            size = np.sqrt(np.diag(spread))
            correlation = (spread / np.outer(size, size)).tolist()
        return _Found(heat, rows, correlation, scatter, _not_fixed(rows, width))

    def _spread(self, jacobian: Array, sigma: float | None) -> Array | None:
        """Return the covariance (k, k) of the logarithms; None without more readings than values.

        A direction that no reading determines has a wide spread in place of an infinite one.
        """
        if sigma is None:
            return None
        _, sizes, directions = np.linalg.svd(jacobian, full_matrices=False)
        floor = max(float(sizes.max()) * 1e-8, 1e-300)
        weights = (sigma / np.maximum(sizes, floor)) ** 2
        return np.asarray(directions.T @ (weights[:, None] * directions))

    def _values(self, heat: BearingHeat, width: Array | None, at_bound: Sequence[bool]) -> list[FittedValue]:
        values = {
            "capacity": heat.path.capacity_J_K,
            "conductance": heat.path.conductance_W_K,
            "friction": heat.friction_factor,
        }
        rows = []
        for place, name in enumerate(self.heat.fit):
            value, log = values[name], None if width is None else float(width[place])
            told = log is not None and log < 20.0
            rows.append(
                FittedValue(
                    name=KEYS[name],
                    value=value,
                    pm=value * log if told and log is not None else None,
                    least=value * math.exp(-log) if told and log is not None else None,
                    greatest=value * math.exp(log) if told and log is not None else None,
                    fixed=log is not None and log < math.log(FIXED_WITHIN) and not at_bound[place],
                )
            )
        return rows


def _not_fixed(rows: Sequence[FittedValue], width: Array | None) -> list[str]:
    """Return a line for each value that the readings leave open."""
    if width is None:
        return ["there are no more readings than values to fit, so the fit has no uncertainty"]
    return [
        f"{row.name}: the readings do not fix it"
        + ("" if row.least is None else f"; it is {row.least:.3g} to {row.greatest:.3g} with 95 %")
        for row in rows
        if not row.fixed
    ]
