"""The ``[cycle]`` table: combustion in each cylinder, firing order and friction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

from autobalance.declare import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, SHARE, Key, Range, Values
from autobalance.engines.bearings.keys import ABOVE_ZERO_KELVIN, OIL_KEYS
from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.cycle.cylinder import Strokes
from autobalance.engines.cycle.drive import DRIVE, drives_of
from autobalance.engines.cycle.model import (
    NO_FRICTION,
    Absorber,
    Cycle,
    CylinderGas,
    Friction,
    MainHeat,
    Model,
    OilFilms,
    Peg,
    Pendulum,
    TraceFile,
)
from autobalance.engines.cycle.model import Path as PendulumPath
from autobalance.engines.cycle.piston_friction import PISTON, piston_friction_of
from autobalance.engines.cycle.weight import GRAVITY, gravity_of
from autobalance.engines.cycle.windage import AIR_KEYS, Air
from autobalance.errors import JobError
from autobalance.job.tables import AddonTables, TablesRead
from autobalance.toml_files.keys import plain
from autobalance.units import BAR_PER_MPA, G_MM2_PER_KG_MM2, M3_PER_MM3, N_M_PER_N_MM

WallHeat = Literal["none", "woschni"]
Gas = Literal["real", "ideal"]
BURNT_GAMMA_PER_K = -7e-5
"""Change of γ [1/K] from a charge of 1.35 when the intake closes to burnt gas of 1.2 at 2500 K (Heywood 1988,
Figs 4.13 to 4.18)."""
ChenFlynn = tuple[float, float, float, float]

BORE = Range("must be ≥ 1", least=1.0)
EXPONENT = Range("must be > 0 and at most 50", above=0.0, most=50.0)
GAMMA = Range("must be > 1 and at most 3", above=1.0, most=3.0)
GAMMA_SLOPE = Range("must be −0.001 to 0.001", least=-1e-3, most=1e-3)
RATIO = Range("must be > 1", above=1.0)
ABSOLUTE = Range("must be absolute, ≥ 0 (gauge?)", least=0.0)
ABSOLUTE_ABOVE_0 = Range("must be absolute, ≥ 0.001 (gauge?)", least=1e-3)
STROKES = Range("must be 2 or 4", one_of=(2, 4))
MM3_PER_CM3 = 1e3
DEAD_CENTRE = "the bottom dead centre beside firing"

CYLINDER = (
    Key("bore_mm", float, "bore of the cylinder", BORE),
    Key(
        "compression_ratio",
        float,
        "largest over smallest volume; may be missing for a trace, whose volumes then count from top dead "
        "centre",
        RATIO,
        None,
        usual="required",
    ),
    Key("model", Model, '`"motored"`: without heat; `"trace"`: measured', default="wiebe"),
    Key(
        "start_deg",
        float,
        "heat release x = 1 − exp(−a ((θ − start)/duration)ⁿ) after firing top dead centre",
        ANY,
        -15.0,
    ),
    Key("duration_deg", float, "duration of the heat release, which continues past it", POSITIVE, 50.0),
    Key("wiebe_a", float, "a of it", POSITIVE, 5.0),
    Key("wiebe_n", float, "n of it", EXPONENT, 3.0),
    Key("heat_J", float, "per cylinder and cycle", NOT_NEGATIVE, None, usual='required for `"wiebe"`'),
    Key("gamma", float, "ratio of specific heats at the intake temperature", GAMMA, 1.35),
    Key(
        "gamma_per_K",
        float,
        "change of gamma with temperature (−6e-5 for air)",
        GAMMA_SLOPE,
        None,
        usual='`-7e-5`; 0 with `gas = "ideal"`',
    ),
    Key("intake_pressure_bar", float, "when the intake closes; absolute", ABSOLUTE_ABOVE_0, 1.0),
    Key("intake_temperature_K", float, "when the intake closes", POSITIVE, 330.0),
    Key("exhaust_pressure_bar", float, "absolute; four strokes", ABSOLUTE, 1.1),
    Key("crankcase_pressure_bar", float, "below the piston, at top dead centre; absolute", ABSOLUTE, 1.0),
    Key(
        "crankcase_volume_cm3",
        float,
        "volume below the piston at top dead centre, whose gas is pressed together without loss",
        POSITIVE,
        None,
        usual="constant pressure",
    ),
    Key("intake_closes_deg", float, "after firing top dead centre, below 0", ANY, None, usual=DEAD_CENTRE),
    Key("exhaust_opens_deg", float, "after firing top dead centre", ANY, None, usual=DEAD_CENTRE),
)
"""Keys that may differ from cylinder to cylinder."""
OF_A_CYLINDER = (
    Key("number", int, "number of the cylinder: by throw, then by place in `bank_deg`", COUNTED),
    *(replace(key, default=None, usual="as `[cycle]`") for key in CYLINDER),
)
OF_THE_ENGINE = (
    Key(
        "trace",
        str,
        "relative to the job: `angle_deg` or `angle_rad`, `pressure_bar`, `_kPa`, `_MPa`, `_Pa` or `_psi`; "
        "whole "
        "cycles on end, or −180° to 180° of a four-stroke",
        default="pressure.csv",
    ),
    Key("trace_shift_deg", float, "added to its angles", ANY, 0.0),
    Key("trace_peg", Peg, '`"intake"` sets its level from −185° to −175°', default="none"),
    Key("trace_smooth_deg", float, "width over which cubics are fitted", NOT_NEGATIVE, 0.0),
    Key(
        "firing_order",
        tuple[int, ...],
        "the order alone: of all firing angles that keep it, those with the least sum of squared intervals",
        COUNTED,
        None,
        usual="for one cylinder",
    ),
    Key(
        "firing_deg",
        tuple[float, ...],
        "instead: the crank angle of each cylinder's firing top dead centre",
        default=None,
    ),
    Key("flywheel_kg_mm2", float, "inertia besides the crank's own", NOT_NEGATIVE, 0.0),
    Key("fluctuation_wanted", float, "fluctuation of speed for which a flywheel is computed", POSITIVE, None),
    Key(
        "gas",
        Gas,
        '`"real"`: heat through the walls and γ by temperature; `"ideal"`: neither',
        default=None,
        usual='`"real"`; `"ideal"` if not `"wiebe"`, or if `gamma`, `gamma_per_K` or `wall_heat` is given',
    ),
    Key(
        "wall_heat",
        WallHeat,
        '`"woschni"`: heat through the walls',
        default=None,
        usual='`"woschni"`; `"none"` with `gas = "ideal"`',
    ),
    Key("wall_temperature_K", float, "temperature of the walls", POSITIVE, 450.0),
)
FRICTION = (
    Key("main_mu", float, "Coulomb at the main journals, |F| d/2 μ/√(1 + μ²)", NOT_NEGATIVE, 0.0),
    Key(
        "chen_flynn",
        ChenFlynn,
        "A + B p_max + C c_m + D c_m² in bar, for rings, skirts and auxiliaries",
        default=NO_FRICTION.chen_flynn,
    ),
)
PENDULUM = (
    Key("order", float, "order that it is tuned to", POSITIVE),
    Key("distance_mm", float, "distance from the crank axis to the pivot", POSITIVE),
    Key("path", PendulumPath, "path of its mass", default="circular"),
    Key("swing_deg", float, "largest swing", POSITIVE, 20.0),
    Key("reduction", float, "share of the order's torque that it is to take", SHARE, 1.0),
)
FILM = (
    Key("viscosity_Pa_s", float, "viscosity of the oil", POSITIVE),
    Key("main_clearance_mm", float, "radial, of the main journals", POSITIVE),
    Key("main_length_mm", float, "length of the main bearings", POSITIVE, None, usual="the journal's width"),
    Key("crankpin_clearance_mm", float, "radial, of the big ends", POSITIVE, None),
    Key(
        "crankpin_length_mm",
        float,
        "length of the crankpin bearings",
        POSITIVE,
        None,
        usual="the crankpin's width",
    ),
)
HEAT = (
    Key("conductance_W_K", float, "conductance from each main bearing to the block", NOT_NEGATIVE),
    Key("ambient_C", float, "temperature of the block", ABOVE_ZERO_KELVIN, 90.0),
    *(key for key in OIL_KEYS if key.name in ("viscosity_mm2_s", "density_kg_m3")),
    Key(
        "supply_C",
        float,
        "temperature of the oil supplied; without it none carries heat off",
        ABOVE_ZERO_KELVIN,
        None,
    ),
    Key("flow_mm3_s", float, "oil through each main bearing", POSITIVE, None, usual="the flow of its film"),
    Key("heat_capacity_J_kg_K", float, "specific heat of the oil", POSITIVE, 2000.0),
)
CYCLE = Key(
    "cycle",
    says="gas cycle of the cylinders: see [cycle.md](cycle.md)",
    default=None,
    verbs="cycle, strength, forces, orders, torsion, bench",
    keys=(
        Key("strokes", int, "strokes of a cycle", STROKES, 4),
        *CYLINDER,
        *OF_THE_ENGINE,
        Key("cylinder", says="a cylinder that differs", keys=OF_A_CYLINDER, many=True, default=()),
        Key("friction", says="friction losses", keys=FRICTION, default=None),
        Key("pendulum", says="a pendulum absorber", keys=PENDULUM, default=None),
        Key("film", says="the journals' orbits in their oil", keys=FILM, default=None),
        Key("gravity", says="weight of crank, rods and pistons", keys=GRAVITY, default=None),
        Key("piston", says="friction of pistons by their side force", keys=PISTON, default=None),
        Key("drive", says="a chain, belt or gear that takes torque", keys=DRIVE, many=True, default=()),
        Key("heat", says="steady temperature of the main bearings", keys=HEAT, default=None),
        Key("windage", says="windage of the webs", keys=AIR_KEYS, default=None),
    ),
    shape={
        "allOf": [
            {
                "if": {"not": {"properties": {"model": {"const": "trace"}}, "required": ["model"]}},
                "then": {"required": ["compression_ratio"]},
            },
            {
                "if": {"properties": {"model": {"const": "wiebe"}}},
                "then": {"required": ["heat_J"]},
            },
        ]
    },
)


def _made(read: TablesRead) -> Cycle | None:
    table = read.values.get("cycle")
    return None if table is None else cycle_of(table, read.raw["cycle"])


def _filled(_: AddonTables, __: TablesRead, cycle: Cycle) -> Values:
    return {"cycle": dict(cycle.values)}


TABLES = AddonTables((CYCLE,), _made, filled=_filled)


def cycle_of(values: Values, raw: Mapping[str, Any]) -> Cycle:
    """Return the cycle of ``[cycle]``; ``raw`` is the table, for keys that its cylinders leave open.

    Raises
    ------
    JobError
        If they contradict each other.
    """
    values = _with_gas(values, raw)
    strokes: Strokes = 2 if values["strokes"] == 2 else 4
    default = _gas(values, strokes, values["wall_heat"], "cycle")
    by_cylinder: dict[int, CylinderGas] = {}
    for place, each in enumerate(values["cylinder"], 1):
        where, number = f"cycle.cylinder[{place}]", each["number"]
        if number in by_cylinder:
            raise JobError(f"{where}.number is {number} twice; each cylinder may be listed once")
        own = {key: value for key, value in each.items() if key in raw["cylinder"][place - 1]}
        by_cylinder[number] = _gas({**values, **own}, strokes, values["wall_heat"], where)
    order, angles = values["firing_order"], values["firing_deg"]
    if order is not None and angles is not None:
        raise JobError("cycle.firing_deg is given beside cycle.firing_order; must be one or the other")
    return Cycle(
        strokes,
        default,
        by_cylinder,
        TraceFile(
            values["trace"],
            math.radians(values["trace_shift_deg"]),
            values["trace_peg"],
            math.radians(values["trace_smooth_deg"]),
        ),
        order,
        None if angles is None else tuple(math.radians(angle) for angle in angles),
        values["flywheel_kg_mm2"] * G_MM2_PER_KG_MM2,
        values["fluctuation_wanted"],
        values["wall_temperature_K"] if values["wall_heat"] == "woschni" else None,
        NO_FRICTION if values["friction"] is None else Friction(**values["friction"]),
        _absorber(values["pendulum"]),
        None if values["film"] is None else OilFilms(*values["film"].values()),
        gravity_of(values["gravity"]),
        drives_of(values["drive"]),
        piston_friction_of(values["piston"]),
        None if values["heat"] is None else _heat(values["heat"], values["film"]),
        None if values["windage"] is None else Air.of(values["windage"], "cycle.windage"),
        _filled_in(values, raw),
    )


STATED_GAS = ("gamma", "gamma_per_K", "wall_heat")
"""Keys that say how the gas is modelled; a job that gives one has the rest as they were without ``gas``."""


def _with_gas(values: Values, raw: Mapping[str, Any]) -> Values:
    """Return the table with its gas decided: real if it burns and the job states nothing else."""
    tables = (raw, *raw.get("cylinder", ()))
    stated = any(key in each for each in tables for key in STATED_GAS)
    solvable = all(each.get("wiebe_n", 1.0) >= 1.0 for each in tables)
    usual: Gas = "real" if values["model"] == "wiebe" and solvable and not stated else "ideal"
    gas = values["gas"] or usual
    real = gas == "real"
    slope = BURNT_GAMMA_PER_K if real else 0.0
    return {
        **values,
        "gas": gas,
        "gamma_per_K": slope if values["gamma_per_K"] is None else values["gamma_per_K"],
        "wall_heat": values["wall_heat"] or ("woschni" if real else "none"),
    }


def _heat(table: Values, film: Values | None) -> MainHeat:
    try:
        oil = WaltherOil.of_points(table["viscosity_mm2_s"], table["density_kg_m3"])
    except ValueError as error:
        raise JobError(f"cycle.heat.viscosity_mm2_s: {error}") from None
    flow, supply = table["flow_mm3_s"], table["supply_C"]
    if flow is not None and supply is None:
        raise JobError("cycle.heat.supply_C is missing; flow_mm3_s is that of the oil supplied")
    if supply is not None and flow is None and film is None:
        raise JobError("cycle.heat.flow_mm3_s is missing; without [cycle.film] no film gives the flow")
    if supply is None and table["conductance_W_K"] == 0.0:
        raise JobError("cycle.heat.conductance_W_K is 0 without supply_C; the heat has no way out")
    return MainHeat(
        table["conductance_W_K"],
        table["ambient_C"],
        oil,
        supply,
        None if flow is None else flow * M3_PER_MM3,
        table["heat_capacity_J_kg_K"],
    )


def _gas(values: Values, strokes: Strokes, wall_heat: WallHeat, where: str) -> CylinderGas:
    model: Model = values["model"]
    for key, rule, required in (
        ("compression_ratio", RATIO, model != "trace"),
        ("heat_J", NOT_NEGATIVE, model == "wiebe"),
    ):
        if required and values[key] is None:
            raise JobError(f"{where}.{key} is missing; it {rule.text}")
    if wall_heat == "woschni" and values["wiebe_n"] < 1.0:
        raise JobError(f"{where}.wiebe_n is {values['wiebe_n']:g}; must be ≥ 1 with wall heat")
    half = 90.0 * strokes
    _check_between(values, where, "intake_closes_deg", -half, 0.0)
    _check_between(values, where, "exhaust_opens_deg", 0.0, half)
    heat, case = values["heat_J"], values["crankcase_volume_cm3"]
    return CylinderGas(
        values["bore_mm"],
        values["compression_ratio"],
        model,
        math.radians(values["start_deg"]),
        math.radians(values["duration_deg"]),
        values["wiebe_a"],
        values["wiebe_n"],
        None if heat is None or model != "wiebe" else heat / N_M_PER_N_MM,
        values["gamma"],
        values["gamma_per_K"],
        values["intake_pressure_bar"] / BAR_PER_MPA,
        values["intake_temperature_K"],
        values["exhaust_pressure_bar"] / BAR_PER_MPA,
        values["crankcase_pressure_bar"] / BAR_PER_MPA,
        None if case is None else case * MM3_PER_CM3,
        _radians(values["intake_closes_deg"]),
        _radians(values["exhaust_opens_deg"]),
    )


def _check_between(values: Values, where: str, key: str, low: float, high: float) -> None:
    """Refuse a valve angle that is not on its side of firing top dead centre."""
    value = values[key]
    if value is not None and not (low <= value <= high and value != 0.0):
        raise JobError(f"{where}.{key} is {value:g}; must be {low:g} to {high:g}, and not 0")


def _radians(degrees: float | None) -> float | None:
    return None if degrees is None else math.radians(degrees)


def _absorber(values: Values | None) -> Absorber | None:
    if values is None:
        return None
    pendulum = Pendulum(values["order"], values["distance_mm"], values["path"])
    swing, most = values["swing_deg"], math.degrees(pendulum.widest_swing_rad)
    if swing > most:
        raise JobError(f"cycle.pendulum.swing_deg is {swing:g}; this path ends at {most:.4g}")
    return Absorber(pendulum, math.radians(swing), values["reduction"])


def _filled_in(values: Values, raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table in its own units, with every default; tables inside as they are."""
    friction = {key.name: plain(key.default) for key in FRICTION} | dict(raw.get("friction", {}))
    tables = ("cylinder", "friction", "pendulum", "film", "gravity", "drive", "piston", "heat", "windage")
    own = {key: raw[key] for key in tables if key in raw and key != "friction"}
    plainly = {key: plain(value) for key, value in values.items() if key not in tables}
    return {**plainly, "friction": friction, **own}
