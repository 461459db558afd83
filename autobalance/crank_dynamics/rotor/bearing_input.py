"""Bearings of a rotor file: linear ones, tables over the speed, oil films."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np

from autobalance.crank_dynamics.rotor.beam_rotor import (
    Bearing,
    rigid_bearing,
)
from autobalance.crank_dynamics.rotor.film_bearing import film_bearing
from autobalance.declare import ANY, NOT_NEGATIVE, POSITIVE, Key, Large, Values
from autobalance.errors import JobError
from autobalance.types import Array
from autobalance.units import M_PER_MM, RAD_S_PER_RPM

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


def read_bearing(place: str, table: Values, asked_rad_s: Array) -> Bearing:
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
        return rigid_bearing(z_m, table["kind"])
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
    return Bearing(z_m, None, speeds * RAD_S_PER_RPM, stiffness, damping)


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
