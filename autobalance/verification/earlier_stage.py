"""A report as the start of the next stage, and the check of a stage after the first."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.balancing import rotor_from_job, run
from autobalance.balancing.loop import Result
from autobalance.balancing.machine_reading import CAUSE
from autobalance.correction.contract import EarlierCut
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import ClaimError, FileError, FormatError
from autobalance.job import Job
from autobalance.rigid_rotor.tolerance import (
    OtherReading,
    Tolerance,
    TolerancePlane,
    permissible_unbalance_g_mm,
)
from autobalance.rigid_rotor.unbalance import Budget, Moments, Share, Unbalance
from autobalance.running_gear.parts import balance_factor, factor_direction_g_mm
from autobalance.solid.formats.read import Source, read
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verification import checked, premises, solids
from autobalance.verification.claimed_scan import with_scan
from autobalance.verification.claims import (
    BOTH_SOLIDS,
    CORRECTED_SOLID,
    FILES,
    INPUT_SOLID,
    RECORD,
    UNCERTAINTY_BUDGET,
    Claims,
)
from autobalance.verification.correction_claims import Change, check_corrections, check_nothing_cut
from autobalance.verification.premises import claimed_anatomy, claimed_job
from autobalance.verification.report_file import read_report
from autobalance.verification.solids import OriginalCrank, input_path

# A report of ``balance`` or ``recut`` as the start of the next stage: its solid, frame, loads and cuts.


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
    planes = tuple(each.record(TolerancePlane) for each in claims.entries("tolerance.planes"))
    several = "others" in claims.get("tolerance", dict)
    others = [each.record(OtherReading) for each in claims.entries("tolerance.others")] if several else []
    return Tolerance(
        float(claims.get("tolerance.grade_mm_s", float)),
        float(claims.get("tolerance.speed_rpm", float)) * RAD_S_PER_RPM,
        float(claims.get("tolerance.rotor_mass_g", float)),
        float(claims.get("tolerance.permissible_g_mm", float)),
        planes,
        job.balance.judge,
        job.balance.margin,
        tuple(others),
    )


def unbalance_moments(unbalance: Unbalance) -> Moments:
    """Return moments of an unbalance without mass."""
    first, second = np.zeros(3), np.zeros((3, 3))
    first[:2] = unbalance.resultant_g_mm
    second[:2, 2] = second[2, :2] = unbalance.moment_g_mm2
    return Moments(0.0, first, second)


# Check of the report of a stage after the first: both solids are measured; the reading is not checked.


def check_recut(held: checked.Held) -> checked.Checked:
    """Check every number that a stage's report claims, but the reading.

    Raises
    ------
    ClaimError
        If a claim fails.
    """
    claims, folder = held.claims, held.folder
    claims.hold("command")
    job, anatomy = premises.claimed_job(claims, folder), premises.claimed_anatomy(claims)
    claims.against("the report of the stage before")
    before = _report_before(claims, folder)
    tolerance = _tolerance(claims, job, before)
    claims.against(INPUT_SOLID)
    crank_before = _old_solid(held, job, anatomy)
    old = crank_before.crank.moments
    size = solids.size_of(crank_before.source, old)
    new, hidden, left, again = old, Moments.zero(), None, None
    is_cut = claims.get("outputs.solid", object) is not None
    claims.against(CORRECTED_SOLID)
    if is_cut:
        left = solids.measured_files(claims, folder, job, anatomy.file_to_rotor, held.files)
        if held.independent:
            again = solids.measured_again(claims, left.source, job, anatomy.file_to_rotor)
        hidden = solids.hidden_part(claims, job, anatomy, crank_before, left.soup)
        new = left.moments + hidden
        claims.against(BOTH_SOLIDS)
        change = Change(
            crank_before.source,
            left.source,
            left.moments - crank_before.bare,
            crank_before.anatomy,
            job,
            held.files,
        )
        check_corrections(claims, change, _first_number(before))
    else:
        claims.hold("outputs.solid")
        check_nothing_cut(claims)
    new = new + solids.pressed_in(claims)
    solids.check_with_slugs(claims, new)
    claims.against("the reading, resolved into its planes again")
    reading = _read(claims)
    checked.check_unbalance(claims, "initial", reading, tolerance, size)
    claims.against(BOTH_SOLIDS)
    residual = reading + Unbalance.of(new - old)
    checked.check_unbalance(claims, "residual", residual, tolerance, size)
    _factors(claims, job, anatomy, reading, residual)
    _stage(claims, residual, size, before)
    checked.check_assembly(claims, job, tolerance, residual, size)
    checked.check_inertia(claims, old, new)
    claims.against(UNCERTAINTY_BUDGET)
    budget = _budget(claims, tolerance)
    ends = checked.Ends(reading, residual, old, new, (None, budget), hidden)
    factor = float(claims.get("balance_factor.target", float))
    claims.against(RECORD)
    _check_as_recorded(held, job, crank_before, factor, tolerance, checked.ended(claims, ends, left))
    claims.against(BOTH_SOLIDS)
    checked.check_course(claims, ends, is_cut)
    claims.against(FILES)
    solids.check_pages(claims, folder)
    claims.against(BOTH_SOLIDS)
    within = _verdict(claims, tolerance, residual, budget, is_cut)
    return checked.Checked((), within, residual, tolerance, (), again, budget)


def _check_as_recorded(
    held: checked.Held, job: Job, before: OriginalCrank, factor: float, tolerance: Tolerance, result: Result
) -> None:
    """Compare a stage's report with a record made again from job and files."""
    webs = solids.webs_left(held.files, before.crank, result.solid)
    checked.check_like(held, run.record_of(job, before.crank, factor, tolerance, result, webs=webs))


def _report_before(claims: Claims, folder: Path) -> Mapping[str, Any]:
    """Check the file and the hash of the report of the stage before; return its values."""
    path = folder / claims.get("previous.report", str)
    if not path.is_file():
        raise FileError(f"{claims.name}: previous.report {path} is missing; a stage continues from it")
    claims.same("previous.sha256", hashlib.sha256(path.read_bytes()).hexdigest())
    claims.hold("previous.report")
    return read_report(path)


def _first_number(before: Mapping[str, Any]) -> int:
    """Return the number of a stage's first correction: numbering continues from the stages before."""
    return len(before.get("earlier_corrections", ())) + len(before["corrections"]) + 1


def _tolerance(claims: Claims, job: Job, before: Mapping[str, Any]) -> Tolerance:
    """Check tolerance, frame and anatomy against the stage before, and U_per against the grade."""
    tolerance = claimed_tolerance(claims, job)
    permissible = permissible_unbalance_g_mm(
        tolerance.rotor_mass_g, job.balance.grade_mm_s, job.balance.service_speed_rad_s
    )
    claims.near("tolerance.permissible_g_mm", permissible, permissible)
    claims.same("tolerance", before["tolerance"])
    claims.same("frame", before["frame"])
    recognised = ["main_journals", "throws", "webs", "journal_misalignment_mm", "datums"]
    later = ("roughness_mm", "axis_uncertainty", "cylinders", "doubts")
    recognised += [key for key in later if key in before["crank"]]
    # not equal to the last digit: angles went from degrees to radians and back
    claims.at("crank", claims.get("crank", dict)).alike({key: before["crank"][key] for key in recognised})
    claims.near("balance_factor.target", float(before["balance_factor"]["target"]), 1.0)
    if "oil" in before:
        claims.alike({"oil": before["oil"]})
    claims.same("earlier_corrections", [*before.get("earlier_corrections", ()), *before["corrections"]])
    untouched = before["outputs"]["solid"] is None and (
        before["command"] == "balance" or bool(before.get("input_is_untouched"))
    )
    claims.same("input_is_untouched", untouched)
    return tolerance


def _old_solid(held: checked.Held, job: Job, anatomy: Anatomy) -> OriginalCrank:
    """Check the claims of the crank that the stage started from; return it."""
    claims, crankshaft = held.claims, job.crankshaft
    path = solids.input_path(claims, held.folder)
    previous = held.folder / claims.get("previous.report", str)
    if not path.is_file():
        path = previous.parent / path.name
    if path.resolve() == (held.folder / claims.get("input.file", str)).resolve():
        claims.hold("input.file")
    else:
        claims.ledger.why_not["input.file"] = f"it was found as {path}"
    untouched = claims.get("input_is_untouched", bool)
    body = crankshaft.body if untouched else "all"
    pressed_up = untouched and not crankshaft.crankpin_in_file
    source = held.files.read(path, crankshaft.unit, body, pressed_up=pressed_up, holes=crankshaft.holes)
    solids.check_source(claims, "input", source)
    key = ("scan", id(source), id(claims.values))
    anatomy = held.files.once(key, lambda: with_scan(claims, anatomy, source.solid.mesh))
    return solids.check_crank(claims, job, source, anatomy, anatomy.file_to_rotor, held.files)


def _read(claims: Claims) -> Unbalance:
    """Return the reading as judged, which is not checked."""
    return Unbalance(claims.array("initial.unbalance_g_mm", (2,)), claims.array("initial.moment_g_mm2", (2,)))


def _factors(claims: Claims, job: Job, anatomy: Anatomy, reading: Unbalance, residual: Unbalance) -> None:
    """Check the bob-weights and the balance factors that follow from reading and residual."""
    target = float(claims.get("balance_factor.target", float))
    if job.balance.factor is not None:
        claims.near("balance_factor.target", job.balance.factor, 1.0)
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    fit_g = rotor_from_job.fitted_bob_weights_g(job, anatomy, target)
    listed = claims.entries("engine.bob_weights", len(loads))
    for part, load, fit in zip(listed, loads, fit_g, strict=True):
        part.near("mass_g", load.parts.bob_weight_g(target), load.parts.bob_weight_g(target))
        part.near("fit_g", fit, load.parts.bob_weight_g(target))
    for key, unbalance in (("initial", reading), ("final", residual)):
        factor = balance_factor(unbalance.resultant_g_mm - target * factor_direction_g_mm(loads), loads)
        if factor is None:
            claims.same(f"balance_factor.{key}", None)
        else:
            claims.near(f"balance_factor.{key}", factor, 10.0)


def _stage(claims: Claims, residual: Unbalance, size_g_mm: float, before: Mapping[str, Any]) -> None:
    """Check the list of stages: those of the report before, and this one."""
    stages = claims.entries("stages")
    if not stages:
        raise ClaimError(f"{claims.name}: stages is empty")
    last, parts = stages[-1], claims.entries("corrections")
    rounding = checked.MOMENT_ROUNDING
    last.same("stage", len(stages))
    last.same("serial", claims.get("serial", object))
    last.same("corrections", len(parts))
    last.same("outcome", claims.get("outcome", str))
    removed = sum(float(part.get("removed_mass_g", float)) for part in parts)
    last.near("removed_mass_g", removed, 1.0)
    last.near("predicted.unbalance_g_mm", residual.resultant_g_mm, size_g_mm, rounding)
    last.near("reading.unbalance_g_mm", _read(claims).resultant_g_mm, size_g_mm, rounding)
    for key, whole in (("predicted", "residual"), ("reading", "initial")):
        before_values = {name: claims.get(whole, dict).get(name) for name in last.get(key, dict)}
        last.at(key, last.get(key, dict)).alike(before_values, scale=0.01 * size_g_mm)
    listed = before.get("stages") or [{"stage": 1, "serial": None, "outcome": before["outcome"]}]
    if len(stages) != len(listed) + 1:
        raise ClaimError(f"{claims.name}: stages has {len(stages)} entries; expected {len(listed) + 1}")
    for part, each in zip(stages, listed, strict=False):
        for key, value in each.items():
            if key != "report":
                part.same(key, value)
    before_values = {name: before["residual"].get(name) for name in last.get("expected", dict)}
    last.at("expected", last.get("expected", dict)).alike(before_values, scale=0.01 * size_g_mm)


def _budget(claims: Claims, tolerance: Tolerance) -> Budget:
    """Return the uncertainty of the reading, the only cause in a stage's budget."""
    planes = tuple(
        float(part.get("uncertainty_g_mm", float))
        for part in claims.entries("initial.planes", len(tolerance.planes))
    )
    share = Share(float(claims.get("initial.uncertainty_g_mm", float)), planes)
    return Budget({CAUSE: share}, tolerance.places_mm)


def _verdict(claims: Claims, tolerance: Tolerance, residual: Unbalance, budget: Budget, is_cut: bool) -> bool:
    """Check the outcome: above tolerance also where U_mar is not below the permissible residual unbalance."""
    blind = float(
        claims.at("machine_reading.file", claims.get("machine_reading.file", dict)).get("umar_g_mm", float)
    )
    judged = [plane.permissible_g_mm for plane in tolerance.planes]
    judged = judged if tolerance.judge == "dynamic" else [tolerance.permissible_g_mm]
    within = tolerance.is_met_by(residual, budget) and all(blind < each for each in judged)
    return checked.check_verdict(claims, within, tolerance, residual, budget, is_cut)
