"""A stage of ``recut``: the reading as judged, its likely mistakes, the cuts that it asks for."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.balancing.loop import Result, balance, left_as_it_is
from autobalance.balancing.machine_reading import (
    JudgedReading,
    MachineAccuracy,
    PlaneReading,
    judged_reading,
    machine_cannot_show,
    needs_no_cut,
)
from autobalance.balancing.measured_crank import input_file, measured_source, work_on_faces
from autobalance.balancing.reading_mistakes import (
    MAX_DIFFERENCE_SIGMAS,
    MAX_LEFT,
    Comparison,
    Suspect,
    bob_weight_fit,
    suspects,
)
from autobalance.balancing.record import Factors, Record
from autobalance.balancing.rotor import Rotor
from autobalance.balancing.run import measure_of, record_of, rotor_of
from autobalance.errors import CorrectionError, JobError
from autobalance.job import Job
from autobalance.job.files.reading import MachineReading, ReadPlane
from autobalance.job.stage import for_recut
from autobalance.report.balance.stage_values import StageNotes, stage_values
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Share
from autobalance.running_gear.balance_factor import balance_factor, bob_weight_moments, factor_direction_g_mm
from autobalance.runtime import Notify, Stopwatch
from autobalance.verbs.crank import Crank
from autobalance.verbs.result_files import with_outputs
from autobalance.verification.earlier_stage import EarlierStage, unbalance_moments

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

    def _suspects(self, judged: JudgedReading, model: Unbalance) -> list[Suspect]:

        before = self._reading_before(model)
        if before is None:
            self._warn_of_bob_weights(judged)
            return []
        cuts = self.earlier.unbalance("residual") - self.earlier.unbalance("initial")
        compared = Comparison(judged, before, cuts, self._per_gram(), self.tolerance.places_mm)
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
        factors = Factors(self._factor(ended.initial), self.earlier.factor, self._factor(ended.residual))
        crankshaft = replace(self.job.crankshaft, file=self.earlier.solid)
        own = replace(self.job, crankshaft=crankshaft)
        record = replace(
            with_outputs(record, own, self.crank, self.watch),
            command="recut",
            input=input_file(self.earlier.solid, self.crank),
            balanced=replace(record.balanced, factors=factors),
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
