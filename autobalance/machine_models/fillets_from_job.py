"""The fillets of a job's crank: what the cycle does to each, and how safe it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from autobalance.engine.cycle.analysis import CycleAnalysis
from autobalance.engine.fatigue import Fatigue, FatigueMetal
from autobalance.engine.fillet_factors import (
    FilletFactors,
    FilletShape,
    fatigue_strength_MPa,
    polar_modulus_mm3,
)
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.job.model.strength import Strength
from autobalance.machine_models.measured import Crank
from autobalance.machine_models.torsion_from_job import journal_beside, sides_of_throws
from autobalance.machine_models.vibration_torques import ThrowVibration
from autobalance.machine_models.web_loads import WebLoads, web_loads
from autobalance.types import Array

N_MM_PER_N_M = 1e3
Place = Literal["crankpin", "journal"]
Costs = Mapping[tuple[int, Place], float]
"""Number of a web, and which of its fillets → by how much cuts beside it raise its stress."""


@dataclass(frozen=True, eq=False)
class Fillet:
    """One fillet over the cycle.

    Attributes
    ----------
    throw, web : int
        Their numbers.
    place : {"crankpin", "journal"}
    bending_MPa, shear_MPa, torsion_MPa : (n,) float
        Nominal stresses; bending positive where it stretches the fillet, shear where it presses.
    factors : FilletFactors
    outside : tuple of str
        Which ratios are outside of the range of the factors.
    cost : float
        By how much cuts beside the fillet raise its stress; 1: not at all, or not known.
    fatigue_MPa : float
        What it bears for ever.
    fatigue : Fatigue
    at_rad : float
        Crank angle where the safeties are least.
    """

    throw: int
    web: int
    place: Place
    bending_MPa: Array
    shear_MPa: Array
    torsion_MPa: Array
    factors: FilletFactors
    outside: tuple[str, ...]
    cost: float
    fatigue_MPa: float
    fatigue: Fatigue
    at_rad: float


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a throw: its dimensions, loads, and whether a main journal stands beside its web."""

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
    JobError
        If it has none.
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
) -> list[Fillet]:
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
    fillets: list[Fillet] = []
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


def _fillet(place: Place, side: Side, strength: Strength, costs: Costs, cycle: CycleAnalysis) -> Fillet:
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
    return Fillet(
        throw=loads.throw,
        web=loads.web,
        place=place,
        bending_MPa=bending,
        shear_MPa=shear,
        torsion_MPa=torsion,
        factors=factors,
        outside=outside,
        cost=cost,
        fatigue_MPa=bears,
        fatigue=fatigue,
        at_rad=at,
    )
