"""What a design is worth: its balance solved for exactly, its objectives, and what it keeps or breaks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalance.balancing import rotor_from_job
from autobalance.balancing.measured_crank import Crank
from autobalance.design_search import strength
from autobalance.design_search.free_metal import FreeMetal, FreeWeb
from autobalance.design_search.neighbours import (
    Clearance,
    Neighbour,
    OtherShaft,
    Piston,
    Rod,
    circle_mm,
    least_clearance,
)
from autobalance.engine.balance_factor import bob_weight_moments
from autobalance.errors import JobError
from autobalance.job.design import DesignJob
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.solid import Solid

Array = NDArray[np.float64]

G_MM2_PER_KG_MM2 = 1000.0
LOAD, STRESS = "greatest_main_load_N", "greatest_stress_MPa"
AIM = 1e-9
"""Share of the permissible value that is left by the solution, by the profiles' own moments."""
ALLOWED = 0.01
"""Share of every permissible value that a written design may leave."""
STEPS = 12
ROUGH_ANGLES = 72
ROUGH_MM = 0.1
"""More clearance is asked of a design that is only looked at every five degrees."""
FACING = -0.7


@dataclass(frozen=True)
class Constraint:
    """Something kept or broken: ``margin`` is negative by how much it is broken, in ``unit``."""

    name: str
    value: float
    limit: float
    unit: str
    margin: float
    scale: float = 1.0
    at_mm: tuple[float, float, float] | None = None
    at_deg: float | None = None


@dataclass(frozen=True, eq=False)
class Amounts:
    """A design as numbers: control radii (n,) of each part and their thickness (None: as it was)."""

    radii_mm: tuple[Array, ...]
    thickness_mm: tuple[float | None, ...]


@dataclass(frozen=True, eq=False)
class Problem:
    """A design job with its crank, ready to judge designs.

    Attributes
    ----------
    design : DesignJob
    crank : Crank
    free : FreeMetal
    loads : Moments
        Of bob-weights and attached rotors at the target factor.
    factor : float
    neighbours : sequence of Neighbour
    """

    design: DesignJob
    crank: Crank
    free: FreeMetal
    loads: Moments
    factor: float
    neighbours: Sequence[Neighbour]

    @classmethod
    def of(cls, design: DesignJob, crank: Crank, free: FreeMetal) -> Problem:
        """Return the problem of a design job."""
        job = design.start
        rotor_from_job.check_engine(job, crank.anatomy)
        factor = rotor_from_job.target_factor(job, crank.anatomy, crank.moments)
        loads = bob_weight_moments(rotor_from_job.throw_loads(crank.anatomy, job.engine), factor)
        loads = loads + rotor_from_job.attached_moments(job.engine.attached)
        return cls(design, crank, free, loads, factor, _neighbours(design, crank))

    # --- variables ------------------------------------------------------------------------------------------

    @property
    def bounds(self) -> Array:
        """Bounds (v, 2) of the variables: control radii of each part, mirrored ones once; thicknesses."""
        rows = [self.free.bounds_mm[k][self._own(k)] for k in range(len(self.free.parts))]
        thick = [part.thickness_mm for part in self.free.parts if part.thickness_mm is not None]
        return np.concatenate([*rows, np.array(thick).reshape(-1, 2)])

    @property
    def start(self) -> Array:
        """The variables (v,) of the crank as it came, within their bounds."""
        rows = []
        for k, part in enumerate(self.free.parts):
            radii = self.free.start_mm[k]
            rows.append((0.5 * (radii + radii[::-1]) if part.symmetric else radii)[self._own(k)])
        thick = [
            self.free.webs[self._first_web(k)].z_mm
            for k, part in enumerate(self.free.parts)
            if part.thickness_mm is not None
        ]
        found = np.concatenate([*rows, np.array([high - low for low, high in thick])])
        low, high = self.bounds.T
        inside: Array = np.clip(found, low, high)
        return inside

    def _first_web(self, part: int) -> int:
        return next(place for place, web in enumerate(self.free.webs) if web.part == part)

    def _own(self, part: int) -> NDArray[np.int64]:
        """Return the control points of a part that are variables."""
        count = self.free.profiles[part].count
        return np.arange((count + 1) // 2 if self.free.parts[part].symmetric else count)

    def amounts(self, variables: Array) -> Amounts:
        """Return radii and thicknesses of variables (v,)."""
        place, radii, thickness = 0, [], []
        for k, part in enumerate(self.free.parts):
            own, count = len(self._own(k)), self.free.profiles[k].count
            half = variables[place : place + own]
            radii.append(np.concatenate([half, half[: count - own][::-1]]) if part.symmetric else half)
            place += own
        for part in self.free.parts:
            thickness.append(None if part.thickness_mm is None else float(variables[place]))
            place += part.thickness_mm is not None
        return Amounts(tuple(radii), tuple(thickness))

    def _folded(self, part: int, gradient: Array) -> Array:
        """Return a gradient with a part's radii (n, ...) as one with its variables."""
        own, count = len(self._own(part)), len(gradient)
        if not self.free.parts[part].symmetric:
            return gradient
        folded = gradient[:own].copy()
        folded[: count - own] += gradient[::-1][: count - own]
        return folded

    # --- moments --------------------------------------------------------------------------------------------

    def moments(self, variables: Array) -> tuple[Moments, Array]:
        """Return the crank's moments, and the gradient (v, 6): Uₓ, U_y, Pₓ, P_y, mass and polar inertia."""
        amounts = self.amounts(variables)
        density = self.crank.density_g_mm3
        total = self.free.held_moments
        parts = [np.zeros((len(self._own(k)), 6)) for k in range(len(self.free.parts))]
        thick = np.zeros((len(self.free.parts), 6))
        areas = [
            profile.moments(radii)
            for profile, radii in zip(self.free.profiles, amounts.radii_mm, strict=True)
        ]
        for web in self.free.webs:
            k = web.part
            own, slope = areas[k]
            low, high = web.reach_mm(amounts.thickness_mm[k])
            t, lever = high - low, 0.5 * (high**2 - low**2)
            total = total + _prism_moments(
                own.area_mm2, own.first_mm3, own.second_mm4, web, low, high, density
            )
            first = slope.first_mm3 @ web.matrix.T
            trace = np.trace(slope.second_mm4, axis1=1, axis2=2)
            row = np.concatenate(
                [t * first, lever * first, t * slope.area_mm2[:, None], t * trace[:, None]], axis=1
            )
            parts[k] += self._folded(k, density * row)
            first_own, z = web.matrix @ own.first_mm3, high if web.grows_up else low
            thick[k] += density * np.array(
                [*first_own, *(z * first_own), own.area_mm2, float(np.trace(own.second_mm4))]
            )
        kept = [k for k, part in enumerate(self.free.parts) if part.thickness_mm is not None]
        return total, np.concatenate([*parts, thick[kept]])

    def tolerance(self, moments: Moments) -> Tolerance:
        """Return what a crank with these moments is judged against."""
        return rotor_from_job.tolerance_of(self.design.start, self.crank.anatomy, moments)

    def residual(self, moments: Moments) -> Unbalance:
        """Return the residual unbalance of a crank with these moments."""
        return Unbalance.of(moments + self.loads)

    def solved(self, variables: Array, off: Array | None = None) -> Array:
        """Return the nearest variables that meet the balance exactly, as far as their bounds allow.

        Newton's steps of least length over the variables that are not at a bound. ``off`` (4,) is added to
        the residual: what the written solid has more than the profiles' own moments.
        """
        low, high = self.bounds.T
        found = np.clip(variables, low, high)
        rows = 2 if self.design.start.balance.judge == "static" else 4
        for _ in range(STEPS):
            moments, gradient = self.moments(found)
            state = self.residual(moments).components + (0.0 if off is None else off)
            tolerance = self.tolerance(moments)
            lever = (
                max(abs(tolerance.planes[1].z_mm - tolerance.planes[0].z_mm), 1.0)
                if tolerance.planes
                else 1.0
            )
            scale = np.array([1.0, 1.0, 1.0 / lever, 1.0 / lever])[:rows]
            left = scale * state[:rows]
            if np.abs(left).max() <= AIM * tolerance.permissible_g_mm:
                break
            slopes = gradient[:, :rows] * scale
            free = np.ones(len(found), dtype=bool)
            for _ in range(len(found)):
                step = np.zeros(len(found))
                step[free] = -np.linalg.lstsq(slopes[free].T, left, rcond=1e-8)[0]
                moved = found + step
                stuck = free & ((moved < low) | (moved > high)) & ((found <= low) | (found >= high))
                if not stuck.any():
                    break
                free &= ~stuck
            found = np.clip(moved, low, high)
        return found

    # --- judging --------------------------------------------------------------------------------------------

    @property
    def wanted(self) -> set[str]:
        """Names of the objectives, without sign."""
        return {name.removeprefix("-") for name in self.design.search.objectives}

    def objectives(self, moments: Moments, solid: Callable[[], Solid] | None = None) -> dict[str, float]:
        """Return what a design is worth.

        ``solid`` makes its solid (rotor frame), on which loads and stress are found; without it loads are
        found by the moments, and stress is left out.
        """
        found = {
            "mass_g": moments.mass_g,
            "polar_inertia_kg_mm2": moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        }
        if not self.wanted & {LOAD, STRESS}:
            return found
        anatomy = self.crank.anatomy
        body = None if solid is None else solid()
        in_file = None if body is None else body.moved(anatomy.rotor_to_file)
        cycle = strength.cycle_of(self.design.start, anatomy, moments, in_file)
        found[LOAD] = strength.greatest_main_load_n(cycle)
        if STRESS in self.wanted and body is not None:
            mesh = strength.body_of(body, self._fem_size_mm)
            loads = strength.greatest_pin_loads_n(cycle)
            found[STRESS] = strength.greatest_stress_MPa(mesh, anatomy, loads, self.crank.density_g_mm3)
        return found

    @property
    def _fem_size_mm(self) -> float | None:
        return None if self.design.fem is None else self.design.fem.size_mm

    def fem_constraints(self, moments: Moments, solid: Solid) -> list[Constraint]:
        """Return what finite elements must find of a design's solid (rotor frame)."""
        limits = self.design.fem
        if limits is None or (limits.min_frequency_hz is None and limits.max_stress_MPa is None):
            return []
        anatomy, density = self.crank.anatomy, self.crank.density_g_mm3
        mesh = strength.body_of(solid, limits.size_mm)
        found = []
        if limits.min_frequency_hz is not None:
            value, least = strength.first_frequency_hz(mesh, density), limits.min_frequency_hz
            found.append(Constraint("first frequency", value, least, "Hz", value - least, 0.01 * least))
        if limits.max_stress_MPa is not None:
            in_file = solid.moved(anatomy.rotor_to_file)
            cycle = strength.cycle_of(self.design.start, anatomy, moments, in_file)
            loads = strength.greatest_pin_loads_n(cycle)
            value, most = strength.greatest_stress_MPa(mesh, anatomy, loads, density), limits.max_stress_MPa
            found.append(Constraint("stress", value, most, "MPa", most - value, 0.01 * most))
        return found

    def constraints(
        self, variables: Array, moments: Moments, residual: Unbalance, *, exact: bool = True
    ) -> tuple[list[Constraint], list[Clearance]]:
        """Return everything a design must keep; ``exact`` sweeps finely."""
        share = self.tolerance(moments).used_share(residual)
        found = [Constraint("residual", share, ALLOWED, "share of permissible", ALLOWED - share, ALLOWED)]
        amounts = self.amounts(variables)
        for k, part in enumerate(self.free.parts):
            found += self._of_profile(k, amounts, part.name)
        clearances = self._clearances(amounts, exact=exact)
        wanted = self.design.envelope.clearance_mm + (0.0 if exact else ROUGH_MM)
        found += [
            Constraint(
                f"clearance to {each.neighbour}",
                each.least_mm,
                wanted,
                "mm",
                each.least_mm - wanted,
                1.0,
                each.at_mm,
                math.degrees(each.at_rad) % 360.0,
            )
            for each in clearances
        ]
        if self.design.mass_g is not None:
            found += _within("mass_g", moments.mass_g, self.design.mass_g)
        if self.design.polar_inertia_kg_mm2 is not None:
            inertia = moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2
            found += _within("polar_inertia_kg_mm2", inertia, self.design.polar_inertia_kg_mm2)
        return found, clearances

    def _of_profile(self, k: int, amounts: Amounts, name: str) -> list[Constraint]:
        part, profile, radii = self.free.parts[k], self.free.profiles[k], amounts.radii_mm[k]
        outline = profile.outline_mm(radii)
        web = self.free.webs[self._first_web(k)]
        low, high = web.reach_mm(amounts.thickness_mm[k])
        found = []

        def at(place: int) -> tuple[float, float, float]:
            x, y = web.matrix @ outline[place]
            return float(x), float(y), 0.5 * (low + high)

        limit = self.design.envelope.radius_mm
        if limit is not None:
            far = np.linalg.norm(outline, axis=1)
            worst = int(far.argmax())
            most = float(far[worst])
            found.append(Constraint(f"{name} radius", most, limit, "mm", limit - most, 1.0, at(worst)))
        if self.design.envelope.z_mm is not None:
            z_low, z_high = self.design.envelope.z_mm
            for each in (web for web in self.free.webs if web.part == k):
                bottom, top = each.reach_mm(amounts.thickness_mm[k])
                room = min(bottom - z_low, z_high - top)
                found.append(Constraint(f"{name} z, web {each.number}", room, 0.0, "mm", room))
        bend = profile.curvature_radii_mm(radii)[1:-1]
        tightest = int(bend.argmin())
        if part.min_curvature_radius_mm > 0.0:
            value = min(float(bend[tightest]), 1e6)
            least = part.min_curvature_radius_mm
            found.append(
                Constraint(f"{name} curvature", value, least, "mm", value - least, 1.0, at(tightest + 1))
            )
        if part.min_wall_mm > 0.0:
            wall, place = _least_wall(outline)
            margin = wall - part.min_wall_mm
            found.append(Constraint(f"{name} wall", wall, part.min_wall_mm, "mm", margin, 1.0, at(place)))
        return found

    def _clearances(self, amounts: Amounts, *, exact: bool) -> list[Clearance]:
        """Return the least clearance of all free metal to each neighbour."""
        found = []
        for neighbour in self.neighbours:
            each = []
            for web in self.free.webs:
                outline = self.free.profiles[web.part].outline_mm(amounts.radii_mm[web.part])
                points = (outline if exact else outline[::4]) @ web.matrix.T
                reach = web.reach_mm(amounts.thickness_mm[web.part])
                gap = max(neighbour.z_mm[0] - reach[1], reach[0] - neighbour.z_mm[1])
                if not exact and gap > self.design.envelope.clearance_mm + ROUGH_MM:
                    continue
                sweep = {} if exact else {"refine": False, "angles": ROUGH_ANGLES}
                each.append(least_clearance(neighbour, points, reach, **sweep))  # type: ignore[arg-type]
            if each:
                found.append(min(each, key=lambda clearance: clearance.least_mm))
        return found


def violation(constraints: Sequence[Constraint]) -> float:
    """Return by how much constraints are broken in all, each in its own scale."""
    return float(sum(max(-each.margin / each.scale, 0.0) for each in constraints))


def _within(name: str, value: float, limits: tuple[float, float]) -> list[Constraint]:
    low, high = limits
    scale = 0.01 * max(abs(low), abs(high))
    unit = "g" if name == "mass_g" else "kg·mm²"
    return [
        Constraint(f"{name} least", value, low, unit, value - low, scale),
        Constraint(f"{name} greatest", value, high, unit, high - value, scale),
    ]


def _least_wall(outline: Array) -> tuple[float, int]:
    """Return the least distance between places of an outline that face away from each other, and where.

    The outline goes counter-clockwise, so metal is on its left.
    """
    points = outline[::2]
    along = np.gradient(points, axis=0)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    offset = points[None] - points[:, None]
    through = np.einsum("ijk,ik->ij", offset, normal) < 0.0
    facing = (normal @ normal.T < FACING) & through & through.T
    distance = np.where(facing, np.linalg.norm(offset, axis=2), np.inf)
    place = int(distance.argmin()) // len(points)
    return min(float(distance.min()), 1e6), 2 * place


def _prism_moments(
    area: float, first: Array, second: Array, web: FreeWeb, low: float, high: float, density: float
) -> Moments:
    """Return the moments of a profile extruded from ``low`` to ``high``, turned to its web."""
    t, lever, square = high - low, 0.5 * (high**2 - low**2), (high**3 - low**3) / 3.0
    turned = web.matrix @ first
    tensor = np.zeros((3, 3))
    tensor[:2, :2] = t * (web.matrix @ second @ web.matrix.T)
    tensor[:2, 2] = tensor[2, :2] = lever * turned
    tensor[2, 2] = square * area
    return Moments(t * area, np.array([*(t * turned), lever * area]), tensor).scaled(density)


def _neighbours(design: DesignJob, crank: Crank) -> list[Neighbour]:
    """Return what free metal must keep clear of."""
    envelope, throws = design.envelope, crank.anatomy.throws
    length = design.start.engine.rod_length_mm
    if (envelope.pistons or envelope.rods) and length is None:
        raise JobError("engine.rod_length_mm is missing; pistons and rods of [envelope] need it")
    for number in (*(room.throw for room in envelope.pistons), *(room.throw for room in envelope.rods)):
        if number > len(throws):
            raise JobError(f"[envelope] names throw {number}; the crank has {len(throws)}")
        if length is not None and length <= throws[number - 1].crank_radius_mm:
            raise JobError(f"engine.rod_length_mm is {length:g}; must be more than the crank radius")
    found: list[Neighbour] = []
    for piston in envelope.pistons:
        throw = throws[piston.throw - 1]
        assert length is not None
        found.append(
            Piston(
                f"piston {piston.throw}",
                piston.z_mm,
                throw.angle_rad,
                throw.crank_radius_mm,
                length,
                piston.skirt_below_pin_mm,
                piston.half_width_mm,
            )
        )
    for rod in envelope.rods:
        throw = throws[rod.throw - 1]
        assert length is not None
        found.append(
            Rod(
                f"rod {rod.throw}",
                rod.z_mm,
                throw.angle_rad,
                throw.crank_radius_mm,
                length,
                rod.big_end_radius_mm,
                rod.shank_half_width_mm,
            )
        )
    for number, shaft in enumerate(envelope.shafts, 1):
        outline = circle_mm(shaft.radius_mm) if shaft.radius_mm is not None else np.array(shaft.outline_mm)
        found.append(
            OtherShaft(
                f"shaft {number}",
                shaft.z_mm,
                np.array(shaft.centre_mm),
                outline,
                shaft.ratio,
                shaft.phase_rad,
            )
        )
    return found
