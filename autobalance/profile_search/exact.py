"""STEP file of a design: its counterweights with true spline surfaces."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.errors import SolidError
from autobalance.profile_search.envelope import Amounts
from autobalance.profile_search.free_metal import FreeMetal, FreeWeb
from autobalance.profile_search.keys import Drilling
from autobalance.profile_search.outlines import past
from autobalance.profile_search.profile import DEGREE
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.spline import (
    SplineBody,
    faceted_solid,
    sector_body,
    step_beside,
    with_new_metal,
)
from autobalance.types import Array

WHOLE, PARTS = "crank.step", "counterweights.step"


def design_step(
    free: FreeMetal, crank: Crank, amounts: Amounts, drillings: tuple[Drilling, ...]
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
    free: FreeMetal, web: FreeWeb, amounts: Amounts, drillings: tuple[Drilling, ...], arc: bool
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
