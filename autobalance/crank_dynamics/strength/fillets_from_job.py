"""The fillets of a job's crank: what the cycle does to each, and how safe it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Literal, Self

from autobalance.balancing.measured import Crank
from autobalance.crank_dynamics.strength.fatigue import (
    Fatigue,
    FatigueMetal,
    FilletFactors,
    FilletShape,
    fatigue_strength_MPa,
    polar_modulus_mm3,
)
from autobalance.crank_dynamics.strength.input import Strength
from autobalance.crank_dynamics.strength.web_loads import WebLoads, web_loads
from autobalance.crank_dynamics.torsion.from_job import journal_beside, sides_of_throws
from autobalance.crank_dynamics.torsion.vibration_torques import ThrowVibration
from autobalance.declare import INLINE, UNWRITTEN, Degrees, Ordinal, Pair, Positive, record
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.types import Array
from autobalance.units import N_MM_PER_N_M
from autobalance.value_classes import dataclass

Place = Literal["crankpin", "journal"]
Costs = Mapping[tuple[int, Place], float]
"""Number of a web, and one of its fillets → factor by which cuts next to it raise its stress."""


@record
class NominalStress:
    """Smallest and largest nominal stress of a cycle: of the web's section, of the pin's in torsion."""

    bending_MPa: Pair
    shear_MPa: Pair
    torsion_MPa: Pair


@record
class FilletRow:
    """One fillet: what the cycle does to it, and how safe it is.

    Attributes
    ----------
    throw, web : int
        Their numbers.
    outside_of_range : sequence of str
        Which ratios are outside of the range of the factors.
    cost_of_cuts : float
        Factor by which cuts next to the fillet raise its stress; 1: not at all, or unknown.
    at_rad : float
        Crank angle where the safeties are least.
    """

    throw: Ordinal
    web: Ordinal
    place: Place
    nominal: NominalStress
    factors: FilletFactors
    outside_of_range: Sequence[str]
    cost_of_cuts: Positive
    fatigue: Annotated[Fatigue, INLINE]
    at_rad: Degrees


@record
class FilletCycle(FilletRow):
    """One fillet over the cycle.

    ``bending_MPa``, ``shear_MPa`` and ``torsion_MPa`` (n,) are nominal stresses; bending positive where it
    stretches the fillet, shear where it presses.
    """

    bending_MPa: Annotated[Array, UNWRITTEN]
    shear_MPa: Annotated[Array, UNWRITTEN]
    torsion_MPa: Annotated[Array, UNWRITTEN]


@record
class LeastSafety:
    """The fillet of the least safety, by Gough and Pollard."""

    throw: Ordinal
    web: Ordinal
    place: Place
    gough_pollard: float
    goodman: float

    @classmethod
    def of(cls, fillets: Sequence[FilletRow]) -> Self | None:
        """Return the least of some fillets; None if nothing stresses them."""
        known = [each for each in fillets if each.fatigue.safety.gough_pollard is not None]
        if not known:
            return None
        least = min(known, key=lambda each: each.fatigue.safety.gough_pollard or 0.0)
        safety = least.fatigue.safety
        assert safety.gough_pollard is not None
        assert safety.goodman is not None
        return cls(
            throw=least.throw,
            web=least.web,
            place=least.place,
            gough_pollard=safety.gough_pollard,
            goodman=safety.goodman,
        )


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a throw: its dimensions, loads, and whether a main journal is next to its web."""

    shape: FilletShape
    loads: WebLoads
    has_journal: bool


def sides(
    job: Job, crank: Crank, cycle: CycleAnalysis, vibration: Sequence[ThrowVibration] | None = None
) -> list[Side]:
    """Return the two sides of every throw, in the order of the axis; with torsional vibration where given."""
    strength = checked_strength(job)
    anatomy = crank.anatomy
    loads = web_loads(cycle, job, anatomy, crank.source.solid, crank.density_g_mm3)
    if vibration is not None:
        loads = [_vibrating(load, vibration[load.throw - 1]) for load in loads]
    shapes = [each for pair in sides_of_throws(crank) for each in pair]
    listed = []
    for shape, load in zip(shapes, loads, strict=True):
        dimensions = FilletShape(
            pin_mm=shape.pin_mm,
            pin_bore_mm=shape.pin_bore_mm,
            journal_mm=shape.journal_mm,
            journal_bore_mm=shape.journal_bore_mm,
            crank_radius_mm=shape.crank_radius_mm,
            web_thickness_mm=shape.web_thickness_mm,
            web_breadth_mm=shape.web_breadth_mm,
            pin_fillet_mm=strength.pin_fillet_mm,
            journal_fillet_mm=strength.journal_fillet_mm,
            pin_recess_mm=strength.recess_mm,
            journal_recess_mm=strength.recess_mm,
        )
        throw = anatomy.throws[load.throw - 1]
        has_journal = journal_beside(anatomy, throw, load.is_above) is not None
        listed.append(Side(dimensions, load, has_journal))
    return listed


def _vibrating(load: WebLoads, vibration: ThrowVibration) -> WebLoads:
    """Return a web's loads with the torque of torsional vibration."""
    beside = vibration.after_n_m if load.is_above else vibration.before_n_m
    return replace(
        load,
        pin_torque_n_m=load.pin_torque_n_m + vibration.crankpin_n_m,
        journal_torque_n_m=load.journal_torque_n_m + beside,
    )


def checked_strength(job: Job) -> Strength:
    """Return the ``[strength]`` of a job.

    Raises
    ------
    JobError If it has no such table.
    """
    strength = job.table(Strength)
    if strength is None:
        raise JobError(
            f"{job.path.name}: [strength] is missing; it needs pin_fillet_mm and material.tensile_MPa"
        )
    return strength


def fillets(
    job: Job,
    crank: Crank,
    cycle: CycleAnalysis,
    costs: Costs | None = None,
    vibration: Sequence[ThrowVibration] | None = None,
) -> list[FilletCycle]:
    """Return every fillet of the crank's throws, in the order of the axis.

    A web between two crankpins has no journal fillet.

    Parameters
    ----------
    job : Job
        With ``[strength]``.
    crank : Crank
    cycle : CycleAnalysis
        Of that crank.
    costs : mapping or None
        What cuts beside fillets cost; None: nothing is known of them.
    vibration : sequence of ThrowVibration or None
        What torsional vibration adds, by throw; None: it is left out.

    Raises
    ------
    JobError
        If a throw has no web on a side, or a fillet is too large for its web.
    """
    strength = checked_strength(job)
    fillets: list[FilletCycle] = []
    for side in sides(job, crank, cycle, vibration):
        _check(side, strength)
        places: tuple[Place, ...] = ("crankpin", "journal") if side.has_journal else ("crankpin",)
        fillets += [_fillet(place, side, strength, costs or {}, cycle) for place in places]
    return fillets


def _check(side: Side, strength: Strength) -> None:
    thickness = side.shape.web_thickness_mm
    for name in ("pin_fillet_mm", "journal_fillet_mm", "recess_mm"):
        if getattr(strength, name) >= thickness:
            raise JobError(
                f"strength.{name} is {getattr(strength, name):g}; web {side.loads.web} is {thickness:.4g} mm"
                " thick, and it must be less"
            )


def _fillet(place: Place, side: Side, strength: Strength, costs: Costs, cycle: CycleAnalysis) -> FilletCycle:
    shape, loads = side.shape, side.loads
    web_area = shape.web_breadth_mm * shape.web_thickness_mm
    bending = N_MM_PER_N_M * loads.bending_n_m / (web_area * shape.web_thickness_mm / 6.0)
    shear = loads.radial_n / web_area
    if place == "crankpin":
        diameter, bore, fillet = shape.pin_mm, shape.pin_bore_mm, strength.pin_fillet_mm
        torque, factors = loads.pin_torque_n_m, shape.crankpin
    else:
        diameter, bore, fillet = shape.journal_mm, shape.journal_bore_mm, strength.journal_fillet_mm
        torque, factors = loads.journal_torque_n_m, shape.journal
        bending = -bending  # what stretches the crankpin's fillet presses the journal's
    outside = shape.outside(fillet)
    if strength.factor is not None:
        factors, outside = FilletFactors(strength.factor.bending, 0.0, strength.factor.torsion), ()
    torsion = N_MM_PER_N_M * torque / polar_modulus_mm3(diameter, bore)
    cost = costs.get((loads.web, place), 1.0)
    bears = strength.fatigue_MPa or fatigue_strength_MPa(strength.tensile_MPa, diameter, fillet)
    fatigue = Fatigue.of(
        cost * (factors.bending * bending - factors.shear * shear),
        cost * factors.torsion * torsion,
        FatigueMetal(strength.tensile_MPa, bears, strength.yield_MPa),
    )
    at = float(cycle.grid.angle_rad[fatigue.at])
    return FilletCycle(
        throw=loads.throw,
        web=loads.web,
        place=place,
        nominal=NominalStress(
            bending_MPa=extremes(bending),
            shear_MPa=extremes(shear),
            torsion_MPa=extremes(torsion),
        ),
        factors=factors,
        outside_of_range=outside,
        cost_of_cuts=cost,
        fatigue=fatigue,
        at_rad=at,
        bending_MPa=bending,
        shear_MPa=shear,
        torsion_MPa=torsion,
    )


def extremes(values: Array) -> tuple[float, float]:
    return float(values.min()), float(values.max())
