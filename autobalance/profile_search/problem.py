"""A design as a problem: its balance solved for exactly, its objectives and its constraints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autobalance.balancing import rotor_from_job
from autobalance.balancing.engine_from_job import with_crankpins, with_oil
from autobalance.balancing.measured import Crank
from autobalance.finite_elements.mesher import need_libraries
from autobalance.profile_search import strength
from autobalance.profile_search.envelope import (
    ROUGH_MM,
    Amounts,
    DesignConstraint,
    clearances_of,
    neighbours_of,
    of_clearance,
    of_profile,
    of_range,
)
from autobalance.profile_search.free_metal import FreeMetal, FreeWeb
from autobalance.profile_search.input import DesignJob
from autobalance.profile_search.neighbours import DesignClearance, Neighbour
from autobalance.profile_search.outlines import AreaMoments
from autobalance.profile_search.strength import StrengthModel
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.value_classes import dataclass

LOAD, STRESS, FREQUENCY = "greatest_main_load_N", "greatest_stress_MPa", "first_frequency_hz"
COLUMNS = {"mass_g": 4, "polar_inertia_kg_mm2": 5}
"""Columns of the moments' gradient."""
BALANCE_TOLERANCE = 1e-9
"""Share of the permissible value to which the balance is solved, by the profiles' own moments."""
MAX_SHARE = 0.01
"""Share of every permissible value that the residual of a written design may reach."""
STEPS = 12


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
    model : StrengthModel or None
        Model of the finite-element results, once some designs were analysed.
    """

    design: DesignJob
    crank: Crank
    free: FreeMetal
    loads: Moments
    factor: float
    neighbours: Sequence[Neighbour]
    model: StrengthModel | None = None

    @classmethod
    def of(cls, design: DesignJob, crank: Crank, free: FreeMetal) -> Problem:
        """Return the problem of a design job.

        Raises
        ------
        JobError
            If the job lacks what its weights, loads or stress need.
        FileError
            If finite elements are wanted and their extra is not installed.
        """
        job = with_oil(design.start, crank)
        rotor_from_job.check_engine(job, crank.anatomy)
        factor = rotor_from_job.target_factor(job, crank.anatomy, crank.moments)
        loads = bob_weight_moments(rotor_from_job.throw_loads(crank.anatomy, job.engine), factor)
        loads = loads + rotor_from_job.beside_throws(job.engine)
        problem = cls(replace(design, start=job), crank, free, loads, factor, neighbours_of(design, crank))
        if problem.strengths_wanted:
            need_libraries()
        if LOAD in problem.wanted or STRESS in problem.strengths_wanted:
            strength.cycle_of(job, crank.anatomy, crank.moments, None)  # raises for what the job lacks
        return problem

    # --- variables ------------------------------------------------------------------------------------------

    @property
    def bounds(self) -> Array:
        """Bounds (v, 2) of the variables: control radii of each part, mirrored ones once; thicknesses."""
        rows = [self.free.bounds_mm[k][self._own(k)] for k in range(len(self.free.parts))]
        thick = [part.thickness_mm for part in self.free.parts if part.thickness_mm is not None]
        return np.concatenate([*rows, np.array(thick).reshape(-1, 2)])

    @property
    def start(self) -> Array:
        """Variables (v,) of the original crank, clipped to their bounds."""
        low, high = self.bounds.T
        inside: Array = np.clip(self.as_it_came, low, high)
        return inside

    @property
    def as_it_came(self) -> Array:
        """Variables (v,) that follow the original crank."""
        rows = []
        for k, part in enumerate(self.free.parts):
            radii = self.free.start_mm[k]
            rows.append((0.5 * (radii + radii[::-1]) if part.symmetric else radii)[self._own(k)])
        thick = [
            self.free.webs[self._first_web(k)].z_mm
            for k, part in enumerate(self.free.parts)
            if part.thickness_mm is not None
        ]
        return np.concatenate([*rows, np.array([high - low for low, high in thick])])

    def _first_web(self, part: int) -> int:
        return next(place for place, web in enumerate(self.free.webs) if web.part == part)

    def _own(self, part: int) -> NDArray[np.int64]:
        """Return the indices of a part's control points that are variables."""
        count = self.free.profiles[part].count
        return np.arange((count + 1) // 2 if self.free.parts[part].symmetric else count)

    def amounts(self, variables: Array) -> Amounts:
        """Return the radii and thicknesses of variables (v,)."""
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
        """Return the gradient with a part's variables, from one with its radii (n, ...)."""
        own, count = len(self._own(part)), len(gradient)
        if not self.free.parts[part].symmetric:
            return gradient
        folded = gradient[:own].copy()
        folded[: count - own] += gradient[::-1][: count - own]
        return folded

    # --- moments --------------------------------------------------------------------------------------------

    def moments(self, variables: Array) -> tuple[Moments, Array]:
        """Return the crank's moments, and their gradient (v, 6): Uₓ, U_y, Pₓ, P_y, mass and polar inertia."""
        amounts = self.amounts(variables)
        density = self.crank.density_g_mm3
        total = self.free.held_moments
        rows, thick = [], np.zeros((len(self.free.parts), 6))
        for k, body in enumerate(self.free.bodies):
            radii = amounts.radii_mm[k]
            thickness = amounts.thickness_mm[k]
            t = self.free.thickness_mm(k) if thickness is None else thickness
            depths, weights = body.nodes(t)
            sections = body.moments(radii, np.append(depths, t))
            row = np.zeros((len(radii), 6))
            for web in (web for web in self.free.webs if web.part == k):
                heights = web.heights_mm(np.append(depths, t))
                for (own, slope), weight, z in zip(sections, weights, heights, strict=False):
                    total = total + _slice_moments(own, web, float(z)).scaled(weight * density)
                    row += weight * density * _slice_slopes(slope, web, float(z))
                thick[k] += density * _slice_row(sections[-1][0], web, float(heights[-1]))
            rows.append(self._folded(k, row))
        kept = [k for k, part in enumerate(self.free.parts) if part.thickness_mm is not None]
        return total, np.concatenate([*rows, thick[kept]])

    def tolerance(self, moments: Moments) -> Tolerance:
        """Return the tolerance of a crank with these moments."""
        return rotor_from_job.tolerance_of(self.design.start, self.crank.anatomy, moments)

    def residual(self, moments: Moments) -> Unbalance:
        return Unbalance.of(moments + self.loads)

    def solved(self, variables: Array, off: Array | None = None) -> Array:
        """Return the nearest variables that meet the balance exactly, as far as their bounds allow.

        Newton's steps of smallest length over the variables that are not at a bound. ``off`` (4,) is added to
        the residual: the excess of the written solid over the profiles' own moments.
        """
        low, high = self.bounds.T
        point = np.clip(variables, low, high)
        rows = 2 if self.design.start.balance.judge == "static" else 4
        for _ in range(STEPS):
            moments, gradient = self.moments(point)
            state = self.residual(moments).components + (0.0 if off is None else off)
            tolerance = self.tolerance(moments)
            lever = (
                max(abs(tolerance.planes[1].z_mm - tolerance.planes[0].z_mm), 1.0)
                if tolerance.planes
                else 1.0
            )
            scale = np.array([1.0, 1.0, 1.0 / lever, 1.0 / lever])[:rows]
            left = scale * state[:rows]
            if np.abs(left).max() <= BALANCE_TOLERANCE * tolerance.permissible_g_mm:
                break
            slopes = gradient[:, :rows] * scale
            free = np.ones(len(point), dtype=bool)
            for _ in range(len(point)):
                step = np.zeros(len(point))
                step[free] = -np.linalg.lstsq(slopes[free].T, left, rcond=1e-8)[0]
                moved = point + step
                stuck = free & ((moved < low) | (moved > high)) & ((point <= low) | (point >= high))
                if not stuck.any():
                    break
                free &= ~stuck
            point = np.clip(moved, low, high)
        return point

    # --- judging --------------------------------------------------------------------------------------------

    @property
    def wanted(self) -> set[str]:
        """Names of the objectives, without sign."""
        return {name.removeprefix("-") for name in self.design.search.objectives}

    def asked(self, objectives: Mapping[str, float]) -> dict[str, float]:
        """Return the objectives of the search alone, in its order."""
        return {name: objectives[name] for name, _ in self.signed_objectives}

    @property
    def strengths_wanted(self) -> tuple[str, ...]:
        """Names of the finite-element results that each design needs."""
        limits = self.design.fem
        frequency = limits is not None and limits.min_frequency_hz is not None
        stress = STRESS in self.wanted or (limits is not None and limits.max_stress_MPa is not None)
        return (FREQUENCY,) * frequency + (STRESS,) * stress

    def strengths(self, moments: Moments, solid: Solid) -> dict[str, float]:
        """Return the finite-element results of a design's solid (rotor frame) by name.

        Raises
        ------
        SolidError
            If the solid cannot be meshed.
        """
        if not self.strengths_wanted:
            return {}
        anatomy, density = self.crank.anatomy, self.crank.density_g_mm3
        size_mm = None if self.design.fem is None else self.design.fem.size_mm
        mesh = strength.body_of(with_crankpins(solid, self.crank), size_mm)
        strengths = {}
        if FREQUENCY in self.strengths_wanted:
            strengths[FREQUENCY] = strength.first_frequency_hz(mesh, density)
        if STRESS in self.strengths_wanted:
            in_file = solid.moved(anatomy.rotor_to_file)
            cycle = strength.cycle_of(self.design.start, anatomy, moments, in_file)
            loads = strength.greatest_pin_loads_n(cycle)
            strengths[STRESS] = strength.greatest_stress_MPa(mesh, anatomy, loads, density)
        return strengths

    def of_strengths(
        self, strengths: Mapping[str, float], errors: Mapping[str, float] | None = None
    ) -> list[DesignConstraint]:
        """Return constraints on strengths; predicted strengths lose their errors (shares) from the margin."""
        limits, constraints = self.design.fem, []
        if limits is None:
            return []
        error = errors or {}
        if limits.min_frequency_hz is not None and FREQUENCY in strengths:
            value, least = strengths[FREQUENCY], limits.min_frequency_hz
            margin = value * (1.0 - error.get(FREQUENCY, 0.0)) - least
            constraints.append(DesignConstraint("first frequency", value, least, "Hz", margin, 0.01 * least))
        if limits.max_stress_MPa is not None and STRESS in strengths:
            value, most = strengths[STRESS], limits.max_stress_MPa
            margin = most - value * (1.0 + error.get(STRESS, 0.0))
            constraints.append(DesignConstraint("stress", value, most, "MPa", margin, 0.01 * most))
        return constraints

    def predicted_limits(self, variables: Array) -> list[DesignConstraint]:
        """Return the finite-element constraints by the model's predictions; empty without a model."""
        if self.model is None:
            return []
        return self.of_strengths(self.model.predicted(variables), self.model.errors_at(variables))

    @property
    def signed_objectives(self) -> list[tuple[str, float]]:
        """Names of the objectives with their signs: −1 for those to be maximized."""
        return [
            (name.removeprefix("-"), -1.0 if name.startswith("-") else 1.0)
            for name in self.design.search.objectives
        ]

    def objectives(
        self, moments: Moments, strengths: Mapping[str, float], solid: Solid | None = None
    ) -> dict[str, float]:
        """Return a design's objectives by name; with its solid (rotor frame), loads come from its bays."""
        values = {
            "mass_g": moments.mass_g,
            "polar_inertia_kg_mm2": moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        }
        if LOAD in self.wanted:
            anatomy = self.crank.anatomy
            in_file = None if solid is None else solid.moved(anatomy.rotor_to_file)
            cycle = strength.cycle_of(self.design.start, anatomy, moments, in_file)
            values[LOAD] = strength.greatest_main_load_n(cycle)
        if STRESS in self.wanted and STRESS in strengths:
            values[STRESS] = strengths[STRESS]
        return values

    def constraints(
        self, variables: Array, moments: Moments, residual: Unbalance, *, exact: bool = True
    ) -> tuple[list[DesignConstraint], list[DesignClearance]]:
        """Return all constraints of a design, with its clearances; ``exact`` sweeps finely."""
        share = self.tolerance(moments).used_share(residual)
        kept = DesignConstraint(
            "residual", share, MAX_SHARE, "share of permissible", MAX_SHARE - share, MAX_SHARE
        )
        limits, clearances = self.limits(variables, lambda: moments, exact=exact)
        return [kept, *limits], clearances

    def limits(
        self, variables: Array, moments: Callable[[], Moments], *, exact: bool = True
    ) -> tuple[list[DesignConstraint], list[DesignClearance]]:
        """Return the constraints beside the balance; ``moments`` is called only where they are limited."""
        constraints = []
        amounts, envelope = self.amounts(variables), self.design.envelope
        for k in range(len(self.free.parts)):
            constraints += of_profile(self.free, k, amounts, envelope)
        near = envelope.clearance_mm
        clearances = clearances_of(self.free, amounts, self.neighbours, near, exact=exact)
        least_mm = near + (0.0 if exact else ROUGH_MM)
        constraints += [of_clearance(each, least_mm) for each in clearances]
        if self.design.mass_g is not None:
            constraints += of_range("mass_g", moments().mass_g, self.design.mass_g)
        if self.design.polar_inertia_kg_mm2 is not None:
            inertia = moments().polar_inertia_g_mm2 / G_MM2_PER_KG_MM2
            constraints += of_range("polar_inertia_kg_mm2", inertia, self.design.polar_inertia_kg_mm2)
        return constraints, clearances


def _slice_moments(own: AreaMoments, web: FreeWeb, z_mm: float) -> Moments:
    """Return the moments of a section of unit density and thickness at a height, turned to its web."""
    first = web.matrix @ own.first_mm3
    tensor = np.zeros((3, 3))
    tensor[:2, :2] = web.matrix @ own.second_mm4 @ web.matrix.T
    tensor[:2, 2] = tensor[2, :2] = z_mm * first
    tensor[2, 2] = z_mm**2 * own.area_mm2
    return Moments(own.area_mm2, np.array([*first, z_mm * own.area_mm2]), tensor)


def _slice_row(own: AreaMoments, web: FreeWeb, z_mm: float) -> Array:
    """Return a section's contribution per millimetre (6,): Uₓ, U_y, Pₓ, P_y, mass and polar inertia."""
    first = web.matrix @ own.first_mm3
    return np.array([*first, *(z_mm * first), own.area_mm2, float(np.trace(own.second_mm4))])


def _slice_slopes(slope: AreaMoments, web: FreeWeb, z_mm: float) -> Array:
    """Return the slopes (n, 6) of a section's contribution per millimetre with its control radii."""
    first = slope.first_mm3 @ web.matrix.T
    trace = np.trace(slope.second_mm4, axis1=1, axis2=2)
    return np.concatenate([first, z_mm * first, slope.area_mm2[:, None], trace[:, None]], axis=1)
