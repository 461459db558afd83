"""Throws with a master rod and link rods become cylinders."""

from __future__ import annotations

from autobalance.balancing.rotor_from_job import rod_weights_g, total_g
from autobalance.crank.anatomy import Throw
from autobalance.errors import JobError
from autobalance.job import Job, RodOnScales
from autobalance.running_gear.articulated import LinkCrank
from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Cylinder

LONG_ROD = 1e3
"""Rod ÷ crank radius where the job gives no rod length; only the first order is used then, which is free
of it."""


def articulated(job: Job, throw: Throw, before: int) -> list[Cylinder]:
    """Return the cylinders of a throw with link rods, by number; none where each rod has its own big end.

    ``before`` is how many cylinders other throws have before it.

    Raises
    ------
    JobError
        If a link's cylinder is not one of the throw's, or the master's direction is not one angle.
    """
    engine = job.engine
    parts = engine.of_throw(throw.number)
    if not parts.links:
        return []
    numbers = list(range(before + 1, before + parts.rods + 1))
    by_number = {link.cylinder: link for link in parts.links}
    for number in by_number:
        if number not in numbers:
            raise JobError(
                f"{job.path.name}: engine.throw number {throw.number}: link.cylinder is {number}; expected"
                f" one of its cylinders, {numbers[0]} to {numbers[-1]}"
            )
    master_number = next(number for number in numbers if number not in by_number)
    banks = engine.layout.banks_of(throw.number) or (0.0,)
    if len(banks) != 1:
        raise JobError(
            f"{job.path.name}: bank_deg of throw {throw.number} has {len(banks)} angles; expected one, the"
            " master's: set bank_deg of link rods in their own tables"
        )
    radius, z = throw.crank_radius_mm, float(throw.crankpin.centre_mm[2])
    length = engine.rod_length_mm or LONG_ROD * radius
    small_end_g, couple = bare_rod(engine.rod, length)
    rotating, reciprocating = total_g(parts.weights.rotating), total_g(parts.weights.reciprocating)
    master = SliderCrank(radius, length, engine.layout.offset_mm)
    cylinders = []
    for number in numbers:
        link = by_number.get(number)
        if link is None:
            cylinders.append(
                Cylinder(master, rotating, reciprocating, throw.angle_rad, banks[0], z, small_end_g, couple)
            )
            continue
        train = LinkCrank(
            radius,
            link.rod_length_mm,
            engine.layout.offset_mm,
            master,
            banks[0] - link.bank_rad,
            link.knuckle_radius_mm,
            link.knuckle_rad,
        )
        turning, moving = rod_weights_g(link, rotating, reciprocating)
        cylinders.append(
            Cylinder(train, turning, moving, throw.angle_rad, link.bank_rad, z, master=master_number - 1)
        )
    return cylinders


def bare_rod(rod: RodOnScales | None, length_mm: float) -> tuple[float, float]:
    """Return a bare rod's mass at its small end and the inertia that two masses miss; 0 where not weighed."""
    if rod is None:
        return 0.0, 0.0
    two_masses = ConnectingRod.from_two_scales(rod.big_end_g, rod.small_end_g, length_mm, rod.inertia_g_mm2)
    return two_masses.small_end_g, two_masses.couple_inertia_g_mm2
