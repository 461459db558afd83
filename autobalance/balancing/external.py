"""External balance: the unbalance of a crank that a damper and a flexplate or flywheel carry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.balancing.measured import Crank
from autobalance.job import Attached, Job
from autobalance.job.model import ExternalPart
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.types import Array, Floats
from autobalance.value_classes import dataclass

NO_LEVER_MM = 1e-6


@dataclass(frozen=True, eq=False)
class CarriedUnbalance:
    """An external part, the unbalance (2,) that it is to carry, and the error ``pm_g_mm`` permitted to it."""

    part: ExternalPart
    unbalance_g_mm: Array
    pm_g_mm: float


def with_external(job: Job, crank: Crank, tolerance: Tolerance, factor: float) -> Job:
    """Return a job with its external parts attached; they carry what they must, if it solves them."""
    balance = job.balance
    if balance.external != "solve":
        return job
    return attached_to(job, carried(balance.external_parts, _bare(job, crank, tolerance, factor), tolerance))


def carried_unbalances(job: Job, tolerance: Tolerance, residual: Unbalance) -> tuple[CarriedUnbalance, ...]:
    """Return the unbalances of a job's external parts, and the errors permitted to them beside a residual.

    Parameters
    ----------
    job : Job
        As ``with_external`` returns it: solved parts are the last that are attached.
    tolerance : Tolerance
    residual : Unbalance
        Of the crank as it was left, its external parts on it.
    """
    balance = job.balance
    parts = balance.external_parts
    if balance.external == "none":
        return ()
    targets: list[Array] = [np.zeros(2) for _ in parts]
    if balance.external == "detroit":
        targets = [np.array(part.unbalance_g_mm) for part in parts]
    if balance.external == "solve":
        targets = [np.array(each.unbalance_g_mm) for each in job.engine.attached[-len(parts) :]]
    allowed = _pm_g_mm(parts, residual, tolerance)
    return tuple(CarriedUnbalance(*each, allowed) for each in zip(parts, targets, strict=True))


def attached_to(job: Job, unbalances_g_mm: Sequence[Floats | Sequence[float]]) -> Job:
    """Return a job whose external parts carry these unbalances."""
    parts = tuple(
        Attached(part.name, 0.0, (float(each[0]), float(each[1])), part.z_mm)
        for part, each in zip(job.balance.external_parts, unbalances_g_mm, strict=True)
    )
    return replace(job, engine=replace(job.engine, attached=(*job.engine.attached, *parts)))


def _bare(job: Job, crank: Crank, tolerance: Tolerance, factor: float) -> Unbalance:
    """Return the unbalance that the external parts have to cancel."""
    on_throws = bob_weight_moments(rotor_from_job.throw_loads(crank.anatomy, job.engine), factor)
    loads = on_throws + rotor_from_job.beside_throws(job.engine)
    return Unbalance.of(crank.moments + loads - rotor_from_job.overbalance_moments(job, tolerance))


def carried(parts: Sequence[ExternalPart], bare: Unbalance, tolerance: Tolerance) -> list[Array]:
    """Return the unbalance (2,) that each part must carry against a rotor's [g·mm].

    Two free parts cancel resultant and moment exactly. Otherwise the worst judged value, over its permissible
    one, is made as small as the parts' limits allow.
    """
    if len(parts) == 2 and abs(parts[1].z_mm - parts[0].z_mm) > NO_LEVER_MM:
        low, high = sorted(parts, key=lambda part: part.z_mm)
        a, b = (np.asarray(-each) for each in bare.in_planes(low.z_mm, high.z_mm))
        exact = [a, b] if parts[0] is low else [b, a]
        if all(_may(part, each) for part, each in zip(parts, exact, strict=True)):
            return exact
    return _least_worst(parts, bare, tolerance)


def _may(part: ExternalPart, unbalance: Array) -> bool:
    """Return whether a part can carry an unbalance in any direction."""
    return part.angle_rad is None and (part.max_g_mm is None or math.hypot(*unbalance) <= part.max_g_mm)


def _rows(bare: Unbalance, parts: Sequence[ExternalPart], tolerance: Tolerance) -> list[tuple[Array, Array]]:
    """Return judged over permissible values: vectors (2,) without the parts, and the parts' shares (p,)."""
    rows = [
        (bare.resultant_g_mm / tolerance.permissible_g_mm, np.ones(len(parts)) / tolerance.permissible_g_mm)
    ]
    if tolerance.judge == "dynamic":
        low, high = tolerance.planes
        vectors = bare.in_planes(low.z_mm, high.z_mm)
        share = np.array([(part.z_mm - low.z_mm) / (high.z_mm - low.z_mm) for part in parts])
        for plane, vector, own in zip((low, high), vectors, (1.0 - share, share), strict=True):
            rows.append((vector / plane.permissible_g_mm, own / plane.permissible_g_mm))
    return rows


def _least_worst(parts: Sequence[ExternalPart], bare: Unbalance, tolerance: Tolerance) -> list[Array]:
    from scipy import optimize

    minimize: Any = optimize.minimize

    rows = _rows(bare, parts, tolerance)
    scale = max(1.0, *(part.max_g_mm or 0.0 for part in parts), math.hypot(*bare.resultant_g_mm))

    def unbalances(x: Array) -> Array:
        """Return (p, 2) from the search's variables: a size where the angle is fixed, else a vector."""
        unbalances_g_mm, at = [], 0
        for part in parts:
            if part.angle_rad is None:
                unbalances_g_mm.append(x[at : at + 2])
                at += 2
            else:
                unbalances_g_mm.append(x[at] * np.array([math.cos(part.angle_rad), math.sin(part.angle_rad)]))
                at += 1
        return np.asarray(unbalances_g_mm) * scale

    def judged(x: Array) -> Array:
        carried_g_mm = unbalances(x)
        return np.array([math.hypot(*(fixed + shares @ carried_g_mm)) for fixed, shares in rows])

    count = sum(2 if part.angle_rad is None else 1 for part in parts)
    size = max(1.0, float(judged(np.zeros(count)).max()))

    def each_spare(x: Array) -> Array:
        return np.asarray(x[-1] ** 2 - (judged(x[:-1]) / size) ** 2)

    limited = [(n, part.max_g_mm / scale) for n, part in enumerate(parts) if part.max_g_mm is not None]

    def within(x: Array) -> Array:
        sizes = ((unbalances(x[:-1]) / scale) ** 2).sum(axis=1)
        return np.array([most**2 - sizes[n] for n, most in limited])

    constraints: list[Any] = [{"type": "ineq", "fun": each_spare}]
    if limited:
        constraints.append({"type": "ineq", "fun": within})
    bounds: list[tuple[float | None, float | None]] = []
    for part in parts:
        bounds += [(None, None)] * 2 if part.angle_rad is None else [(0.0, None)]
    start = np.append(np.full(count, 1e-3), 1.0)
    unbalances_g_mm = minimize(
        lambda x: float(x[-1]),
        start,
        method="SLSQP",
        bounds=[*bounds, (0.0, None)],
        constraints=constraints,
        options={"maxiter": 500, "ftol": 1e-14},
    )
    return list(unbalances(unbalances_g_mm.x[:-1]))


def _pm_g_mm(parts: Sequence[ExternalPart], residual: Unbalance, tolerance: Tolerance) -> float:
    """Return the error permitted to each part, where all are off at once and in the worst direction."""
    left = [
        max(0.0, 1.0 - math.hypot(*fixed)) / float(np.abs(shares).sum())
        for fixed, shares in _rows(residual, parts, tolerance)
    ]
    return min(left)
