"""Surfaces of an exact solid by which a crank's parts are recognised: planes and cylinders."""

from __future__ import annotations

from dataclasses import dataclass

from autobalance.types import Array, Indices


@dataclass(frozen=True, eq=False)
class PlaneFace:
    """A plane face: its number in the solid, outward unit normal (3,), area and centroid (3,) [mm]."""

    number: int
    normal: Array
    area_mm2: float
    centroid_mm: Array


@dataclass(frozen=True, eq=False)
class CylinderFace:
    """A cylindrical face.

    ``point_mm`` (3,) and ``axis`` (unit, (3,)) give the axis, on which the face reaches from ``low_mm`` to
    ``high_mm``; ``hollow`` is true of a hole. ``swept_rad`` is the angle that it spans.
    """

    number: int
    point_mm: Array
    axis: Array
    radius_mm: float
    low_mm: float
    high_mm: float
    hollow: bool
    area_mm2: float
    swept_rad: float


Surface = PlaneFace | CylinderFace


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The plane and cylindrical faces of a solid, and the face that each triangle of its mesh belongs to.

    ``owner`` (m,) holds numbers of faces, also of faces that are neither plane nor cylindrical.
    """

    faces: tuple[Surface, ...]
    owner: Indices

    @property
    def planes(self) -> tuple[PlaneFace, ...]:
        return tuple(face for face in self.faces if isinstance(face, PlaneFace))

    @property
    def cylinders(self) -> tuple[CylinderFace, ...]:
        return tuple(face for face in self.faces if isinstance(face, CylinderFace))
