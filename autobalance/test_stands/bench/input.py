"""Read ``BENCH.toml``: a rotor, its bearings, the speed control, the schedule and the readings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from autobalance.declare import Values, names
from autobalance.engines.bearings.cases import RollingCase
from autobalance.engines.bearings.fed_states import HeatPath
from autobalance.engines.bearings.film import JournalBearing
from autobalance.engines.bearings.input import parse_bearing
from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.cycle.windage import Air
from autobalance.errors import JobError
from autobalance.test_stands.bench.heat import BearingHeat, TimedReading
from autobalance.test_stands.bench.keys import (
    BENCH_KEYS,
    DRY_KEYS,
    PLAIN_KEYS,
    ROLLING_KEYS,
    TIMED_KEYS,
    Pair,
)
from autobalance.test_stands.bench.rotor import (
    BenchBearings,
    DiscHole,
    DiscOnShaft,
    DryBearings,
    PlainBearings,
    RollingBearings,
    disc_thickness_mm,
)
from autobalance.test_stands.bench.speed_control import SpeedControl
from autobalance.toml_files.keys import read_document
from autobalance.units import (
    G_MM2_PER_KG_MM2,
    G_PER_KG,
    G_PER_MM3_PER_KG_M3,
    M_PER_MM,
    RAD_S_PER_RPM,
)
from autobalance.value_classes import dataclass

GRAVITY_M_S2 = 9.80665
MOST_RUNS = 1000
DEFAULT_ZERO_V = 0.2


@dataclass(frozen=True)
class SpeedReading:
    """Measurement at a speed: volts of each run, or the torque; ``dropped`` runs count from 1.

    Runs in ``cold`` are among the volts: their temperature was not held.
    """

    case: int | str
    speed_rpm: float
    volts: tuple[float, ...]
    dropped: tuple[int, ...]
    torque_N_m: float | None
    simulated_N_m: float | None
    cold: tuple[int, ...] = ()

    @property
    def kept(self) -> tuple[float, ...]:
        """Volts of the runs that count."""
        return tuple(v for run, v in enumerate(self.volts, 1) if run not in self.dropped)


@dataclass(frozen=True, eq=False)
class Bench:
    """The file in mm, g, s, rad, N and V.

    ``zero_V`` None: the mean of the readings at rest; ``bearings`` None: nothing is run.
    """

    values: Values
    mass_g: float
    weight_N: float
    polar_g_mm2: float
    shape: DiscOnShaft | None
    density_g_mm3: float
    holes: tuple[DiscHole, ...]
    bearings: BenchBearings | None
    control: SpeedControl
    speeds_rpm: tuple[float, ...]
    ramp_s: float
    hold_s: float
    repeats: int
    zero_V: float | None
    N_m_per_V: float
    zero_pm_V: float
    N_m_per_V_pm: float
    readings: tuple[SpeedReading, ...]
    heat: BearingHeat | None = None
    air: Air | None = None

    @property
    def speeds_rad_s(self) -> tuple[float, ...]:
        """Speeds of the schedule."""
        return tuple(RAD_S_PER_RPM * each for each in self.speeds_rpm)


def read_bench(source: str | Path | Mapping[str, Any]) -> Bench:
    """Read a bench file, or its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible.
    """
    return read_document(source, "bench file", BENCH_KEYS, _bench)


def refuse_runs_without_bearings(tables: Mapping[str, Any]) -> None:
    """Refuse a schedule without bearings.

    Raises
    ------
    JobError
        If a file has ``[schedule]`` and no ``[bearing]``.
    """
    if "schedule" in tables and "bearing" not in tables:
        raise JobError("[bearing] is missing; the runs of [schedule] need its friction")


def _bench(values: Values) -> Bench:
    schedule, reduction = values["schedule"], values["reduction"]
    if not schedule["speeds_rpm"]:
        raise JobError("schedule.speeds_rpm is an empty list; expected at least one speed")
    if len(schedule["speeds_rpm"]) * schedule["repeats"] > MOST_RUNS:
        raise JobError(f"schedule has more than {MOST_RUNS} runs; choose fewer speeds or repeats")
    if reduction["zero_V"] is not None and reduction["zero"] is not None:
        raise JobError("reduction.zero_V is given with zero; expected one of them")
    hold = reduction["temperature_C"]
    if hold is not None and not hold[0] <= hold[1]:
        raise JobError(f"reduction.temperature_C is [{hold[0]:g}, {hold[1]:g}]; the first must be the lower")
    if reduction["zero_V"] is None and reduction["zero"] is None:
        reduction["zero_V"] = DEFAULT_ZERO_V
    if values["control"]["kp_N_m_s"] == 0.0 and values["control"]["ki_N_m"] == 0.0:
        raise JobError("control.kp_N_m_s and control.ki_N_m are both 0; there is no control")
    density = values["rotor"]["density_kg_m3"] * G_PER_MM3_PER_KG_M3
    shape = _shape(values["rotor"], density)
    _check_holes(values["hole"], values["rotor"]["disc_mm"])
    mass, weight = _mass(values["rotor"], shape)
    control = values["control"]
    return Bench(
        values,
        mass,
        weight,
        _inertia(values["rotor"], shape),
        shape,
        density,
        tuple(
            DiscHole(
                each["diameter_mm"], each["depth_mm"], each["radius_mm"], math.radians(each["angle_deg"])
            )
            for each in values["hole"]
        ),
        None if values["bearing"] is None else _bearings(values["bearing"]),
        SpeedControl(control["kp_N_m_s"], control["ki_N_m"], control["torque_limit_N_m"], control["delay_s"]),
        schedule["speeds_rpm"],
        schedule["ramp_s"],
        schedule["hold_s"],
        schedule["repeats"],
        reduction["zero_V"],
        reduction["N_m_per_V"],
        reduction["zero_pm_V"],
        reduction["N_m_per_V_pm"],
        tuple(
            _reading(each, f"reading[{number}]", reduction["temperature_C"])
            for number, each in enumerate(values["reading"], 1)
        ),
        None if values["heat"] is None else _heat(values["heat"], values["bearing"]),
        _air(values["windage"], shape),
    )


def _air(table: Values | None, shape: DiscOnShaft | None) -> Air | None:
    if table is None:
        return None
    if shape is None:
        raise JobError("rotor.disc_mm is missing; windage needs the shape of the rotor")
    return Air.of(table, "windage")


def _heat(table: Values, bearing: Values | None) -> BearingHeat:
    """Return the bearings' heat; their oil gives the viscosity by temperature."""
    if bearing is None:
        raise JobError("[bearing] is missing; the heat of [heat] is that of its friction")
    oil = None
    if bearing["kind"] != "dry":
        if bearing["oil"] is None:
            raise JobError("bearing.oil is missing; with [heat] the viscosity follows the temperature")
        oil = _oil(bearing["oil"])
    course = tuple((seconds, rpm) for seconds, rpm in table["course"]) * table["cycles"]
    if not course or not all(seconds > 0.0 for seconds, _ in course):
        raise JobError("heat.course must have at least one stage [seconds, rpm], the seconds > 0")
    whole = sum(seconds for seconds, _ in course)
    for number, each in enumerate(table["reading"], 1):
        if each["time_s"] > whole:
            raise JobError(
                f"heat.reading[{number}].time_s is {each['time_s']:g}; the course ends at {whole:g}"
            )
    fit = tuple(dict.fromkeys(table["fit"]))
    if fit and len(table["reading"]) < len(fit):
        raise JobError(
            f"heat.fit has {len(fit)} values, but there are {len(table['reading'])} [[heat.reading]]; "
            "fit fewer or add readings"
        )
    start = table["ambient_C"] if table["start_C"] is None else table["start_C"]
    return BearingHeat(
        HeatPath(table["capacity_J_K"], table["conductance_W_K"], table["ambient_C"]),
        start,
        course,
        table["friction_factor"],
        fit,
        tuple(TimedReading(*(each[key] for key in names(TIMED_KEYS))) for each in table["reading"]),
        None if oil is None else oil.kinematic_mm2_s if bearing["kind"] == "rolling" else oil.viscosity_Pa_s,
    )


def _oil(table: Values) -> WaltherOil:
    try:
        return WaltherOil.of_points(table["viscosity_mm2_s"], table["density_kg_m3"])
    except ValueError as error:
        raise JobError(f"bearing.oil.viscosity_mm2_s: {error}") from None


def _check_holes(holes: Sequence[Values], disc_mm: float | None) -> None:
    """Refuse holes whose middle lies outside of the disc; one drilled from the rim may reach over it."""
    for number, each in enumerate(holes, 1):
        if disc_mm is not None and each["radius_mm"] > 0.5 * disc_mm:
            raise JobError(
                f"hole[{number}].radius_mm is {each['radius_mm']:g}; "
                f"must lie in the disc, 0 to {0.5 * disc_mm:g}"
            )


def _shape(rotor: Values, density: float) -> DiscOnShaft | None:
    """Return the disc on its shaft; None if the file has no disc."""
    if rotor["disc_mm"] is None:
        for key in ("shaft_mm", "length_mm", "thickness_mm"):
            if rotor[key] is not None:
                raise JobError(f"rotor.{key} is given without disc_mm; both make the rotor's shape")
        return None
    for key in ("shaft_mm", "length_mm"):
        if rotor[key] is None:
            raise JobError(f"rotor.{key} is missing; the rotor's shape needs it with disc_mm")
    disc, shaft, length, thickness = (
        rotor[key] for key in ("disc_mm", "shaft_mm", "length_mm", "thickness_mm")
    )
    if not disc > shaft:
        raise JobError(f"rotor.disc_mm is {disc:g}; must be over shaft_mm, {shaft:g}")
    if thickness is None:
        if rotor["inertia_kg_mm2"] is None:
            raise JobError("rotor.inertia_kg_mm2 is missing; or thickness_mm, from which it is found")
        inertia = rotor["inertia_kg_mm2"] * G_MM2_PER_KG_MM2
        try:
            thickness = disc_thickness_mm(inertia, disc, shaft, length, density)
        except ValueError as error:
            raise JobError(f"rotor.inertia_kg_mm2 is {rotor['inertia_kg_mm2']:g}: {error}") from None
    if thickness > length:
        raise JobError(f"rotor.thickness_mm is {thickness:g}; must be at most length_mm, {length:g}")
    return DiscOnShaft(disc, shaft, length, thickness, density)


def _inertia(rotor: Values, shape: DiscOnShaft | None) -> float:
    if rotor["inertia_kg_mm2"] is not None:
        return float(rotor["inertia_kg_mm2"] * G_MM2_PER_KG_MM2)
    if shape is None:
        raise JobError("rotor.inertia_kg_mm2 is missing")
    return shape.polar_g_mm2


def _mass(rotor: Values, shape: DiscOnShaft | None) -> tuple[float, float]:
    """Return mass and weight, from whichever is given."""
    mass, weight = rotor["mass_kg"], rotor["weight_N"]
    if mass is None and weight is None:
        if shape is None:
            raise JobError("rotor.mass_kg is missing; or weight_N, or disc_mm, shaft_mm, length_mm")
        mass = shape.mass_g / G_PER_KG
    mass = weight / GRAVITY_M_S2 if mass is None else mass
    return mass * G_PER_KG, mass * GRAVITY_M_S2 if weight is None else weight


def _bearings(table: Values) -> BenchBearings:
    kind = table["kind"]
    known = {"dry": DRY_KEYS, "rolling": ROLLING_KEYS, "hydrodynamic": PLAIN_KEYS}
    own = set(names(known[kind])) | (
        {"diameter_mm", "mu", "count", "oil"} if kind == "hydrodynamic" else set()
    )
    for other, keys in known.items():
        for key in names(keys):
            if key not in own and table[key] is not None:
                raise JobError(f'bearing.{key} is given, but kind is "{kind}"; it is a key of "{other}"')
    if table["small_angle"] and kind != "dry":
        raise JobError(f'bearing.small_angle is given, but kind is "{kind}"; it is a key of "dry"')
    return _dry(table) if kind == "dry" else _rolling(table) if kind == "rolling" else _plain(table)


def _plain(table: Values) -> PlainBearings:
    if table["oil"] is not None:
        if table["viscosity_Pa_s"] is not None:
            raise JobError("bearing.viscosity_Pa_s and bearing.oil are both given; leave one out")
        table["viscosity_Pa_s"] = _oil(table["oil"]).viscosity_Pa_s(table["oil"]["temperature_C"])
    for key in ("diameter_mm", *names(PLAIN_KEYS), "mu"):
        if table[key] is None:
            why = ", friction where journal and bearing touch" if key == "mu" else "; must be > 0"
            raise JobError(f"bearing.{key} is missing{why}")
    sizes = (table["diameter_mm"], table["length_mm"], table["radial_clearance_mm"])
    return PlainBearings(
        JournalBearing(*(each * M_PER_MM for each in sizes)),
        table["count"] or 2,
        table["viscosity_Pa_s"],
        table["mu"],
    )


def _dry(table: Values) -> DryBearings:
    if table["diameter_mm"] is None:
        raise JobError("bearing.diameter_mm is missing; must be > 0")
    if (table["mu"] is None) == (table["mu_by_speed"] is None):
        fault = "mu is missing" if table["mu"] is None else "mu is given with mu_by_speed"
        raise JobError(f"bearing.{fault}; expected either mu or mu_by_speed")
    curve = ((0.0, table["mu"]),) if table["mu_by_speed"] is None else table["mu_by_speed"]
    speeds = [speed for speed, _ in curve]
    if not curve or any(b <= a for a, b in pairwise(speeds)):
        raise JobError("bearing.mu_by_speed must have at least one pair [rpm, mu], the speeds rising")
    return DryBearings(table["diameter_mm"], curve, table["small_angle"])


def _rolling(table: Values) -> RollingBearings:
    raw = {key: table[key] for key in ("kind", *names(ROLLING_KEYS)) if table[key] is not None}
    try:
        case = parse_bearing(_lists({**raw, "load_N": 0.0})).case
    except JobError as error:
        raise JobError(f"bearing.{error}") from None
    assert isinstance(case, RollingCase)
    viscosity = case.lubricant.kinematic_mm2_s
    assert viscosity is not None
    return RollingBearings(case.bearing, case.count, viscosity)


def _lists(value: Any) -> Any:
    """Return tuples as lists, as TOML has them."""
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    return [_lists(item) for item in value] if isinstance(value, tuple) else value


def _off_hold(each: Values, where: str, hold: Pair | None) -> tuple[int, ...]:
    """Return the runs, from 1, whose temperature was not held."""
    temperatures = each["temperature_C"]
    if temperatures is None:
        return ()
    if len(temperatures) != len(each["volts"] or ()):
        raise JobError(
            f"{where}.temperature_C has {len(temperatures)} values for {len(each['volts'] or ())} volts"
        )
    if hold is None:
        return ()
    return tuple(run for run, value in enumerate(temperatures, 1) if not hold[0] <= value <= hold[1])


def _reading(each: Values, where: str, hold: Pair | None) -> SpeedReading:
    volts, torque = each["volts"], each["torque_N_m"]
    if (volts is None) == (torque is None):
        fault = "volts is missing" if volts is None else "volts is given with torque_N_m"
        raise JobError(f"{where}.{fault}; expected either volts or torque_N_m")
    for run in each["drop"]:
        if not 1 <= run <= len(volts or ()):
            raise JobError(f"{where}.drop names run {run}; there are {len(volts or ())}, counted from 1")
    cold = _off_hold(each, where, hold)
    dropped = tuple(sorted({*each["drop"], *cold}))
    reading = SpeedReading(
        each["case"], each["speed_rpm"], volts or (), dropped, torque, each["simulated_N_m"], cold
    )
    if volts is not None and not reading.kept:
        key = "temperature_C" if cold else "drop"
        raise JobError(f"{where}.{key} leaves no run; at least one must count")
    return reading
