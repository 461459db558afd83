"""``ab.recut``: a corrected crank was spun on a balancing machine; what is still to cut."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.api.balance import REPORT, BalanceResult, choice_of, staged
from autobalance.api.progress import Progress, telling
from autobalance.errors import FormatError, JobError
from autobalance.report.files import Staging
from autobalance.runtime import Stopwatch

if TYPE_CHECKING:
    from autobalance.api.balance import Tell
    from autobalance.balancing.loop import Result
    from autobalance.balancing.machine_reading import JudgedReading
    from autobalance.balancing.reading_mistakes import Suspect
    from autobalance.balancing.rotor import Rotor
    from autobalance.job import Job
    from autobalance.job.reading import MachineReading, ReadPlane
    from autobalance.report.bundle import Choice
    from autobalance.rigid_rotor.unbalance import Unbalance
    from autobalance.verification.earlier_stage import EarlierStage

Values = dict[str, Any]
MOST_STAGES = 10
HISTORY = "history.html"
UNBALANCE_KEYS = (
    "unbalance_g_mm",
    "magnitude_g_mm",
    "angle_deg",
    "planes",
    "moment_g_mm2",
    "uncertainty_g_mm",
)


@dataclass(frozen=True, eq=False)
class StageNotes:
    """What the report of a stage says besides what every run says; paths are found from its folder."""

    earlier: EarlierStage
    reading: MachineReading
    judged: JudgedReading
    suspects: tuple[Suspect, ...]
    fitted_g: tuple[float, ...]


@dataclass(frozen=True, eq=False, repr=False)
class RecutResult(BalanceResult):
    """The end of a stage; ``stages`` of the report has all of them so far."""

    notes: StageNotes
    folder: Path

    @property
    def stage(self) -> int:
        """Number of the stage."""
        return int(self.report["stages"][-1]["stage"])

    @cached_property
    def history(self) -> str:
        """The page of all stages."""
        from autobalance.report.history import history_page

        return history_page(self.report)

    def text(self, units: str = "metric") -> str:
        """Return the summary that the command prints."""
        from autobalance.report.recut_text import recut_text
        from autobalance.report.text import UNITS

        return recut_text(self.report, UNITS[units])

    def write(
        self,
        folder: str | Path | None = None,
        only: tuple[str, ...] | None = None,
        *,
        paper: str = "A4",
        units: str = "metric",
        date: str | None = None,
        progress: Progress | None = None,
    ) -> tuple[Path, ...]:
        """Write the solid, ``report.json``, ``history.html`` and the pages: all files or none.

        ``folder`` is ``stage-N`` in the folder of the first stage's report unless given; for the rest see
        ``BalanceResult.write``.
        """
        target = self.folder if folder is None else Path(folder)
        with Staging([target]) as staging:
            _, files = stage_files(
                self, target, choice_of(only, paper, units, date), telling(progress), staging
            )
            staging.commit()
        return files


def stage_files(
    result: RecutResult, folder: Path, choice: Choice, tell: Tell, staging: Staging
) -> tuple[Values, tuple[Path, ...]]:
    """Stage all files of a result for a folder; return the report and the files."""
    from autobalance.report.history import history_page
    from autobalance.report.json import report

    placed = _placed(result, folder)
    page = history_page(report(placed.record)).encode()
    staging.add(folder / HISTORY, page)
    entry = {"file": HISTORY, "sha256": hashlib.sha256(page).hexdigest()}
    record = replace(placed.record, outputs={**placed.record.outputs, "history": entry})
    values, files = staged(replace(placed, record=record), folder, choice, tell, staging)
    return values, (*files, folder / HISTORY)


def _placed(result: RecutResult, folder: Path) -> RecutResult:
    """Return a result whose report names other reports as seen from a folder."""
    record = result.record
    assert record.balanced is not None
    extra = staged_values(result.notes, folder, record.balanced.result)
    return replace(result, record=replace(record, staged=extra))


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
        Of ``balance`` or of an earlier ``recut``, its solid beside it.
    reading : path or dict
        A ``READING.toml`` or its structure.
    folder : path or None
        Where the result will be written; None: ``stage-N`` in the folder of the first stage's report.
    trust_reading : bool
        Go on where a mistake would explain the reading better than the crank does.
    progress : callable or None
        Told words and the share done.

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
    from autobalance.verification.earlier_stage import earlier_stage

    tell, watch = telling(progress), Stopwatch()
    read = read_reading(reading)
    name = None if isinstance(reading, Mapping) else Path(reading).name
    tell("reading the crank")
    with watch.stage("load"):
        earlier = earlier_stage(Path(report))
    if earlier.number >= MOST_STAGES:
        raise FormatError(f"{earlier.path.name} is stage {earlier.number}; {MOST_STAGES} stages are the most")
    target = earlier.first_report.parent / f"stage-{earlier.number + 1}" if folder is None else Path(folder)
    try:
        return _Stage(earlier, read, trust_reading, tell, watch).result(target)
    except JobError as error:
        raise error if name is None else JobError(f"{name}: {error}") from None


class _Stage:
    """One stage: the reading as judged, its likely mistakes, the cuts."""

    def __init__(
        self, earlier: EarlierStage, reading: MachineReading, trust: bool, tell: Tell, watch: Stopwatch
    ) -> None:
        from autobalance.balancing import rotor_from_job
        from autobalance.balancing.machine_reading import MachineAccuracy
        from autobalance.balancing.measured_crank import measured_source, work_on_faces
        from autobalance.engine.balance_factor import bob_weight_moments

        self.earlier, self.reading, self.trust = earlier, reading, trust
        self.tell, self.watch = tell, watch
        self.tolerance = earlier.tolerance
        self.accuracy = MachineAccuracy(reading.urr, reading.umar_g_mm)
        self.job = _job(earlier.job, reading)
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
        self.loads = bob_weight_moments(loads, earlier.factor) + self.attached
        self.fit_g = rotor_from_job.fitted_bob_weights_g(self.job, earlier.anatomy, earlier.factor)
        self.fitted_g = self._fitted()
        self.warnings: list[str] = []

    def _fitted(self) -> tuple[float, ...]:
        given = self.reading.bob_weights_g
        if given is not None and len(given) != len(self.fit_g):
            throws = len(self.fit_g)
            raise JobError(f"bob_weights_g has {len(given)} entries; the crank has {throws} throws, one each")
        return self.fit_g if given is None else given

    def _off(self) -> Unbalance:
        """Return what the job hangs on the rotor less what was on it."""
        from autobalance.rigid_rotor.unbalance import Unbalance

        off = (
            Unbalance(np.zeros(2), np.zeros(2))
            if self.reading.attached_fitted
            else Unbalance.of(self.attached)
        )
        for throw, fit, fitted in zip(self.earlier.anatomy.throws, self.fit_g, self.fitted_g, strict=True):
            off = off + _bob_weight(throw, fit - fitted)
        return off

    def _per_gram(self) -> Unbalance:
        from autobalance.rigid_rotor.unbalance import Unbalance

        total = Unbalance(np.zeros(2), np.zeros(2))
        for throw in self.earlier.anatomy.throws:
            total = total + _bob_weight(throw, 1.0)
        return total

    def _judged(self, planes: tuple[ReadPlane, ...], key: str, model: Unbalance) -> JudgedReading:
        from autobalance.balancing.machine_reading import PlaneReading, judged_reading

        found = [PlaneReading(self._place(each, key), each.unbalance_g_mm) for each in planes]
        if len(found) == 2 and found[0].z_mm == found[1].z_mm:
            raise JobError(f"{key}[2] stands at z = {found[1].z_mm:g} mm as {key}[1]; two planes must differ")
        zero = math.radians(self.reading.values["zero_deg"])
        return judged_reading(found, self.accuracy, self._off(), model, self.tolerance.places_mm, zero)

    def _place(self, plane: ReadPlane, key: str) -> float | None:
        if plane.at is None:
            return plane.z_mm
        for known in self.tolerance.planes:
            if known.name == plane.at:
                return known.z_mm
        raise JobError(f'{key}.at is "{plane.at}", but the report has no tolerance planes; give z_mm')

    def result(self, folder: Path) -> RecutResult:
        from autobalance.balancing.machine_reading import machine_cannot_show, needs_no_cut
        from autobalance.rigid_rotor.unbalance import Unbalance

        model = Unbalance.of(self.crank.moments + self.earlier.pressed_in + self.loads)
        judged = self._judged(self.reading.planes, "plane", model)
        if judged.static and self.tolerance.judge == "dynamic":
            self.warnings.append(
                'one plane was read, but judge is "dynamic": the moment is that of the model'
            )
        found = self._suspects(judged, model)
        rotor = self._rotor(judged)
        shown = machine_cannot_show(self.accuracy, self.tolerance)
        ended = self._ended(rotor, shown, needs_no_cut(judged, self.tolerance))
        notes = StageNotes(self.earlier, self.reading, judged, tuple(found), self.fitted_g)
        return self._recorded(ended, notes, folder)

    def _rotor(self, judged: JudgedReading) -> Rotor:
        """Return the crank as it was left, with loads that make its unbalance what was read."""
        from autobalance.balancing.run import rotor_of
        from autobalance.rigid_rotor.unbalance import Unbalance
        from autobalance.verification.earlier_stage import unbalance_moments

        rotor = rotor_of(self.job, self.crank, self.tolerance, self.earlier.factor)
        places = self.tolerance.places_mm
        return replace(
            rotor,
            loads=unbalance_moments(judged.unbalance - Unbalance.of(self.crank.moments)),
            budget=lambda _bare, _made: judged.budget(places),
            earlier=self.earlier.earlier_cuts,
        )

    def _ended(self, rotor: Rotor, cannot: str | None, no_cut: bool) -> Result:
        from autobalance.balancing.loop import balance, left_as_it_is
        from autobalance.balancing.run import measure_of
        from autobalance.errors import CorrectionError

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
                    self.tell,
                    prefer=self.job.prefer,
                    cut_anyway=True,
                )
            except CorrectionError as error:
                raise JobError(f"correction: {error}") from None

    # --- mistakes -------------------------------------------------------------------------------------------

    def _suspects(self, judged: JudgedReading, model: Unbalance) -> list[Suspect]:
        from autobalance.balancing.reading_mistakes import Comparison, suspects

        before = self._reading_before(model)
        if before is None:
            self._look_at_bob_weights(judged)
            return []
        cuts = self.earlier.unbalance("residual") - self.earlier.unbalance("initial")
        compared = Comparison(judged, before, cuts, self._per_gram(), self.tolerance.places_mm)
        found = suspects(compared)
        if found and not self.trust:
            worst = found[0]
            raise JobError(
                f"{worst.key}: the change of reading is {worst.difference_g_mm:.3g} g·mm off what the "
                "cuts did; "
                f"only {worst.left_g_mm:.3g} are left if {worst.says}; --trust-reading goes on"
            )
        self.warnings += [
            f"{each.key}: {each.says}? The change of reading is {each.difference_g_mm:.3g} g·mm off "
            "what the cuts "
            f"did, {each.left_g_mm:.3g} would be left"
            for each in found
        ]
        if not found and not compared.agrees:
            change = float(np.linalg.norm(compared.seen(judged.unbalance - before.unbalance)))
            did = float(np.linalg.norm(compared.seen(cuts)))
            off = float(np.linalg.norm(compared.difference))
            self.warnings.append(
                f"the reading changed by {change:.4g} g·mm, the cuts did {did:.4g} g·mm by the model; "
                "they differ "
                f"by {off:.4g} g·mm, more than both uncertainties, and no usual mistake explains it"
            )
        return found

    def _reading_before(self, model: Unbalance) -> JudgedReading | None:
        """Return what was read before the last cuts: by this file, or as the stage before says."""
        if self.reading.before:
            return self._judged(self.reading.before, "before", model)
        if self.earlier.values["command"] != "recut":
            return None
        return earlier_reading(self.earlier)

    def _look_at_bob_weights(self, judged: JudgedReading) -> None:
        """Warn where bob-weights that are all off alike would explain a first reading."""
        from autobalance.balancing import rotor_from_job
        from autobalance.balancing.reading_mistakes import DOUBTS, EXPLAINS, bob_weight_fit
        from autobalance.rigid_rotor.unbalance import Unbalance

        places = self.tolerance.places_mm
        left = Unbalance.of(rotor_from_job.overbalance_moments(self.earlier.job, self.tolerance))
        off = judged.unbalance - self.earlier.unbalance("residual") - left

        def seen(unbalance: Unbalance) -> Any:
            if places is None or judged.static:
                return unbalance.resultant_g_mm[None, :]
            return unbalance.in_planes(*places)

        doubts = judged.share.planes_g_mm if places and not judged.static else (judged.share.resultant_g_mm,)
        if (np.linalg.norm(seen(off), axis=1) <= DOUBTS * np.array(doubts)).all():
            return
        fitted = bob_weight_fit(seen(off), seen(self._per_gram()))
        difference = float(np.linalg.norm(seen(off)))
        if fitted is not None and fitted[1] <= EXPLAINS * difference:
            self.warnings.append(
                f"bob_weights_g: the reading is {difference:.4g} g·mm off what the model says; "
                "bob-weights that are "
                f"each {fitted[0]:+.2f} g off would explain it (a casting of another density looks the same)"
            )

    # --- the record -----------------------------------------------------------------------------------------

    def _recorded(self, ended: Result, notes: StageNotes, folder: Path) -> RecutResult:
        import time

        from autobalance.api.balance import solid_entry_of
        from autobalance.api.crank import Crank
        from autobalance.balancing.record import Factors
        from autobalance.balancing.run import input_file, record_of
        from autobalance.report.json import report

        record = record_of(self.job, self.crank, self.earlier.factor, self.tolerance, ended)
        assert record.balanced is not None
        factors = Factors(self._factor(ended.initial), self.earlier.factor, self._factor(ended.residual))
        crankshaft = replace(self.job.crankshaft, file=self.earlier.solid)
        own = replace(self.job, crankshaft=crankshaft)
        started = time.perf_counter()
        outputs = {"solid": solid_entry_of(own, self.crank, record)}
        self.watch.add("write", time.perf_counter() - started)
        record = replace(
            record,
            command="recut",
            input=input_file(self.earlier.solid, self.crank),
            balanced=replace(record.balanced, factors=factors),
            warnings=tuple(self.warnings),
            outputs=outputs,
            seconds=self.watch.seconds,
            staged=staged_values(notes, folder, ended),
            cuts_before=max((int(each["number"]) for each in self.earlier.cuts), default=0),
        )
        return RecutResult(report(record), own, record, Crank(self.crank, crankshaft), notes, folder)

    def _factor(self, unbalance: Unbalance) -> float | None:
        """Return the balance factor at which an unbalance, judged at the target, would be least."""
        from autobalance.balancing import rotor_from_job
        from autobalance.engine.balance_factor import balance_factor, factor_direction_g_mm

        loads = rotor_from_job.throw_loads(self.earlier.anatomy, self.job.engine)
        at_zero = unbalance.resultant_g_mm - self.earlier.factor * factor_direction_g_mm(loads)
        return balance_factor(at_zero, loads)


def _bob_weight(throw: Any, grams: float) -> Unbalance:
    """Return what grams at the centre of a crankpin add."""
    from autobalance.rigid_rotor.unbalance import Unbalance

    at = grams * throw.crankpin.centre_mm[:2]
    return Unbalance(at, at * float(throw.crankpin.centre_mm[2]))


def _job(job: Job, reading: MachineReading) -> Job:
    """Return the job with the reading's [correction] in place of its own."""
    from autobalance import job as jobs

    if reading.correction is None:
        return job
    return jobs.parse({**job.raw, "correction": reading.correction}, job.path)


def earlier_reading(earlier: EarlierStage) -> JudgedReading:
    """Return the reading that an earlier stage went by, as it was judged then."""
    from autobalance.balancing.machine_reading import JudgedReading, PlaneReading
    from autobalance.rigid_rotor.unbalance import Unbalance
    from autobalance.rigid_rotor.uncertainty import Share

    said = earlier.values["machine_reading"]
    judged = earlier.unbalance("initial")
    machine = Unbalance(np.array(said["unbalance_g_mm"]), np.array(said["moment_g_mm2"]))
    initial = earlier.values["initial"]
    planes = tuple(PlaneReading(each["z_mm"], complex(*each["unbalance_g_mm"])) for each in said["planes"])
    doubts = tuple(float(each["uncertainty_g_mm"]) for each in initial["planes"])
    share = Share(float(initial["uncertainty_g_mm"]), doubts)
    return JudgedReading(judged, machine, judged - machine, share, planes, math.radians(said["zero_deg"]))


# --- what only a stage's report says ------------------------------------------------------------------------


def staged_values(notes: StageNotes, folder: Path, ended: Result) -> Values:
    """Return the keys of a stage's report, its paths as seen from its folder."""
    from autobalance.report.json import unbalance_values

    earlier, places = notes.earlier, notes.earlier.tolerance.places_mm
    read = unbalance_values(notes.judged.unbalance, places, notes.judged.budget(places))
    expected = earlier.values["residual"]
    apart = notes.judged.unbalance - earlier.unbalance("residual")
    stage = {
        "stage": earlier.number + 1,
        "serial": notes.reading.serial,
        "report": REPORT,
        "outcome": ended.outcome,
        "bob_weights_g": list(notes.fitted_g),
        "speed_rpm": notes.reading.speed_rpm,
        "corrections": len(ended.corrections),
        "removed_mass_g": -sum(each.change.mass_g for each in ended.corrections),
        "reading": _told(read),
        "expected": _told(expected),
        "deviation": _told(unbalance_values(apart, places, notes.judged.budget(places))),
        "predicted": _told(unbalance_values(ended.residual, places, notes.judged.budget(places))),
        "suspects": [
            {
                "cause": each.cause,
                "key": each.key,
                "difference_g_mm": each.difference_g_mm,
                "left_g_mm": each.left_g_mm,
                "says": each.says,
            }
            for each in notes.suspects
        ],
    }
    machine = notes.judged.machine
    return {
        "serial": notes.reading.serial,
        "previous": {"report": _seen_from(folder, earlier.path), "sha256": earlier.sha256},
        "stages": [*_earlier_stages(earlier, folder), stage],
        "machine_reading": {
            "file": notes.reading.values,
            "zero_deg": notes.reading.values["zero_deg"],
            "unbalance_g_mm": [float(each) for each in machine.resultant_g_mm],
            "moment_g_mm2": [float(each) for each in machine.moment_g_mm2],
            "planes": [
                {
                    "z_mm": each.z_mm,
                    "unbalance_g_mm": [each.unbalance_g_mm.real, each.unbalance_g_mm.imag],
                }
                for each in notes.judged.planes
            ],
        },
        "earlier_corrections": [dict(each) for each in earlier.cuts],
        "input_is_untouched": _untouched(earlier),
    }


def _untouched(earlier: EarlierStage) -> bool:
    """Tell whether the crank is still as it came: no stage has cut it."""
    if earlier.values["outputs"]["solid"] is not None:
        return False
    return earlier.values["command"] == "balance" or bool(earlier.values["input_is_untouched"])


def _told(values: Mapping[str, Any]) -> Values:
    return {key: values[key] for key in UNBALANCE_KEYS}


def _earlier_stages(earlier: EarlierStage, folder: Path) -> list[Values]:
    """Return the entries of the stages before, their paths as seen from a folder."""
    listed = earlier.values.get("stages")
    if listed:
        here = earlier.path.parent
        return [{**each, "report": _seen_from(folder, here / each["report"])} for each in listed]
    corrections = earlier.values["corrections"]
    fit = [each.get("fit_g", each["mass_g"]) for each in earlier.values["engine"]["bob_weights"]]
    return [
        {
            "stage": 1,
            "serial": None,
            "report": _seen_from(folder, earlier.path),
            "outcome": earlier.values["outcome"],
            "bob_weights_g": fit,
            "speed_rpm": None,
            "corrections": len(corrections),
            "removed_mass_g": sum(each["removed_mass_g"] for each in corrections),
            "reading": None,
            "expected": None,
            "deviation": None,
            "predicted": _told(earlier.values["residual"]),
            "suspects": [],
        }
    ]


def _seen_from(folder: Path, path: Path) -> str:
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
