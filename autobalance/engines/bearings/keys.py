"""Keys of a bearing's file, a form for each kind of bearing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from autobalance.declare import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, Key, Range
from autobalance.engines.bearings.cases import Solver
from autobalance.engines.bearings.film import Boundary

Pair = tuple[float, float]
Turns = Literal["ccw", "cw"]
MOST_SPEEDS = 10_000
FEWEST_CELLS = (8, 4)
MOST_CELLS = 100_000
OIL_POINTS: tuple[Pair, Pair] = ((40.0, 100.0), (100.0, 11.0))
"""Oil of a file that states none of its keys: an SAE 30."""

UP_TO_ONE = Range("must be 0 to 1: the journal touches its bush at 1", least=0.0, most=1.0)
ABOVE_ZERO_KELVIN = Range("must be above -273.15", above=-273.15)

OIL_KEYS = (
    Key(
        "viscosity_mm2_s",
        tuple[Pair, Pair],
        "two pairs °C, mm²/s; by Walther's law between and beyond; default an SAE 30",
        default=OIL_POINTS,
    ),
    Key("density_kg_m3", float, "density of the oil", POSITIVE, 860.0),
    Key("temperature_C", float, "temperature of the film", ABOVE_ZERO_KELVIN, None),
    Key(
        "supply_C",
        float,
        'temperature of the oil supplied, "hydrodynamic" only: a heat balance gives that of the film',
        ABOVE_ZERO_KELVIN,
        None,
    ),
    Key("heat_capacity_J_kg_K", float, "heat capacity of the oil, with `supply_C`", POSITIVE, 2000.0),
)
HISTORY_KEYS = (
    Key("file", str, "CSV with `angle_deg` and the columns below", default="series.csv"),
    Key("x", str, "column of the force on the bush along x [N]", default=None, usual="main_1_x_N"),
    Key("y", str, "column of the force on the bush along y [N]", default=None, usual="main_1_y_N"),
    Key("bush_speed_rpm", float, "speed of the bush about its own axis", ANY, 0.0),
    Key("turns", Turns, '"cw" for the series of an engine with `turns = "cw"`', default="ccw"),
)
SUPPLY_KEYS = (
    Key("angle_deg", float, "middle, from the load's direction in the sense of turning", ANY, 0.0),
    Key("width_mm", float, "width around; without it and `diameter_mm`: a groove all around", POSITIVE, None),
    Key("length_mm", float, "length along the bearing", POSITIVE, None),
    Key("diameter_mm", float, "or a hole of this diameter", POSITIVE, None),
    Key("z_mm", float, "middle, from the middle of the bearing's length", ANY, 0.0),
    Key("count", int, "number of these, evenly around from `angle_deg`", COUNTED, 1),
    Key(
        "pressure_bar",
        float,
        "pressure above the ambient's",
        NOT_NEGATIVE,
        None,
        usual="`supply_pressure_bar`",
    ),
    Key(
        "restrictor",
        Literal["none", "capillary", "orifice", "flow"],
        'device upstream of it; "none": it has the supply pressure',
        default="none",
    ),
    Key("capillary_diameter_mm", float, "bore of the capillary", POSITIVE, None),
    Key("capillary_length_mm", float, "length of the capillary", POSITIVE, None),
    Key("orifice_diameter_mm", float, "diameter of the orifice", POSITIVE, None),
    Key("discharge_coefficient", float, "discharge coefficient of the orifice", POSITIVE, 0.6),
    Key("flow_mm3_s", float, "flow of each, at any pressure", NOT_NEGATIVE, None),
    Key(
        "depth_mm",
        float,
        "depth below the bush's surface, for friction; without it, it adds no friction",
        POSITIVE,
        None,
    ),
)
"""Keys of a recess, groove or hole under pressure."""


def _viscosity(name: str, quantity: str) -> tuple[Key, Key]:
    """Return the key of a viscosity and the table that may be in its place."""
    return (
        Key(
            name,
            float,
            f"{quantity} viscosity of the oil, or give `[oil]`",
            POSITIVE,
            instead="oil",
            missing="give it, must be > 0, or an [oil] table",
        ),
        Key("oil", says="in place of the viscosity", keys=OIL_KEYS, default=None),
    )


def _form(kind: str, *keys: Key, speed: Range = POSITIVE) -> tuple[Key, ...]:
    return (
        Key("kind", Literal[kind], "kind of bearing"),
        Key(
            "speed_rpm",
            float | tuple[float, ...],
            "one speed or a list; the first is reported in full, the others as rows",
            speed,
            3000.0,
            not_empty=f"must have 1 to {MOST_SPEEDS} entries",
        ),
        *keys,
    )


DIAMETER = Key("diameter_mm", float, "diameter of the journal", POSITIVE)
LENGTH = Key("length_mm", float, "length of the bearing", POSITIVE)
DRY = _form(
    "dry",
    DIAMETER,
    Key("load_N", float, "static load", NOT_NEGATIVE),
    Key("rotating_load_N", float, "load that turns with the shaft", NOT_NEGATIVE, 0.0),
    Key("mu", float, "coefficient of friction; or give `torque_N_m`", NOT_NEGATIVE, None),
    Key("torque_N_m", float, "measured, to find the coefficient from", NOT_NEGATIVE, None),
)
CLEARANCE = Key("radial_clearance_mm", float, "clearance of the journal in its bush", POSITIVE)
GRID = Key(
    "grid",
    tuple[int, int],
    f"cells around and along; at least {FEWEST_CELLS}, {MOST_CELLS} in all",
    default=(120, 40),
    shape={"prefixItems": [{"type": "integer", "minimum": fewest} for fewest in FEWEST_CELLS]},
)
OF_FEEDS = (
    Key(
        "supply_pressure_bar", float, "pressure of the oil supplied, above the ambient's", NOT_NEGATIVE, None
    ),
    Key(
        "eccentricity_ratios",
        tuple[float, ...],
        "eccentricity ratios at which load, flow, powers, stiffness and damping are listed too",
        UP_TO_ONE,
        (),
    ),
)
HYDRODYNAMIC = _form(
    "hydrodynamic",
    DIAMETER,
    LENGTH,
    CLEARANCE,
    *_viscosity("viscosity_Pa_s", "dynamic"),
    Key("load_N", float, "steady; or `eccentricity_ratio`, or a `[history]` alone", NOT_NEGATIVE, None),
    Key("eccentricity_ratio", float, "in place of the load; with petroff beside it", UP_TO_ONE, None),
    Key("attitude_deg", float, 'angle from load to line of centres, with "petroff" only', default=None),
    Key("solver", Solver, "model of the film", default="reynolds"),
    Key(
        "boundary",
        Boundary,
        "treatment of negative pressure",
        default=None,
        usual='"half" with ocvirk, else "reynolds"',
    ),
    GRID,
    *OF_FEEDS,
    Key(
        "supply",
        says="recess, groove or hole under pressure in the film",
        keys=SUPPLY_KEYS,
        many=True,
        default=None,
    ),
    Key("history", says="loads by angle, for the journal's orbit", keys=HISTORY_KEYS, default=None),
)


def _fed(kind: str) -> tuple[Key, ...]:
    return _form(
        kind,
        DIAMETER,
        LENGTH,
        CLEARANCE,
        *_viscosity("viscosity_Pa_s", "dynamic"),
        Key("load_N", float, "steady load; or `eccentricity_ratio`", NOT_NEGATIVE, None),
        Key("eccentricity_ratio", float, "in place of the load", UP_TO_ONE, None),
        Key("boundary", Boundary, "treatment of negative pressure", default="reynolds"),
        GRID,
        *OF_FEEDS,
        Key("supply", says="recess, groove or hole under pressure", keys=SUPPLY_KEYS, many=True),
        speed=NOT_NEGATIVE,
    )


PALMGREN_KEYS = (
    Key("f0", float, "palmgren: constant of the part without load", NOT_NEGATIVE),
    Key("f1", float, "palmgren: constant of the part with load", NOT_NEGATIVE, 0.0),
)
SKF_KEYS = (
    Key("r1", float, "skf: rolling constant R₁", NOT_NEGATIVE),
    Key("s1", float, "skf: sliding constant S₁", NOT_NEGATIVE),
    Key("bore_mm", float, "skf: bore d", POSITIVE),
    Key("outer_mm", float, "skf: outer diameter D", POSITIVE),
    Key("mu_bl", float, "skf: sliding coefficient of the boundary film", NOT_NEGATIVE, 0.15),
    Key("mu_ehl", float, "skf: sliding coefficient of the full film", NOT_NEGATIVE, 0.05),
    Key("k_rs", float, "skf: starvation constant", NOT_NEGATIVE, 6e-8),
    Key("k_z", float, "skf: geometry constant", NOT_NEGATIVE, 3.1),
    Key("seal_N_mm", float, "skf: moment of the seals", NOT_NEGATIVE, 0.0),
    Key("drag_N_mm", float, "skf: moment of oil drag", NOT_NEGATIVE, 0.0),
)


def _rolling(model: Key, constants: tuple[Key, ...]) -> tuple[Key, ...]:
    return _form(
        "rolling",
        model,
        Key("mean_diameter_mm", float, "(d + D)/2", POSITIVE),
        *_viscosity("kinematic_viscosity_mm2_s", "kinematic"),
        Key("load_N", float, "radial, on each", NOT_NEGATIVE),
        Key("count", int, "number of equal bearings", COUNTED, 1),
        *constants,
    )


SQUEEZE_FILM = _form(
    "squeeze_film",
    *_viscosity("viscosity_Pa_s", "dynamic"),
    Key("load_N", float, "load on the plates", NOT_NEGATIVE),
    Key("film_mm", float, "thickness of the film", POSITIVE),
    Key("length_mm", float, "length of the plates", POSITIVE),
    Key("width_mm", float, "width of the plates", POSITIVE),
)
BEARING_FORMS: Mapping[str, tuple[Key, ...]] = {
    "dry": DRY,
    "hydrodynamic": HYDRODYNAMIC,
    "hydrostatic": _fed("hydrostatic"),
    "hybrid": _fed("hybrid"),
    "rolling": _rolling(
        Key("model", Literal["palmgren"], "method for the friction", default="palmgren"), PALMGREN_KEYS
    ),
    "rolling, skf": _rolling(Key("model", Literal["skf"], "method for the friction"), SKF_KEYS),
    "squeeze_film": SQUEEZE_FILM,
}
"""Form of the file → all that may be at its top level."""


def form_of(raw: Mapping[str, Any]) -> tuple[Key, ...]:
    """Return the keys of the form that a file's kind and model name; by default the first."""
    name = str(raw.get("kind"))
    return BEARING_FORMS.get(f"{name}, {raw.get('model')}", BEARING_FORMS.get(name, DRY))
