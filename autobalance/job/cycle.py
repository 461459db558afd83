"""The ``[cycle]`` table: what burns in each cylinder, when it fires, what it costs in friction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

from autobalance.engine.cycle.cylinder import Strokes
from autobalance.engine.cycle.friction import NO_FRICTION, Friction
from autobalance.engine.cycle.pendulum import Path as PendulumPath
from autobalance.engine.cycle.pendulum import Pendulum
from autobalance.errors import JobError
from autobalance.job.model.cycle import Absorber, Cycle, CylinderGas, Film, Model, Peg, TraceFile
from autobalance.job.toml.table import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, SHARE, Rule, Table
from autobalance.units import BAR_PER_MPA, G_MM2_PER_KG_MM2, N_M_PER_N_MM

WallHeat = Literal["none", "woschni"]

BORE = Rule(lambda x: x >= 1.0, "must be ≥ 1")
EXPONENT = Rule(lambda x: 0.0 < x <= 50.0, "must be > 0 and at most 50")
GAMMA = Rule(lambda x: 1.0 < x <= 3.0, "must be > 1 and at most 3")
GAMMA_SLOPE = Rule(lambda x: abs(x) <= 1e-3, "must be −0.001 to 0.001")
RATIO = Rule(lambda x: x > 1.0, "must be > 1")
ABSOLUTE = Rule(lambda x: x >= 0.0, "must be absolute, ≥ 0 (gauge?)")
ABSOLUTE_ABOVE_0 = Rule(lambda x: x >= 1e-3, "must be absolute, ≥ 0.001 (gauge?)")
LARGEST_SWING_DEG = 90.0
MM3_PER_CM3 = 1e3

CYLINDER_KEYS: Mapping[str, tuple[Any, Rule, Any]] = {
    "bore_mm": (float, BORE, None),
    "compression_ratio": (float, RATIO, None),
    "model": (Model, ANY, "wiebe"),
    "start_deg": (float, ANY, -15.0),
    "duration_deg": (float, POSITIVE, 50.0),
    "wiebe_a": (float, POSITIVE, 5.0),
    "wiebe_n": (float, EXPONENT, 3.0),
    "heat_J": (float, NOT_NEGATIVE, None),
    "gamma": (float, GAMMA, 1.35),
    "gamma_per_K": (float, GAMMA_SLOPE, 0.0),
    "intake_pressure_bar": (float, ABSOLUTE_ABOVE_0, 1.0),
    "intake_temperature_K": (float, POSITIVE, 330.0),
    "exhaust_pressure_bar": (float, ABSOLUTE, 1.1),
    "crankcase_pressure_bar": (float, ABSOLUTE, 1.0),
    "crankcase_volume_cm3": (float, POSITIVE, None),
    "intake_closes_deg": (float, ANY, None),
    "exhaust_opens_deg": (float, ANY, None),
}
"""Keys that may differ from cylinder to cylinder: type, rule, default."""
ENGINE_KEYS: Mapping[str, tuple[Any, Rule, Any]] = {
    "trace": (str, ANY, "pressure.csv"),
    "trace_shift_deg": (float, ANY, 0.0),
    "trace_peg": (Peg, ANY, "none"),
    "trace_smooth_deg": (float, NOT_NEGATIVE, 0.0),
    "firing_order": (tuple[int, ...], COUNTED, None),
    "firing_deg": (tuple[float, ...], ANY, None),
    "flywheel_kg_mm2": (float, NOT_NEGATIVE, 0.0),
    "fluctuation_wanted": (float, POSITIVE, None),
    "wall_heat": (WallHeat, ANY, "none"),
    "wall_temperature_K": (float, POSITIVE, 450.0),
}
FRICTION_KEYS = ("main_mu", "chen_flynn")
PENDULUM_KEYS = ("order", "distance_mm", "path", "swing_deg", "reduction")
FILM_KEYS = (
    "viscosity_Pa_s",
    "main_clearance_mm",
    "main_length_mm",
    "crankpin_clearance_mm",
    "crankpin_length_mm",
)
ChenFlynn = tuple[float, float, float, float]


def read_cycle(root: Table) -> Cycle | None:
    """Read ``[cycle]``; None where it is absent.

    Raises
    ------
    JobError
        If a key is unknown, missing, of the wrong type or impossible.
    """
    if "cycle" not in root:
        return None
    known = ("strokes", *CYLINDER_KEYS, *ENGINE_KEYS, "cylinder", "friction", "pendulum", "film")
    table = root.table("cycle", known)
    strokes = _strokes(table)
    shared = {key: table.raw[key] for key in CYLINDER_KEYS if key in table}
    own = {key: table.optional(key, *each) for key, each in ENGINE_KEYS.items()}
    default = _gas(Table(shared, table.path, None), strokes, own["wall_heat"])
    by_cylinder: dict[int, CylinderGas] = {}
    for item in table.tables("cylinder", ("number", *CYLINDER_KEYS)):
        number = item.value("number", int, COUNTED)
        if number in by_cylinder:
            raise JobError(f"{item.place('number')} is {number} again; each cylinder may stand once")
        merged = {**shared, **{key: value for key, value in item.raw.items() if key != "number"}}
        by_cylinder[number] = _gas(Table(merged, item.path, None), strokes, own["wall_heat"])
    if own["firing_order"] is not None and own["firing_deg"] is not None:
        raise JobError("cycle.firing_deg is given beside cycle.firing_order; must be one or the other")
    given = own["firing_deg"]
    return Cycle(
        strokes,
        default,
        by_cylinder,
        TraceFile(
            own["trace"],
            math.radians(own["trace_shift_deg"]),
            own["trace_peg"],
            math.radians(own["trace_smooth_deg"]),
        ),
        own["firing_order"],
        None if given is None else tuple(math.radians(angle) for angle in given),
        own["flywheel_kg_mm2"] * G_MM2_PER_KG_MM2,
        own["fluctuation_wanted"],
        own["wall_temperature_K"] if own["wall_heat"] == "woschni" else None,
        _friction(table),
        _absorber(table),
        _film(table),
        _filled_in(table, strokes, own),
    )


def _strokes(table: Table) -> Strokes:
    strokes = table.optional("strokes", int, default=4)
    if strokes not in (2, 4):
        raise JobError(f"{table.place('strokes')} is {strokes}; must be 2 or 4")
    return 2 if strokes == 2 else 4


def _gas(table: Table, strokes: Strokes, wall_heat: WallHeat) -> CylinderGas:
    values = {key: table.optional(key, *each) for key, each in CYLINDER_KEYS.items()}
    bore = table.value("bore_mm", float, BORE)
    model: Model = values["model"]
    if model != "trace":
        table.value("compression_ratio", float, RATIO)
    if model == "wiebe":
        table.value("heat_J", float, NOT_NEGATIVE)
    if wall_heat == "woschni" and values["wiebe_n"] < 1.0:
        raise JobError(f"{table.place('wiebe_n')} is {values['wiebe_n']:g}; must be ≥ 1 with wall heat")
    half = 90.0 * strokes
    _check_between(table, "intake_closes_deg", -half, 0.0)
    _check_between(table, "exhaust_opens_deg", 0.0, half)
    heat, case = values["heat_J"], values["crankcase_volume_cm3"]
    return CylinderGas(
        bore,
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


def _check_between(table: Table, key: str, low: float, high: float) -> None:
    """Refuse a valve angle that is not on its side of firing top dead centre."""
    value = table.optional(key, float)
    if value is not None and not (low <= value <= high and value != 0.0):
        raise JobError(f"{table.place(key)} is {value:g}; must be {low:g} to {high:g}, and not 0")


def _radians(degrees: float | None) -> float | None:
    return None if degrees is None else math.radians(degrees)


def _friction(cycle: Table) -> Friction:
    if "friction" not in cycle:
        return NO_FRICTION
    table = cycle.table("friction", FRICTION_KEYS)
    return Friction(
        table.optional("main_mu", float, NOT_NEGATIVE, default=0.0),
        table.optional("chen_flynn", ChenFlynn, default=NO_FRICTION.chen_flynn),
    )


def _absorber(cycle: Table) -> Absorber | None:
    if "pendulum" not in cycle:
        return None
    table = cycle.table("pendulum", PENDULUM_KEYS)
    path: PendulumPath = table.optional("path", PendulumPath, default="circular")
    pendulum = Pendulum(
        table.value("order", float, POSITIVE), table.value("distance_mm", float, POSITIVE), path
    )
    swing = table.optional("swing_deg", float, POSITIVE, default=20.0)
    most = math.degrees(pendulum.widest_swing_rad)
    if swing > most:
        raise JobError(f"{table.place('swing_deg')} is {swing:g}; this path ends at {most:.4g}")
    return Absorber(pendulum, math.radians(swing), table.optional("reduction", float, SHARE, default=1.0))


def _film(cycle: Table) -> Film | None:
    if "film" not in cycle:
        return None
    table = cycle.table("film", FILM_KEYS)
    return Film(
        table.value("viscosity_Pa_s", float, POSITIVE),
        table.value("main_clearance_mm", float, POSITIVE),
        table.optional("main_length_mm", float, POSITIVE),
        table.optional("crankpin_clearance_mm", float, POSITIVE),
        table.optional("crankpin_length_mm", float, POSITIVE),
    )


def _filled_in(table: Table, strokes: Strokes, own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table as it was read, in its own units, with every default."""
    friction = table.table("friction", FRICTION_KEYS).raw
    values = {
        "strokes": strokes,
        **{key: table.optional(key, *each) for key, each in CYLINDER_KEYS.items()},
        **{key: list(value) if isinstance(value, tuple) else value for key, value in own.items()},
        "friction": {"main_mu": 0.0, "chen_flynn": [0.0, 0.0, 0.0, 0.0], **friction},
    }
    for key in ("cylinder", "pendulum", "film"):
        if key in table:
            values[key] = table.raw[key]
    return values
