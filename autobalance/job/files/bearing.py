"""Read a bearing's TOML, strictly, and bring its numbers to SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from autobalance.bearings.cases import (
    Case,
    DryCase,
    History,
    Lubricant,
    PlainCase,
    PlatesCase,
    RollingCase,
    Solver,
)
from autobalance.bearings.film import JournalBearing
from autobalance.bearings.heat_balance import Supply
from autobalance.bearings.oil import Oil
from autobalance.bearings.reynolds import Boundary
from autobalance.bearings.rolling import FourSources, Palmgren, RollingBearing
from autobalance.errors import JobError
from autobalance.job.files.history import history_of_arrays, read_history
from autobalance.job.toml.document import text_of, toml_of
from autobalance.job.toml.table import Table
from autobalance.ranges import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, Rule
from autobalance.units import M_PER_MM, RAD_S_PER_RPM

Turns = Literal["ccw", "cw"]
Kind = Literal["dry", "hydrodynamic", "rolling", "squeeze_film"]
Given = str | Path | Mapping[str, Any] | None
"""A history in place of the one that a file names."""
MOST_SPEEDS = 10_000
FEWEST_CELLS = (8, 4)
MOST_CELLS = 100_000

OIL_KEYS = ("viscosity_mm2_s", "density_kg_m3", "temperature_C", "supply_C", "heat_capacity_J_kg_K")
HISTORY_KEYS = ("file", "x", "y", "bush_speed_rpm", "turns")
ROLLING_KEYS = {
    "palmgren": ("f0", "f1"),
    "skf": ("r1", "s1", "bore_mm", "outer_mm", "mu_bl", "mu_ehl", "k_rs", "k_z", "seal_N_mm", "drag_N_mm"),
}
KEYS: dict[str, tuple[str, ...]] = {
    "dry": ("diameter_mm", "load_N", "rotating_load_N", "mu", "torque_N_m"),
    "hydrodynamic": (
        "diameter_mm",
        "length_mm",
        "radial_clearance_mm",
        "viscosity_Pa_s",
        "load_N",
        "eccentricity_ratio",
        "attitude_deg",
        "solver",
        "boundary",
        "grid",
        "oil",
        "history",
    ),
    "rolling": ("model", "mean_diameter_mm", "kinematic_viscosity_mm2_s", "load_N", "count", "oil"),
    "squeeze_film": ("load_N", "film_mm", "viscosity_Pa_s", "length_mm", "width_mm", "oil"),
}
"""Keys of each kind besides ``kind`` and ``speed_rpm``; a rolling bearing's model adds its constants."""

OIL_POINTS = ((40.0, 100.0), (100.0, 11.0))
"""Of an oil that names none: an SAE 30."""
SERIES = {"file": "series.csv", "x": "main_1_x_N", "y": "main_1_y_N"}
"""File and columns of a history that names none."""

UP_TO_ONE = Rule("must be 0 to 1: the journal touches its bush at 1", least=0.0, most=1.0)
ABOVE_ZERO_KELVIN = Rule("must be above -273.15", above=-273.15)


@dataclass(frozen=True, eq=False)
class BearingFile:
    """A bearing as a file says it; ``described`` is the file with its defaults filled in."""

    kind: Kind
    speeds_rpm: tuple[float, ...]
    case: Case
    described: dict[str, Any]

    @property
    def speeds_rad_s(self) -> tuple[float, ...]:
        """Speeds [rad/s]."""
        return tuple(RAD_S_PER_RPM * speed for speed in self.speeds_rpm)


def load_bearing(path: str | Path, history: Given = None) -> BearingFile:
    """Read a bearing's file.

    Parameters
    ----------
    path : path
        A TOML file; the history it names is relative to it.
    history : path or mapping, optional
        In place of the one that the file names: a CSV file, or arrays (see ``ab.bearing``).

    Raises
    ------
    FileError
        If a file cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    path = Path(path)
    raw = toml_of(text_of(path, "bearing"), path.name)
    try:
        return parse_bearing(raw, path.parent, history)
    except JobError as error:
        raise JobError(f"{path.name}: {error}") from None


def parse_bearing(raw: Mapping[str, Any], folder: Path = Path(), history: Given = None) -> BearingFile:
    """Return the bearing that a TOML document says; its history's file is relative to ``folder``."""
    reader = _Reader(dict(raw), "", None)
    kind: Kind = reader.value("kind", Kind)
    known = ("kind", "speed_rpm", *KEYS[kind])
    if kind == "rolling":
        known += ROLLING_KEYS[reader.value("model", Literal["palmgren", "skf"], default="palmgren")]
    Table(reader.table.raw, "", known)
    speeds = reader.value("speed_rpm", float | tuple[float, ...], POSITIVE, 3000.0)
    speeds = speeds if isinstance(speeds, tuple) else (speeds,)
    if not 1 <= len(speeds) <= MOST_SPEEDS:
        raise JobError(f"speed_rpm has {len(speeds)} entries; must have 1 to {MOST_SPEEDS}")
    case = _case(kind, reader)
    if isinstance(case, PlainCase):
        case = _with_history(case, reader, folder, history)
    elif history is not None:
        raise JobError(f'a history is given, but kind is "{kind}"; only "hydrodynamic" has a film to follow')
    return BearingFile(kind, speeds, case, reader.described)


def _case(kind: Kind, reader: _Reader) -> Case:
    if kind == "dry":
        return _dry(reader)
    if kind == "rolling":
        return _rolling(reader)
    return _plates(reader) if kind == "squeeze_film" else _plain(reader)


class _Reader:
    """A table that notes what it was asked for, so that the report can list the file with its defaults."""

    def __init__(self, raw: object, path: str, known: tuple[str, ...] | None) -> None:
        self.table = Table(raw, path, known)
        self.described: dict[str, Any] = dict(self.table.raw)

    def __contains__(self, key: str) -> bool:
        return key in self.table

    def value(self, key: str, hint: Any, rule: Rule = ANY, default: Any = ...) -> Any:
        """Return a value; required where no default is given."""
        if key in self.table or default is ...:
            return self.table.value(key, hint, rule)
        self.described[key] = _listed(default)
        return default

    def inner(self, key: str, known: tuple[str, ...]) -> _Reader:
        """Return a table inside this one."""
        reader = _Reader(self.table.raw[key], self.table.place(key), known)
        self.described[key] = reader.described
        return reader


def _listed(value: Any) -> Any:
    """Return tuples as the lists of a file."""
    return [_listed(item) for item in value] if isinstance(value, tuple) else value


def _dry(reader: _Reader) -> DryCase:
    case = DryCase(
        reader.value("diameter_mm", float, POSITIVE) * M_PER_MM,
        reader.value("load_N", float, NOT_NEGATIVE),
        reader.value("rotating_load_N", float, NOT_NEGATIVE, 0.0),
        reader.value("mu", float, NOT_NEGATIVE, None),
        reader.value("torque_N_m", float, NOT_NEGATIVE, None),
    )
    if (case.mu is None) == (case.torque_N_m is None):
        fault = "mu is missing" if case.mu is None else "mu and torque_N_m are both given"
        raise JobError(f"{fault}; a dry bearing needs either mu, or torque_N_m to find it from")
    if case.torque_N_m is not None and not case.load_N + case.rotating_load_N > 0.0:
        raise JobError("load_N is 0; must be > 0 to find mu from torque_N_m")
    return case


def _plain(reader: _Reader) -> PlainCase:
    bearing = JournalBearing(
        reader.value("diameter_mm", float, POSITIVE) * M_PER_MM,
        reader.value("length_mm", float, POSITIVE) * M_PER_MM,
        reader.value("radial_clearance_mm", float, POSITIVE) * M_PER_MM,
    )
    if not bearing.clearance_m < bearing.radius_m:
        clearance = bearing.clearance_m / M_PER_MM
        raise JobError(f"radial_clearance_mm is {clearance:g}; must be less than half of diameter_mm")
    solver: Solver = reader.value("solver", Solver, default="reynolds")
    load = reader.value("load_N", float, NOT_NEGATIVE, None)
    ratio = reader.value("eccentricity_ratio", float, UP_TO_ONE, None)
    if solver != "petroff" and load is not None and ratio is not None:
        raise JobError(
            "load_N and eccentricity_ratio are both given; each follows from the other: leave one out"
        )
    if solver != "petroff" and "attitude_deg" in reader:
        raise JobError(f'attitude_deg is given, but solver is "{solver}", which finds it; leave it out')
    lubricant = _lubricant(reader, "viscosity_Pa_s")
    if lubricant.supply is not None and (load is None or solver == "petroff"):
        raise JobError("oil.supply_C needs load_N and a solver of the film to balance its heat")
    return PlainCase(
        bearing,
        lubricant,
        solver,
        _boundary(reader, solver),
        _grid(reader),
        load,
        ratio,
        math.radians(reader.value("attitude_deg", float, ANY, 0.0 if solver == "petroff" else None) or 0.0),
        None,
    )


def _boundary(reader: _Reader, solver: Solver) -> Boundary:
    boundary: Boundary = reader.value(
        "boundary", Boundary, default="half" if solver == "ocvirk" else "reynolds"
    )
    if solver == "ocvirk" and boundary != "half":
        raise JobError(f'boundary is "{boundary}"; solver "ocvirk" has "half" only')
    return boundary


def _grid(reader: _Reader) -> tuple[int, int]:
    around, along = reader.value("grid", tuple[int, int], ANY, (120, 40))
    for name, cells, fewest in zip(("around", "along"), (around, along), FEWEST_CELLS, strict=True):
        if cells < fewest:
            raise JobError(f"grid has {cells} cells {name}; must have at least {fewest}")
    if around * along > MOST_CELLS:
        raise JobError(f"grid has {around * along} cells; must have at most {MOST_CELLS}")
    return around, along


def _lubricant(reader: _Reader, key: str, heats: bool = True) -> Lubricant:
    """Return the viscosity that ``key`` gives, or the oil of [oil]; ``heats``: a film that may balance it."""
    if "oil" not in reader:
        if key not in reader:
            raise JobError(f"{key} is missing; give it, must be > 0, or an [oil] table")
        value = reader.value(key, float, POSITIVE)
        return Lubricant(value, None) if key == "viscosity_Pa_s" else Lubricant(None, value)
    if key in reader:
        raise JobError(f"{key} and [oil] are both given; the viscosity must come from one of them")
    reader.described[key] = None
    table = reader.inner("oil", OIL_KEYS)
    points = table.value("viscosity_mm2_s", tuple[tuple[float, float], tuple[float, float]], ANY, OIL_POINTS)
    density = table.value("density_kg_m3", float, POSITIVE, 860.0)
    try:
        oil = Oil.of_points(points, density)
    except ValueError as error:
        raise JobError(f"oil.viscosity_mm2_s: {error}") from None
    if "supply_C" not in table:
        celsius = table.value("temperature_C", float, ABOVE_ZERO_KELVIN)
        _flows(oil, celsius, "oil.temperature_C")
        return Lubricant(oil=oil, celsius=celsius)
    if "temperature_C" in table:
        raise JobError(
            "oil.temperature_C and oil.supply_C are both given; the supply's heat balance finds it"
        )
    if not heats:
        raise JobError(
            'oil.supply_C is given; only a "hydrodynamic" film balances its heat: give temperature_C'
        )
    supply = table.value("supply_C", float, ABOVE_ZERO_KELVIN)
    _flows(oil, supply, "oil.supply_C")
    heat = table.value("heat_capacity_J_kg_K", float, POSITIVE, 2000.0)
    return Lubricant(oil=oil, supply=Supply(supply, heat))


def _flows(oil: Oil, celsius: float, where: str) -> None:
    """Refuse a temperature at which the law gives no viscosity."""
    try:
        flows = 0.0 < oil.kinematic_mm2_s(celsius) < math.inf
    except OverflowError:
        flows = False
    if not flows:
        raise JobError(f"{where} is {celsius:g}; the oil of viscosity_mm2_s has no viscosity there")


def _with_history(case: PlainCase, reader: _Reader, folder: Path, source: Given) -> PlainCase:
    """Add the history, and see that there is some load."""
    if "history" in reader or source is not None:
        return replace(case, history=_history(reader, folder, source))
    if case.solver != "petroff" and case.load_N is None and case.eccentricity_ratio is None:
        raise JobError("load_N is missing; a film needs load_N, eccentricity_ratio or a [history] of loads")
    return case


def _history(reader: _Reader, folder: Path, source: Given) -> History:
    table = reader.inner("history", HISTORY_KEYS) if "history" in reader else _Reader({}, "history", ())
    turns = table.value("turns", Turns, default="ccw")
    return replace(_forces(table, folder, source), clockwise=turns == "cw")


def _forces(table: _Reader, folder: Path, source: Given) -> History:
    bush = table.value("bush_speed_rpm", float, ANY, 0.0) * RAD_S_PER_RPM
    if isinstance(source, Mapping):
        return history_of_arrays(source, bush)
    if source is not None:
        columns = table.value("x", str, default="x_N"), table.value("y", str, default="y_N")
        return read_history(Path(source), *columns, bush)
    file, x, y = (table.value(key, str, default=usual) for key, usual in SERIES.items())
    return read_history(folder / file, x, y, bush)


def _rolling(reader: _Reader) -> RollingCase:
    model = reader.value("model", str, default="palmgren")
    bearing = RollingBearing(
        reader.value("mean_diameter_mm", float, POSITIVE),
        _palmgren(reader) if model == "palmgren" else _four_sources(reader),
    )
    return RollingCase(
        bearing,
        _lubricant(reader, "kinematic_viscosity_mm2_s", heats=False),
        reader.value("load_N", float, NOT_NEGATIVE),
        reader.value("count", int, COUNTED, 1),
    )


def _palmgren(reader: _Reader) -> Palmgren:
    return Palmgren(reader.value("f0", float, NOT_NEGATIVE), reader.value("f1", float, NOT_NEGATIVE, 0.0))


def _four_sources(reader: _Reader) -> FourSources:
    model = FourSources(
        reader.value("r1", float, NOT_NEGATIVE),
        reader.value("s1", float, NOT_NEGATIVE),
        reader.value("bore_mm", float, POSITIVE),
        reader.value("outer_mm", float, POSITIVE),
        reader.value("mu_bl", float, NOT_NEGATIVE, 0.15),
        reader.value("mu_ehl", float, NOT_NEGATIVE, 0.05),
        reader.value("k_rs", float, NOT_NEGATIVE, 6e-8),
        reader.value("k_z", float, NOT_NEGATIVE, 3.1),
        reader.value("seal_N_mm", float, NOT_NEGATIVE, 0.0),
        reader.value("drag_N_mm", float, NOT_NEGATIVE, 0.0),
    )
    if not model.bore_mm < model.outer_mm:
        raise JobError(f"bore_mm is {model.bore_mm:g}; must be less than outer_mm, {model.outer_mm:g}")
    return model


def _plates(reader: _Reader) -> PlatesCase:
    return PlatesCase(
        _lubricant(reader, "viscosity_Pa_s", heats=False),
        reader.value("load_N", float, NOT_NEGATIVE),
        reader.value("film_mm", float, POSITIVE) * M_PER_MM,
        reader.value("length_mm", float, POSITIVE) * M_PER_MM,
        reader.value("width_mm", float, POSITIVE) * M_PER_MM,
    )
