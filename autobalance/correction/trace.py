"""What can be read of a correction off the metal that really went or came, to hold a report against it.

A trace begins with what a report says of one correction. It tells which metal may be that correction's, and
reads place, depth and size off that metal anew.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.kind import Array, Item, Limits
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.errors import FormatError
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.shape import equal_area
from autobalance.solid.csg.solid import Region, Solid, union
from autobalance.solid.mesh.mesh import Mesh

SLACK_SHARE = 0.05
"""Share of its size by which metal may lie outside of what is claimed and still be that correction's: it is
measured then, and found to be other than claimed."""
SLACK_MM = 0.2
FAR_MM = 1e4
"""Beyond any crank."""
MOST = 1e6
"""No length [mm] or density [kg/m³] of a correction is greater."""
ON_PLANE = 0.999
"""Cosine between normals of facets of one plane, at least."""
FLAP = 0.5
"""Share of a level's forward area below which what is left over counts as a flap."""


RING_MM = 0.05
RING_SIDES = 360
EQUAL_AREA = equal_area(RING_SIDES)
"""A thin ring over a turned radius, its sides, and by how much its corners lie out for a circle's area."""
CLEAN = 0.01
"""Share by which the area of a turned surface may differ from that of the rings without flaps on it."""
SEEN = 0.25
"""Share of what faces the axis that lies at a radius where flaps on the old rim may be the rest."""
CORNERS = 1.001
"""The corners of a tool's prism stick out of the circle of its area by this factor at most."""


@dataclass(frozen=True, eq=False)
class Before:
    """The crank before its corrections: its mesh in file coordinates, its planar faces in the rotor frame.

    ``patches`` are the centroids (k, 3) of each face's triangles, rotor frame.
    """

    mesh: Mesh
    anatomy: Anatomy
    faces: tuple[Face, ...]
    patches: tuple[Array, ...]

    @cached_property
    def corners(self) -> Array:
        """Corners (k, 3, 3) of its facets, rotor frame."""
        return self.mesh.moved(self.anatomy.file_to_rotor).corners


THIN, THIN_MM = 8.0, 1e-4
"""Times how exactly places are known, and length beside that, within which heights are one."""


@dataclass(frozen=True, eq=False)
class Metal:
    """Metal that went or came with one correction, and what it is read with.

    Attributes
    ----------
    pieces : tuple of Solid
        Rotor frame. Booleans of rounded solids leave flaps on them, thinner than the rounding but wide: no
        single vertex means anything, areas and volumes do.
    crank : Before
    near_mm : float
        How exactly places are known: what the file rounds to, and how far its facets lie from true surfaces.
    """

    pieces: tuple[Solid, ...]
    density_g_mm3: float
    crank: Before
    limits: Limits | None
    service_speed_rad_s: float
    near_mm: float

    @cached_property
    def corners(self) -> Array:
        """Corners (k, 3, 3) of the facets."""
        return np.concatenate([np.zeros((0, 3, 3)), *(piece.mesh.corners for piece in self.pieces)])

    @cached_property
    def moments(self) -> Moments:
        """Volume moments (density 1)."""
        return sum((piece.moments(1.0) for piece in self.pieces), Moments.zero())

    @cached_property
    def area_mm2(self) -> float:
        """Area of its surface."""
        return float(np.linalg.norm(self._areas, axis=1).sum())

    @cached_property
    def _areas(self) -> Array:
        a, b, c = self.corners.transpose(1, 0, 2)
        return 0.5 * np.cross(b - a, c - a)

    def facing(self, normal: Array) -> tuple[float, Moments]:
        """Return the height of most of the surface that faces along ``normal``, and its (1, r, r rᵀ) dA.

        A flap at that height has two sides, of which one is taken off again.
        """
        along = self._areas @ normal
        flat = np.abs(along) > ON_PLANE * np.linalg.norm(self._areas, axis=1)
        corners, along = self.corners[flat], along[flat]
        heights = (corners @ normal).mean(axis=1)
        thin_mm = THIN * self.near_mm + THIN_MM
        faces = (along > 0.0) & ~_of_flaps(heights, along, thin_mm)
        if not faces.any():
            faces = along > 0.0
        if not faces.any():
            return math.nan, Moments.zero()
        size, level = along[faces], heights[faces]
        order = np.argsort(level)
        height = float(level[order[np.searchsorted(np.cumsum(size[order]), 0.5 * size.sum())]])
        near = np.abs(corners @ normal - height).max(axis=1) <= thin_mm
        forth, back = surface_moments(corners[near & faces]), surface_moments(corners[near & (along < 0.0)])
        return height, forth - back if back.mass_g < forth.mass_g else forth


def _of_flaps(heights: Array, along: Array, thin_mm: float) -> NDArray[np.bool_]:
    """Tell facets of flaps: at their height, as much faces back as forth.

    Parameters
    ----------
    heights : (k,)
        Of facets, along the normal [mm].
    along : (k,)
        Their areas [mm²], negative where they face against the normal.
    thin_mm : float
        Heights nearer than that are one level.
    """
    order = np.argsort(heights)
    level = np.zeros(len(heights), dtype=np.intp)
    level[order] = np.cumsum(np.diff(heights[order], prepend=heights[order][:1]) > thin_mm)
    net = np.bincount(level, along)
    forth = np.bincount(level, np.maximum(along, 0.0))
    flaps: NDArray[np.bool_] = (net < FLAP * forth)[level]
    return flaps


class Trace(Protocol):
    """What one correction leaves behind."""

    @property
    def takes_metal(self) -> bool:
        """Whether metal goes or comes at all."""
        ...

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return what of the list follows from the rest of it, the job's limits and the crank as it came."""
        ...

    def room(self, crank: Before) -> Solid:
        """Return where this correction's metal lies, with some slack, rotor frame."""
        ...

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return what is read off the metal, by the keys of the report."""
        ...


def surface_moments(corners: Array) -> Moments:
    """Return ∫ (1, r, r rᵀ) dA over triangles (k, 3, 3)."""
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    total = corners.sum(axis=1)
    second = np.einsum("k,ki,kj->ij", area, total, total) + np.einsum("k,kni,knj->ij", area, corners, corners)
    return Moments(float(area.sum()), area @ total / 3.0, second / 12.0)


@dataclass(frozen=True, eq=False)
class Reading:
    """A value read off the metal, and by how much the metal itself leaves it open."""

    value: Array
    within: float


def rates(change: Moments) -> dict[str, Any]:
    """Return what one more millimetre changes, as a report has it."""
    return {
        "unbalance_per_mm_g_mm": change.first_g_mm[:2],
        "moment_per_mm_g_mm2": change.second_g_mm2[:2, 2],
    }


def stated_number(item: Item, key: str) -> float:
    """Return a number of a listed correction."""
    value = item.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormatError(f"{key} of a correction of kind {item.get('kind')!r} is no number")
    if abs(value) > MOST:
        raise FormatError(
            f"{key} of a correction of kind {item.get('kind')!r} is {value:g}; at most {MOST:g}"
        )
    return float(value)


def stated_size(item: Item, key: str) -> float:
    """Return a size of a listed correction, which must be above 0."""
    value = stated_number(item, key)
    if not value > 0.0:
        raise FormatError(
            f"{key} of a correction of kind {item.get('kind')!r} is {value:g}; needed more than 0"
        )
    return value


def stated_vector(item: Item, key: str) -> Array:
    """Return three numbers of a listed correction."""
    value = item.get(key)
    if not (isinstance(value, list) and len(value) == 3):
        raise FormatError(f"{key} of a correction of kind {item.get('kind')!r} is not 3 numbers")
    return np.array([stated_number({**item, key: each}, key) for each in value])


def stated_unit(item: Item, key: str) -> Array:
    """Return a direction of a listed correction."""
    found = stated_vector(item, key)
    size = float(np.linalg.norm(found))
    if not abs(size - 1.0) <= 1e-6:
        raise FormatError(f"{key} of a correction of kind {item.get('kind')!r} is no unit vector")
    return found / size


def turn_deg(x: float, y: float) -> float:
    """Return an angle in [0, 360)."""
    return math.degrees(math.atan2(y, x)) % 360.0 % 360.0


def slack_mm(length_mm: float) -> float:
    """Return how far metal may reach beyond what is claimed: it is measured then, and found to be more."""
    return SLACK_MM + SLACK_SHARE * abs(length_mm)


def faceted_ring(inner_mm: float, outer_mm: float, low_mm: float, high_mm: float, sides: int = 72) -> Solid:
    """Return a ring about the crank axis, its corners at these radii."""
    outline = [(inner_mm, low_mm), (outer_mm, low_mm), (outer_mm, high_mm), (inner_mm, high_mm)]
    return Solid.revolved(np.array(outline), sides)


@dataclass(frozen=True)
class RingTrace:
    """Rims turned down to a radius about the crank axis."""

    item: Item

    @property
    def takes_metal(self) -> bool:
        """Always."""
        return True

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the new radius: the old one less the depth."""
        del crank, limits
        new = stated_number(self.item, "rim_radius_mm") - stated_number(self.item, "depth_mm")
        return {"new_radius_mm": new}

    def room(self, crank: Before) -> Solid:
        """All beyond the new radius, along its webs."""
        inner = stated_number(self.item, "new_radius_mm")
        inner = max(inner - slack_mm(inner), 0.0)
        listed = self.item.get("webs")
        if not isinstance(listed, list):
            raise FormatError(f"webs of a correction of kind {self.item.get('kind')!r} is no list")
        rings = [
            faceted_ring(inner, FAR_MM, web.z_min_mm - SLACK_MM, web.z_max_mm + SLACK_MM)
            for web in crank.anatomy.webs
            if web.number in listed
        ]
        return union(rings) if rings else Solid.nothing()

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Read the new radius off the surface towards the axis, the webs off the pieces."""
        claimed = stated_number(self.item, "new_radius_mm")
        new, turned = self._turned(metal, claimed)
        rim = float(np.hypot(metal.corners[:, :, 0], metal.corners[:, :, 1]).max())
        webs = sorted(
            {web_at(metal.crank.anatomy, float(each.moments(1.0).centre_mm[2])) for each in metal.pieces}
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
        """Return what one more millimetre of radius changes, values or readings."""
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
        is_seen = low <= most <= high or float(weight[there].sum()) >= SEEN * float(weight.sum())
        new = claimed_mm if is_seen else most
        turned = facing & (np.abs(across - most).max(axis=1) <= near + (CORNERS - 1.0) * most)
        return new, surface_moments(corners[turned])


def _ring_rates(metal: Metal, radius_mm: float, turned: Moments) -> dict[str, Any]:
    """Return what one more millimetre of radius changes: from the turned surface, where it can be believed.

    Flaps may hang on the metal where the old rim hardly stood out. So the metal in two thin rings over the
    new radius counts too: flaps have no volume. With m(δ) the moments of what lies within δ of the radius,
    (4 m(δ) − m(2δ)) / 2δ is dm/dδ to second order; m(δ)/δ, to first, tells how far to trust it. The surface
    is believed as far as the rings confirm it: where the rim hardly stands out, some is rounded away.
    """
    exact = rates(turned.scaled(-metal.density_g_mm3))
    if math.isnan(radius_mm):  # nothing faces the axis
        return exact
    low, high = (float(f(piece.bounds[k][2] for piece in metal.pieces)) for k, f in ((0, min), (1, max)))
    thin, thick = (
        _within(metal, radius_mm + step, low - SLACK_MM, high + SLACK_MM) for step in (RING_MM, 2.0 * RING_MM)
    )
    rate = (thin.scaled(4.0) - thick).scaled(0.5 / RING_MM)
    doubt = rate - thin.scaled(1.0 / RING_MM)
    found, off = (rates(each.scaled(-metal.density_g_mm3)) for each in (rate, doubt))
    rounding = 4.0 * metal.near_mm / RING_MM * metal.density_g_mm3 * thin.mass_g / RING_MM * radius_mm
    reach = {"unbalance_per_mm_g_mm": 1.0, "moment_per_mm_g_mm2": max(abs(low), abs(high))}
    clean = abs(turned.mass_g - rate.mass_g) <= CLEAN * rate.mass_g
    told: dict[str, Any] = {}
    for key, value in found.items():
        within = float(np.linalg.norm(off[key])) + rounding * reach[key]
        apart = float(np.linalg.norm(exact[key] - value))
        told[key] = Reading(exact[key], apart) if clean and apart <= within else Reading(value, within)
    return told


def _within(metal: Metal, radius_mm: float, low_mm: float, high_mm: float) -> Moments:
    """Return volume moments (density 1) of the metal within a radius about the axis."""
    rod = faceted_ring(0.0, radius_mm * EQUAL_AREA, low_mm, high_mm, RING_SIDES)
    return sum(((piece & rod).moments(1.0) for piece in metal.pieces), Moments.zero())


@dataclass(frozen=True)
class PocketTrace:
    """A milled pocket: a sector between two radii with round corners, along the axis."""

    item: Item

    @property
    def takes_metal(self) -> bool:
        """Always."""
        return True

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the cutter of the job."""
        del crank
        return {"direction": "axial", "cutter_mm": getattr(limits, "cutter_mm", self.item.get("cutter_mm"))}

    def room(self, crank: Before) -> Solid:
        """All between the radii and the angles, from the cheek down."""
        depth, z = stated_size(self.item, "depth_mm"), stated_number(self.item, "face_z_mm")
        inner, outer = (stated_number(self.item, f"{name}_radius_mm") for name in ("inner", "outer"))
        start, end = stated_number(self.item, "start_deg"), stated_number(self.item, "end_deg")
        slack = slack_mm(depth)
        around = faceted_ring(max(inner - slack, 0.0), outer + slack, z - depth - slack, z + depth + slack)
        wide = min((end - start) % 360.0 or 360.0, 350.0)
        more = math.degrees(slack / max(inner, 1.0))
        angles = np.radians(np.linspace(start - more, start + wide + more, 64))
        wedge = np.concatenate(
            [np.zeros((1, 2)), 2.0 * outer * np.column_stack([np.cos(angles), np.sin(angles)])]
        )
        return around & Solid.prism(Region.of([wedge]), z - depth - slack, z + depth + slack)

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Radii and angles from the section at half depth, the floor's section for the rate."""
        centre = metal.moments.centre_mm
        up = np.sign(stated_number(self.item, "face_z_mm") - centre[2])
        axis = np.array([0.0, 0.0, up])
        floor, cut = metal.facing(-axis)
        cheek, _ = metal.facing(axis)
        outline = np.concatenate(
            [np.zeros((0, 2)), *(p for each in metal.pieces for p in each.section(centre[2]).polygons)]
        )
        radius, middle = np.hypot(*outline.T), math.atan2(centre[1], centre[0])
        off = np.angle(np.exp(1j * (np.arctan2(outline[:, 1], outline[:, 0]) - middle)))
        return {
            "direction": "axial",
            "face": None,
            "cutter_mm": getattr(metal.limits, "cutter_mm", None),
            "web": web_at(metal.crank.anatomy, float(centre[2])),
            "inner_radius_mm": float(radius.min()),
            "outer_radius_mm": float(radius.max()),
            "start_deg": math.degrees(middle + float(off.min())) % 360.0,
            "end_deg": math.degrees(middle + float(off.max())) % 360.0,
            "face_z_mm": up * cheek,
            "depth_mm": cheek + floor,
            "position_mm": centre,
            **rates(cut.scaled(-metal.density_g_mm3)),
        }


def web_at(anatomy: Anatomy, z_mm: float) -> int:
    """Return the number of the web nearest to a place on the axis."""
    return min(anatomy.webs, key=lambda web: max(web.z_min_mm - z_mm, z_mm - web.z_max_mm)).number
