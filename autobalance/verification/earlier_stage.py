"""A report of ``balance`` or ``recut`` as the start of the next stage: its solid, frame, loads and cuts."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.correction.contract import EarlierCut
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import ClaimError, FileError, FormatError
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import OtherReading, Tolerance, TolerancePlane
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.formats.read import Source, read
from autobalance.units import RAD_S_PER_RPM
from autobalance.verification.claimed_scan import with_scan
from autobalance.verification.claims import Claims
from autobalance.verification.premises import claimed_anatomy, claimed_job
from autobalance.verification.report_file import read_report
from autobalance.verification.solids import input_path

COMMANDS = ("balance", "recut")
"""Commands whose reports have a job and a corrected solid."""


@dataclass(frozen=True, eq=False)
class EarlierStage:
    """Start of the next stage.

    ``solid`` is the file of the crank as it was left and ``source`` its content; ``pressed_in`` are all its
    slugs, ``cuts`` its corrections and those of the stages before, as the reports list them.
    """

    path: Path
    sha256: str
    values: Mapping[str, Any]
    job: Job
    anatomy: Anatomy
    tolerance: Tolerance
    factor: float
    solid: Path
    source: Source
    cuts: tuple[Mapping[str, Any], ...]
    pressed_in: Moments

    @property
    def number(self) -> int:
        """Number of the stage, 1 for ``balance``."""
        stages = self.values.get("stages")
        return int(stages[-1]["stage"]) if stages else 1

    @property
    def first_report(self) -> Path:
        stages = self.values.get("stages")
        return self.path.parent / stages[0]["report"] if stages else self.path

    @property
    def earlier_cuts(self) -> tuple[EarlierCut, ...]:
        """Earlier cuts by place, for limits of their number; a deepened hole counts once."""
        cuts_found: list[EarlierCut] = []
        for each in self.cuts:
            entry = each.get("entry_mm") or each["position_mm"]  # a hole that was deepened: where it began
            place = np.array(entry, dtype=float)
            cut = EarlierCut(str(each["kind"]), each.get("web"), place, each.get("diameter_mm"))
            if not any(other.kind == cut.kind and other.is_at(cut.position_mm) for other in cuts_found):
                cuts_found.append(cut)
        return tuple(cuts_found)

    def unbalance(self, key: str) -> Unbalance:
        """Return the report's unbalance at ``initial`` or ``residual``."""
        values = self.values[key]
        return Unbalance(np.array(values["unbalance_g_mm"]), np.array(values["moment_g_mm2"]))


def earlier_stage(path: Path) -> EarlierStage:
    """Read a report and the solid that it left.

    Raises
    ------
    FileError
        If the report or its solid is gone.
    FormatError, ClaimError
        If the report is none of ``balance`` or ``recut``, or the solid is another.
    """
    claims = Claims(path.name, read_report(path))
    command = claims.get("command", str)
    if command not in COMMANDS:
        raise FormatError(f"{path.name} is a report of {command!r}; expected one of {', '.join(COMMANDS)}")
    job = claimed_job(claims, path.parent)
    anatomy = claimed_anatomy(claims)
    solid, source = left_solid(path, claims, job)
    anatomy = with_scan(claims, anatomy, source.solid.mesh)
    cuts = (*claims.values.get("earlier_corrections", ()), *claims.get("corrections", list))
    return EarlierStage(
        path,
        hashlib.sha256(path.read_bytes()).hexdigest(),
        claims.values,
        job,
        anatomy,
        claimed_tolerance(claims, job),
        float(claims.get("balance_factor.target", float)),
        solid,
        source,
        tuple(cuts),
        slugs(cuts),
    )


def slugs(cuts: Any) -> Moments:
    """Return the slugs of listed corrections: they are not in the solid's file."""
    total = Moments.zero()
    for each in cuts:
        if each.get("slug_mass_g") is not None:
            total = total + Moments.point(float(each["slug_mass_g"]), np.array(each["slug_centre_mm"]))
    return total


def left_solid(path: Path, claims: Claims, job: Job) -> tuple[Path, Source]:
    """Return the file and the solid that a report left: its own, or the one it started from."""
    crankshaft = job.crankshaft
    entry = claims.get("outputs.solid", object)
    if entry is None:
        solid, digest = input_path(claims, path.parent), claims.get("input.sha256", str)
        first = claims.get("command", str) == "balance" or bool(claims.values.get("input_is_untouched"))
    else:
        solid, digest, first = path.parent / Path(str(entry["file"])).name, entry["sha256"], False
    if not solid.is_file():
        raise FileError(f"{path.name}: its solid {solid} is missing; put it next to the report")
    if hashlib.sha256(solid.read_bytes()).hexdigest() != digest:
        raise ClaimError(f"{path.name}: {solid} is not the solid of this report: its sha256 differs")
    body = crankshaft.body if first else "all"
    return solid, read(solid, crankshaft.unit, body, pressed_up=first and not crankshaft.crankpin_in_file)


def claimed_tolerance(claims: Claims, job: Job) -> Tolerance:
    """Return the tolerance of a report, which is fixed from the first stage on."""

    def planes_of(listed: Sequence[Mapping[str, Any]]) -> tuple[TolerancePlane, ...]:
        return tuple(
            TolerancePlane(each["name"], float(each["z_mm"]), float(each["permissible_g_mm"]))
            for each in listed
        )

    tolerance = claims.get("tolerance", dict)
    return Tolerance(
        float(claims.get("tolerance.grade_mm_s", float)),
        float(claims.get("tolerance.speed_rpm", float)) * RAD_S_PER_RPM,
        float(claims.get("tolerance.rotor_mass_g", float)),
        float(claims.get("tolerance.permissible_g_mm", float)),
        planes_of(claims.get("tolerance.planes", list)),
        job.balance.judge,
        job.balance.margin,
        tuple(
            OtherReading(str(each["meant"]), planes_of(each["planes"]))
            for each in tolerance.get("others", ())
        ),
    )


def unbalance_moments(unbalance: Unbalance) -> Moments:
    """Return moments of an unbalance without mass."""
    first, second = np.zeros(3), np.zeros((3, 3))
    first[:2] = unbalance.resultant_g_mm
    second[:2, 2] = second[2, :2] = unbalance.moment_g_mm2
    return Moments(0.0, first, second)
