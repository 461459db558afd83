"""The oil in a job's crank, by throw: what counts in its bob-weights, and what no bob-weight stands for."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from autobalance.balancing.crankpins import with_crankpins
from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Anatomy, Throw
from autobalance.crank.oil_room import OilRoom, oil_rooms
from autobalance.job import Job
from autobalance.job.model import ThrowOil
from autobalance.rigid_rotor.moments import Moments


def rooms_of(crank: Crank) -> tuple[OilRoom, ...]:
    """Return the oil volumes in a crank, its crankpins put in if they are not in the file."""
    return oil_rooms(
        with_crankpins(crank.source.solid.moved(crank.anatomy.file_to_rotor), crank), crank.anatomy
    )


def with_oil(job: Job, crank: Crank) -> Job:
    """Return a job with the oil that its crank holds, by throw, where ``[engine.oil]`` fills it."""
    density = job.engine.oil_g_mm3
    if density is None:
        return job
    rooms, anatomy = rooms_of(crank), crank.anatomy
    planes = _between_throws_mm(anatomy)
    by_throw = {}
    for throw, low, high in zip(anatomy.throws, (None, *planes), (*planes, None), strict=True):
        oil = Moments.zero()
        for room in rooms:
            piece = room.solid if low is None else room.solid.above(low)
            oil = oil + (piece if high is None else piece.below(high)).moments(density)
        if oil.mass_g > 0.0:
            by_throw[throw.number] = throw_oil(oil, throw)
    return replace(job, engine=replace(job.engine, oil=by_throw))


def throw_oil(oil: Moments, throw: Throw) -> ThrowOil:
    """Return a throw's oil as a mass in its crankpin with the same pull along the throw, and the rest."""
    along = float(oil.first_g_mm[:2] @ throw.direction) / throw.crank_radius_mm
    on_crankpin = max(0.0, along)  # more oil on the counterweight's side is not a bob-weight
    return ThrowOil(oil, on_crankpin, oil - Moments.point(on_crankpin, throw.crankpin.centre_mm))


def _between_throws_mm(anatomy: Anatomy) -> tuple[float, ...]:
    """Return z between neighbouring throws' oil: in the middle of the main journal, else halfway [mm]."""
    mains = [float(journal.centre_mm[2]) for journal in anatomy.main_journals]
    pins = [float(throw.crankpin.centre_mm[2]) for throw in anatomy.throws]
    return tuple(
        next((z for z in mains if low < z < high), float(np.mean([low, high])))
        for low, high in pairwise(pins)
    )
