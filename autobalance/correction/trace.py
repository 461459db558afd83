"""Values of a correction read off the metal that really went or came, to verify a report.

A trace starts from one correction of a report. It bounds the metal that may be that correction's, and reads
place, depth and size off that metal again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.contract import Item, Limits
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.errors import FormatError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

SLACK_SHARE = 0.05
"""Share of its size by which metal may lie outside of the claimed room and still be that correction's: it is
then measured, and differs from the claim."""
SLACK_MM = 0.2
FAR_MM = 1e4
"""Length beyond any crank."""
GREATEST_VALUE = 1e6
"""Bound of every length [mm] and density [kg/m³] of a correction."""
ON_PLANE = 0.999
"""Smallest cosine between normals of facets of one plane."""
FLAP_AREA_SHARE = 0.5
"""Share of a level's forward area below which its net area counts as a flap."""


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

    @cached_property
    def placed(self) -> Solid:
        """The solid that its mesh bounds, rotor frame."""
        return Solid.from_mesh(self.mesh).moved(self.anatomy.file_to_rotor)

    @property
    def facet_mm2(self) -> float:
        """Area of the 99th percentile of facets."""
        return 0.5 * float(np.quantile(self.mesh.doubled_areas, 0.99))


THIN, THIN_MM = 8.0, 1e-4
"""Multiple of the accuracy of places, and a length beside that, within which heights are one."""


@dataclass(frozen=True, eq=False)
class Metal:
    """Metal removed or added by one correction, and the context to read it with.

    Attributes
    ----------
    pieces : tuple of Solid
        Rotor frame. Booleans of rounded solids leave flaps on them, thinner than the rounding but wide: no
        single vertex means anything, areas and volumes do.
    crank : Before
    near_mm : float
        Accuracy of places: the rounding of the file, and the distance of its facets from true surfaces.
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

        A flap at that height has two sides; one is removed again.
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
    """Return whether facets are of flaps (k,): as much area at their height faces back as forth.

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
    flaps: NDArray[np.bool_] = (net < FLAP_AREA_SHARE * forth)[level]
    return flaps


class Trace(Protocol):
    """Evidence of one correction in the metal."""

    @property
    def takes_metal(self) -> bool:
        """Whether metal goes or comes at all."""
        ...

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the listed values that follow from the others, the job's limits and the crank as it came."""
        ...

    def room(self, crank: Before) -> Solid:
        """Return a body around this correction's metal, with some slack, rotor frame."""
        ...

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return the values read off the metal, by the keys of the report."""
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
    """Value read off the metal, and its uncertainty from the metal itself."""

    value: Array
    within: float


DEEPEST_MM = 5e-3
"""Uncertainty of the largest depth beside the machine's step, on files that were rounded."""


def depth_left(deepest_mm: float, depth_mm: float, step_mm: float) -> Reading:
    """Return the depth that a cut has left, to the largest depth or a step short of it."""
    return Reading(np.array(deepest_mm - depth_mm - 0.5 * step_mm), 0.5 * step_mm + DEEPEST_MM)


def rates(change: Moments) -> dict[str, Any]:
    """Return the change by one more millimetre, by the keys of a report."""
    return {
        "unbalance_per_mm_g_mm": change.first_g_mm[:2],
        "moment_per_mm_g_mm2": change.second_g_mm2[:2, 2],
    }


def where_listed(item: Item, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that a correction lists: reports of earlier versions have fewer."""
    return {key: value for key, value in values.items() if key in item}


def stated_number(item: Item, key: str) -> float:
    """Return a number of a listed correction."""
    value = item.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormatError(f"{key} of a correction of kind {item.get('kind')!r} is not a number")
    if abs(value) > GREATEST_VALUE:
        raise FormatError(
            f"{key} of a correction of kind {item.get('kind')!r} is {value:g}; at most {GREATEST_VALUE:g}"
        )
    return float(value)


def stated_size(item: Item, key: str) -> float:
    """Return a size of a listed correction, which must be above 0."""
    value = stated_number(item, key)
    if not value > 0.0:
        raise FormatError(
            f"{key} of a correction of kind {item.get('kind')!r} is {value:g}; expected more than 0"
        )
    return value


def stated_vector(item: Item, key: str) -> Array:
    """Return three numbers of a listed correction."""
    value = item.get(key)
    if not (isinstance(value, list) and len(value) == 3):
        raise FormatError(f"{key} of a correction of kind {item.get('kind')!r} is not 3 numbers")
    return np.array([stated_number({**item, key: each}, key) for each in value])


def stated_unit(item: Item, key: str) -> Array:
    """Return a unit vector of a listed correction."""
    vector = stated_vector(item, key)
    size = float(np.linalg.norm(vector))
    if not abs(size - 1.0) <= 1e-6:
        raise FormatError(f"{key} of a correction of kind {item.get('kind')!r} is not a unit vector")
    return vector / size


def turn_deg(x: float, y: float) -> float:
    """Return the angle of (x, y) in [0, 360)."""
    return wrapped_deg(math.degrees(math.atan2(y, x)))


def slack_mm(length_mm: float) -> float:
    """Return the excess over a claimed length within which metal is still measured as the correction's."""
    return SLACK_MM + SLACK_SHARE * abs(length_mm)


def web_at(anatomy: Anatomy, z_mm: float) -> int:
    """Return the number of the web nearest to a place on the axis."""
    return min(anatomy.webs, key=lambda web: round(max(web.z_min_mm - z_mm, z_mm - web.z_max_mm), 6)).number
