"""Effect of a job's weights on a crank that was opened: shown as one types, before anything is planned."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.types import Values

if TYPE_CHECKING:
    from autobalance.rigid_rotor.moments import Moments


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

    Raises
    ------
    JobError
        If a key of the job is wrong or missing.
    """
    from autobalance.balancing import rotor_from_job as from_job
    from autobalance.declare import encoded
    from autobalance.job import Job
    from autobalance.report.records import balance as records
    from autobalance.rigid_rotor.unbalance import Unbalance
    from autobalance.running_gear.balance_factor import bob_weight_moments
    from autobalance.verification.claims import Claims
    from autobalance.verification.premises import claimed_anatomy

    job = Job.from_dict(tables, folder=folder)
    anatomy = claimed_anatomy(Claims("report.json", inspected))
    crank = crank_moments(inspected["crank"], job.crankshaft.density_g_mm3)
    loads, attached = from_job.hung_on(job, anatomy)
    factor = from_job.target_factor(job, anatomy, crank)
    tolerance = from_job.tolerance_of(job, anatomy, crank)
    initial = Unbalance.of(crank + bob_weight_moments(loads, factor) + attached)
    fitted = from_job.fitted_bob_weights_g(job, anatomy, factor)
    return {
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
            "planes": [
                {"name": each.name, "z_mm": each.z_mm, "permissible_g_mm": each.permissible_g_mm}
                for each in tolerance.planes
            ],
        },
    }


def crank_moments(crank: Mapping[str, Any], density_g_mm3: float) -> Moments:
    """Return the moments of a reported crank (rotor frame), at another density if need be."""
    from autobalance.rigid_rotor.moments import Moments

    mass = float(crank["mass_g"])
    inertia = 1000.0 * np.array(crank["inertia_kg_mm2"], dtype=np.float64)
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    moments = Moments(mass, mass * np.array(crank["centre_of_mass_mm"], dtype=np.float64), second)
    return moments.scaled(density_g_mm3 * float(crank["volume_mm3"]) / mass)
