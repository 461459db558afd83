"""The rotor that is balanced: a crank with the loads, factor and tolerance of its job."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from autobalance.correction.contract import Correction, EarlierCut
from autobalance.crank.anatomy import Anatomy, Doubt, Face, MainJournal, Pin, exchanged
from autobalance.errors import JobError
from autobalance.job import Attached, EngineParts, Job, PartWeights, Weight
from autobalance.job.model import AssemblyEntry, LinkRod, ThrowParts
from autobalance.quantities import Quantity, joined, said
from autobalance.rigid_rotor.staged_assembly import AssemblyStage, Part, ShaftState, assemble
from autobalance.rigid_rotor.tolerance import OtherRotor, Tolerance
from autobalance.rigid_rotor.unbalance import Budget, Moments, Unbalance
from autobalance.running_gear.parts import Parts, ThrowLoad, balance_factor, bob_weight_moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.types import Floats
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.solid.cad.brep import Exact


# Rotor that is balanced: the crank as a solid, its moments, and the loads that turn with it.


@dataclass(frozen=True, eq=False)
class Rotor:
    """Rotor that is balanced: the crank in file coordinates [mm] and the loads that turn with it.

    ``exact`` is the crank with its true surfaces, if its file keeps them: plans are made on ``solid``, its
    triangles, and the exact solid is cut. ``moments`` are the bare crank's and ``loads`` those of bob-weights
    and attached rotors, both in the rotor frame. ``loads_per_factor`` is the derivative of the loads with the
    balance factor ``factor``. ``budget`` gives the residual's uncertainty, from the bare crank's moments, the
    corrections made on it and the solid left; None if that is unknown. ``hidden`` gives the moments between
    the facets (loose triangles, file coordinates) and the smooth surface, which ``moments`` include; None:
    nothing is added. ``added`` is the share of a calibration or a scan in them, cut or not. ``earlier`` are
    the cuts of earlier stages, which count if cuts are limited in number.
    """

    solid: Solid
    moments: Moments
    density_g_mm3: float
    anatomy: Anatomy
    faces: tuple[Face, ...]
    loads: Moments
    loads_per_factor: Moments
    factor: float
    budget: Callable[[Moments, Sequence[Correction], Solid | None], Budget] | None = None
    exact: Exact | None = None
    hidden: Callable[[Floats], Moments] | None = None
    earlier: tuple[EarlierCut, ...] = ()
    added: Moments = field(default_factory=Moments.zero)

    def doubt(
        self, bare: Moments, corrections: Sequence[Correction] = (), left: Solid | None = None
    ) -> Budget | None:
        """Return the uncertainty of the residual of the solid ``left``, None where that is not known."""
        return None if self.budget is None else self.budget(bare, corrections, left)


# A job and its crank become a rotor: what hangs on the throws, the factor, what it is judged against.


CRANKPIN = "crankpin"
"""The part in ``crankpin_g`` that is the pin itself, of a crank whose file does not hold it."""
STROKE_SLACK_MM = 0.1
STROKE_SLACK_SHARE = 0.005


# --- weights ------------------------------------------------------------------------------------------------


def throw_loads(
    anatomy: Anatomy, engine: EngineParts, weights: PartWeights | None = None
) -> tuple[ThrowLoad, ...]:
    """Return the loads on each throw, its oil too; ``weights`` take the place of the job's parts on all."""
    return tuple(
        ThrowLoad(
            _parts(
                weights or engine.of_throw(throw.number).weights,
                engine.of_throw(throw.number),
                engine.oil_on_crankpin_g(throw.number),
            ),
            throw.crank_radius_mm,
            throw.angle_rad,
            float(throw.crankpin.centre_mm[2]),
        )
        for throw in anatomy.throws
    )


def hung_on(job: Job, anatomy: Anatomy) -> tuple[tuple[ThrowLoad, ...], Moments]:
    """Return the loads on each throw of a job's crank, and the moments of all else that turns with it."""
    return throw_loads(anatomy, job.engine), beside_throws(job.engine)


def fitted_bob_weights_g(job: Job, anatomy: Anatomy, factor: float) -> tuple[float, ...]:
    """Return the bob-weight of each throw that is clamped on where the crank is spun [g].

    The bob-weight less a crankpin that is not in the file: on the machine it is in.
    """
    pins = [job.engine.of_throw(throw.number).weights.crankpin.get(CRANKPIN) for throw in anatomy.throws]
    loads = throw_loads(anatomy, job.engine)
    return tuple(
        load.parts.bob_weight_g(factor) - (0.0 if pin is None else pin.mass_g)
        for load, pin in zip(loads, pins, strict=True)
    )


def _parts(weights: PartWeights, throw: ThrowParts, oil_g: float) -> Parts:
    """Return the parts on a throw; rods of different weights count with their mean."""
    rotating, reciprocating = total_g(weights.rotating), total_g(weights.reciprocating)
    if throw.links:
        master = throw.rods - len(throw.links)
        others = [rod_weights_g(each, rotating, reciprocating) for each in throw.links]
        turning, moving = (sum(each[n] for each in others) for n in (0, 1))
        rotating = (master * rotating + turning) / throw.rods
        reciprocating = (master * reciprocating + moving) / throw.rods
    return Parts(rotating, reciprocating, total_g(weights.crankpin) + oil_g, throw.rods)


def rod_weights_g(link: LinkRod, rotating_g: float, reciprocating_g: float) -> tuple[float, float]:
    """Return rotating and reciprocating weight of a link rod; the throw's if the job has no separate ones."""
    return (
        rotating_g if link.rotating_g is None else link.rotating_g,
        reciprocating_g if link.reciprocating_g is None else link.reciprocating_g,
    )


def total_g(weights: Mapping[str, Weight]) -> float:
    """Return the sum of named weights."""
    return sum(weight.mass_g for weight in weights.values())


def beside_throws(engine: EngineParts) -> Moments:
    """Return moments beside the bob-weights: attached rotors, and oil that no bob-weight stands for."""
    return attached_moments(engine.attached) + oil_rest(engine)


def oil_rest(engine: EngineParts) -> Moments:
    """Return the oil that no bob-weight stands for; a dry crank on a balancing machine lacks it."""
    return sum((oil.rest for oil in engine.oil.values()), Moments.zero())


def attached_moments(attached: tuple[Attached, ...]) -> Moments:
    """Return moments of attached rotors: their mass on the axis, their unbalance at their place."""
    total = Moments.zero()
    for part in attached:
        on_axis = Moments.point(part.mass_g, np.array([0.0, 0.0, part.z_mm]))
        total = total + on_axis + unbalance_at(part.unbalance_g_mm, part.z_mm)
    return total


def unbalance_at(unbalance_g_mm: tuple[float, float], z_mm: float) -> Moments:
    """Return the moments of an unbalance at a place on the axis."""
    x, y = unbalance_g_mm
    second = np.zeros((3, 3))
    second[0, 2] = second[2, 0] = x * z_mm
    second[1, 2] = second[2, 1] = y * z_mm
    return Moments(0.0, np.array([x, y, 0.0]), second)


def overbalance_moments(job: Job, tolerance: Tolerance) -> Moments:
    """Return the unbalance that is left on purpose for final drilling, midway between the planes."""
    balance = job.balance
    x = balance.overbalance_g_mm * math.cos(balance.overbalance_rad)
    y = balance.overbalance_g_mm * math.sin(balance.overbalance_rad)
    return unbalance_at((x, y), 0.5 * sum(plane.z_mm for plane in tolerance.planes))


def crank_factor(crank: Moments, loads: tuple[ThrowLoad, ...], attached: Moments) -> float | None:
    """Return the balance factor that a crank has with these parts."""
    rotating = crank + bob_weight_moments(loads, 0.0) + attached
    return balance_factor(Unbalance.of(rotating).resultant_g_mm, loads)


def makers_factor(job: Job, anatomy: Anatomy, crank: Moments) -> float | None:
    """Return the balance factor of the untouched crank with its old parts; None without them."""
    if job.original is None:
        return None
    loads = throw_loads(anatomy, job.engine, job.original)
    return crank_factor(crank, loads, beside_throws(job.engine))


def target_factor(job: Job, anatomy: Anatomy, crank: Moments) -> float:
    """Return the balance factor requested; with ``"original"``, the untouched crank's with its old parts.

    Raises
    ------
    JobError
        If the crank has no balance factor, or one outside 0..1.
    """
    if job.balance.factor is not None:
        return job.balance.factor
    factor = makers_factor(job, anatomy, crank)
    where = f'{job.path.name}: balance.factor = "original"'
    if factor is None:
        raise JobError(f"{where}: the throws cancel each other out, so the crank has no balance factor")
    if not 0.0 <= factor <= 1.0:
        raise JobError(
            f"{where}: the crank's factor with the [original] parts is {factor:.4f}; must be 0 to 1; check "
            "the weights, the unit and the density"
        )
    return factor


# --- checks against the geometry ----------------------------------------------------------------------------


def check_engine(job: Job, anatomy: Anatomy) -> None:
    """Refuse a job whose engine is not this crank's.

    Raises
    ------
    JobError
        If a throw's number does not exist, or the stroke contradicts a crank radius.
    """
    count = len(anatomy.throws)
    for number in job.engine.by_throw:
        if number > count:
            throws = "1 throw" if count == 1 else f"{count} throws"
            raise JobError(f"{job.path.name}: engine.throw number {number}: the crank has {throws}")
    stroke = job.engine.stroke_mm
    if stroke is None:
        return
    slack = max(STROKE_SLACK_MM, STROKE_SLACK_SHARE * stroke)
    for throw in anatomy.throws:
        measured = 2.0 * throw.crank_radius_mm
        if abs(measured - stroke) > slack:
            raise JobError(
                f"{job.path.name}: engine.stroke_mm is {stroke:g}, but throw {throw.number} of the crank "
                f"strokes {measured:.3f} mm; expected equal within {slack:.3g} mm "
                f"({_other_stroke(stroke, measured, slack)})"
            )


def _other_stroke(stroke_mm: float, measured_mm: float, slack_mm: float) -> str:
    """Return possible causes of a stroke that differs from the crank's: its radius, another unit or file."""
    if abs(2.0 * stroke_mm - measured_mm) <= 2.0 * slack_mm:
        return "the crank radius is entered: the stroke is twice that"
    for unit, mm in MM_PER.items():
        for ratio in (mm, 1.0 / mm):
            if mm != 1.0 and abs(ratio * measured_mm - stroke_mm) <= slack_mm:
                return f"is crankshaft.unit right? 1 {unit} is {mm:g} mm"
    return "is crankshaft.file this engine's crank?"


# --- tolerance ----------------------------------------------------------------------------------------------


def default_planes_mm(anatomy: Anatomy) -> tuple[float, float] | None:
    """Return the mid-planes of the outermost main journals; None with fewer than two."""
    if len(anatomy.main_journals) < 2:
        return None
    first, last = anatomy.main_journals[0], anatomy.main_journals[-1]
    return float(first.centre_mm[2]), float(last.centre_mm[2])


def tolerance_of(job: Job, anatomy: Anatomy, crank: Moments) -> Tolerance:
    """Return the permissible residual unbalance.

    Raises
    ------
    JobError
        If a dynamic verdict has no planes.
    """
    balance = job.balance
    planes = balance.tolerance_planes_mm or default_planes_mm(anatomy)
    if planes is None and balance.judge == "dynamic":
        count = len(anatomy.main_journals)
        raise JobError(
            f'{job.path.name}: balance.tolerance_planes_mm is missing: judge = "dynamic" needs two '
            f"planes and the crank has {count} main journal{'' if count == 1 else 's'} to take them from"
        )
    rotor = crank + _crankpins_not_in_file(job, anatomy)
    return Tolerance.of(
        grade_mm_s=balance.grade_mm_s,
        service_speed_rad_s=balance.service_speed_rad_s,
        rotor_mass_g=balance.rotor_mass_g or rotor.mass_g,
        z_centre_mm=float(rotor.centre_mm[2]),
        planes_z_mm=planes,
        judge=balance.judge,
        margin=balance.margin,
        others_z_mm=other_readings(job, anatomy, crank),
    )


OtherPlanes = tuple[str, tuple[float, float] | OtherRotor | None]
"""Other reading, and planes A and B [mm] in it, or the rotor about another axis; None if unknown."""


def other_readings(job: Job, anatomy: Anatomy, crank: Moments) -> list[OtherPlanes]:
    """Return the other readings of a crank of some moments.

    Planes that the job states stay where they are, whichever cylinders are the main journals.
    """
    others: list[OtherPlanes] = [
        (
            said("the {} is {}", _part(doubt), _cylinder(doubt.other)),
            _about_other_axis(job, anatomy, crank, doubt),
        )
        for doubt in anatomy.doubts
        if doubt.about != "main_journal"
    ]
    stated = job.balance.tolerance_planes_mm is not None
    return others if stated or len(anatomy.main_journals) < 2 else others + _other_ends(anatomy)


def _about_other_axis(job: Job, anatomy: Anatomy, crank: Moments, doubt: Doubt) -> OtherRotor | None:
    """Return the rotor as it is if its crankpin is the shaft and its main journal the crankpin.

    None if the job has oil in bores or parts that carry what the crank lacks: both are found for one axis.
    """
    if doubt.about != "axis" or len(anatomy.throws) != 1 or job.engine.oil or job.balance.external != "none":
        return None
    there = exchanged(anatomy)
    engine = job.engine if doubt.pin_in_file is not True else _without_crankpins(job.engine)
    other = replace(job, engine=engine)
    from_here = there.file_to_rotor @ anatomy.rotor_to_file
    moved = crank.moved(from_here)
    try:
        tolerance = tolerance_of(other, there, moved)
        loads = _all_loads(other, there, moved, tolerance)
        here = _all_loads(job, anatomy, crank, tolerance_of(job, replace(anatomy, doubts=()), crank))
    except JobError:  # of an original factor outside 0 to 1 about that axis
        return None
    pin = there.throws[0].crankpin.centre_mm if doubt.pin_in_file is False else None
    return OtherRotor(tolerance, from_here, here, loads, pin, job.balance.rotor_mass_g is None)


def _all_loads(job: Job, anatomy: Anatomy, crank: Moments, tolerance: Tolerance) -> Moments:
    """Return the moments of all that is not the crank's solid, less an unbalance left on purpose."""
    factor = target_factor(job, anatomy, crank)
    bobs = bob_weight_moments(throw_loads(anatomy, job.engine), factor)
    return bobs + beside_throws(job.engine) - overbalance_moments(job, tolerance)


def _without_crankpins(engine: EngineParts) -> EngineParts:
    """Return an engine whose crankpins are metal of the file, and no parts."""

    def bare(throw: ThrowParts) -> ThrowParts:
        parts = {name: each for name, each in throw.weights.crankpin.items() if name != CRANKPIN}
        return replace(throw, weights=replace(throw.weights, crankpin=parts))

    by_throw = {number: bare(throw) for number, throw in engine.by_throw.items()}
    return replace(engine, default=bare(engine.default), by_throw=by_throw)


def _other_ends(anatomy: Anatomy) -> list[OtherPlanes]:
    """Return the planes at the outermost main journals for each way in which these may be meant."""
    others: list[OtherPlanes] = []
    ends: list[list[tuple[str, Pin]]] = [
        [("", journal), *((name, doubt.other) for doubt in anatomy.doubts if _is_of(doubt, journal))]
        for name, journal in (("front", anatomy.main_journals[0]), ("rear", anatomy.main_journals[-1]))
    ]
    for first, last in product(*ends):
        named = [(name, pin) for name, pin in (first, last) if name]
        if named:
            meant = joined(
                " and ", (said("the {} main journal is {}", name, _cylinder(pin)) for name, pin in named)
            )
            others.append((meant, (float(first[1].centre_mm[2]), float(last[1].centre_mm[2]))))
    return others


def _part(doubt: Doubt) -> str:
    return "axis" if doubt.about == "axis" else f"{doubt.about} {doubt.number}"


def _is_of(doubt: Doubt, journal: MainJournal) -> bool:
    return doubt.about == "main_journal" and doubt.number == journal.number


def _cylinder(pin: Pin) -> Quantity:
    return Quantity("⌀{} at {}", (pin.diameter_mm, float(pin.centre_mm[2])), "mm", "g")


def _crankpins_not_in_file(job: Job, anatomy: Anatomy) -> Moments:
    total = Moments.zero()
    for throw in anatomy.throws:
        pin = job.engine.of_throw(throw.number).weights.crankpin.get(CRANKPIN)
        if pin is not None:
            total = total + Moments.point(pin.mass_g, throw.crankpin.centre_mm)
    return total


# The staged assembly of a job, on the crank as it was left.


def staged_assembly(job: Job, tolerance: Tolerance, residual: Unbalance) -> tuple[AssemblyStage, ...]:
    """Put the parts of a job on, in the order listed.

    The crank's shaft starts from the residual as judged, and from the rotor mass that it is judged with.

    Raises
    ------
    JobError
        If a part's solid cannot be measured.
    """
    if not job.assembly:
        return ()
    crank = ShaftState(
        tolerance.rotor_mass_g, complex(*residual.resultant_g_mm), complex(*residual.moment_g_mm2)
    )
    parts = [_assembled_part(each, job) for each in job.assembly]
    return assemble(crank, parts, tolerance.grade_mm_s, tolerance.service_speed_rad_s)


def _assembled_part(entry: AssemblyEntry, job: Job) -> Part:
    mass, unbalance, own_moment = entry.mass_g, entry.unbalance_g_mm, 0j
    if entry.solid is not None:
        moments = read(entry.solid.file, entry.solid.unit, "all").moments(entry.solid.density_g_mm3)
        turn = cmath.exp(1j * entry.solid.turn_rad)
        mass = moments.mass_g
        unbalance = turn * complex(*moments.first_g_mm[:2])
        own_moment = turn * complex(*moments.second_g_mm2[:2, 2])
    if mass is None:
        raise JobError(f"{job.path.name}: assembly part {entry.name!r} has no mass")
    return Part(
        entry.name,
        entry.shaft,
        mass,
        entry.z_mm,
        unbalance,
        entry.z_mm * unbalance + own_moment,
        entry.runout_mm,
        entry.key,
        entry.correct_mm,
        entry.permissible_g_mm,
        entry.speed_ratio,
    )
