"""The whole engine on the stand: crank variants side by side, for ``bench`` with ``[engine]``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance import job as jobs
from autobalance.report.plots import Plots
from autobalance.runtime import Progress, no_progress
from autobalance.test_stands.bench.answer import (
    BenchVariant,
    BesideFirst,
    EngineBenchReport,
    VariantRunUp,
)
from autobalance.test_stands.bench.engine_input import EngineBench, Variant, read_engine_bench
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.crank import Crank
from autobalance.verbs.engine_case import request
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.engines.cycle.free_run import FreeRun
    from autobalance.test_stands.bench.engine_input import FiringVariant, VariantCurves


@dataclass(frozen=True, eq=False, repr=False)
class EngineBenchResult(VerbResult):
    """Variants of a crank in one engine."""

    content: EngineBenchReport
    curves: tuple[VariantCurves, ...] = ()

    def text(self, units: str = "metric") -> str:
        """Return the variants as lines for people; always metric."""
        from autobalance.test_stands.bench.show import engine_bench_text

        return engine_bench_text(self.content)

    def plots(self) -> Plots:
        """Return torque over the cycle, bearing loads and acceleration over the speed, and the run-up."""
        from autobalance.test_stands.bench.show import engine_bench_plots

        return Plots(engine_bench_plots(self.content, self.curves))

    def series(self) -> bytes:
        """Return the torque of every variant over the cycle at the last speed as CSV."""
        names = [f"{each.name.replace(',', ' ')}_torque_N_m" for each in self.curves]
        rows = np.stack([self.curves[0].angle_deg, *(each.torque_N_m for each in self.curves)], axis=1)
        lines = [",".join(["angle_deg", *names]), *(",".join(map(repr, row)) for row in rows.tolist())]
        return ("\n".join(lines) + "\n").encode()

    def files(self) -> Mapping[str, bytes]:
        """Return the series as ``bench.csv``."""
        return {"bench.csv": self.series()}


def engine_bench(
    source: str | Path | Mapping[str, Any],
    notify: Progress = no_progress,
) -> EngineBenchResult:
    """Put crank variants into the engine of a job and set what they do side by side.

    Raises
    ------
    JobError
        If a key is wrong, or the job has no cycle.
    AutobalanceError
        For anything wrong with a crank.
    """
    stand = read_engine_bench(source)
    cranks: dict[tuple[str, ...], Crank] = {}
    rows, curves = [], []
    warnings: dict[str, None] = {}  # each once, in order
    for number, variant in enumerate(stand.variants):
        notify(variant.name, number / len(stand.variants))
        values, curve, odd = _variant(stand, variant, cranks)
        warnings.update(dict.fromkeys(odd))
        rows.append(values)
        curves.append(curve)
    report = EngineBenchReport(
        input=stand.values, variants=rows, beside=_beside(rows), warnings=list(warnings)
    )
    return EngineBenchResult(report, tuple(curves))


def _variant(
    stand: EngineBench, variant: Variant, cranks: dict[tuple[str, ...], Crank]
) -> tuple[BenchVariant, VariantCurves, tuple[str, ...]]:
    from autobalance.engines.cycle.firing import check_cycle
    from autobalance.test_stands.bench.engine_input import FiringVariant, VariantCurves

    own = () if variant.crank is None else (f"crankshaft.file={str(variant.crank.resolve())!r}",)
    job = jobs.load(stand.job, (*variant.settings, *own))
    check_cycle(job)
    key = tuple(each for each in (*variant.settings, *own) if each.strip().startswith("crankshaft"))
    case = request(job, cranks.get(key))
    cranks.setdefault(key, Crank(case.crank, job.crankshaft))
    tried = FiringVariant(job, case.crank, variant.factor)
    speeds = (case.speed_rpm,) if stand.speeds_rpm is None else stand.speeds_rpm
    points = [tried.point(speed) for speed in speeds]
    _, torque, analysis = points[-1]
    run = None
    if stand.run_up_rpm is not None:
        run = tried.run_up(*(speed * RAD_S_PER_RPM for speed in stand.run_up_rpm))
    values = BenchVariant(
        name=variant.name,
        crank=None if job.crankshaft.file is None else job.crankshaft.file.name,
        factor=variant.factor,
        balance_factor=_factor(tried),
        inertia_g_mm2=analysis.mean_inertia_g_mm2,
        points=[figures for figures, _, _ in points],
        run_up=None if stand.run_up_rpm is None else _run_up(stand.run_up_rpm, run),
    )
    even = analysis.grid.even
    angles = np.degrees(analysis.grid.even_rad)
    curves = VariantCurves(variant.name, angles, even(torque), run)
    return values, curves, case.warnings


def _factor(tried: FiringVariant) -> float | None:
    """Return the factor of the crank as it is, or of the ideal one."""
    from autobalance.balancing.rotor_from_job import crank_factor, hung_on

    if tried.factor is not None:
        return tried.factor
    return crank_factor(tried.crank.moments, *hung_on(tried.job, tried.crank.anatomy))


def _run_up(speeds_rpm: tuple[float, float], run: FreeRun | None) -> VariantRunUp:
    return VariantRunUp(
        from_rpm=speeds_rpm[0],
        to_rpm=speeds_rpm[1],
        time_s=None if run is None else float(run.time_s[-1]),
        turns=None if run is None else float(run.angle_rad[-1] / (2.0 * np.pi)),
        gas_work_J=None if run is None else run.gas_work_n_m,
        friction_work_J=None if run is None else run.friction_work_n_m,
        kinetic_J=None if run is None else run.kinetic_n_m,
    )


def _beside(rows: Sequence[BenchVariant]) -> list[BesideFirst]:
    """Return the changes of each further variant's figures from the first one's, in percent."""
    return [
        BesideFirst(
            name=row.name,
            speed_rpm=point.speed_rpm,
            acceleration_percent=_percent(point.acceleration_rad_s2, base.acceleration_rad_s2),
            greatest_main_percent=_percent(point.greatest_main_n, base.greatest_main_n),
            mean_main_percent=_percent(point.mean_main_n, base.mean_main_n),
            torque_mean_percent=_percent(point.torque_mean_n_m, base.torque_mean_n_m),
            friction_mean_percent=_percent(point.friction_mean_n_m, base.friction_mean_n_m),
        )
        for row in rows[1:]
        for point, base in zip(row.points, rows[0].points, strict=True)
    ]


def _percent(value: float, base: float) -> float | None:
    return 100.0 * (value / base - 1.0) if base else None
