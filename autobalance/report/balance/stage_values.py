"""What only the report of a stage says: what a balancing machine read, and the stages before."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.report.balance.values import unbalance_values

if TYPE_CHECKING:
    from autobalance.balancing.loop import Result
    from autobalance.balancing.machine_reading import JudgedReading
    from autobalance.balancing.reading_mistakes import Suspect
    from autobalance.job.files.reading import MachineReading
    from autobalance.verification.earlier_stage import EarlierStage

Values = dict[str, Any]
REPORT = "report.json"
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


def stage_values(notes: StageNotes, folder: Path, ended: Result) -> Values:
    """Return the keys of a stage's report, its paths as seen from its folder."""
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
    """Return whether the crank is still as it came: no stage has cut it."""
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
