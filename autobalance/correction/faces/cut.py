"""Common parts of lowered faces and metal on faces: choice of faces, their frame, their listing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from autobalance.correction.contract import Correction, Item
from autobalance.correction.cut import EmptyPlace, listed
from autobalance.correction.faces.curve import DepthCurve
from autobalance.correction.faces.layer import moments_of
from autobalance.correction.faces.patches import FaceLimits, Patch, auto_patches, chosen_patches
from autobalance.correction.kind import Workpiece
from autobalance.correction.outline import loops_area_mm2, region_outline
from autobalance.crank.anatomy import Face
from autobalance.quantities import mm, said
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.region import Region
from autobalance.types import Array
from autobalance.wording import degrees


class FaceCut(EmptyPlace):
    """Cut into a planar face, or metal on one: the same with two signs."""

    face: Face
    to_face: Array
    sector_deg: tuple[float, float] | None
    density_g_mm3: float
    height_mm: float
    """Height of the face along its normal, from the rotor's origin."""

    @cached_property
    def _curve(self) -> DepthCurve:
        """Moments of the section at the new face, over the depth."""
        raise NotImplementedError

    @property
    def _sign(self) -> float:
        return 1.0 if self.adds_metal else -1.0

    @cached_property
    def to_rotor(self) -> Array:
        """The face's frame in the rotor's."""
        back = np.eye(4)
        back[:3, :3] = self.to_face[:3, :3].T
        return back

    def effect(self, depth_mm: float) -> Moments:
        return self._change(self._curve.integral(depth_mm))

    def rate(self, depth_mm: float) -> Moments:
        """Return d effect / d depth = ±ρ ∫ (1, r, r rᵀ) dA over the new face, rotor frame."""
        return self._change(self._curve.value(depth_mm))

    def _change(self, section: Array) -> Moments:
        return moments_of(section).moved(self.to_rotor).scaled(self._sign * self.density_g_mm3)

    def listed(self, kind: str, depth_mm: float, region: Region, **own: Any) -> Correction:
        """Return the finished correction; ``region`` is the face as it is now, in its own axes."""
        outline = region_outline(region, self.to_rotor)
        return listed(
            kind,
            self.effect(depth_mm),
            -self._sign * depth_mm,
            self.density_g_mm3,
            web=self.face.web,
            axis=self._sign * self.face.normal,
            tool_volume_mm3=abs(depth_mm) * loops_area_mm2(outline["outline"]),
            face=self.face.id,
            normal=[float(value) for value in self.face.normal],
            face_height_mm=self.height_mm,
            new_height_mm=self.height_mm + self._sign * depth_mm,
            **own,
            **outline,
            sector_deg=None if self.sector_deg is None else list(self.sector_deg),
        )


def patches_of(
    work: Workpiece, limits: FaceLimits, heavy_at: Sequence[tuple[float, Array]], search_level: int
) -> list[Patch]:
    """Return the patches of faces that a job picks, or of those on the heavy side."""
    mesh = work.solid.mesh
    if limits.faces == "auto":
        return auto_patches(mesh, work.anatomy, work.faces, heavy_at, limits, search_level)
    return chosen_patches(limits, mesh, work.anatomy, work.faces)


WHOLE_SIDE_DEG = 179.0
"""Angle from which on a sector is the whole heavy side, 180° except for rounding."""


def part_name(sector_deg: Sequence[float] | None) -> str:
    """Return the name of the part of a face that a cut keeps to; empty for a whole face or heavy side."""
    if sector_deg is None or not 0.0 < (sector_deg[1] - sector_deg[0]) % 360.0 < WHOLE_SIDE_DEG:
        return ""
    return f", its part from {degrees(sector_deg[0])} to {degrees(sector_deg[1])}"


def face_heights(item: Item) -> str:
    """Return the height of a corrected face before and after, where the report has them."""
    if item.get("new_height_mm") is None:
        return ""
    return said("{} → {}", mm(item["face_height_mm"], ",.3f"), mm(item["new_height_mm"], ",.3f"))


SAME_SECTOR_DEG = 0.5
"""Angle up to which sectors are the same: reports round theirs."""


def is_kept_face(cut: FaceCut, item: Item) -> bool:
    """Return whether a face, or its sector, is that of an earlier report."""
    listed = item.get("sector_deg")
    if cut.face.id != item.get("face") or (cut.sector_deg is None) != (listed is None):
        return False
    pairs = zip(cut.sector_deg or (), listed or (), strict=True)
    return all(abs((a - float(b) + 180.0) % 360.0 - 180.0) < SAME_SECTOR_DEG for a, b in pairs)
