"""The rotor of a report as a machine spins it: its solid read back from disk, with bob-weights."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.errors import FormatError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.test_stands.bench.spun_rotor import RigidBody
from autobalance.value_classes import dataclass
from autobalance.verification.claims import Claims
from autobalance.verification.premises import claimed_anatomy, claimed_job
from autobalance.verification.report_file import read_report
from autobalance.verification.solids import measured_solid

COMMANDS = ("balance", "recut")
"""Commands whose reports have a job and a solid."""


@dataclass(frozen=True, eq=False)
class ReportedRotor:
    """A rotor on a balancing machine: ``fit_g`` are the bob-weights to clamp on, by throw.

    A pressed-up crank has its crankpins in when it is spun, so ``fit_g`` leaves them out where the file does.
    """

    body: RigidBody
    planes_mm: tuple[float, float] | None
    fit_g: tuple[float, ...]
    serial: str | None


def reported_rotor(path: Path) -> ReportedRotor:
    """Return the rotor of a report, its solid read back from disk.

    Raises
    ------
    FileError
        If one of them cannot be read.
    FormatError, ClaimError
        If the report is none of ``balance`` or ``recut``, or the solid is another.
    """
    claims = Claims(path.name, read_report(path))
    command = claims.get("command", str)
    if command not in COMMANDS:
        raise FormatError(f"{path.name} is a report of {command!r}; expected one of {', '.join(COMMANDS)}")
    job, anatomy = claimed_job(claims, path.parent), claimed_anatomy(claims)
    factor = claims.get("balance_factor.target", float)
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    attached = rotor_from_job.attached_moments(job.engine.attached)
    spun = measured_solid(claims, path.parent, job, anatomy) + bob_weight_moments(loads, factor) + attached
    planes = [float(plane["z_mm"]) for plane in claims.get("tolerance.planes", list)]

    return ReportedRotor(
        body_of(spun),
        (planes[0], planes[1]) if planes else None,
        rotor_from_job.fitted_bob_weights_g(job, anatomy, factor),
        claims.values.get("serial"),
    )


def body_of(moments: Moments) -> RigidBody:
    """Return moments about the rotor's origin as a body for a balancing machine."""
    unbalance = complex(*moments.first_g_mm[:2])
    about_centre = moments.second_g_mm2 - np.outer(moments.first_g_mm, moments.first_g_mm) / moments.mass_g
    across = float(about_centre[0, 0] + about_centre[1, 1])
    return RigidBody(
        moments.mass_g,
        float(moments.centre_mm[2]),
        unbalance,
        complex(*moments.second_g_mm2[:2, 2]),
        0.5 * across + float(about_centre[2, 2]),
        about_centre,
    )
