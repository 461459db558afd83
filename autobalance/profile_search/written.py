"""Designs as solids: built, written, read again, measured, corrected; and their jobs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.errors import SolidError
from autobalance.profile_search.envelope import Amounts, DesignConstraint
from autobalance.profile_search.free_metal import FreeMetal, FreeWeb
from autobalance.profile_search.input import OilDrilling
from autobalance.profile_search.neighbours import DesignClearance
from autobalance.profile_search.outlines import DEGREE, PAST_MM, past, round_mm, sector_mm
from autobalance.profile_search.problem import MAX_SHARE, Problem
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.spline import SplineBody, faceted_solid, sector_body, step_beside, with_new_metal
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import through_file
from autobalance.solid.mesh.measure import soup_moments
from autobalance.toml_files.document import toml_text
from autobalance.types import Array
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.profile_search.free_metal import FreeMetal, FreeWeb


# Solids of designs: the old free metal of a crank removed and new metal added (rotor frame).


SNAP_MM = 1e-3
SKIN_MM = 1e-4
"""Skin of old metal left around a new outline, so that no two surfaces nearly coincide."""


def with_profiles(free: FreeMetal, radii_mm: Sequence[Array], thickness_mm: Sequence[float | None]) -> Solid:
    """Return the crank with these profiles (rotor frame).

    Old metal beyond the new outline is cut away and the new body added: metal that is old and new stays in
    one piece, without seams.
    """
    cut, added = Solid.nothing(), Solid.nothing()
    for web in free.webs:
        radii, thickness = radii_mm[web.part], thickness_mm[web.part]
        sector = Region.of([sector_mm(free.profiles[web.part], free.far_mm) @ web.matrix.T])
        cut = cut + (Solid.prism(sector, *past(web.z_mm)) - free_body(free, web, radii, None, SKIN_MM))
        for low, high in _thinner(web.z_mm, web.reach_mm(thickness)):
            cut = cut + Solid.prism(sector, low, high)
        added = added + free_body(free, web, radii, thickness)
    openings = _holes(free, thickness_mm) + free.drillings
    total = (free.solid - cut) + added
    return total if openings.is_empty else total - openings


def free_body(
    free: FreeMetal, web: FreeWeb, radii_mm: Array, thickness_mm: float | None, skin_mm: float = 0.0
) -> Solid:
    """Return a web's new metal without its openings, a skin thicker on all sides but towards held metal."""
    body = free.bodies[web.part]
    low, high = web.reach_mm(thickness_mm)
    if not body.slope:
        outline = Region.of([body.profile.polygon_mm(radii_mm) @ web.matrix.T])
        rounded = body.rounded(radii_mm)
        outline = outline if rounded is None else outline & rounded.turned(web.matrix)
        if skin_mm:
            return Solid.prism(outline.grown(skin_mm), *past(past((low, high))))
        return Solid.prism(outline, low, high)
    base = np.asarray(radii_mm) + skin_mm
    count = len(body.profile.spline_points_mm(radii_mm))
    near, far = (
        body.profile.polygon_mm(body.radii_at(base, depth), count) @ web.matrix.T
        for depth in (-PAST_MM * bool(skin_mm), high - low + PAST_MM * bool(skin_mm))
    )
    z = past(past((low, high))) if skin_mm else (low, high)
    metal = Solid.lofted(near, far, *z) if web.grows_up else Solid.lofted(far, near, *z)
    rounded = body.rounded(base)
    return metal if rounded is None else metal & Solid.prism(rounded.turned(web.matrix), *z)


def _holes(free: FreeMetal, thickness_mm: Sequence[float | None]) -> Solid:
    total = Solid.nothing()
    for web in free.webs:
        outlines = [
            round_mm(hole.diameter_mm, hole.centre_mm) @ web.matrix.T for hole in free.bodies[web.part].holes
        ]
        if outlines:
            total = total + Solid.prism(Region.of(outlines), *past(web.reach_mm(thickness_mm[web.part])))
    return total


def _thinner(old: tuple[float, float], new: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the ranges of height from which a thinner web takes its metal."""
    strips = []
    if new[0] > old[0] + SNAP_MM:
        strips.append((old[0] - PAST_MM, new[0]))
    if new[1] < old[1] - SNAP_MM:
        strips.append((new[1], old[1] + PAST_MM))
    return strips


# Designs as solids: written, read again, measured, and corrected until the file meets the balance.


PASSES = 6
MIN_IMPROVEMENT_SHARE = 1e-3
"""Smallest change of the residual in a pass, as a share: with less, bounds are in the way."""
AIM_SHARE = 0.1
"""Share of the limit that is aimed at: the frame found again on the file moves by its rounding."""
FORMAT = "stl"


@dataclass(frozen=True, eq=False)
class WrittenDesign:
    """A design as the bytes of its solid, with all its measurements.

    ``solid`` is in file coordinates. ``strengths`` are its finite-element results.
    """

    variables: Array
    amounts: Amounts
    data: bytes
    solid: Solid
    moments: Moments
    residual: Unbalance
    used_share: float
    constraints: tuple[DesignConstraint, ...]
    clearances: tuple[DesignClearance, ...]
    strengths: Mapping[str, float] = field(default_factory=dict)

    def rotor_solid(self, problem: Problem) -> Solid:
        """Return the solid in the rotor frame."""
        return self.solid.moved(problem.crank.anatomy.file_to_rotor)

    def objectives(self, problem: Problem) -> dict[str, float]:
        """Return the values of the search's objectives by name."""
        return problem.asked(problem.objectives(self.moments, self.strengths, self.rotor_solid(problem)))

    @property
    def feasible(self) -> bool:
        return all(each.margin >= 0.0 for each in self.constraints)


def written(problem: Problem, variables: Array) -> WrittenDesign:
    """Write a design's solid and measure it, with the changes by facets and rounding corrected.

    Raises
    ------
    SolidError
        If finite elements are wanted, and the solid cannot be meshed.
    """
    off, before = np.zeros(4), np.nan
    best: WrittenDesign | None = None
    for _ in range(PASSES):
        solved = problem.solved(variables, off)
        design = _written_design(problem, solved)
        if best is None or design.used_share < best.used_share:
            best = design
        if (
            best.used_share <= AIM_SHARE * MAX_SHARE
            or abs(design.used_share - before) <= MIN_IMPROVEMENT_SHARE * before
        ):
            break
        before = design.used_share
        off = design.residual.components - problem.residual(problem.moments(solved)[0]).components
    assert best is not None
    if not problem.strengths_wanted:
        return best
    strengths = problem.strengths(best.moments, best.rotor_solid(problem))
    every = (*best.constraints, *problem.of_strengths(strengths))
    return replace(best, constraints=every, strengths=strengths)


def _written_design(problem: Problem, variables: Array) -> WrittenDesign:
    amounts, crank = problem.amounts(variables), problem.crank
    rotor_solid = with_profiles(problem.free, amounts.radii_mm, amounts.thickness_mm)
    solid = rotor_solid.moved(crank.anatomy.rotor_to_file)
    scale = crank.source.mm_per_unit
    data, soup = through_file(solid.mesh, FORMAT, scale)
    moments = soup_moments(soup, crank.density_g_mm3, crank.anatomy.file_to_rotor)
    residual = problem.residual(moments)
    constraints, clearances = problem.constraints(variables, moments, residual)
    return WrittenDesign(
        variables,
        amounts,
        data,
        solid,
        moments,
        residual,
        problem.tolerance(moments).used_share(residual),
        tuple(constraints),
        tuple(clearances),
    )


# STEP file of a design: its counterweights with true spline surfaces.


WHOLE, PARTS = "crank.step", "counterweights.step"


def design_step(
    free: FreeMetal, crank: Crank, amounts: Amounts, drillings: tuple[OilDrilling, ...]
) -> tuple[str, bytes]:
    """Return the name and the bytes of a design's STEP file.

    A crank read from STEP stays one solid with all its own surfaces. For one read from facets, the held metal
    is a solid of planar faces, and each counterweight a solid next to it. If the kernel rejects these facets,
    the file holds the counterweights alone, and its name shows it.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed.
    SolidError
        If the kernel cannot join exact surfaces.
    """
    frame, source = crank.anatomy.rotor_to_file, crank.source
    exact = source.exact
    bodies = [_spline_body(free, web, amounts, drillings, exact is not None) for web in free.webs]
    if exact is None:
        held = _held(free, crank)
        return PARTS if held is None else WHOLE, step_beside(held or (), bodies, frame, "mm")
    sectors = [sector_body(_inner(free, web), True, free.far_mm, past(web.z_mm)) for web in free.webs]
    return WHOLE, with_new_metal(exact.solid, sectors, bodies, frame).step(exact.unit, exact.name)


@lru_cache(maxsize=1)
def _held(free: FreeMetal, crank: Crank) -> tuple[ExactSolid, ...] | None:
    """Return the held metal as solids of planar faces, in file coordinates; None: the kernel rejects them.

    It is the same for all designs.
    """
    pieces = (piece.moved(crank.anatomy.rotor_to_file) for piece in free.held.pieces())
    try:
        return tuple(faceted_solid(piece.mesh) for piece in pieces)
    except SolidError:
        return None


def _inner(free: FreeMetal, web: FreeWeb) -> Array:
    inner: Array = free.profiles[web.part].arc_mm @ web.matrix.T
    return inner


def _spline_body(
    free: FreeMetal, web: FreeWeb, amounts: Amounts, drillings: tuple[OilDrilling, ...], arc: bool
) -> SplineBody:
    body, radii = free.bodies[web.part], amounts.radii_mm[web.part]
    low, high = web.reach_mm(amounts.thickness_mm[web.part])
    near, far = (
        body.profile.control_points_mm(body.radii_at(radii, depth)) @ web.matrix.T
        for depth in (0.0, high - low)
    )
    holes = [
        (*_through(web.matrix @ np.array(hole.centre_mm), past((low, high))), hole.diameter_mm)
        for hole in body.holes
    ]
    oil = [(np.array(each.from_mm), np.array(each.to_mm), each.diameter_mm) for each in drillings]
    return SplineBody(
        near if web.grows_up else far,
        far if web.grows_up else near,
        body.profile.knots,
        DEGREE,
        _inner(free, web),
        arc,
        (low, high),
        body.corner_radius_mm,
        (*holes, *oil),
    )


def _through(centre_mm: Array, z_mm: tuple[float, float]) -> tuple[Array, Array]:
    low, high = (np.array([*centre_mm, z]) for z in z_mm)
    return low, high


# Job of a written design, by which ``balance`` finds it within tolerance already.


def job_toml(problem: Problem) -> str:
    """Return a job of the written crank, by which ``balance`` finds it within tolerance already."""
    raw, start, anatomy = problem.design.raw, problem.design.start, problem.crank.anatomy
    back = anatomy.rotor_to_file
    own = raw["crankshaft"]

    def in_file(point: Any) -> list[float]:
        return [float(v) for v in back[:3, :3] @ np.asarray(point) + back[:3, 3]]

    def pins(crankpins: Sequence[Any]) -> list[dict[str, Any]]:
        return [
            {"centre_mm": in_file(p.centre_mm), "diameter_mm": p.diameter_mm, "width_mm": p.width_mm}
            for p in crankpins
        ]

    crankshaft: dict[str, Any] = {
        "file": "crank.stl",
        "unit": own.get("unit") or _unit_of(problem),
        "density_kg_m3": own["density_kg_m3"],
        "crankpin_in_file": start.crankshaft.crankpin_in_file,
        "axis_point_mm": in_file([0.0, 0.0, 0.0]),
        "axis_direction": [float(v) for v in back[:3, 2]],
        "crankpins": pins([throw.crankpin for throw in anatomy.throws]),
        "main_journals": pins(anatomy.main_journals),
    }
    balance = {**raw["balance"], "factor": problem.factor}
    tables = {"crankshaft": crankshaft, "engine": raw.get("engine", {}), "balance": balance}
    return toml_text({**tables, "correction": {"method": "drill"}})


def _unit_of(problem: Problem) -> str:
    scale = problem.crank.source.mm_per_unit
    return next(name for name, mm in MM_PER.items() if mm == scale)
