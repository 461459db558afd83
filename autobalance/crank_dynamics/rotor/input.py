"""Read a rotor file: shaft, discs, bearings, unbalances and questions about them; SI units out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from autobalance.crank_dynamics.rotor import beam_rotor
from autobalance.declare import (
    ANY,
    COUNTED,
    MM,
    NOT_NEGATIVE,
    POSITIVE,
    RPM,
    Key,
    Large,
    Range,
    Values,
    keys_of,
    made,
)
from autobalance.engines.bearings.film import JournalBearing, film_coefficients
from autobalance.engines.bearings.reynolds import ocvirk, reynolds
from autobalance.errors import JobError
from autobalance.toml_files.keys import read_document
from autobalance.types import Array
from autobalance.units import M_PER_MM, RAD_S_PER_RPM, STEEL_KG_M3
from autobalance.value_classes import dataclass

# An oil film as a rotor's bearing: its stiffness and damping over the requested speeds.


TABLE_SPEEDS = 33
"""Speeds of the table; linear between them."""
MIN_SPEED_SHARE = 0.02
"""Share of the highest speed below which the coefficients stay: a film at rest has no stiffness."""
SPEED_MULTIPLE = 10.0
"""Highest speed of the table over a single requested one, for critical speeds."""


def film_bearing(place: str, z_m: float, values: Mapping[str, Any], asked_rad_s: Array) -> beam_rotor.Bearing:
    """Return the bearing of a film under a steady load.

    Raises
    ------
    JobError
        If there is no load or no speed, or the journal touches at a speed that is asked about.
    """
    load = values["load_N"]
    if not any(load):
        raise JobError(f"{place}.load_N is [0, 0]; a film without load has no direction")
    top = float(asked_rad_s[-1]) * (SPEED_MULTIPLE if len(asked_rad_s) == 1 else 1.0)
    if top <= 0.0:
        raise JobError(f"{place} needs a speed_rpm above 0; a film carries nothing at rest")
    speeds = np.geomspace(MIN_SPEED_SHARE * top, top, TABLE_SPEEDS)
    journal = JournalBearing(
        *(M_PER_MM * values[k] for k in ("diameter_mm", "length_mm", "radial_clearance_mm"))
    )
    slenderness = journal.slenderness
    model = ocvirk(slenderness) if values["solver"] == "ocvirk" else reynolds(slenderness)
    table = film_coefficients(journal, model, values["viscosity_Pa_s"], speeds, load)
    carried = np.isfinite(table.stiffness_N_m).all(axis=(1, 2))
    if not carried.any() or speeds[carried][0] > max(float(asked_rad_s[0]), MIN_SPEED_SHARE * top):
        rpm = float(speeds[~carried][-1]) / RAD_S_PER_RPM
        raise JobError(f"{place}: the journal touches the bearing at {rpm:.4g} rpm and below; ask above it")
    return beam_rotor.Bearing(
        z_m, None, speeds[carried], table.stiffness_N_m[carried], table.damping_N_s_m[carried]
    )


# Bearings of a rotor file: linear ones, tables over the speed, oil films.


PerSpeed = Large | tuple[Large, ...]
STIFFNESS = ("kxx_n_m", "kxy_n_m", "kyx_n_m", "kyy_n_m")
DAMPING = ("cxx_n_s_m", "cxy_n_s_m", "cyx_n_s_m", "cyy_n_s_m")
LINEAR = ("k_n_m", *STIFFNESS, "c_n_s_m", *DAMPING)
FILM = (
    Key("diameter_mm", float, "journal's diameter", POSITIVE),
    Key("length_mm", float, "bearing's length", POSITIVE),
    Key("radial_clearance_mm", float, "radial", POSITIVE),
    Key("viscosity_Pa_s", float, "dynamic", POSITIVE),
    Key("load_N", tuple[float, float], "force of the journal on the bearing along x and y"),
    Key("solver", Literal["ocvirk", "reynolds"], "as in `bearing`", ANY, "reynolds"),
)
BEARING = (
    Key("z_mm", float, "place on the shaft, from its start"),
    Key("film", says="an oil film, its coefficients over the speed", keys=FILM, default=None),
    Key("kind", Literal["pinned", "clamped"], "a rigid support, instead of a stiffness", ANY, None),
    *(Key(name, PerSpeed, "one number, or one for each of speeds_rpm", ANY, None) for name in LINEAR),
    Key("speeds_rpm", tuple[float, ...], "speeds of a table; linear between them", NOT_NEGATIVE, None),
    Key("allow_negative", bool, "whether a direct stiffness may be negative", ANY, False),
)


def read_bearing(place: str, table: Values, asked_rad_s: Array) -> beam_rotor.Bearing:
    """Return a support, with coefficients at the requested speeds."""
    z_m = table["z_mm"] * M_PER_MM
    linear = [key for key in (*LINEAR, "speeds_rpm") if table[key] is not None]
    if table["film"] is not None:
        other = [*linear, *(["kind"] if table["kind"] is not None else [])]
        if other:
            raise JobError(f"{place}.{other[0]} is given, but the film supplies it; remove one")
        return film_bearing(f"{place}.film", z_m, table["film"], asked_rad_s)
    if table["kind"] is not None:
        if linear:
            raise JobError(f'{place}.{linear[0]} is given, but a "{table["kind"]}" bearing does not give')
        return beam_rotor.rigid_bearing(z_m, table["kind"])
    if not set(linear) - {"speeds_rpm"}:
        raise JobError(f'{place}.k_n_m is missing; or kxx_n_m and kyy_n_m, or kind = "pinned"')
    speeds = _table_speeds(place, table["speeds_rpm"])
    stiffness = _both(place, table, "k_n_m", STIFFNESS, len(speeds))
    damping = _both(place, table, "c_n_s_m", DAMPING, len(speeds))
    if not table["allow_negative"]:
        for key, values in (("xx", stiffness[:, 0, 0]), ("yy", stiffness[:, 1, 1])):
            if (values < 0.0).any():
                name = "k_n_m" if table["k_n_m"] is not None else f"k{key}_n_m"
                raise JobError(f"{place}.{name} is {values.min():g}; must be ≥ 0, or allow_negative = true")
    return beam_rotor.Bearing(z_m, None, speeds * RAD_S_PER_RPM, stiffness, damping)


def _table_speeds(place: str, speeds: tuple[float, ...] | None) -> Array:
    if speeds is None:
        return np.zeros(1)
    if len(speeds) < 2 or not all(a < b for a, b in pairwise(speeds)):
        raise JobError(f"{place}.speeds_rpm must be at least two speeds that ascend")
    return np.array(speeds)


def _both(place: str, values: Values, one: str, four: tuple[str, ...], count: int) -> Array:
    """Return a matrix (count, 2, 2) that is given by one number for both directions, or by its entries."""
    present = [key for key in four if values[key] is not None]
    if values[one] is not None and present:
        raise JobError(f"{place}.{one} and {present[0]} are both given; which is meant?")
    for key in (four[0], four[3]):
        if present and values[key] is None:
            raise JobError(f"{place}.{key} is missing; {present[0]} needs {four[0]} and {four[3]}")
    names = [one, None, None, one] if not present else list(four)
    columns = [_column(place, name, None if name is None else values[name], count) for name in names]
    return np.stack(columns, axis=1).reshape(count, 2, 2)


def _column(place: str, name: str | None, entry: float | tuple[float, ...] | None, count: int) -> Array:
    if entry is None:
        return np.zeros(count)
    if not isinstance(entry, tuple):
        return np.full(count, entry)
    if count == 1:
        raise JobError(f"{place}.{name} is a list; it needs speeds_rpm, one for each")
    if len(entry) != count:
        raise JobError(
            f"{place}.{name} has {len(entry)} entries; must be {count}, one for each of speeds_rpm"
        )
    return np.array(entry)


# Read a rotor file: shaft, discs, bearings, unbalances and questions about them; SI units out.


PA_PER_GPA = 1e9
Speeds = float | tuple[float, float]

POISSON = Range("must be over -1 and at most 0.5", above=-1.0, most=0.5)
POINTS = Range("must be 2 to 100000", least=2, most=100000)
MODES = Range("must be 1 to 200", least=1, most=200)
STEEPEST, WIDEST, SLENDEREST = 20.0, 200.0, 2000.0
"""Ratios of diameters in a cone and in a shaft, and of length to diameter, that beams can be requested."""
SPEED = Range("must be ≥ 0 and at most 1e6", least=0.0, most=1e6)
ELEMENTS = Range("must be 0 (as many as needed) to 2000", least=0, most=2000)

SHAFT = (
    Key("length_mm", float, "length of the section", POSITIVE),
    Key("outer_mm", float, "outer diameter, at the start of a cone", POSITIVE),
    Key("inner_mm", float, "inner diameter", NOT_NEGATIVE, 0.0),
    Key("outer_end_mm", float, "outer diameter at the end; default: the same", POSITIVE, None),
    Key("inner_end_mm", float, "inner diameter at the end; default: the same", NOT_NEGATIVE, None),
    Key("e_gpa", float, "Young's modulus", POSITIVE, 210.0),
    Key("nu", float, "Poisson's ratio; default 0.3, or what g_gpa makes it", POISSON, None),
    Key("g_gpa", float, "shear modulus, instead of nu", POSITIVE, None),
    Key("density_kg_m3", float, "density", POSITIVE, STEEL_KG_M3),
    Key("shear_factor", float, "Timoshenko's shear factor; 0: Cowper's", NOT_NEGATIVE, 0.0),
    Key("elements", int, "classical elements; 0: as many as 1e-5 of a frequency needs", ELEMENTS, 0),
)


@dataclass(frozen=True)
class Balancing:
    """Planes for added unbalance, and modes to be left without excitation."""

    planes_m: Annotated[tuple[float, ...], MM, "correction planes"]
    modes: Annotated[int, COUNTED, "number of the lowest planar modes"] = 1
    rigid: Annotated[bool, "whether resultant and moment vanish too (N + 2)"] = False


@dataclass(frozen=True)
class StiffnessMap:
    """Range of a bearing stiffness that all bearings shall have in turn."""

    k_n_m: Annotated[tuple[Large, Large], POSITIVE, "range of the stiffness of all bearings"]
    points: Annotated[int, POINTS, "stiffnesses in the range"] = 31


@dataclass(frozen=True, kw_only=True)
class RunUp:
    """A run from one speed to another at constant acceleration."""

    from_rad_s: Annotated[float, RPM, NOT_NEGATIVE, "first speed"] = 0.0
    to_rad_s: Annotated[float, RPM, POSITIVE, "last speed"]
    time_s: Annotated[float, POSITIVE, "duration"]
    points: Annotated[int, POINTS, "times in the result"] = 2001


@dataclass(frozen=True)
class Probe:
    """A place where motion is computed."""

    z_m: beam_rotor.Place


ROTOR = (
    Key("speed_rpm", Speeds, "a speed, or the lowest and highest", SPEED, 3000.0),
    Key("points", int, "speeds in a range", POINTS, 101),
    Key("beam", beam_rotor.BeamTheory, "theory of the shaft", ANY, "timoshenko"),
    Key("gravity_m_s2", tuple[float, float], "along x and y", ANY, (0.0, 0.0)),
    Key("max_modes", int, "modes listed at each speed", MODES, 12),
    Key("shaft", says="sections on end, from z = 0", keys=SHAFT, many=True),
    Key("disc", says="rigid discs", keys=keys_of(beam_rotor.Disc), many=True, default=()),
    Key("bearing", says="supports", keys=BEARING, many=True, default=()),
    Key("unbalance", says="heavy spots", keys=keys_of(beam_rotor.PointUnbalance), many=True, default=()),
    Key(
        "probe",
        says="stations for which motion is computed; default: every disc and bearing",
        keys=keys_of(Probe),
        many=True,
        default=(),
    ),
    Key("balancing", says="modal balancing", keys=keys_of(Balancing), default=None),
    Key(
        "stiffness_map",
        says="undamped critical speeds over bearing stiffness",
        keys=keys_of(StiffnessMap),
        default=None,
    ),
    Key("run_up", says="a run through critical speeds in time", keys=keys_of(RunUp), default=None),
)
"""Every key of a rotor file."""


@dataclass(frozen=True, eq=False)
class RotorRequest:
    """A rotor and the questions about it; ``filled`` is the file as read, defaults filled in."""

    rotor: beam_rotor.BeamRotor
    speeds_rad_s: Array
    max_modes: int
    probes_m: tuple[float, ...]
    balancing: Balancing | None
    stiffness_map: StiffnessMap | None
    run_up: RunUp | None
    filled: dict[str, Any]


def read_rotor(source: str | Path | Mapping[str, Any]) -> RotorRequest:
    """Read a rotor file, or a dict of its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    return read_document(source, "rotor", ROTOR, _request)


def _request(filled: Values) -> RotorRequest:
    speeds = _speeds(filled)
    for number, values in enumerate(filled["shaft"], 1):
        _complete_section(f"shaft[{number}]", values)
    length_mm = sum(each["length_mm"] for each in filled["shaft"])
    for name in ("disc", "bearing", "unbalance", "probe"):
        for number, values in enumerate(filled[name], 1):
            _check_place(f"{name}[{number}].z_mm", values["z_mm"], length_mm)
    _check_proportions(filled["shaft"])
    rotor = beam_rotor.BeamRotor(
        tuple(_section(each) for each in filled["shaft"]),
        tuple(made(beam_rotor.Disc, each) for each in filled["disc"]),
        tuple(read_bearing(f"bearing[{n}]", each, speeds) for n, each in enumerate(filled["bearing"], 1)),
        tuple(made(beam_rotor.PointUnbalance, each) for each in filled["unbalance"]),
        filled["beam"],
        filled["gravity_m_s2"],
    )
    if not filled["probe"]:
        places = dict.fromkeys(each["z_mm"] for each in (*filled["disc"], *filled["bearing"]))
        filled["probe"] = [{"z_mm": z} for z in places]
    return RotorRequest(
        rotor,
        speeds,
        filled["max_modes"],
        tuple(M_PER_MM * each["z_mm"] for each in filled["probe"]),
        _balancing(filled["balancing"], length_mm),
        _stiffness_map(filled),
        _run_up(filled["run_up"]),
        filled,
    )


def _check_proportions(sections: Sequence[Values]) -> None:
    """Refuse an impossible shaft: beam elements would be divided without end, or lose all digits."""
    for number, each in enumerate(sections, 1):
        thick, thin = (pick(each["outer_mm"], each["outer_end_mm"]) for pick in (max, min))
        if thick > STEEPEST * thin:
            raise JobError(
                f"shaft[{number}] tapers from {thick:g} to {thin:g} mm; "
                f"a cone may taper by {STEEPEST:g} at most"
            )
    ends = [each[f"outer{end}"] for each in sections for end in ("_mm", "_end_mm")]
    length_mm = sum(each["length_mm"] for each in sections)
    if max(ends) > WIDEST * min(ends):
        raise JobError(
            f"[[shaft]]: outer diameters are from {min(ends):g} to {max(ends):g} mm; the largest may be "
            f"{WIDEST:g} times the smallest at most"
        )
    if length_mm > SLENDEREST * min(ends):
        raise JobError(
            f"[[shaft]]: {length_mm:g} mm long and {min(ends):g} mm thick; "
            f"a shaft may be {SLENDEREST:g} times as long as thick at most"
        )


def _speeds(top: Mapping[str, Any]) -> Array:
    speed = top["speed_rpm"]
    if not isinstance(speed, tuple):
        return np.array([speed * RAD_S_PER_RPM])
    if not speed[0] < speed[1]:
        raise JobError(f"speed_rpm is [{speed[0]:g}, {speed[1]:g}]; the first must be the lower one")
    return np.asarray(np.linspace(speed[0], speed[1], top["points"]) * RAD_S_PER_RPM)


def _complete_section(place: str, values: Values) -> None:
    """Fill in a section's end diameters, and refuse impossible ones."""
    for name in ("outer", "inner"):
        if values[f"{name}_end_mm"] is None:
            values[f"{name}_end_mm"] = values[f"{name}_mm"]
    for end in ("_mm", "_end_mm"):
        if values["inner" + end] >= values["outer" + end]:
            raise JobError(
                f"{place}.inner{end} is {values['inner' + end]:g}; "
                f"must be less than the outer diameter, {values['outer' + end]:g}"
            )
    if values["g_gpa"] is None:
        values["nu"] = 0.3 if values["nu"] is None else values["nu"]
        values["g_gpa"] = values["e_gpa"] / (2.0 * (1.0 + values["nu"]))
    elif values["nu"] is not None:
        raise JobError(f"{place}.nu and g_gpa are both given; one follows from the other")
    else:
        values["nu"] = poisson = values["e_gpa"] / (2.0 * values["g_gpa"]) - 1.0
        if not -1.0 < poisson <= 0.5 + 1e-9:
            raise JobError(
                f"{place}.g_gpa is {values['g_gpa']:g}; with e_gpa {values['e_gpa']:g} Poisson's ratio "
                f"would be {values['nu']:.3g}, must be over -1 and at most 0.5"
            )


def _section(values: Mapping[str, Any]) -> beam_rotor.ShaftSection:
    return beam_rotor.ShaftSection(
        values["length_mm"] * M_PER_MM,
        values["outer_mm"] * M_PER_MM,
        values["outer_end_mm"] * M_PER_MM,
        values["inner_mm"] * M_PER_MM,
        values["inner_end_mm"] * M_PER_MM,
        values["e_gpa"] * PA_PER_GPA,
        values["g_gpa"] * PA_PER_GPA,
        values["density_kg_m3"],
        values["shear_factor"],
        values["elements"],
    )


# --- places and the other tables ----------------------------------------------------------------------------


def _check_place(place: str, z_mm: float, length_mm: float) -> None:
    if not -1e-9 * length_mm <= z_mm <= length_mm * (1.0 + 1e-9):
        raise JobError(f"{place} is {z_mm:g}; must lie on the shaft, 0 to {length_mm:g}")


def _balancing(values: Values | None, length_mm: float) -> Balancing | None:
    if values is None:
        return None
    if not values["planes_mm"]:
        raise JobError("balancing.planes_mm is an empty list; name at least one plane")
    for z_mm in values["planes_mm"]:
        _check_place("balancing.planes_mm", z_mm, length_mm)
    return made(Balancing, values)


def _stiffness_map(filled: Values) -> StiffnessMap | None:
    values = filled["stiffness_map"]
    if values is None:
        return None
    low, high = values["k_n_m"]
    if not low < high:
        raise JobError(f"stiffness_map.k_n_m is [{low:g}, {high:g}]; the first must be the lower one")
    if all(each["kind"] is not None for each in filled["bearing"]):
        raise JobError("stiffness_map needs a [[bearing]] with a stiffness; none of those here gives")
    return made(StiffnessMap, values)


def _run_up(values: Values | None) -> RunUp | None:
    if values is None:
        return None
    if values["from_rpm"] == values["to_rpm"]:
        raise JobError("run_up.to_rpm is the speed it starts from; must be another")
    return made(RunUp, values)
