"""The keys of ``BENCH.toml``."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from autobalance.declare import COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, Key
from autobalance.engines.bearings.keys import ABOVE_ZERO_KELVIN, PALMGREN_KEYS, SKF_KEYS
from autobalance.engines.cycle.windage import AIR_KEYS
from autobalance.units import STEEL_KG_M3

Pair = tuple[float, float]
Fitted = Literal["capacity", "conductance", "friction"]

ROTOR_KEYS = (
    Key(
        "inertia_kg_mm2",
        float,
        "inertia about the axis; with disc_mm and no thickness_mm the disc fits it",
        POSITIVE,
        None,
    ),
    Key("mass_kg", float, "mass of the rotor", POSITIVE, None),
    Key("weight_N", float, "or its weight", POSITIVE, None),
    Key("disc_mm", float, "or its shape: diameter of the disc", POSITIVE, None),
    Key("shaft_mm", float, "diameter of the shaft", POSITIVE, None),
    Key("length_mm", float, "length of the whole rotor", POSITIVE, None),
    Key("thickness_mm", float, "thickness of the disc", POSITIVE, None),
    Key("density_kg_m3", float, "density of rotor and holes", POSITIVE, STEEL_KG_M3),
)
HOLE_KEYS = (
    Key("diameter_mm", float, "diameter of the hole", POSITIVE),
    Key("depth_mm", float, "depth of the hole", POSITIVE),
    Key("radius_mm", float, "radius of its middle", NOT_NEGATIVE),
    Key("angle_deg", float, "angle of the hole", default=0.0),
)
OIL_KEYS = (
    Key("viscosity_mm2_s", tuple[Pair, Pair], "two pairs °C, ν"),
    Key("density_kg_m3", float, "density of the oil", POSITIVE, 860.0),
    Key("temperature_C", float, "temperature of the oil"),
)
DRY_KEYS = (
    Key("diameter_mm", float, "dry, hydrodynamic: of the journals", POSITIVE, None),
    Key("mu", float, "dry: coefficient of friction; hydrodynamic: where they touch", NOT_NEGATIVE, None),
    Key("mu_by_speed", tuple[Pair, ...], "or pairs [rpm, mu], straight between them", NOT_NEGATIVE, None),
)
PLAIN_KEYS = (
    Key("length_mm", float, "hydrodynamic: of each bearing", POSITIVE, None),
    Key("radial_clearance_mm", float, "hydrodynamic: of each bearing", POSITIVE, None),
    Key("viscosity_Pa_s", float, "hydrodynamic: dynamic, of the oil", POSITIVE, None),
)
ROLLING_KEYS = (
    Key("model", Literal["palmgren", "skf"], "rolling: how friction is found", default=None),
    Key("mean_diameter_mm", float, "rolling: (d + D)/2", POSITIVE, None),
    Key("kinematic_viscosity_mm2_s", float, "rolling: of the oil", POSITIVE, None),
    Key("count", int, "rolling, hydrodynamic: number of equal bearings that share the load", COUNTED, None),
    *(replace(key, default=None) for key in (*PALMGREN_KEYS, *SKF_KEYS)),
    Key("oil", says="rolling, hydrodynamic: instead of the viscosity", keys=OIL_KEYS, default=None),
)
BEARING_KEYS = (
    Key("kind", Literal["dry", "rolling", "hydrodynamic"], "bearings of the rotor"),
    *DRY_KEYS,
    Key("small_angle", bool, "dry: μ in place of μ/√(1 + μ²)", default=False),
    *ROLLING_KEYS,
    *PLAIN_KEYS,
)
CONTROL_KEYS = (
    Key("kp_N_m_s", float, "torque by speed error", NOT_NEGATIVE, 0.05),
    Key("ki_N_m", float, "torque by the integral of the speed error", NOT_NEGATIVE, 0.5),
    Key("torque_limit_N_m", float, "largest torque", POSITIVE, 5.0),
    Key("delay_s", float, "delay of the torque", NOT_NEGATIVE, 0.0),
)
SCHEDULE_KEYS = (
    Key("speeds_rpm", tuple[float, ...], "each from rest", POSITIVE, (3000.0, 6000.0, 9000.0)),
    Key("ramp_s", float, "straight up", POSITIVE, 2.0),
    Key("hold_s", float, "then held", POSITIVE, 1.5),
    Key("repeats", int, "runs at each speed", COUNTED, 1),
)
REDUCTION_KEYS = (
    Key("zero_V", float, "reading without torque (0.2)", default=None),
    Key("zero", Literal["rest"], "or: mean of the readings at 0 rpm of the case", default=None),
    Key("N_m_per_V", float, "sensitivity of the torque transducer", POSITIVE, 5.0 / 4.8),
    Key("zero_pm_V", float, "half-width of the zero's range", NOT_NEGATIVE, 0.0),
    Key("N_m_per_V_pm", float, "half-width of the scale's range", NOT_NEGATIVE, 0.0),
    Key("temperature_C", tuple[float, float], "hold: runs outside from–to do not count", default=None),
)
READING_KEYS = (
    Key("case", int | str, "name of the case"),
    Key("speed_rpm", float, "0: at rest", NOT_NEGATIVE),
    Key("volts", tuple[float, ...], "one a run", default=None),
    Key("torque_N_m", float, "or the torque", default=None),
    Key("temperature_C", tuple[float, ...], "temperatures of the bearings, one a run", default=None),
    Key("drop", tuple[int, ...], "runs that do not count, from 1", default=()),
    Key("simulated_N_m", float, "torque to compare with; default the run of that speed here", default=None),
)
TIMED_KEYS = (
    Key("time_s", float, "time since the course began", NOT_NEGATIVE),
    Key("torque_N_m", float, "torque measured then", POSITIVE),
    Key("pm_N_m", float, "uncertainty, 95 %; without it: the readings' scatter", POSITIVE, None),
)
HEAT_KEYS = (
    Key("capacity_J_K", float, "heat capacity of all that warms with the bearings", POSITIVE),
    Key("conductance_W_K", float, "conductance from there to the ambient", POSITIVE),
    Key("ambient_C", float, "temperature of the ambient", ABOVE_ZERO_KELVIN, 20.0),
    Key(
        "start_C",
        float,
        "temperature of the bearings at the start",
        ABOVE_ZERO_KELVIN,
        None,
        usual="ambient_C",
    ),
    Key("course", tuple[Pair, ...], "stages [seconds, rpm], one after the other", NOT_NEGATIVE),
    Key("cycles", int, "number of times that the course is run on end", COUNTED, 1),
    Key("friction_factor", float, "measured friction over that of the bearings' model", POSITIVE, 1.0),
    Key(
        "fit",
        tuple[Fitted, ...],
        "values to fit to the readings, from the ones given",
        default=(),
    ),
    Key("reading", says="torque at a time of the course", keys=TIMED_KEYS, many=True, default=()),
)
BENCH_KEYS = (
    Key("rotor", says="rotor", keys=ROTOR_KEYS),
    Key("hole", says="drilled: its weight is missing", keys=HOLE_KEYS, many=True, default=None),
    Key("bearing", says="both together; without it nothing is run", keys=BEARING_KEYS, default=None),
    Key("control", says="speed control", keys=CONTROL_KEYS, default=FILLED),
    Key("schedule", says="schedule of the runs", keys=SCHEDULE_KEYS, default=FILLED),
    Key("reduction", says="reduction of volts to torque", keys=REDUCTION_KEYS, default=FILLED),
    Key("windage", says="windage of the disc and its shaft", keys=AIR_KEYS, default=None),
    Key("heat", says="bearings that warm over a course of speeds", keys=HEAT_KEYS, default=None),
    Key("reading", says="measured values", keys=READING_KEYS, many=True, default=None),
)
