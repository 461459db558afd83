"""Offset of planar faces inward: the shoulder is ground or milled lower."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

FacePoint = tuple[float, float, float]


@dataclass(frozen=True)
class ShoulderLimits:
    """What a job asks of shoulder corrections.

    Attributes
    ----------
    faces : "auto" or tuple
        Ids of faces, or points in file coordinates [mm], one on each face.
    sector_deg : (float, float) or None
        Only this part of each face: angles about the crank axis, rotor frame [deg].
    max_depth_mm : float or None
    same_depth : bool
        One depth for all faces.
    min_wall_mm : float or None
        Metal to leave, from every point of the new face along −n to the next surface [mm].
    depth_step_mm : float
        Step in which the machine sets the depth; 0: any depth [mm].
    """

    faces: Literal["auto"] | tuple[str | FacePoint, ...] = "auto"
    sector_deg: tuple[float, float] | None = None
    max_depth_mm: float | None = None
    same_depth: bool = False
    min_wall_mm: float | None = None
    depth_step_mm: float = 0.0
