"""``autobalance.torsion``: a crank or any chain of inertias as a torsional oscillator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance import job as jobs
from autobalance.crank_dynamics.torsion.answer import TorsionReport
from autobalance.crank_dynamics.torsion.chain import TorsionChain
from autobalance.crank_dynamics.torsion.dampers import FittedDamper, damper_figures, with_dampers
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain, excited_crank
from autobalance.crank_dynamics.torsion.figures import (
    AbsorberSize,
    Damping,
    ThrowFigures,
    TorsionModeFigures,
    TrainFigures,
)
from autobalance.crank_dynamics.torsion.from_job import CrankChain, crank_chain
from autobalance.crank_dynamics.torsion.input import (
    DAMPING_RATIO,
    INERTIA,
    SHARED,
    SPRING,
    check_station,
    crank_torsion,
    question_of,
)
from autobalance.crank_dynamics.torsion.model import CrankTorsion, SpeedRamp, TorsionQuestion, named_train
from autobalance.crank_dynamics.torsion.run_up import LinkFriction, RunUpFigures, run_up_figures
from autobalance.crank_dynamics.torsion.strains import critical_orders, order_peaks, order_responses
from autobalance.declare import ABSENT, FILLED, HERTZ, Key, Values
from autobalance.engines.cycle.model import Cycle
from autobalance.errors import JobError, UsageError
from autobalance.job import Job
from autobalance.job.read import tables_of
from autobalance.report.plots import Plots
from autobalance.runtime import Progress, no_progress
from autobalance.toml_files.document import with_settings
from autobalance.toml_files.keys import named_in, read_document
from autobalance.units import KG_M2_PER_KG_MM2, M_PER_MM
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import job_set, request
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank as MeasuredCrank
    from autobalance.crank_dynamics.torsion.throw_twist import ThrowTwist
    from autobalance.engines.cycle.analysis import ThrowTorques
    from autobalance.verbs.crank import Crank


# Read a chain's file for ``torsion``. SI units out.


CHAIN = (
    *SHARED,
    Key("inertia", says="stations in order", keys=INERTIA, many=True),
    Key("spring", says="springs between one station and the next", keys=SPRING, many=True, default=()),
    Key("torsion", says="settings of the calculation", keys=(DAMPING_RATIO,), default=FILLED),
)
"""Every key of a chain's file."""


@dataclass(frozen=True, eq=False)
class ChainFile:
    """A chain with the questions about it; ``filled`` is the file as read, defaults filled in."""

    question: TorsionQuestion
    chain: TorsionChain
    names: tuple[str, ...]
    diameters_m: tuple[float | None, ...]
    filled: Values


def read_chain(source: str | Path | Mapping[str, Any]) -> ChainFile:
    """Read a chain's file, or a dict of its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    return read_document(source, "torsion file", CHAIN, _chain)


def _chain(filled: Values) -> ChainFile:
    inertias, springs = filled["inertia"], filled["spring"]
    if len(springs) != len(inertias) - 1:
        raise JobError(
            f"there are {len(springs)} [[spring]] tables; {len(inertias)} inertias need {len(inertias) - 1}"
        )
    chain = TorsionChain(
        KG_M2_PER_KG_MM2 * np.array([each["kg_mm2"] for each in inertias]),
        np.array([each["N_m_rad"] for each in springs]),
        np.array([each["damping_N_m_s_rad"] for each in inertias]),
        np.array([each["damping_N_m_s_rad"] for each in springs]),
    )
    diameters = tuple(None if d is None else M_PER_MM * d for d in (s["diameter_mm"] for s in springs))
    names = tuple(each["name"] or f"station {n}" for n, each in enumerate(inertias, 1))
    branched = sum(len(each["inertia"]) for each in filled["branch"])
    return ChainFile(question_of(filled, len(inertias) + branched), chain, names, diameters, filled)


POISSON = 0.3
"""Material of the crank, if finite elements need it."""
MODES_SHOWN = 6


@dataclass(frozen=True, eq=False, repr=False)
class TorsionResult(VerbResult):
    """Result of ``torsion``."""

    content: TorsionReport

    def __repr__(self) -> str:
        modes = [f"{HERTZ.written(each):.5g}" for each in self.content.natural_frequencies_rad_s]
        shown = ", ".join(modes[:MODES_SHOWN]) + (", ..." if len(modes) > MODES_SHOWN else "")
        return f"<autobalance torsion: natural frequencies {shown or 'none'} Hz>"

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people; always metric."""
        from autobalance.crank_dynamics.torsion.answer import torsion_text

        return torsion_text(self.content)

    def plots(self) -> Plots:
        """Return mode shapes and the response over the speed."""
        from autobalance.crank_dynamics.torsion.answer import torsion_plots

        return Plots(torsion_plots(self.content))


@documented
def torsion(
    source: Job | str | Path | Mapping[str, Any],
    *,
    crank: Crank | None = None,
    settings: Sequence[str] = (),
    fem: bool | None = None,
    progress: Progress | None = None,
) -> TorsionResult:
    """Compute the torsional vibration of a job's crank, or of a separate chain.

    Parameters
    ----------
    source : Job, path or dict
        Job, or a chain of [[inertia]] and [[spring]]. The crank's own metal and dimensions make a job's
        chain, and its ``[cycle]`` excites it; or a dict of either.
    fem : bool or None
        Twist each throw's metal by finite elements too (extra fem). None: the job's ``torsion.fem``.

    Raises
    ------
    JobError If the file has an unknown key or an impossible value. AutobalanceError For anything wrong with
    the crank.
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
    inputs = _with(file.filled, damping_ratio=model.damping_ratio)
    content = replace(
        _solved(inputs, model, dampers),
        job_set=list(settings) if settings else ABSENT,
        warnings=_warnings(model, dampers) or ABSENT,
    )
    return TorsionResult(content)


def _of_job(job: Job, crank: Crank | None, fem: bool | None, progress: Progress | None) -> TorsionResult:
    case = request(job, crank, None, progress)
    torsion = case.job.table(CrankTorsion) or crank_torsion(case.job.raw)
    with_fem = torsion.fem if fem is None else fem
    chain = crank_chain(case.job, case.crank, torsion)
    torques = _cycle_torques(case.job, case.crank)
    model = excited_crank(chain, torsion.question, torques)
    _check_stations(torsion.question, len(model.named.names))
    model, dampers = with_dampers(model)
    values = {
        **jobs.describe(case.job),
        **_with(torsion.filled, fem=with_fem, damping_ratio=model.damping_ratio),
    }
    twists = _twisted(case.crank, torsion, progress) if with_fem else None
    metal = _of_metal(chain, twists)
    modes = None if metal is None else excited_crank(chain, torsion.question, None, metal).modes()
    content = replace(
        _solved(values, model, dampers, chain, metal),
        **job_set(case.job),
        fem_natural_frequencies_rad_s=None if modes is None else [mode.frequency_rad_s for mode in modes],
        throws=[
            ThrowFigures.of(number, chain, torsion.formula, None if twists is None else twists[number - 1])
            for number in range(1, len(chain.shapes) + 1)
        ],
        warnings=[*case.warnings, *_warnings(model, dampers)],
    )
    return TorsionResult(content)


def _warnings(model: ExcitedTrain, dampers: Sequence[FittedDamper]) -> list[str]:
    """Return warnings of a train: its couplings' torque, and dampers that the search could not tune."""
    texts = list(model.named.warnings)
    for number, each in enumerate(dampers, 1):
        if each.bound is not None:
            texts.append(
                f"damper[{number}] is not tuned: the search ended at its {each.bound}"
                f" ({each.n_m_s_rad:.4g} N·m·s/rad); a damper of this inertia at station"
                f" {each.damper.station + 1} barely relieves the crank's shafts"
            )
    return texts


def _with(filled: Mapping[str, Any], **values: Any) -> Values:
    """Return the tables of a file with keys of ``[torsion]`` as they were used."""
    return {**filled, "torsion": {**filled["torsion"], **values}}


def _of_metal(chain: CrankChain, twists: Sequence[ThrowTwist] | None) -> TorsionChain | None:
    """Return the chain with the springs of the throws' own metal; None where one of them is not known."""
    known = [each.stiffness for each in twists or () if each.stiffness is not None]
    if twists is None or len(known) < len(twists):
        return None
    return chain.with_throws([each.n_m_rad for each in known])


def _twisted(
    crank: MeasuredCrank, torsion: CrankTorsion, progress: Progress | None
) -> tuple[ThrowTwist, ...]:
    from autobalance.crank_dynamics.torsion.throw_twist import throw_twists

    shear = torsion.shear_modulus_mpa
    youngs = 2.0 * (1.0 + POISSON) * shear
    notify = no_progress if progress is None else progress
    return tuple(throw_twists(crank, youngs, shear, torsion.fem_size_mm, notify))


def _check_stations(question: TorsionQuestion, stations: int) -> None:
    for number, each in enumerate(question.excitations, 1):
        check_station(f"excitation[{number}].station", each.station + 1, stations)
    if question.pendulum is not None and question.pendulum.station is not None:
        check_station("pendulum.station", question.pendulum.station + 1, stations)


def _cycle_torques(job: Job, crank: MeasuredCrank) -> ThrowTorques | None:
    if job.table(Cycle) is None:
        return None
    from autobalance.engines.cycle.analysis import throw_torques

    return throw_torques(job, crank)


def _solved(
    inputs: Values,
    model: ExcitedTrain,
    dampers: Sequence[FittedDamper],
    of_crank: CrankChain | None = None,
    metal: TorsionChain | None = None,
) -> TorsionReport:
    """Return the report with the parts that a chain and a crank have in common."""
    modes = model.modes()
    absorber = model.question.pendulum
    return TorsionReport(
        input=inputs,
        model=TrainFigures.of(model.named, of_crank, None if metal is None else metal.springs_n_m_rad),
        excited=any(model.torque_at(order, model.question.speeds_rad_s).any() for order in model.orders),
        damping=Damping(ratio=model.damping_ratio, dampers=model.damped),
        natural_frequencies_rad_s=[mode.frequency_rad_s for mode in modes],
        modes=[TorsionModeFigures.of(model, mode) for mode in modes],
        critical=critical_orders(model, modes),
        peaks=order_peaks(model),
        response=order_responses(model),
        pendulum=None if absorber is None else AbsorberSize.of(absorber),
        dampers=[damper_figures(model, each) for each in dampers],
        run_up=None if model.question.run_up is None else _run_up(model, model.question.run_up, dampers),
    )


def _run_up(model: ExcitedTrain, ramp: SpeedRamp, dampers: Sequence[FittedDamper]) -> RunUpFigures:
    absorber = model.question.pendulum
    if absorber is not None and absorber.station is not None:
        raise JobError(
            "run_up: a pendulum at a station counts at its orders alone; leave pendulum.station out"
        )
    dry = [LinkFriction(each.link, each.damper.friction_n_m) for each in dampers]
    pairs = zip(model.named.couplings, model.question.parts.couplings, strict=True)
    dry += [LinkFriction(state.link, each.friction_n_m) for state, each in pairs]
    try:
        return run_up_figures(model, ramp, [each for each in dry if each.torque_n_m > 0.0])
    except ValueError as error:
        raise JobError(f"run_up: {error}") from None
