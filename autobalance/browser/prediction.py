"""Effect of other depths, places and weights, by a linear model about a measured result."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np

from autobalance.declare import Pair, Triple, decoded, encoded, record
from autobalance.errors import JobError
from autobalance.report.records.balance import Plane
from autobalance.rigid_rotor.tolerance import TolerancePlane
from autobalance.types import Array, Values
from autobalance.units import G_MM2_PER_KG_MM2

if TYPE_CHECKING:
    from autobalance.crank.anatomy import Anatomy
    from autobalance.job import Job
    from autobalance.report.records.balanced import Cut
    from autobalance.report.records.crank import MassProperties
    from autobalance.rigid_rotor.unbalance import Moments
    from autobalance.verbs.balance import BalanceResult


# Residual of other depths and places of the cuts: a linear model about a result that was measured.


DRAGGED_KEYS = ("depths_mm", "turns_deg", "diameters_mm")
"""Values that a user may change by hand in the cuts, one entry a cut each."""
MAX_DIAMETER_RATIO = 1.6
"""Largest ratio, up or down, of the drills that the page offers for a hole to the hole's own."""
TURNS_DEG = 60.0
"""Largest turn of a hole about the crank axis on the page, each way."""


@record
class UnbalanceLeft:
    """Unbalance and moment of a rotor."""

    unbalance_g_mm: Pair
    moment_g_mm2: Pair


@record
class Effect(UnbalanceLeft):
    """Change of a rotor by metal, and of a cut its slope with the depth, a millimetre."""

    mass_g: float
    inertia_kg_mm2: float

    @classmethod
    def of(cls, moments: Moments) -> Self:
        first, second = moments.first_g_mm, moments.second_g_mm2
        return cls(
            mass_g=float(moments.mass_g),
            inertia_kg_mm2=float(moments.polar_inertia_g_mm2) / G_MM2_PER_KG_MM2,
            unbalance_g_mm=first[:2],
            moment_g_mm2=second[:2, 2],
        )


@record
class DrillAtHand:
    """A drill of the shop."""

    diameter_mm: float
    drill: str | None


@record
class CutModel:
    """A cut that was made, how it may be changed, and what it does; ``may_turn`` about the crank axis.

    ``begin_mm`` and ``deeper`` are its start and its direction, rotor frame: the handle that is dragged.
    ``rim_mm`` is the radius of a rim that shrinks with the depth, None for cuts that go one way.
    """

    number: int
    kind: str
    web: int | None
    label: str
    depth_mm: float
    least_depth_mm: float
    max_depth_mm: float
    depth_step_mm: float
    limit: str
    may_turn: bool
    diameter_mm: float | None
    drills: Sequence[DrillAtHand]
    begin_mm: Triple
    deeper: Triple
    rim_mm: float | None
    effect: Effect
    rate: Effect


@record
class PermittedUnbalance:
    """Permissible unbalance, and how it is judged."""

    permissible_g_mm: float
    judge: Literal["dynamic", "static"]
    planes: Sequence[TolerancePlane]


@record
class PredictionModel:
    """A result that was measured, every cut's effect and its slope with the depth."""

    residual: UnbalanceLeft
    tolerance: PermittedUnbalance
    mass_change_g: float
    inertia_change_kg_mm2: float
    cuts: Sequence[CutModel]


def linear_model(result: BalanceResult) -> PredictionModel:
    """Return the input of `predicted` from a result; effects are those of the kinds of correction."""
    found = result.record.balanced
    assert found is not None
    ended, tolerance = found.result, found.tolerance
    change = Effect.of(ended.final_moments - ended.initial_moments)
    return PredictionModel(
        residual=UnbalanceLeft(
            unbalance_g_mm=ended.residual.resultant_g_mm, moment_g_mm2=ended.residual.moment_g_mm2
        ),
        tolerance=PermittedUnbalance(
            permissible_g_mm=tolerance.permissible_g_mm, judge=tolerance.judge, planes=tolerance.planes
        ),
        mass_change_g=change.mass_g,
        inertia_change_kg_mm2=change.inertia_kg_mm2,
        cuts=[
            _cut(cut, depth, each)
            for (cut, depth), each in zip(ended.made, result.typed_report.corrections, strict=True)
        ],
    )


def _cut(cut: Any, depth_mm: float, listed: Cut) -> CutModel:
    begin, deeper, rim_mm = _grip(listed, depth_mm)
    return CutModel(
        number=listed.number,
        kind=listed.kind,
        web=listed.web,
        label=cut.label,
        depth_mm=depth_mm,
        least_depth_mm=float(cut.least_depth_mm),
        max_depth_mm=float(cut.max_depth_mm),
        depth_step_mm=float(cut.depth_step_mm),
        limit=cut.limit,
        may_turn=listed.of_kind.has_axis,
        diameter_mm=listed.diameter_mm,
        drills=_drills(cut, listed),
        begin_mm=begin,
        deeper=deeper,
        rim_mm=rim_mm,
        effect=Effect.of(cut.effect(depth_mm) + cut.pressed_in(depth_mm)),
        rate=Effect.of(cut.rate(depth_mm)),
    )


def _drills(cut: Any, listed: Cut) -> Sequence[DrillAtHand]:
    """Return the shop's drills about as wide as a hole's own; none for a hole that is deepened."""
    about = getattr(getattr(cut, "limits", None), "listed_about", None)  # other cuts know of no drills
    if about is None or listed.is_deepened:
        return ()
    return [decoded(DrillAtHand, each) for each in about(cut.diameter_mm, MAX_DIAMETER_RATIO)]


def _grip(listed: Cut, depth_mm: float) -> tuple[Array, Array, float | None]:
    at = np.asarray(listed.position_mm, dtype=np.float64)
    rim_mm = None
    if listed.hole is not None:
        begin, deeper = at, np.asarray(listed.hole.inward, dtype=np.float64)
    elif listed.new_face is not None:  # the metal's middle lies half way
        deeper = np.asarray(listed.new_face.normal) * math.copysign(1.0, -listed.depth_mm)
        begin = at - 0.5 * depth_mm * deeper
    elif listed.pocket is not None and listed.pocket.face_z_mm is not None:
        begin = np.array([at[0], at[1], listed.pocket.face_z_mm])
        deeper = np.array([0.0, 0.0, math.copysign(1.0, at[2] - begin[2])])
    else:
        assert listed.new_rim is not None  # no other kind is left
        rim_mm, out = listed.new_rim.rim_radius_mm, math.hypot(at[0], at[1])
        deeper = np.array([-at[0] / out, -at[1] / out, 0.0]) if out > 0.0 else np.array([-1.0, 0.0, 0.0])
        begin = np.array([0.0, 0.0, at[2]]) - rim_mm * deeper
    return begin, deeper, rim_mm


@record
class Predicted:
    """Predicted residual, and its worst judged share of the permissible value."""

    unbalance_g_mm: Pair
    magnitude_g_mm: float
    planes: Sequence[Plane]
    worst_share: float
    mass_change_g: float
    inertia_change_kg_mm2: float


def predicted(
    model: PredictionModel,
    depths_mm: Sequence[Any],
    turns_deg: Sequence[Any] = (),
    diameters_mm: Sequence[Any] = (),
) -> Predicted:
    """Return the residual of other depths, drills, and cuts turned about the axis: predicted, not measured.

    Parameters
    ----------
    model : PredictionModel
    depths_mm, turns_deg, diameters_mm : sequence of float
        One a cut; without turns every cut stays at its angle, without diameters every hole as wide as it is.

    Raises
    ------
    JobError
        If there are not as many as cuts, or one is not a number or out of its limits.
    """
    depths, turns, diameters = checked_cuts(model, depths_mm, turns_deg, diameters_mm)
    unbalance, moment = complex(*model.residual.unbalance_g_mm), complex(*model.residual.moment_g_mm2)
    mass, inertia = model.mass_change_g, model.inertia_change_kg_mm2
    for cut, depth, turn, diameter in zip(model.cuts, depths, turns, diameters, strict=True):
        area = 1.0 if diameter is None or cut.diameter_mm is None else (diameter / cut.diameter_mm) ** 2
        more = depth - cut.depth_mm
        about = complex(math.cos(math.radians(turn)), math.sin(math.radians(turn)))
        effect, rate = cut.effect, cut.rate
        was, slope = complex(*effect.unbalance_g_mm), complex(*rate.unbalance_g_mm)
        unbalance += area * (was + more * slope) * about - was
        was, slope = complex(*effect.moment_g_mm2), complex(*rate.moment_g_mm2)
        moment += area * (was + more * slope) * about - was
        mass += area * (effect.mass_g + more * rate.mass_g) - effect.mass_g
        inertia += area * (effect.inertia_kg_mm2 + more * rate.inertia_kg_mm2) - effect.inertia_kg_mm2
    tolerance = model.tolerance
    vectors = _in_planes(tolerance.planes, unbalance, moment)
    shares = [abs(unbalance) / tolerance.permissible_g_mm]
    if tolerance.judge == "dynamic":
        shares += [abs(v) / each.permissible_g_mm for v, each in zip(vectors, tolerance.planes, strict=True)]
    return Predicted(
        unbalance_g_mm=[unbalance.real, unbalance.imag],
        magnitude_g_mm=abs(unbalance),
        planes=[
            Plane(name=plane.name, unbalance_g_mm=[v.real, v.imag], magnitude_g_mm=abs(v))
            for plane, v in zip(tolerance.planes, vectors, strict=True)
        ],
        worst_share=max(shares),
        mass_change_g=mass,
        inertia_change_kg_mm2=inertia,
    )


def _in_planes(planes: Sequence[TolerancePlane], unbalance: complex, moment: complex) -> list[complex]:
    if len(planes) != 2:
        return []
    low, high = planes[0].z_mm, planes[1].z_mm
    upper = (moment - low * unbalance) / (high - low)
    return [unbalance - upper, upper]


def checked_cuts(
    model: PredictionModel,
    depths_mm: Sequence[Any],
    turns_deg: Sequence[Any],
    diameters_mm: Sequence[Any] = (),
) -> tuple[list[float], list[float], list[float | None]]:
    """Return depths, turns and diameters, one a cut; a diameter that stays as it is is None.

    Raises
    ------
    JobError
        If there are not as many as cuts, or one is not a number or out of its limits.
    """
    cuts = model.cuts
    depths = _checked("depths_mm", depths_mm, len(cuts))
    turns = _checked("turns_deg", turns_deg, len(cuts)) if turns_deg else [0.0] * len(cuts)
    for number, (cut, depth, turn) in enumerate(zip(cuts, depths, turns, strict=True), 1):
        _refuse(cut, depth, turn, number)
    if not diameters_mm:
        return depths, turns, [None] * len(cuts)
    if not isinstance(diameters_mm, list | tuple) or len(diameters_mm) != len(cuts):
        raise JobError(f"diameters_mm must be a list of {len(cuts)} numbers or null, one a cut")
    pairs = enumerate(zip(cuts, diameters_mm, strict=True), 1)
    return depths, turns, [_drill(cut, diameter, number) for number, (cut, diameter) in pairs]


def _drill(cut: CutModel, diameter_mm: Any, number: int) -> float | None:
    """Return the diameter of one of the shop's drills; None where the hole keeps its own."""
    if diameter_mm is None or diameter_mm == cut.diameter_mm:
        return None
    at_hand = [each.diameter_mm for each in cut.drills]
    if isinstance(diameter_mm, bool) or diameter_mm not in at_hand:
        said = ", ".join(f"{each:g}" for each in at_hand) or "null: no other drill fits this cut"
        raise JobError(f"diameters_mm[{number}] is {diameter_mm!r}; expected one of {said}")
    return float(diameter_mm)


def _checked(name: str, entries: Sequence[Any], count: int) -> list[float]:
    if not isinstance(entries, list | tuple) or len(entries) != count:
        raise JobError(f"{name} must be a list of {count} numbers, one a cut")
    for each in entries:
        if isinstance(each, bool) or not isinstance(each, int | float) or not np.isfinite(each):
            raise JobError(f"{name} holds {each!r}; expected numbers")
    return [float(each) for each in entries]


def _refuse(cut: CutModel, depth: float, turn: float, number: int) -> None:
    most = max(cut.max_depth_mm, cut.depth_mm)
    if not 0.0 <= depth <= most + 1e-9:
        raise JobError(f"depths_mm[{number}] is {depth:g}; must be 0 to {most:g}: {cut.limit}")
    if turn and not (cut.may_turn and abs(turn) <= TURNS_DEG):
        raise JobError(
            f"turns_deg[{number}] is {turn:g}; must be 0, or within {TURNS_DEG:g} for holes and slugs"
        )


# Effect of a job's weights on a crank that was opened: shown as one types, before anything is planned.


def preview(inspected: Mapping[str, Any], tables: Mapping[str, Any], folder: Path) -> Values:
    """Return bob-weights, the factor before, unbalance and what is permitted, for a job on a measured crank.

    Parameters
    ----------
    inspected : mapping
        Report of ``inspect``.
    tables : mapping
        The job, as its TOML.
    folder : Path
        Folder of the job.

    Returns
    -------
    dict
        ``bob_weights``, ``balance_factor``, ``initial`` and ``tolerance`` with keys as in a report;
        ``balance_factor.makers`` is the factor with the ``[original]`` parts, null without them.
        ``forces`` are ``greatest_n`` at ``speed_rpm`` before anything is cut, or ``why`` they are unknown;
        null without a rod length.

    Raises
    ------
    JobError
        If a key of the job is wrong or missing.
    """
    from autobalance.balancing import rotor_from_job as from_job
    from autobalance.job import Job
    from autobalance.report.records import balance as records
    from autobalance.report.records.crank import Crank
    from autobalance.rigid_rotor.unbalance import Unbalance
    from autobalance.running_gear.parts import bob_weight_moments
    from autobalance.verification.claims import Claims
    from autobalance.verification.premises import claimed_anatomy

    job = Job.from_dict(tables, folder=folder)
    anatomy = claimed_anatomy(Claims("report.json", inspected))
    crank = crank_moments(decoded(Crank, inspected["crank"], partly=True).body, job.crankshaft.density_g_mm3)
    loads, attached = from_job.hung_on(job, anatomy)
    factor = from_job.target_factor(job, anatomy, crank)
    tolerance = from_job.tolerance_of(job, anatomy, crank)
    initial = Unbalance.of(crank + bob_weight_moments(loads, factor) + attached)
    fitted = from_job.fitted_bob_weights_g(job, anatomy, factor)
    return {
        "forces": None if job.engine.rod_length_mm is None else _forces(job, anatomy, crank),
        "bob_weights": [
            {"throw": throw.number, "mass_g": load.parts.bob_weight_g(factor), "fit_g": fit_g}
            for throw, load, fit_g in zip(anatomy.throws, loads, fitted, strict=True)
        ],
        "balance_factor": {
            "initial": from_job.crank_factor(crank, loads, attached),
            "target": factor,
            "makers": from_job.makers_factor(job, anatomy, crank),
        },
        "initial": encoded(records.Unbalance.of(initial, tolerance.places_mm)),
        "tolerance": {
            "permissible_g_mm": tolerance.permissible_g_mm,
            "planes": encoded(tolerance.planes),
        },
    }


def _forces(job: Job, anatomy: Anatomy, crank: Moments) -> Values:
    """Return the shaking force of the crank as it is, or the reason why it is not known."""
    from autobalance.balancing.engine_from_job import shaking

    try:
        force = shaking(job, anatomy, crank)
    except JobError as error:
        return {"greatest_n": None, "speed_rpm": None, "why": str(error)}
    if force is None:
        missing = "engine.layout.bank_deg is missing; forces of several rods on a crankpin need it"
        return {"greatest_n": None, "speed_rpm": None, "why": missing}
    speed_rpm = 30.0 / math.pi * job.balance.service_speed_rad_s
    return {"greatest_n": force.greatest_n, "speed_rpm": round(speed_rpm, 6), "why": ""}


def crank_moments(crank: MassProperties, density_g_mm3: float) -> Moments:
    """Return the moments of a reported crank (rotor frame), at another density if need be."""
    from autobalance.rigid_rotor.unbalance import Moments

    mass = crank.mass_g
    inertia = 1000.0 * np.array(crank.inertia_kg_mm2, dtype=np.float64)
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    moments = Moments(mass, mass * np.array(crank.centre_of_mass_mm, dtype=np.float64), second)
    return moments.scaled(density_g_mm3 * crank.volume_mm3 / mass)
