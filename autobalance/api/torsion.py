"""``autobalance.torsion``: a crank or any chain of inertias as a torsional oscillator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance import job as jobs
from autobalance.api.common_parameters import documented
from autobalance.api.engine_case import job_set, request
from autobalance.api.result import Plots, Values, VerbResult, report_head
from autobalance.dynamics.torsion_chain import TorsionChain
from autobalance.errors import UsageError
from autobalance.job import Job
from autobalance.job.files.torsion import ChainFile, read_chain
from autobalance.job.model.torsion import CrankTorsion, TorsionQuestion
from autobalance.job.read import tables_of
from autobalance.job.toml.keys import named_in
from autobalance.job.toml.settings import with_settings
from autobalance.job.torsion import check_station, crank_torsion
from autobalance.machine_models.torsion_dampers import FittedDamper, with_dampers
from autobalance.machine_models.torsion_excited import ExcitedTrain
from autobalance.machine_models.torsion_from_job import CrankChain, crank_chain
from autobalance.machine_models.torsion_trains import named_train
from autobalance.report.rotor import torsion_values
from autobalance.runtime import Progress

if TYPE_CHECKING:
    from autobalance.api.crank import Crank
    from autobalance.machine_models.cycle_torques import ThrowTorques
    from autobalance.machine_models.measured import Crank as MeasuredCrank
    from autobalance.machine_models.throw_twist import ThrowTwist

POISSON = 0.3
"""Of the crank's metal, where finite elements need it."""
USUAL_ORDERS = tuple(0.5 * n for n in range(1, 25))
"""Of which critical speeds are told where nothing says what excites a crank."""


@dataclass(frozen=True, eq=False, repr=False)
class TorsionResult(VerbResult):
    """What ``torsion`` found."""

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people; always metric."""
        from autobalance.report.rotor.torsion_text import torsion_text

        return torsion_text(self.report)

    def plots(self) -> Plots:
        """Return mode shapes and the response over the speed."""
        from autobalance.report.rotor.torsion_plots import torsion_plots

        return torsion_plots(self.report)


@documented
def torsion(
    source: Job | str | Path | Mapping[str, Any],
    *,
    crank: Crank | None = None,
    settings: Sequence[str] = (),
    fem: bool | None = None,
    progress: Progress | None = None,
) -> TorsionResult:
    """Compute the torsional vibration of a job's crank, or of a chain of its own.

    Parameters
    ----------
    source : Job, path or dict
        Job, or a chain of [[inertia]] and [[spring]]. The crank's own metal and dimensions make a job's
        chain, and its ``[cycle]`` excites it; or a dict of either.
    fem : bool or None
        Twist each throw's own metal by finite elements too (extra fem). None: as the job says,
        ``torsion.fem``.

    Raises
    ------
    JobError
        If the file says something unknown or impossible.
    AutobalanceError
        For anything wrong with the crank.
    """
    if isinstance(source, Job):
        return _of_job(source, crank, fem, progress)
    raw = with_settings(source if isinstance(source, Mapping) else tables_of(Path(source)), settings)
    if "inertia" in raw or not (crank is not None or "crankshaft" in raw):
        if fem:
            raise UsageError("--fem is for a crank; a chain has no metal")
        if not settings:
            return _of_chain(read_chain(source))
        with named_in(source):
            return _of_chain(read_chain(raw), settings)
    job = Job.from_dict(raw) if isinstance(source, Mapping) else jobs.load(source, settings)
    return _of_job(job, crank, fem, progress)


def _of_chain(file: ChainFile, settings: Sequence[str] = ()) -> TorsionResult:
    orders = tuple(sorted({each.order for each in file.question.excitations}))
    named = named_train(file.chain, file.names, file.diameters_m, file.question.parts)
    model = ExcitedTrain(named, file.chain if file.question.parts.plain else None, file.question, orders)
    model, dampers = with_dampers(model)
    file.filled["torsion"]["damping_ratio"] = model.damping_ratio
    head = {**report_head("torsion"), **({"job_set": list(settings)} if settings else {})}
    values = {**head, "input": file.filled}
    return TorsionResult({**values, **_solved(model, dampers)})


def _of_job(job: Job, crank: Crank | None, fem: bool | None, progress: Progress | None) -> TorsionResult:
    found = request(job, crank, None, progress)
    asked = found.job.torsion or crank_torsion(found.job.raw)
    asked.filled["torsion"]["fem"] = asked.fem if fem is None else fem
    made = crank_chain(found.job, found.crank, asked)
    torques = _cycle_torques(found.job, found.crank)
    model = _excited(made, asked.question, torques)
    _check_stations(asked.question, len(model.named.names))
    model, dampers = with_dampers(model)
    asked.filled["torsion"]["damping_ratio"] = model.damping_ratio
    told = {**jobs.describe(found.job), **asked.filled}
    values = {**report_head("torsion"), **job_set(found.job), "input": told}
    solved = _solved(model, dampers, made)
    twists = _twisted(found.crank, asked, progress) if asked.filled["torsion"]["fem"] else None
    metal = torsion_values.metal_values(
        made, twists, lambda chain: _excited(made, asked.question, None, chain)
    )
    solved["model"]["fem_N_m_rad"] = metal.pop("springs")
    throws, warnings = _throws(made, asked, twists), list(found.warnings)
    return TorsionResult({**values, **solved, **metal, "throws": throws, "warnings": warnings})


def _excited(
    made: CrankChain,
    question: TorsionQuestion,
    torques: ThrowTorques | None,
    chain: TorsionChain | None = None,
) -> ExcitedTrain:
    """Return a crank's chain, or another in its place, as the train that the job makes of it."""
    chain = made.chain if chain is None else chain
    behind = None if torques is None else (made.throw_stations[-1], torques.mean_n_m)
    named = named_train(chain, made.names, made.diameters_m, question.parts, behind)
    orders = {each.order for each in question.excitations}
    orders |= set(USUAL_ORDERS) if torques is None else {float(each) for each in torques.orders}
    plain = chain if question.parts.plain else None
    return ExcitedTrain(named, plain, question, tuple(sorted(orders)), torques, made.throw_stations)


def _twisted(crank: MeasuredCrank, asked: CrankTorsion, progress: Progress | None) -> tuple[ThrowTwist, ...]:
    from autobalance.machine_models.throw_twist import throw_twists

    shear = asked.shear_modulus_mpa
    youngs = 2.0 * (1.0 + POISSON) * shear
    tell = {} if progress is None else {"progress": progress}
    return tuple(throw_twists(crank, youngs, shear, asked.fem_size_mm, **tell))


def _check_stations(question: TorsionQuestion, stations: int) -> None:
    for number, each in enumerate(question.excitations, 1):
        check_station(f"excitation[{number}].station", each.station + 1, stations)
    if question.pendulum is not None and question.pendulum.station is not None:
        check_station("pendulum.station", question.pendulum.station + 1, stations)


def _cycle_torques(job: Job, crank: MeasuredCrank) -> ThrowTorques | None:
    if job.cycle is None:
        return None
    from autobalance.machine_models.cycle_torques import throw_torques

    return throw_torques(job, crank)


def _throws(made: CrankChain, asked: CrankTorsion, twists: Sequence[ThrowTwist] | None) -> list[Values]:
    """Return the dimensions that the stiffness of each throw was computed from, and what came of them."""
    return [
        {
            "number": number,
            "journal_mm": shape.journal_mm,
            "journal_bore_mm": shape.journal_bore_mm,
            "journal_length_mm": shape.journal_length_mm,
            "crankpin_mm": shape.pin_mm,
            "crankpin_bore_mm": shape.pin_bore_mm,
            "crankpin_length_mm": shape.pin_length_mm,
            "crank_radius_mm": shape.crank_radius_mm,
            "web_thickness_mm": shape.web_thickness_mm,
            "web_breadth_mm": shape.web_breadth_mm,
            "formula": asked.formula,
            **{f"{name}_N_m_rad": each[number - 1] for name, each in made.throws_n_m_rad.items()},
            **torsion_values.twist_values(None if twists is None else twists[number - 1]),
        }
        for number, shape in enumerate(made.shapes, 1)
    ]


def _solved(model: ExcitedTrain, dampers: Sequence[FittedDamper], made: CrankChain | None = None) -> Values:
    modes = model.modes()
    formulas = () if made is None else (made.ker_wilson_n_m_rad, made.carter_n_m_rad)
    speeds = model.question.speeds_rad_s
    return {
        "model": {
            **torsion_values.model_values(model.named.train, model.named.names, *formulas),
            **torsion_values.train_values(model.named),
        },
        "damping": torsion_values.damping_values(model),
        "natural_frequencies_hz": [mode.frequency_rad_s / torsion_values.TWO_PI for mode in modes],
        "modes": torsion_values.mode_values(model, modes),
        "critical": torsion_values.critical_values(model, modes),
        "response": [
            torsion_values.response_values(order, speeds, model.response(order, speeds), model.named)
            for order in model.orders
            if model.torque_at(order, speeds).any()
        ],
        "pendulum": torsion_values.pendulum_values(model.question.pendulum),
        "dampers": [torsion_values.damper_values(model, each) for each in dampers],
    }
