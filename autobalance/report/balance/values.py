"""The report as JSON values, with the entries of a stage: every key, ``None`` if it does not apply."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.balancing.record import Record
from autobalance.declare import changed, encoded
from autobalance.report.files import seen_from
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.balanced import BalancedReport
from autobalance.report.records.report import Report
from autobalance.report.records.stage import (
    Previous,
    ReadPlane,
    ReadUnbalance,
    Stage,
    Staged,
    StageUnbalance,
)
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.balancing.loop import Result
    from autobalance.balancing.machine_reading import JudgedReading, StageSuspect
    from autobalance.job.reading import MachineReading
    from autobalance.verification.earlier_stage import EarlierStage


# The report as JSON values: every key of the interface, ``None`` where a thing does not apply, never NaN.


Values = dict[str, Any]


def report(record: Record) -> Values:
    """Return the report of a run as JSON values, keys in the order of the interface."""
    values: Values = encoded(Report.of(record))
    return values


def dumps(values: Mapping[str, Any]) -> str:
    """Return a report as JSON text; raises ValueError for NaN and infinity.

    Bytes of a file's name that are not UTF-8 become JSON's escapes of lone surrogates, and read back as such.
    """
    text = json.dumps(values, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode("utf-8", "backslashreplace").decode()


def showable(values: Values) -> Values:
    """Return a report for pages, with question marks for bytes of a file's name that are not UTF-8."""
    text = json.dumps(values, ensure_ascii=False)
    shown = text.encode("utf-8", "replace").decode()
    shown_values: Values = values if shown == text else json.loads(shown)
    return shown_values


def schema() -> Values:
    """Return the JSON Schema (draft 2020-12) of reports."""
    from autobalance.report.records.report import written_schema

    return written_schema()


# Entries of a stage's report alone: the balancing machine's reading, and the stages before.


REPORT = "report.json"


@dataclass(frozen=True, eq=False)
class StageNotes:
    """Sources of the entries that only a stage's report has; paths are relative to its folder."""

    earlier: EarlierStage
    reading: MachineReading
    judged: JudgedReading
    suspects: tuple[StageSuspect, ...]
    fitted_g: tuple[float, ...]


def stage_values(notes: StageNotes, folder: Path, ended: Result) -> Staged:
    """Return the keys of a stage's report, its paths as seen from its folder."""
    earlier, machine = notes.earlier, notes.judged.machine
    before = BalancedReport.read(earlier.values)
    return Staged(
        serial=notes.reading.serial,
        previous=Previous(report=seen_from(folder, earlier.path), sha256=earlier.sha256),
        stages=[*_earlier_stages(earlier, before, folder), _stage(notes, before, ended)],
        machine_reading=ReadUnbalance(
            file=notes.reading.values,
            zero_deg=notes.reading.values["zero_deg"],
            unbalance_g_mm=machine.resultant_g_mm,
            moment_g_mm2=machine.moment_g_mm2,
            planes=[
                ReadPlane(z_mm=each.z_mm, unbalance_g_mm=[each.unbalance_g_mm.real, each.unbalance_g_mm.imag])
                for each in notes.judged.planes
            ],
        ),
        earlier_corrections=earlier.cuts,
        input_is_untouched=_untouched(before),
    )


def _stage(notes: StageNotes, before: BalancedReport, ended: Result) -> Stage:
    earlier, judged, places = notes.earlier, notes.judged, notes.earlier.tolerance.places_mm
    budget = judged.budget(places)
    apart = judged.unbalance - earlier.unbalance("residual")
    return Stage(
        stage=earlier.number + 1,
        serial=notes.reading.serial,
        report=REPORT,
        outcome=ended.outcome,
        bob_weights_g=notes.fitted_g,
        speed_rpm=notes.reading.speed_rpm,
        corrections=len(ended.corrections),
        removed_mass_g=-sum(each.change.mass_g for each in ended.corrections),
        reading=StageUnbalance.of(Unbalance.of(judged.unbalance, places, budget)),
        expected=StageUnbalance.of(before.residual),
        deviation=StageUnbalance.of(Unbalance.of(apart, places, budget)),
        predicted=StageUnbalance.of(Unbalance.of(ended.residual, places, budget)),
        suspects=notes.suspects,
    )


def _untouched(before: BalancedReport) -> bool:
    """Return whether the crank is still as it came: no stage has cut it."""
    return before.written.solid is None and (before.command == "balance" or before.input_is_untouched)


def _earlier_stages(earlier: EarlierStage, before: BalancedReport, folder: Path) -> list[Stage]:
    """Return the entries of the stages before, their paths as seen from a folder."""
    if before.stages:
        here = earlier.path.parent
        return [changed(each, report=seen_from(folder, here / each.report)) for each in before.stages]
    fit = [each.fit_g if hasattr(each, "fit_g") else each.mass_g for each in before.engine.bob_weights]
    return [
        Stage(
            stage=1,
            serial=None,
            report=seen_from(folder, earlier.path),
            outcome=before.outcome,
            bob_weights_g=fit,
            speed_rpm=None,
            corrections=len(before.corrections),
            removed_mass_g=sum(each.removed_mass_g for each in before.corrections),
            reading=None,
            expected=None,
            deviation=None,
            predicted=StageUnbalance.of(before.residual),
            suspects=[],
        )
    ]
