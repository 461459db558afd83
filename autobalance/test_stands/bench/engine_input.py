"""Engine on a bench: its input, and variants of it that are compared."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from autobalance.balancing.engine_from_job import as_measured
from autobalance.balancing.measured import Crank
from autobalance.declare import (
    NEWTONS,
    POSITIVE,
    SHARE,
    Floats,
    Key,
    NewtonMetres,
    NotNegative,
    Positive,
    Values,
)
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.factors import FactorMainLoads
from autobalance.engines.cycle.firing import firing_engine
from autobalance.engines.cycle.firing_engine import FiringEngine
from autobalance.engines.cycle.free_run import FreeRun, free_run
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.running_gear.whole_engine import Engine
from autobalance.toml_files.keys import read_document
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

# ``BENCH.toml`` of a whole engine: its job, speeds, and the cranks to try in it.


ENGINE = (
    Key("job", str, "job of the engine, with [cycle]; relative to this file"),
    Key("speeds_rpm", tuple[float, ...], "speeds held; default the job's", POSITIVE, None),
    Key("run_up_rpm", tuple[float, float], "first and last speed of a run-up without load", POSITIVE, None),
)
VARIANT = (
    Key("name", str, "name", default=""),
    Key("crank", str, "crank file that replaces the job's", default=None),
    Key("factor", float, "an ideal crank of this factor in place of its unbalance", SHARE, None),
    Key("set", tuple[str, ...], 'keys of the job: "cycle.flywheel_kg_mm2=2000"', default=()),
)
ENGINE_BENCH_KEYS = (
    Key("engine", says="a whole engine on the stand", keys=ENGINE),
    Key(
        "variant",
        says="cranks to try; default: as it is, and the usual factors",
        keys=VARIANT,
        many=True,
        default=(),
    ),
)
USUAL_FACTORS = (0.0, 0.28, 0.5, 0.64, 1.0)
MOST_POINTS = 1000


@dataclass(frozen=True)
class Variant:
    """A crank in the engine: another file, an ideal factor, changed keys of the job."""

    name: str
    crank: Path | None = None
    factor: float | None = None
    settings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class EngineBench:
    """The file; ``speeds_rpm`` None: the job's own."""

    values: Values
    job: Path
    speeds_rpm: tuple[float, ...] | None
    run_up_rpm: tuple[float, float] | None
    variants: tuple[Variant, ...]


def read_engine_bench(source: str | Path | Mapping[str, Any]) -> EngineBench:
    """Read the bench file of a whole engine, or its structure (files relative to the working folder).

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible.
    """
    folder = Path() if isinstance(source, Mapping) else Path(source).parent

    def bench(values: Values) -> EngineBench:
        return _engine_bench(values, folder)

    return read_document(source, "bench file", ENGINE_BENCH_KEYS, bench)


def _engine_bench(values: Values, folder: Path) -> EngineBench:
    engine = values["engine"]
    run_up = engine["run_up_rpm"]
    if run_up is not None and not run_up[0] < run_up[1]:
        raise JobError(
            f"engine.run_up_rpm is [{run_up[0]:g}, {run_up[1]:g}]; the first must be the lower one"
        )
    if engine["speeds_rpm"] == ():
        raise JobError("engine.speeds_rpm is an empty list; expected at least one speed")
    if not values["variant"]:
        values["variant"] = [{"name": "as it is", "crank": None, "factor": None, "set": ()}]
        values["variant"] += [
            {"name": f"factor {factor:g}", "crank": None, "factor": factor, "set": ()}
            for factor in USUAL_FACTORS
        ]
    if len(values["variant"]) * len(engine["speeds_rpm"] or (1,)) > MOST_POINTS:
        raise JobError(f"more than {MOST_POINTS} variants and speeds; list fewer")
    variants = tuple(
        Variant(
            each["name"] or f"variant {number}",
            None if each["crank"] is None else folder / each["crank"],
            each["factor"],
            each["set"],
        )
        for number, each in enumerate(values["variant"], 1)
    )
    names = [each.name for each in variants]
    for name in names:
        if names.count(name) > 1:
            raise JobError(f"two variants are called {name!r}; give each its own name")
    return EngineBench(values, folder / engine["job"], engine["speeds_rpm"], run_up, variants)


# Cranks in one engine, side by side: what each does to acceleration, bearing loads and output torque.


@dataclass(frozen=True, eq=False)
class VariantFigures:
    """An engine with one crank at one speed.

    Attributes
    ----------
    acceleration_rad_s2 : float
        (gas − friction)/J, means, without load [rad/s²].
    greatest_main_n, mean_main_n : float
        Largest and mean magnitude of the mains' loads over the cycle [N].
    greatest_mains_n : (m,) float
        Largest magnitude of each [N].
    torque_mean_n_m, torque_greatest_n_m, torque_least_n_m : float
        Of gas − friction + inertia at the angles of the grid [N·m].
    fluctuation : float or None
        Of the speed under a constant load; None where the crank would stop.
    """

    speed_rpm: Positive
    acceleration_rad_s2: float
    greatest_main_n: Annotated[NotNegative, NEWTONS]
    mean_main_n: Annotated[NotNegative, NEWTONS]
    greatest_mains_n: Annotated[Floats, NEWTONS]
    torque_mean_n_m: NewtonMetres
    torque_greatest_n_m: NewtonMetres
    torque_least_n_m: NewtonMetres
    friction_mean_n_m: NewtonMetres
    power_W: float
    fluctuation: float | None


@dataclass(frozen=True, eq=False)
class VariantCurves:
    """Torque over the cycle at the last speed, and the run-up, of one variant."""

    name: str
    angle_deg: Array
    torque_N_m: Array
    run: FreeRun | None


@dataclass(frozen=True, eq=False)
class FiringVariant:
    """A job's engine with one crank in it, of a separate unbalance or an ideal one of a factor."""

    job: Job
    crank: Crank
    factor: float | None

    def firing(self, speed_rad_s: float) -> FiringEngine:
        """Return the engine at a speed, which only heat through its walls depends on."""
        return firing_engine(self.job, self.crank.anatomy, speed_rad_s, lambda: self._engine)

    @cached_property
    def _engine(self) -> Engine:
        return as_measured(self.job, self.crank)

    def point(self, speed_rpm: float) -> tuple[VariantFigures, Array, CycleAnalysis]:
        """Return figures and torque [N·m] at a speed, and the analysis whose gas and inertia they have."""
        speed_rad_s = speed_rpm * RAD_S_PER_RPM
        analysis = CycleAnalysis(self.firing(speed_rad_s), speed_rad_s)
        firing, grid = analysis.firing, analysis.grid
        sizes = FactorMainLoads.of(firing).sizes_n(self.factor, speed_rad_s)
        lever = firing.friction.main_lever_mm(firing.main_diameters_mm)
        friction = lever @ sizes * N_M_PER_N_MM + firing.piston_friction_n_m(speed_rad_s)
        lost = float(grid.mean(friction))
        uneven, torque = analysis.uneven_speed, analysis.gas_n_m - friction + analysis.inertia_n_m
        mean = firing.gas_mean_n_m - lost + analysis.inertia_mean_n_m
        greatest = sizes.max(axis=1)
        figures = VariantFigures(
            speed_rpm=speed_rpm,
            acceleration_rad_s2=(firing.gas_mean_n_m - lost)
            / (analysis.mean_inertia_g_mm2 * N_M_PER_G_MM2_S2),
            greatest_main_n=float(greatest.max()),
            mean_main_n=float(np.mean(grid.mean(sizes))),
            greatest_mains_n=greatest,
            torque_mean_n_m=mean,
            torque_greatest_n_m=float(torque.max()),
            torque_least_n_m=float(torque.min()),
            friction_mean_n_m=lost,
            power_W=mean * speed_rad_s,
            fluctuation=None if uneven is None else uneven.fluctuation,
        )
        return figures, torque, analysis

    def run_up(self, start_rad_s: float, end_rad_s: float) -> FreeRun | None:
        """Return the run from one speed to another without load."""
        return free_run(self.firing(end_rad_s), self.factor, start_rad_s, end_rad_s)
