"""Read ``TRIALS.toml``: readings, trial weights and possible weights as complex numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import numpy as np

from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Key, Values, keys_of, made
from autobalance.errors import JobError
from autobalance.job.reading import AS_READ
from autobalance.test_stands.influence.fitted_weights import Fitting
from autobalance.test_stands.influence.limited_weights import (
    RECORDS_KEYS,
    Goal,
    Trial,
    changes,
    with_recorded_readings,
)
from autobalance.toml_files.document import text_of, toml_of
from autobalance.toml_files.keys import named_in, read_document
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

Reading = tuple[float, float]
PlaneName = int | str

Readings = tuple[Reading, ...] | str | tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class TrialRun:
    """``[[trial]]``: a run with a trial weight; ``readings`` are numbers once records were read."""

    plane: Annotated[PlaneName, "correction plane: a number or a name"]
    g_mm: Annotated[float | None, POSITIVE, "trial weight times its radius, added [g·mm]"] = None
    g: Annotated[float | None, POSITIVE, "or: trial weight [g], with radius_mm"] = None
    radius_mm: Annotated[float | None, POSITIVE, "radius of the trial weight [mm]"] = None
    angle_deg: Annotated[float, "angle at which it is added, counter-clockwise [°]"]
    readings: Annotated[
        Readings,
        "[amplitude, phase_deg] of each reading with the trial weight on, or a record, or one a speed",
    ]
    left_on: Annotated[bool, "whether it stays on for the trials after it"] = False

    def size_g_mm(self, where: str) -> float:
        """Return the trial's unbalance, given as ``g_mm``, or as ``g`` with ``radius_mm``.

        Raises
        ------
        JobError
            If neither or both are given.
        """
        if self.g_mm is not None:
            if self.g is not None:
                raise JobError(f"{where}.g is given with g_mm; expected one of them")
            return self.g_mm
        if self.g is None:
            raise JobError(f"{where}.g_mm is missing; or g with radius_mm")
        if self.radius_mm is None:
            raise JobError(f"{where}.radius_mm is missing; g needs it")
        return self.g * self.radius_mm


@dataclass(frozen=True, kw_only=True)
class FittedPlane:
    """``[[plane]]``: weights that can be fitted in a plane."""

    plane: Annotated[PlaneName, "a plane of the trials"]
    max_g_mm: Annotated[float | None, POSITIVE, "largest size of the plane's sum [g·mm]"] = None
    angles_deg: Annotated[
        tuple[float, ...] | None, "places, at most one weight at each [°]; none: any angle"
    ] = None
    weights_g_mm: Annotated[
        tuple[float, ...] | None, POSITIVE, "weights in stock, any number of each [g·mm]; none: any"
    ] = None
    max_weights: Annotated[int | None, COUNTED, "weights in the plane at most"] = None

    def fitting(self) -> Fitting:
        """Return the same for the search for weights."""
        angles, weights = self.angles_deg, self.weights_g_mm
        return Fitting(
            None if angles is None else np.radians(sorted({angle % 360.0 for angle in angles})),
            None if weights is None else np.array(sorted(set(weights))),
            self.max_weights,
            math.inf if self.max_g_mm is None else self.max_g_mm,
        )


SEAM_KEYS = (
    Key("at", tuple[Literal["A", "B"], ...], "tolerance plane of each plane of the trials", default=None),
    Key("z_mm", tuple[float, ...], "or: position of each along the axis, rotor frame [mm]", default=None),
    *AS_READ,
)
"""Conventions as in a reading file; ``rotation`` and ``zero_deg`` define the angles of the trials."""
TRIALS_KEYS = (
    Key("goal", Literal["least_squares", "least_worst"], "quantity to minimise", default="least_squares"),
    Key("phases", Literal["same", "opposite"], "sense in which phase_deg counts", default="same"),
    Key(
        "initial",
        Readings,
        "[amplitude, phase_deg] of each reading, all trial weights off, or a record, or one a speed",
    ),
    Key("reading_weights", tuple[float, ...], "weight of each reading", NOT_NEGATIVE, None),
    Key("target", float, "amplitude that each residual must not exceed", POSITIVE, None),
    Key("trial", says="runs with a trial weight, in their order", keys=keys_of(TrialRun), many=True),
    Key("plane", says="weights that can be fitted", keys=keys_of(FittedPlane), many=True, default=None),
    Key("records", says="evaluation of records into readings", keys=RECORDS_KEYS, default=None),
    Key("reading", says="conditions of the measurement that `recut` needs", keys=SEAM_KEYS, default=None),
)


@dataclass(frozen=True, eq=False)
class Trials:
    """The file as complex numbers; ``radius_mm`` by plane where the trials say one, else None.

    ``initial`` and the trials' readings are conjugated if phases count against the angles, so that weights
    and readings turn in one direction. ``phases_opposite`` records this for the written files.
    """

    values: Values
    planes: tuple[PlaneName, ...]
    initial: Complex
    reading_weights: Array
    trials: tuple[Trial, ...]
    fittings: tuple[Fitting, ...]
    radius_mm: tuple[float | None, ...]
    goal: Goal
    target: float | None
    phases_opposite: bool


def read_trials(source: str | Path | Mapping[str, Any]) -> Trials:
    """Read a trials file, or its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible, or a trial weight changes nothing.
    """
    if isinstance(source, Mapping):
        return read_document(with_recorded_readings(source, Path()), "", TRIALS_KEYS, _trials)
    path = Path(source)
    raw = toml_of(text_of(path, "trials file"), path.name)
    with named_in(path):
        values = with_recorded_readings(raw, path.parent)
        return read_document(values, "", TRIALS_KEYS, _trials)


def _trials(values: Values) -> Trials:
    count = len(values["initial"])
    if not count:
        raise JobError("initial is an empty list; expected at least one reading")
    opposite = values["phases"] == "opposite"
    runs = [made(TrialRun, each) for each in values["trial"]]
    planes = tuple(dict.fromkeys(run.plane for run in runs))
    if values["reading_weights"] is None:
        values["reading_weights"] = (1.0,) * count
    _check_length(values["reading_weights"], "reading_weights", count)
    if not any(values["reading_weights"]):
        raise JobError("reading_weights are all 0; at least one reading must count")
    if len(planes) > count:
        raise JobError(
            f"trial has {len(planes)} planes, initial {count} reading{'s' * (count > 1)}; expected at "
            "least as many readings as planes"
        )
    _check_seam(values["reading"], len(planes))
    initial = _readings(values["initial"], "initial", opposite)
    trials = tuple(
        _trial(run, f"trial[{number}]", planes, count, opposite) for number, run in enumerate(runs, 1)
    )
    _check_changes(initial, trials)
    return Trials(
        values,
        planes,
        initial,
        np.array(values["reading_weights"]),
        trials,
        _fittings([made(FittedPlane, each) for each in values["plane"]], planes),
        tuple(_radius(runs, plane) for plane in planes),
        values["goal"],
        values["target"],
        opposite,
    )


def _check_seam(seam: Values | None, planes: int) -> None:
    """Refuse a ``[reading]`` that ``recut`` does not take: one plane or two, each with its place."""
    if seam is None:
        return
    if planes > 2:
        raise JobError(f"reading is given for {planes} planes; recut takes one or two")
    places = [key for key in ("at", "z_mm") if seam[key] is not None]
    if len(places) != 1 and not (planes == 1 and not places):
        raise JobError(
            "reading.at is missing; or z_mm, one for each plane"
            if not places
            else "reading.at is given with z_mm; expected one of them"
        )
    for key in places:
        if len(seam[key]) != planes:
            raise JobError(f"reading.{key} has {len(seam[key])} entries; the trials have {planes} planes")


def _check_length(entries: tuple[Any, ...], where: str, count: int) -> None:
    if len(entries) != count:
        raise JobError(
            f"{where} has {len(entries)} entries; initial has {count}; expected one for each reading"
        )


def _readings(pairs: tuple[Reading, ...], where: str, opposite: bool) -> Complex:
    for number, (amplitude, _) in enumerate(pairs, 1):
        if amplitude < 0.0:
            raise JobError(f"{where}[{number}] has an amplitude of {amplitude:g}; must be ≥ 0")
    readings = np.array([a * np.exp(1j * math.radians(phase)) for a, phase in pairs], dtype=complex)
    return np.conj(readings) if opposite else readings


def _trial(run: TrialRun, where: str, planes: tuple[PlaneName, ...], count: int, opposite: bool) -> Trial:
    pairs = cast("tuple[Reading, ...]", run.readings)  # records were read before
    _check_length(pairs, f"{where}.readings", count)
    weight = run.size_g_mm(where) * np.exp(1j * math.radians(run.angle_deg))
    readings = _readings(pairs, f"{where}.readings", opposite)
    return Trial(planes.index(run.plane), complex(weight), readings, run.left_on)


LEAST_CHANGE = 1e-6
"""Share of the largest amplitude: a trial weight that changes less shows nothing."""


def _check_changes(initial: Complex, trials: tuple[Trial, ...]) -> None:
    greatest = max(
        float(np.abs(readings).max()) for readings in (initial, *(each.readings for each in trials))
    )
    for number, change in enumerate(changes(initial, trials), 1):
        if float(np.abs(change).max()) < LEAST_CHANGE * greatest or not change.any():
            raise JobError(
                f"trial[{number}]: changes nothing; its readings are those without it; choose a heavier "
                "weight or another place"
            )


def _radius(runs: list[TrialRun], plane: PlaneName) -> float | None:
    """Return the radius of a plane's trial weights; None if they state no radius, or differ."""
    radii = {run.radius_mm for run in runs if run.plane == plane and run.radius_mm is not None}
    return radii.pop() if len(radii) == 1 else None


def _fittings(fitted: list[FittedPlane], planes: tuple[PlaneName, ...]) -> tuple[Fitting, ...]:
    fittings = dict.fromkeys(planes, Fitting())
    seen = set()
    for number, each in enumerate(fitted, 1):
        where, plane = f"plane[{number}]", each.plane
        if plane not in fittings:
            listed = ", ".join(str(known) for known in planes)
            raise JobError(f"{where}.plane is {plane!r}; no trial is in that plane: {listed}")
        if plane in seen:
            raise JobError(f"{where}.plane is {plane!r} twice; each plane may be listed once")
        seen.add(plane)
        for key in ("angles_deg", "weights_g_mm"):
            if getattr(each, key) == ():
                raise JobError(f"{where}.{key} is an empty list; leave it out, or name at least one")
        fittings[plane] = each.fitting()
    return tuple(fittings.values())
