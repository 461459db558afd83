"""Strength of a design: main-bearing loads of the cycle, stress under its largest load, first frequency."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from autobalance.balancing.engine_from_job import with_moments, with_solid
from autobalance.crank.anatomy import Anatomy, Pin
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.firing_from_job import firing_engine
from autobalance.errors import JobError
from autobalance.finite_elements.elasticity import STEEL, ElasticBody, Material
from autobalance.finite_elements.modes import modes_of
from autobalance.finite_elements.solid_meshes import bodies_of_solid
from autobalance.finite_elements.statics import facet_nodes, facet_shares, solved
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.running_gear.whole_engine import Engine
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

T_MM3_PER_G_MM3 = 1e-6
SURFACE_SHARE = 0.03
"""Largest distance of a faceted pin's surface from its cylinder, as a share of the radius."""


def cycle_of(job: Job, anatomy: Anatomy, moments: Moments, solid: Solid | None) -> CycleAnalysis:
    """Return the cycle of a job's engine: with a crank's solid (file coordinates), or else with its moments.

    Raises
    ------
    JobError
        If the job has no cycle.
    """
    density = job.crankshaft.density_g_mm3

    def engine() -> Engine:
        if solid is None:
            return with_moments(job, anatomy, moments)
        return with_solid(job, anatomy, solid, density, moments)

    speed = job.balance.service_speed_rad_s
    return CycleAnalysis(firing_engine(job, anatomy, speed, engine), speed)


def greatest_main_load_n(cycle: CycleAnalysis) -> float:
    """Return the largest load of any main bearing in a cycle [N]."""
    return max(peak.greatest_n for peak in cycle.peaks(cycle.loads.main_n))


def greatest_pin_loads_n(cycle: CycleAnalysis) -> Array:
    """Return the loads (t, 2) on the crankpins in the crank's frame when one of them is largest [N]."""
    turning = cycle.loads.crankpin_in_crank_frame_n()
    pins = np.stack([turning[list(throw.cylinders)].sum(axis=0) for throw in cycle.firing.throws])
    worst = int(np.linalg.norm(pins, axis=2).max(axis=0).argmax())
    loads: Array = pins[:, worst]
    return loads


def material_of(density_g_mm3: float) -> Material:
    """Return the material steel with a density."""
    return Material(STEEL.young_MPa, STEEL.poisson, density_g_mm3 * T_MM3_PER_G_MM3)


def body_of(rotor_solid: Solid, size_mm: float | None) -> ElasticBody:
    return bodies_of_solid(rotor_solid, size_mm)[0]


def first_frequency_hz(body: ElasticBody, density_g_mm3: float) -> float:
    """Return the first natural frequency of a free crank."""
    return modes_of(body, material_of(density_g_mm3), 1)[0].frequency_hz


def greatest_stress_MPa(
    body: ElasticBody, anatomy: Anatomy, pin_loads_n: Array, density_g_mm3: float
) -> float:
    """Return the largest von Mises stress of a crank held at its main journals and loaded at its crankpins.

    Raises
    ------
    JobError
        If a journal or a crankpin has no surface in the mesh.
    """
    held = np.zeros((body.nodes, 3), dtype=bool)
    for journal in anatomy.main_journals:
        facets = _facets_on(body, journal, journal.z_range_mm, f"main journal {journal.number}")
        held[np.unique(facet_nodes(body, facets))] = True
    force = np.zeros((body.nodes, 3))
    for throw, load in zip(anatomy.throws, pin_loads_n, strict=True):
        near = [
            web
            for web in anatomy.webs
            if abs(0.5 * (web.z_min_mm + web.z_max_mm) - throw.crankpin.centre_mm[2])
            < throw.crankpin.width_mm + (web.z_max_mm - web.z_min_mm)
        ]
        low, high = throw.crankpin.z_range_mm
        reach = min([low, *(w.z_min_mm for w in near)]), max([high, *(w.z_max_mm for w in near)])
        shares = facet_shares(body, _facets_on(body, throw.crankpin, reach, f"crankpin {throw.number}"))
        force[:, :2] += (shares / shares.sum())[:, None] * load
    result = solved(body, material_of(density_g_mm3), held.reshape(-1), force.reshape(-1))
    return float(result.von_mises_MPa.max())


def _facets_on(body: ElasticBody, pin: Pin, z_mm: tuple[float, float], name: str) -> NDArray[np.int64]:
    """Return the boundary facets on a pin's cylinder between two heights."""
    facets = body.mesh.boundary_facets()
    corners = body.mesh.p[:, body.mesh.facets[:, facets]]
    radius = 0.5 * pin.diameter_mm
    off = np.hypot(corners[0] - pin.centre_mm[0], corners[1] - pin.centre_mm[1])
    slack = SURFACE_SHARE * radius
    on = (np.abs(off - radius) < slack).all(axis=0)
    on &= ((corners[2] > z_mm[0] - slack) & (corners[2] < z_mm[1] + slack)).all(axis=0)
    if not on.any():
        raise JobError(
            f"[fem]: the mesh has no surface of {name} (⌀{2 * radius:.4g} mm); choose a smaller size_mm, "
            f"less than {math.tau * radius / 8:.3g}"
        )
    on_face: NDArray[np.int64] = facets[on].astype(np.int64)
    return on_face
