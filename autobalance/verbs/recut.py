"""``ab.recut``: a corrected crank was spun on a balancing machine; what is still to cut."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.balancing.loop import Result, balance, left_as_it_is
from autobalance.balancing.machine_reading import (
    MAX_DIFFERENCE_SIGMAS,
    MAX_LEFT,
    JudgedReading,
    MachineAccuracy,
    PlaneReading,
    ReadingComparison,
    StageSuspect,
    bob_weight_fit,
    judged_reading,
    machine_cannot_show,
    needs_no_cut,
    suspects,
)
from autobalance.balancing.measured_crank import input_file, measured_source, work_on_faces
from autobalance.balancing.record import BalanceFactor, Record
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.balancing.run import measure_of, record_of, rotor_of
from autobalance.errors import CorrectionError, FileError, FormatError, JobError
from autobalance.job import Job
from autobalance.job.from_options import for_recut
from autobalance.job.reading import MachineReading, ReadPlane
from autobalance.report.balance.values import StageNotes, stage_values
from autobalance.rigid_rotor.unbalance import Share, Unbalance
from autobalance.running_gear.parts import balance_factor, bob_weight_moments, factor_direction_g_mm
from autobalance.runtime import Notify, Progress, Stopwatch
from autobalance.value_classes import dataclass
from autobalance.verbs.balance import BalanceResult
from autobalance.verbs.crank import Crank
from autobalance.verbs.declaration import documented
from autobalance.verbs.progress import telling
from autobalance.verbs.result_files import REPORT, Staged, staged_files, with_outputs
from autobalance.verification.earlier_stage import EarlierStage, unbalance_moments

if TYPE_CHECKING:
    from autobalance.report.balance.values import StageNotes
    from autobalance.report.files import Staging
    from autobalance.report.material import Choice
    from autobalance.report.records.stage import Stage


# ``ab.recut``: a corrected crank was spun on a balancing machine; what is still to cut.


MOST_STAGES = 10
HISTORY = "history.html"


@dataclass(frozen=True, eq=False, repr=False)
class RecutResult(BalanceResult):
    """The end of a stage; ``stages`` of the report has all of them so far."""

    notes: StageNotes
    folder: Path

    @property
    def stage(self) -> int:
        """Number of the stage."""
        return self.typed_report.stages[-1].stage

    @cached_property
    def history(self) -> str:
        """The page of all stages."""
        from autobalance.report.page.html import history_page

        shown = self.typed_report
        return history_page(shown, stage_dates(shown.stages[:-1], self.folder))

    def _text(self, units: str, verbose: bool) -> str:
        from autobalance.report.balance.text import recut_text
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.report.tables import unglued

        return unglued(recut_text(self.typed_report, ON_SCREEN[units], verbose=verbose))

    def write(
        self,
        folder: str | Path | None = None,
        only: tuple[str, ...] | None = None,
        *,
        paper: str = "A4",
        units: str = "metric",
        date: str | None = None,
        zero: str = "keyway",
        progress: Progress | None = None,
    ) -> tuple[Path, ...]:
        """Write the solid, ``report.json``, ``history.html`` and the pages: all files or none.

        ``folder`` is ``stage-N`` in the folder of the first stage's report unless given; for the rest see
        ``BalanceResult.write``.
        """
        target = self.folder if folder is None else folder
        return super().write(target, only, paper=paper, units=units, date=date, zero=zero, progress=progress)

    def staged(self, folder: Path, choice: Choice, notify: Notify, staging: Staging) -> Staged:
        """Stage all files for a folder, the page of all stages too; other reports are named from there."""
        from autobalance.report.balance.values import report, stage_values
        from autobalance.report.page.html import history_page
        from autobalance.report.records.balanced import BalancedReport
        from autobalance.report.records.outputs import Page

        record = self.record
        assert record.balanced is not None
        record = replace(record, staged=stage_values(self.notes, folder, record.balanced.result))
        shown = BalancedReport.read(report(record))
        for each in shown.stages[:-1]:
            if (folder / each.report).resolve() == (folder / REPORT).resolve():
                raise FileError(
                    f"{folder} holds the report of stage {each.stage} of this crank; choose another folder"
                )
        dates = [*stage_dates(shown.stages[:-1], folder), choice.date]
        page = history_page(shown, dates, choice.units).encode()
        staging.add(folder / HISTORY, page)
        entry = Page(file=HISTORY, sha256=hashlib.sha256(page).hexdigest())
        record = replace(record, outputs={**record.outputs, "history": entry})
        written, files = staged_files(record, self.before, folder, choice, notify, staging)
        return written, (*files, folder / HISTORY)


def stage_dates(stages: Sequence[Stage], folder: Path) -> list[str]:
    """Return the days on which the reports of earlier stages were written; "" of one that is gone."""
    reports = [folder / each.report for each in stages]
    return [
        date.fromtimestamp(path.stat().st_mtime).isoformat() if path.is_file() else "" for path in reports
    ]


@documented
def recut(
    report: str | Path,
    reading: str | Path | Mapping[str, Any],
    *,
    folder: str | Path | None = None,
    trust_reading: bool = False,
    progress: Progress | None = None,
) -> RecutResult:
    """Plan and make further cuts on a corrected crank, from what a balancing machine read on it.

    Nothing is written until ``write`` of the result.

    Parameters
    ----------
    report : path
        Report of balance or recut, its solid beside it.
    reading : path or dict
        Reading of the balancing machine, a READING.toml. Or its structure.
    folder : path or None
        Folder of the results; None: stage-N beside the first stage's report.
    trust_reading : bool
        Continue even if the reading looks like a known set-up error.

    Returns
    -------
    RecutResult

    Raises
    ------
    JobError
        If a key of the reading is wrong, or a likely mistake explains it.
    AutobalanceError
        If the report, its solid or the limits of the correction are.
    """
    from autobalance.job.reading import read_reading
    from autobalance.report.records.report import Report
    from autobalance.verification.earlier_stage import earlier_stage

    notify, watch = telling(progress), Stopwatch()
    read = read_reading(reading)
    name = None if isinstance(reading, Mapping) else Path(reading).name
    notify("reading the crank")
    with watch.stage("load"):
        earlier = earlier_stage(Path(report))
    if earlier.number >= MOST_STAGES:
        raise FormatError(f"{earlier.path.name} is stage {earlier.number}; {MOST_STAGES} stages are the most")
    first = Path(os.path.normpath(earlier.first_report.parent))
    target = first / f"stage-{earlier.number + 1}" if folder is None else Path(folder)
    try:
        own, record, before, notes = RecutStage(earlier, read, trust_reading, notify, watch).made(target)
    except JobError as error:
        raise error if name is None else JobError(f"{name}: {error}") from None
    return RecutResult(Report.of(record), own, record, before, notes, target)


# A stage of ``recut``: the reading as judged, its likely mistakes, the cuts that it asks for.


Made = tuple[Job, Record, Crank, StageNotes]


class RecutStage:
    """One stage: the reading as judged, its likely mistakes, the cuts."""

    def __init__(
        self, earlier: EarlierStage, reading: MachineReading, trust: bool, notify: Notify, watch: Stopwatch
    ) -> None:

        self.earlier, self.reading, self.trust = earlier, reading, trust
        self.notify, self.watch = notify, watch
        self.tolerance = earlier.tolerance
        self.accuracy = MachineAccuracy(reading.urr, reading.umar_g_mm)
        self.job = for_recut(earlier.job, reading.correction)
        with watch.stage("measure"):
            self.crank = measured_source(
                earlier.source,
                earlier.anatomy,
                earlier.job.crankshaft.density_g_mm3,
                earlier.job.balance,
                work_on_faces(self.job),
            )
        loads = rotor_from_job.throw_loads(earlier.anatomy, self.job.engine)
        self.attached = rotor_from_job.attached_moments(self.job.engine.attached)
        self.loads = bob_weight_moments(loads, earlier.factor) + rotor_from_job.beside_throws(self.job.engine)
        self.fit_g = rotor_from_job.fitted_bob_weights_g(self.job, earlier.anatomy, earlier.factor)
        self.fitted_g = self._fitted()
        self.warnings: list[str] = []

    def _fitted(self) -> tuple[float, ...]:
        weights = self.reading.bob_weights_g
        if weights is not None and len(weights) != len(self.fit_g):
            throws = len(self.fit_g)
            raise JobError(
                f"bob_weights_g has {len(weights)} entries; the crank has {throws} throws, one each"
            )
        return self.fit_g if weights is None else weights

    def _off(self) -> Unbalance:
        """Return the job's weights on the rotor, less those that were on it while it was read."""
        off = Unbalance.of(rotor_from_job.oil_rest(self.job.engine))
        if not self.reading.attached_fitted:
            off = off + Unbalance.of(self.attached)
        for throw, fit, fitted in zip(self.earlier.anatomy.throws, self.fit_g, self.fitted_g, strict=True):
            off = off + _bob_weight(throw, fit - fitted)
        return off

    def _per_gram(self) -> Unbalance:

        total = Unbalance(np.zeros(2), np.zeros(2))
        for throw in self.earlier.anatomy.throws:
            total = total + _bob_weight(throw, 1.0)
        return total

    def _judged(self, planes: tuple[ReadPlane, ...], key: str, model: Unbalance) -> JudgedReading:

        readings = [PlaneReading(self._place(each, key), each.unbalance_g_mm) for each in planes]
        if len(readings) == 2 and readings[0].z_mm == readings[1].z_mm:
            raise JobError(f"{key}[2] is at z = {readings[1].z_mm:g} mm as {key}[1]; two planes must differ")
        zero = math.radians(self.reading.values["zero_deg"])
        return judged_reading(readings, self.accuracy, self._off(), model, self.tolerance.places_mm, zero)

    def _place(self, plane: ReadPlane, key: str) -> float | None:
        if plane.at is None:
            return plane.z_mm
        for known in self.tolerance.planes:
            if known.name == plane.at:
                return known.z_mm
        raise JobError(f'{key}.at is "{plane.at}", but the report has no tolerance planes; give z_mm')

    def made(self, folder: Path) -> Made:
        """Return the job as it was run, what was found, the crank as it came, and the stage's notes."""
        model = Unbalance.of(self.crank.moments + self.earlier.pressed_in + self.loads)
        judged = self._judged(self.reading.planes, "plane", model)
        if judged.static and self.tolerance.judge == "dynamic":
            self.warnings.append(
                'one plane was read, but judge is "dynamic": the moment is that of the model'
            )
        suspected = self._suspects(judged, model)
        rotor = self._rotor(judged)
        shown = machine_cannot_show(self.accuracy, self.tolerance)
        ended = self._ended(rotor, shown, needs_no_cut(judged, self.tolerance))
        notes = StageNotes(self.earlier, self.reading, judged, tuple(suspected), self.fitted_g)
        return self._recorded(ended, notes, folder)

    def _rotor(self, judged: JudgedReading) -> Rotor:
        """Return the crank as it was left, with loads that make its unbalance what was read."""
        rotor = rotor_of(self.job, self.crank, self.tolerance, self.earlier.factor)
        places = self.tolerance.places_mm
        return replace(
            rotor,
            loads=unbalance_moments(judged.unbalance - Unbalance.of(self.crank.moments)),
            budget=lambda _bare, _made, _left: judged.budget(places),
            earlier=self.earlier.earlier_cuts,
        )

    def _ended(self, rotor: Rotor, cannot: str | None, no_cut: bool) -> Result:

        if cannot is not None:
            return left_as_it_is(rotor, "above_tolerance", cannot)
        if no_cut:
            return left_as_it_is(rotor, "already_within_tolerance", None)
        measure = measure_of(self.crank.source)
        with self.watch.stage("plan"):
            try:
                return balance(
                    rotor,
                    self.tolerance,
                    self.job.methods,
                    measure,
                    self.notify,
                    prefer=self.job.prefer,
                    min_gain=self.job.min_gain,
                    cut_anyway=True,
                )
            except CorrectionError as error:
                raise JobError(f"correction: {error}") from None

    # --- mistakes -------------------------------------------------------------------------------------------

    def _suspects(self, judged: JudgedReading, model: Unbalance) -> list[StageSuspect]:

        before = self._reading_before(model)
        if before is None:
            self._warn_of_bob_weights(judged)
            return []
        cuts = self.earlier.unbalance("residual") - self.earlier.unbalance("initial")
        compared = ReadingComparison(judged, before, cuts, self._per_gram(), self.tolerance.places_mm)
        suspected = suspects(compared)
        if suspected and not self.trust:
            worst = suspected[0]
            raise JobError(
                f"{worst.key}: the change of reading differs by {worst.difference_g_mm:.3g} g·mm from "
                "the effect of the cuts; "
                f"only {worst.left_g_mm:.3g} are left if {worst.says}. "
                "Check the reading, or use --trust-reading"
            )
        self.warnings += [
            f"{each.key}: {each.says}? The change of reading is {each.difference_g_mm:.3g} g·mm off "
            "what the cuts "
            f"did, {each.left_g_mm:.3g} would be left"
            for each in suspected
        ]
        if not suspected and not compared.agrees:
            change = float(np.linalg.norm(compared.seen(judged.unbalance - before.unbalance)))
            did = float(np.linalg.norm(compared.seen(cuts)))
            off = float(np.linalg.norm(compared.difference))
            self.warnings.append(
                f"the reading changed by {change:.4g} g·mm, the cuts did {did:.4g} g·mm by the model; "
                "they differ "
                f"by {off:.4g} g·mm, more than both uncertainties, and no usual mistake explains it"
            )
        return suspected

    def _reading_before(self, model: Unbalance) -> JudgedReading | None:
        """Return the reading before the last cuts: of this file, or of the stage before."""
        if self.reading.before:
            return self._judged(self.reading.before, "before", model)
        if self.earlier.values["command"] != "recut":
            return None
        return earlier_reading(self.earlier)

    def _warn_of_bob_weights(self, judged: JudgedReading) -> None:
        """Warn if equal errors of all bob-weights would explain a first reading."""
        places = self.tolerance.places_mm
        left = Unbalance.of(rotor_from_job.overbalance_moments(self.earlier.job, self.tolerance))
        off = judged.unbalance - self.earlier.unbalance("residual") - left

        def seen(unbalance: Unbalance) -> Any:
            if places is None or judged.static:
                return unbalance.resultant_g_mm[None, :]
            return unbalance.in_planes(*places)

        doubts = judged.share.planes_g_mm if places and not judged.static else (judged.share.resultant_g_mm,)
        if (np.linalg.norm(seen(off), axis=1) <= MAX_DIFFERENCE_SIGMAS * np.array(doubts)).all():
            return
        fitted = bob_weight_fit(seen(off), seen(self._per_gram()))
        difference = float(np.linalg.norm(seen(off)))
        if fitted is not None and fitted[1] <= MAX_LEFT * difference:
            self.warnings.append(
                f"bob_weights_g: the reading differs by {difference:.4g} g·mm from the model; "
                "bob-weights that are "
                f"each {fitted[0]:+.2f} g off would explain it (a casting of another density looks the same)"
            )

    # --- the record -----------------------------------------------------------------------------------------

    def _recorded(self, ended: Result, notes: StageNotes, folder: Path) -> Made:
        record = record_of(self.job, self.crank, self.earlier.factor, self.tolerance, ended)
        assert record.balanced is not None
        factor = BalanceFactor(
            initial=self._factor(ended.initial),
            target=self.earlier.factor,
            final=self._factor(ended.residual),
        )
        crankshaft = replace(self.job.crankshaft, file=self.earlier.solid)
        own = replace(self.job, crankshaft=crankshaft)
        record = replace(
            with_outputs(record, own, self.crank, self.watch),
            command="recut",
            input=input_file(self.earlier.solid, self.crank),
            balanced=replace(record.balanced, factor=factor),
            warnings=tuple(self.warnings),
            staged=stage_values(notes, folder, ended),
            cuts_before=max((int(each["number"]) for each in self.earlier.cuts), default=0),
        )
        return own, record, Crank(self.crank, crankshaft), notes

    def _factor(self, unbalance: Unbalance) -> float | None:
        """Return the balance factor at which an unbalance, judged at the target, would be least."""
        loads = rotor_from_job.throw_loads(self.earlier.anatomy, self.job.engine)
        at_zero = unbalance.resultant_g_mm - self.earlier.factor * factor_direction_g_mm(loads)
        return balance_factor(at_zero, loads)


def _bob_weight(throw: Any, grams: float) -> Unbalance:
    """Return the unbalance of a mass in grams at the centre of a crankpin."""
    at = grams * throw.crankpin.centre_mm[:2]
    return Unbalance(at, at * float(throw.crankpin.centre_mm[2]))


def earlier_reading(earlier: EarlierStage) -> JudgedReading:
    """Return the reading that an earlier stage went by, as it was judged then."""
    reading = earlier.values["machine_reading"]
    judged = earlier.unbalance("initial")
    machine = Unbalance(np.array(reading["unbalance_g_mm"]), np.array(reading["moment_g_mm2"]))
    initial = earlier.values["initial"]
    planes = tuple(PlaneReading(each["z_mm"], complex(*each["unbalance_g_mm"])) for each in reading["planes"])
    doubts = tuple(float(each["uncertainty_g_mm"]) for each in initial["planes"])
    share = Share(float(initial["uncertainty_g_mm"]), doubts)
    return JudgedReading(judged, machine, judged - machine, share, planes, math.radians(reading["zero_deg"]))
