"""Turned rims: their trace."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.correction.contract import Item, Limits
from autobalance.correction.trace import (
    FAR_MM,
    ON_PLANE,
    SLACK_MM,
    Before,
    Metal,
    Reading,
    rates,
    slack_mm,
    stated_number,
    surface_moments,
    web_at,
    where_listed,
)
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import FormatError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.difference import common
from autobalance.solid.csg.shape import equal_area
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from autobalance.value_classes import dataclass

# Traces of rims turned down.


PIN_WALL_MM = 2.0
"""Metal that a default ``min_radius_mm`` leaves outside of the crankpins (ours)."""
BESIDE_MM = 0.25
"""Reach of the tool beyond a web's faces, so that no skin is left; never over a quarter of the gap."""
RING_MM = 0.05
RING_SIDES = 360
GRAINS_OF_RING = 32.0
"""Thickness of a thin ring over a turned radius, its sides, and its smallest thickness in roundings."""
EQUAL_AREA = equal_area(RING_SIDES)
"""Factor on the ring's corners for a circle's area."""
MAX_FLAP_AREA_SHARE = 0.01
"""Share by which the area of a turned surface may differ from that of the rings without flaps on it."""
FLAP_SHARE = 0.25
"""Smallest share of the surface towards the axis at a radius, where flaps on the old rim may be the rest."""
CORNERS = 1.001
"""The corners of a tool's prism stick out of the circle of its area by this factor at most."""


def faceted_ring(inner_mm: float, outer_mm: float, low_mm: float, high_mm: float, sides: int = 72) -> Solid:
    """Return a ring about the crank axis, its corners at these radii."""
    outline = [(inner_mm, low_mm), (outer_mm, low_mm), (outer_mm, high_mm), (inner_mm, high_mm)]
    return Solid.revolved(np.array(outline), sides)


def slab_of(web: Web, webs: Sequence[Web]) -> tuple[float, float]:
    """Return the tool's extent along the axis: a little more than the web's thickness."""
    below = [web.z_min_mm - other.z_max_mm for other in webs if other.z_max_mm <= web.z_min_mm]
    above = [other.z_min_mm - web.z_max_mm for other in webs if other.z_min_mm >= web.z_max_mm]
    return (
        web.z_min_mm - min([BESIDE_MM, *(0.25 * gap for gap in below)]),
        web.z_max_mm + min([BESIDE_MM, *(0.25 * gap for gap in above)]),
    )


def least_radius_mm(anatomy: Anatomy) -> float:
    """Return the smallest radius to turn to if a job states no radius."""
    pins = [throw.crank_radius_mm + 0.5 * throw.crankpin.diameter_mm for throw in anatomy.throws]
    journals = [0.5 * journal.diameter_mm for journal in anatomy.main_journals]
    return max([*pins, *journals], default=0.0) + PIN_WALL_MM


def far_mm(mesh: Mesh, anatomy: Anatomy) -> float:
    """Return a radius about the crank axis beyond all metal."""
    frame = anatomy.file_to_rotor
    xy = (mesh.vertices @ frame[:3, :3].T + frame[:3, 3])[:, :2]
    return 1.1 * float(np.hypot(*xy.T).max()) + 1.0


def tool_volume_mm3(radius_mm: float, far_mm: float, slabs: Sequence[tuple[float, float]]) -> float:
    """Return the volume of the rings between two radii along stretches of the axis."""
    return math.pi * (far_mm**2 - radius_mm**2) * sum(high - low for low, high in slabs)


@dataclass(frozen=True)
class RingTrace:
    """Rims turned down to a radius about the crank axis."""

    item: Item

    @property
    def takes_metal(self) -> bool:
        return True

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the new radius: the old one less the depth; and what is left to turn."""
        new = stated_number(self.item, "rim_radius_mm") - stated_number(self.item, "depth_mm")
        webs, listed = crank.anatomy.webs, self.item.get("webs")
        slabs = [slab_of(web, webs) for web in webs if isinstance(listed, list) and web.number in listed]
        if not slabs:
            return {"new_radius_mm": new}
        least = getattr(limits, "min_radius_mm", None)
        far = far_mm(crank.mesh, crank.anatomy)
        tool = {
            "z_from_mm": min(low for low, _ in slabs),
            "z_to_mm": max(high for _, high in slabs),
            "outer_radius_mm": far,
            "tool_volume_mm3": tool_volume_mm3(new, far, slabs),
            "sector_deg": None,
            "depth_left_mm": new - (least_radius_mm(crank.anatomy) if least is None else least),
        }
        return {"new_radius_mm": new, **where_listed(self.item, tool)}

    def room(self, crank: Before) -> Solid:
        """Return all beyond the new radius, along its webs."""
        inner = stated_number(self.item, "new_radius_mm")
        inner = max(inner - slack_mm(inner), 0.0)
        listed = self.item.get("webs")
        if not isinstance(listed, list):
            raise FormatError(f"webs of a correction of kind {self.item.get('kind')!r} is not a list")
        rings = [
            faceted_ring(inner, FAR_MM, web.z_min_mm - SLACK_MM, web.z_max_mm + SLACK_MM)
            for web in crank.anatomy.webs
            if web.number in listed
        ]
        return union(rings) if rings else Solid.nothing()

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return the new radius from the surface towards the axis, the webs from the pieces."""
        claimed = stated_number(self.item, "new_radius_mm")
        new, turned = self._turned(metal, claimed)
        rim = float(np.hypot(metal.corners[:, :, 0], metal.corners[:, :, 1]).max())
        webs = sorted(
            {
                web_at(metal.crank.anatomy, float(each.moments(1.0).centre_mm[2]))
                for each in metal.pieces
                if each.volume_mm3 > metal.near_mm * each.area_mm2  # no flap that rounding left
            }
        )
        return {
            "webs": webs,
            "web": webs[0] if len(webs) == 1 else None,
            "rim_radius_mm": rim,
            "new_radius_mm": new,
            "depth_mm": rim - new,
            "position_mm": metal.moments.centre_mm,
            **_ring_rates(metal, new, turned),
        }

    def rates(self, metal: Metal, claimed_mm: float) -> dict[str, Any]:
        """Return the change by one more millimetre of radius, as values or readings."""
        return _ring_rates(metal, *self._turned(metal, claimed_mm))

    def _turned(self, metal: Metal, claimed_mm: float) -> tuple[float, Moments]:
        """Return the new radius, and (1, r, r rᵀ) dA over the turned surface; a prism's corners stick out."""
        corners = metal.corners
        across = np.hypot(corners[:, :, 0], corners[:, :, 1])
        a, b, c = corners.transpose(1, 0, 2)
        vectors = np.cross(b - a, c - a)
        middle = corners.mean(axis=1)
        inward = -(vectors[:, :2] * middle[:, :2]).sum(axis=1)
        size = np.linalg.norm(vectors, axis=1) * np.hypot(middle[:, 0], middle[:, 1])
        facing = inward > ON_PLANE * size
        if not facing.any():
            return math.nan, Moments.zero()
        radii, weight = across[facing].mean(axis=1), size[facing]
        order = np.argsort(radii)
        most = float(radii[order[np.searchsorted(np.cumsum(weight[order]), 0.5 * weight.sum())]])
        near = metal.near_mm + 1e-4
        low, high = (
            claimed_mm * EQUAL_AREA * math.cos(math.pi / RING_SIDES) - near,
            claimed_mm * CORNERS + near,
        )
        there = ((across[facing] >= low) & (across[facing] <= high)).all(axis=1)
        is_seen = low <= most <= high or float(weight[there].sum()) >= FLAP_SHARE * float(weight.sum())
        new = claimed_mm if is_seen else most
        turned = facing & (np.abs(across - most).max(axis=1) <= near + (CORNERS - 1.0) * most)
        return new, surface_moments(corners[turned])


def _ring_rates(metal: Metal, radius_mm: float, turned: Moments) -> dict[str, Any]:
    """Return the change by one more millimetre of radius: from the turned surface, where it is reliable.

    Flaps may remain on the metal where the old rim barely protruded. So the metal in two thin rings over the
    new radius counts too: flaps have no volume. The surface is used as far as the rings confirm it: where the
    rim barely protrudes, some is rounded away.
    """
    exact = rates(turned.scaled(-metal.density_g_mm3))
    if math.isnan(radius_mm):  # nothing faces the axis
        return exact
    low, high = (float(f(piece.bounds[k][2] for piece in metal.pieces)) for k, f in ((0, min), (1, max)))
    rate, first_order, ring_mm = _rate_by_rings(metal, radius_mm, low - SLACK_MM, high + SLACK_MM)
    measured, off = (rates(each.scaled(-metal.density_g_mm3)) for each in (rate, rate - first_order))
    rounding = 4.0 * metal.near_mm / ring_mm * metal.density_g_mm3 * first_order.mass_g * radius_mm
    reach = {"unbalance_per_mm_g_mm": 1.0, "moment_per_mm_g_mm2": max(abs(low), abs(high))}
    clean = abs(turned.mass_g - rate.mass_g) <= MAX_FLAP_AREA_SHARE * rate.mass_g
    readings: dict[str, Any] = {}
    for key, value in measured.items():
        within = float(np.linalg.norm(off[key])) + rounding * reach[key]
        apart = float(np.linalg.norm(exact[key] - value))
        readings[key] = Reading(exact[key], apart) if clean and apart <= within else Reading(value, within)
    return readings


def _rate_by_rings(
    metal: Metal, radius_mm: float, low_mm: float, high_mm: float
) -> tuple[Moments, Moments, float]:
    """Return dm/dδ of the metal m(δ) within δ of a radius, to second and to first order, and δ [mm].

    (4 m(δ) − m(2δ)) / 2δ is dm/dδ to second order, m(δ)/δ to first, which shows how far to trust it. The
    corners of a faceted rim may stand out by less than 2δ: rings are halved until that changes nothing.
    """

    def within(step_mm: float) -> Moments:
        rod = faceted_ring(0.0, (radius_mm + step_mm) * EQUAL_AREA, low_mm, high_mm, RING_SIDES)
        return sum((common(piece, rod).moments(1.0) for piece in metal.pieces), Moments.zero())

    def second_order(thin: Moments, thick: Moments, step_mm: float) -> Moments:
        return (thin.scaled(4.0) - thick).scaled(0.5 / step_mm)

    step = RING_MM
    thin, thick = within(step), within(2.0 * step)
    rate = second_order(thin, thick, step)
    while step > GRAINS_OF_RING * metal.near_mm:
        finer_thin = within(0.5 * step)
        finer = second_order(finer_thin, thin, 0.5 * step)
        if abs(finer.mass_g - rate.mass_g) <= MAX_FLAP_AREA_SHARE * abs(finer.mass_g):
            break
        thin, rate, step = finer_thin, finer, 0.5 * step
    return rate, thin.scaled(1.0 / step), step
