"""Read a bearing's file: its case, its loads over a cycle."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from autobalance.declare import Values, names
from autobalance.engines.bearings import keys
from autobalance.engines.bearings.cases import (
    Case,
    DryCase,
    History,
    Lubricant,
    PlainCase,
    PlatesCase,
    RollingCase,
    Solver,
    Supply,
)
from autobalance.engines.bearings.film import JournalBearing
from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.bearings.rolling import FourSources, Palmgren, RollingBearing
from autobalance.errors import JobError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.toml_files.document import text_of, toml_of
from autobalance.toml_files.keys import plain, read
from autobalance.toml_files.table import Table, did_you_mean
from autobalance.toml_files.typed_units import in_base_units
from autobalance.types import Array
from autobalance.units import M_PER_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

# Forces on a bearing through a cycle, from a table of angles: a CSV file or arrays.


ANGLE = "angle_deg"
LARGEST_BYTES = 1 << 27
FEWEST_ROWS = 8
WIDEST_GAP_DEG = 10.0
EVEN_SHARE = 1e-3
"""Share of a step by which rows may be off equal steps and still count as such."""
STEP_DEG = 0.5
"""Number of rows to which uneven ones are resampled."""


def read_history(path: Path, x_column: str, y_column: str, bush_speed_rad_s: float = 0.0) -> History:
    """Return the forces by angle of a CSV file with a header, as ``cycle --series`` writes it.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a column is missing, a cell is not a number, or the angles are not those of whole turns.
    """
    with file_errors(f"read the history {path}"):
        if path.stat().st_size > LARGEST_BYTES:
            raise JobError(f"{path.name} is larger than {LARGEST_BYTES} bytes; is it a series?")
        refuse_pipe(path)
        note_read(path)
        text = path.read_text("utf-8-sig")
    rows = csv.reader(text.splitlines())
    header = [name.strip() for name in next(rows, [])]
    places = [_column(header, name, path.name) for name in (ANGLE, x_column, y_column)]
    table = [_numbers(row, places, header, rows.line_num, path.name) for row in rows if any(row)]
    values = np.array(table, dtype=np.float64).reshape(-1, 3)
    return history_of(values[:, 0], values[:, 1], values[:, 2], bush_speed_rad_s, path.name)


def history_of_arrays(arrays: Mapping[str, npt.ArrayLike], bush_speed_rad_s: float = 0.0) -> History:
    """Return the forces by angle of arrays ``angle_deg``, ``x_N`` and ``y_N``, each (n,)."""
    names = (ANGLE, "x_N", "y_N")
    unknown = [name for name in arrays if name not in names]
    missing = [name for name in names if name not in arrays]
    if unknown or missing:
        present = ", ".join(map(str, arrays))
        raise JobError(f"history holds {present or 'nothing'}; must hold {', '.join(names)}")
    columns = [np.asarray(arrays[name], dtype=np.float64) for name in names]
    if any(column.ndim != 1 or len(column) != len(columns[0]) for column in columns):
        raise JobError("history's arrays differ in length; must be three lists of one length")
    if not all(np.isfinite(column).all() for column in columns):
        raise JobError("history holds a number that is not finite")
    return history_of(columns[0], columns[1], columns[2], bush_speed_rad_s, "history")


def history_of(angle_deg: Array, x_N: Array, y_N: Array, bush_speed_rad_s: float, name: str) -> History:
    """Return forces over equal steps of one cycle; ``name`` is their source.

    Raises
    ------
    JobError
        If there are too few rows, the angle does not rise, or the rows leave a gap.
    """
    if len(angle_deg) < FEWEST_ROWS:
        raise JobError(f"{name} has {len(angle_deg)} rows; must have at least {FEWEST_ROWS}")
    steps = np.diff(angle_deg)
    if not (steps > 0.0).all():
        row = int(np.argmin(steps > 0.0)) + 2
        raise JobError(f"{name}: {ANGLE} does not rise at row {row}; it must rise from row to row")
    span = float(angle_deg[-1] - angle_deg[0])
    turns = round(span / 360.0)
    if turns >= 1 and abs(span - 360.0 * turns) < 1e-6 * span:  # the end repeats the beginning
        angle_deg, x_N, y_N, steps = angle_deg[:-1], x_N[:-1], y_N[:-1], steps[:-1]
    else:
        turns = math.ceil(span / 360.0)
    cycle = 360.0 * turns
    steps = np.append(steps, cycle - float(angle_deg[-1] - angle_deg[0]))
    if (widest := float(steps.max())) > WIDEST_GAP_DEG:
        raise JobError(
            f"{name}: rows are up to {widest:g}° apart over a cycle of {cycle:g}°; "
            f"at most {WIDEST_GAP_DEG:g}° are allowed"
        )
    if np.ptp(steps) > EVEN_SHARE * steps.mean():
        even = angle_deg[0] + np.arange(0.0, cycle, STEP_DEG)
        x_N, y_N = (np.interp(even, angle_deg, each, period=cycle) for each in (x_N, y_N))
        angle_deg = even
    force = np.stack([x_N, y_N], axis=-1)
    return History(np.radians(angle_deg), force, bush_speed_rad_s)


def _column(header: list[str], name: str, file: str) -> int:
    if name not in header:
        hint = did_you_mean(name, header) or f"; it has {', '.join(header[:12])}"
        raise JobError(f"{file} has no column {name!r}{hint}")
    return header.index(name)


def _numbers(row: list[str], places: list[int], header: list[str], line: int, file: str) -> list[float]:
    numbers = []
    for place in places:
        text = row[place] if place < len(row) else ""
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise JobError(f"{file} line {line}: {header[place]} is {text!r}; must be a finite number")
        numbers.append(number)
    return numbers


# Read a bearing's TOML, strictly, and bring its numbers to SI.


Kind = Literal["dry", "hydrodynamic", "hydrostatic", "hybrid", "rolling", "squeeze_film"]
Model = Literal["palmgren", "skf"]
HistorySource = str | Path | Mapping[str, Any] | None
"""A history in place of the one that a file names."""
SERIES_COLUMNS = {"x": "main_1_x_N", "y": "main_1_y_N"}
"""Columns of a history whose file names no columns, as `cycle --series` writes them."""


@dataclass(frozen=True, eq=False)
class BearingFile:
    """A bearing's file as read; ``described`` is the file with its defaults filled in."""

    kind: Kind
    speeds_rpm: tuple[float, ...]
    case: Case
    described: dict[str, Any]

    @property
    def speeds_rad_s(self) -> tuple[float, ...]:
        """Speeds [rad/s]."""
        return tuple(RAD_S_PER_RPM * speed for speed in self.speeds_rpm)


def load_bearing(path: str | Path, history: HistorySource = None) -> BearingFile:
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


def parse_bearing(
    raw: Mapping[str, Any], folder: Path = Path(), history: HistorySource = None
) -> BearingFile:
    """Return the bearing of a TOML document; its history's file is relative to ``folder``."""
    table = Table(dict(raw), "", None)
    kind: Kind = table.value("kind", Kind)
    if kind == "rolling" and "model" in raw:
        table.value("model", Model)
    values = read(in_base_units(raw), keys.form_of(raw))
    speeds = values["speed_rpm"] if isinstance(values["speed_rpm"], tuple) else (values["speed_rpm"],)
    if len(speeds) > keys.MOST_SPEEDS:
        raise JobError(f"speed_rpm has {len(speeds)} entries; must have 1 to {keys.MOST_SPEEDS}")
    case = _case(kind, values)
    if isinstance(case, PlainCase):
        case = _with_history(case, values, folder, history)
    elif history is not None or values.get("history") is not None:
        what = "the film has a [[supply]]" if kind == "hydrodynamic" else f'kind is "{kind}"'
        raise JobError(f'a history is given, but {what}; only "hydrodynamic" without a supply has an orbit')
    return BearingFile(kind, speeds, case, _described(values))


def _described(values: Values) -> dict[str, Any]:
    """Return the file with its defaults filled in, without tables that are missing."""
    described: dict[str, Any] = plain(values)
    for key in ("oil", "history", "supply", "supply_pressure_bar", "eccentricity_ratios"):
        if described.get(key, ...) in (None, [], ()):
            del described[key]
    if "oil" in described:
        of_heat = ("supply_C", "heat_capacity_J_kg_K")
        for key in of_heat if values["oil"]["supply_C"] is None else ("temperature_C",):
            del described["oil"][key]
    return described


def _case(kind: Kind, values: Values) -> Case:
    if kind == "dry":
        return _dry(values)
    if kind == "rolling":
        return _rolling(values)
    if kind == "squeeze_film":
        return PlatesCase(
            _lubricant(values, "viscosity_Pa_s", heats=False),
            values["load_N"],
            *(M_PER_MM * values[key] for key in ("film_mm", "length_mm", "width_mm")),
        )
    if kind in ("hydrostatic", "hybrid") or values["supply"]:
        from autobalance.engines.bearings.fed_mesh import fed_case

        return fed_case(kind, values, _journal_bearing(values), _lubricant(values, "viscosity_Pa_s"))
    return _plain(values)


def _dry(values: Values) -> DryCase:
    case = DryCase(
        values["diameter_mm"] * M_PER_MM,
        values["load_N"],
        values["rotating_load_N"],
        values["mu"],
        values["torque_N_m"],
    )
    if (case.mu is None) == (case.torque_N_m is None):
        fault = "mu is missing" if case.mu is None else "mu and torque_N_m are both given"
        raise JobError(f"{fault}; a dry bearing needs either mu, or torque_N_m to find it from")
    if case.torque_N_m is not None and not case.load_N + case.rotating_load_N > 0.0:
        raise JobError("load_N is 0; must be > 0 to find mu from torque_N_m")
    return case


def _journal_bearing(values: Values) -> JournalBearing:
    bearing = JournalBearing(
        *(M_PER_MM * values[key] for key in ("diameter_mm", "length_mm", "radial_clearance_mm"))
    )
    if not bearing.clearance_m < bearing.radius_m:
        clearance = bearing.clearance_m / M_PER_MM
        raise JobError(f"radial_clearance_mm is {clearance:g}; must be less than half of diameter_mm")
    check_grid(values["grid"])
    return bearing


def _plain(values: Values) -> PlainCase:
    bearing = _journal_bearing(values)
    for key in ("supply_pressure_bar", "eccentricity_ratios"):
        if values[key] not in (None, ()):
            raise JobError(
                f"{key} is given without a [[supply]]; add the groove or hole that has the pressure"
            )
    solver: Solver = values["solver"]
    load, ratio = values["load_N"], values["eccentricity_ratio"]
    if solver != "petroff" and load is not None and ratio is not None:
        raise JobError(
            "load_N and eccentricity_ratio are both given; each follows from the other: leave one out"
        )
    if solver != "petroff" and values["attitude_deg"] is not None:
        raise JobError(f'attitude_deg is given, but solver is "{solver}", which finds it; leave it out')
    lubricant = _lubricant(values, "viscosity_Pa_s")
    if lubricant.supply is not None and (load is None or solver == "petroff"):
        raise JobError("oil.supply_C needs load_N and a solver of the film to balance its heat")
    if solver == "petroff" and values["attitude_deg"] is None:
        values["attitude_deg"] = 0.0
    if values["boundary"] is None:
        values["boundary"] = "half" if solver == "ocvirk" else "reynolds"
    if solver == "ocvirk" and values["boundary"] != "half":
        raise JobError(f'boundary is "{values["boundary"]}"; solver "ocvirk" has "half" only')
    return PlainCase(
        bearing,
        lubricant,
        solver,
        values["boundary"],
        values["grid"],
        load,
        ratio,
        math.radians(values["attitude_deg"] or 0.0),
        None,
    )


def check_grid(grid: tuple[int, int]) -> None:
    for name, cells, fewest in zip(("around", "along"), grid, keys.FEWEST_CELLS, strict=True):
        if cells < fewest:
            raise JobError(f"grid has {cells} cells {name}; must have at least {fewest}")
    if grid[0] * grid[1] > keys.MOST_CELLS:
        raise JobError(f"grid has {grid[0] * grid[1]} cells; must have at most {keys.MOST_CELLS}")


def _lubricant(values: Values, key: str, heats: bool = True) -> Lubricant:
    """Return the viscosity of ``key``, or the oil of [oil]; ``heats``: a film that may balance it."""
    table = values["oil"]
    if table is None:
        value = values[key]
        return Lubricant(value, None) if key == "viscosity_Pa_s" else Lubricant(None, value)
    try:
        oil = WaltherOil.of_points(table["viscosity_mm2_s"], table["density_kg_m3"])
    except ValueError as error:
        raise JobError(f"oil.viscosity_mm2_s: {error}") from None
    celsius, supply = table["temperature_C"], table["supply_C"]
    if celsius is None and supply is None:
        raise JobError("oil.temperature_C is missing; it must be above -273.15")
    if celsius is not None and supply is not None:
        raise JobError(
            "oil.temperature_C and oil.supply_C are both given; with supply_C the temperature is computed: "
            "remove one of them"
        )
    if celsius is not None:
        _flows(oil, celsius, "oil.temperature_C")
        return Lubricant(oil=oil, celsius=celsius)
    if not heats:
        raise JobError(
            'oil.supply_C is given; only a "hydrodynamic" film balances its heat: give temperature_C'
        )
    _flows(oil, supply, "oil.supply_C")
    return Lubricant(oil=oil, supply=Supply(supply, table["heat_capacity_J_kg_K"]))


def _flows(oil: WaltherOil, celsius: float, where: str) -> None:
    """Refuse a temperature at which the law gives no viscosity."""
    try:
        flows = 0.0 < oil.kinematic_mm2_s(celsius) < math.inf
    except OverflowError:
        flows = False
    if not flows:
        raise JobError(f"{where} is {celsius:g}; viscosity_mm2_s has no value at this temperature")


def _with_history(case: PlainCase, values: Values, folder: Path, source: HistorySource) -> PlainCase:
    """Return a case with its history; refuse one without any load."""
    if values["history"] is not None or source is not None:
        return replace(case, history=_history(values, folder, source))
    if case.solver != "petroff" and case.load_N is None and case.eccentricity_ratio is None:
        raise JobError("load_N is missing; a film needs load_N, eccentricity_ratio or a [history] of loads")
    return case


def _history(values: Values, folder: Path, source: HistorySource) -> History:
    """Return the loads by angle; columns that the table does not name are noted in it."""
    table = values["history"] or read({}, keys.HISTORY_KEYS)
    usual = {"x": "x_N", "y": "y_N"} if source is not None else SERIES_COLUMNS
    for column in usual:
        table[column] = table[column] or usual[column]
    bush = table["bush_speed_rpm"] * RAD_S_PER_RPM
    if isinstance(source, Mapping):
        history = history_of_arrays(source, bush)
    else:
        path = folder / table["file"] if source is None else Path(source)
        history = read_history(path, table["x"], table["y"], bush)
    return replace(history, clockwise=table["turns"] == "cw")


def _rolling(values: Values) -> RollingCase:
    model = _palmgren(values) if values["model"] == "palmgren" else _four_sources(values)
    return RollingCase(
        RollingBearing(values["mean_diameter_mm"], model),
        _lubricant(values, "kinematic_viscosity_mm2_s", heats=False),
        values["load_N"],
        values["count"],
    )


def _palmgren(values: Values) -> Palmgren:
    return Palmgren(**{key: values[key] for key in names(keys.PALMGREN_KEYS)})


def _four_sources(values: Values) -> FourSources:
    model = FourSources(**{key: values[key] for key in names(keys.SKF_KEYS)})
    if not model.bore_mm < model.outer_mm:
        raise JobError(f"bore_mm is {model.bore_mm:g}; must be less than outer_mm, {model.outer_mm:g}")
    return model
