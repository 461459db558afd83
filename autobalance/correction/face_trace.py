"""What lowered and built-up faces leave behind."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalance.correction.kind import Array, Item
from autobalance.correction.layer import Layer
from autobalance.correction.patches import ROUNDING_SHARE, face_frame, face_region, farthest_mm, sector
from autobalance.correction.trace import (
    ON_PLANE,
    Before,
    Metal,
    rates,
    slack_mm,
    stated_number,
    stated_unit,
    surface_moments,
)
from autobalance.crank.anatomy import Face
from autobalance.errors import FormatError
from autobalance.solid.csg.solid import Region, Solid

LEAN = 1.0
"""How far beside a face metal is looked for, as a share of the depth: if it went elsewhere, that is found."""
BESIDE_MM = 0.1
WHOLE_FACE = 0.98
"""Share of a face that is cut where all of it is."""
EDGE_MM2 = 0.1
"""Area of metal cut off at an angle that shows where the angle is."""


def _hanging_together(
    crank: Before, to_face: Array, under: Region, height_mm: float, slack_mm: float
) -> Region:
    """Return the crank's cross-section at a new face, as far as it hangs together with the old one.

    Where neighbours lean far outward, a rounded edge above all, far more goes than lies under the face.
    """
    frame, grain = to_face @ crank.anatomy.file_to_rotor, ROUNDING_SHARE * crank.mesh.diagonal_mm
    layer = Layer.of(crank.mesh, frame, height_mm - slack_mm, height_mm + slack_mm, grain)
    parts = [part for part in layer.section(height_mm + grain).pieces() if not (part & under).is_empty]
    return sum(parts, Region.of([])).grown(BESIDE_MM)


BESIDE_DEG = 1e-3
"""How far a room reaches beyond its sector: walls of both in one plane would be merged into slanting ones."""


@dataclass(frozen=True)
class FaceTrace:
    """A face that was lowered, or metal that stands on one (``adds``)."""

    item: Item
    adds: bool = False

    @property
    def takes_metal(self) -> bool:
        """Always."""
        return True

    def room(self, crank: Before) -> Solid:
        """Reach over or under the face, beside it as far as walls may lean."""
        ends = sorted((stated_number(self.item, "face_height_mm"), stated_number(self.item, "new_height_mm")))
        slack, to_face = slack_mm(ends[1] - ends[0]), face_frame(stated_unit(self.item, "normal"))
        face = next((face for face in crank.faces if face.id == self.item.get("face")), None)
        if face is None:
            raise FormatError(f"face {self.item.get('face')!r} of a correction is none of the crank")
        under = face_region(crank.mesh, crank.anatomy, face, to_face)
        outline = under.grown(LEAN * (ends[1] - ends[0]) + BESIDE_MM)
        if not self.adds:
            outline = outline + _hanging_together(crank, to_face, under, ends[0], slack)
        room = Solid.prism(outline, ends[0] - slack, ends[1] + slack).moved(to_face.T)
        if self._angles_deg is None:
            return room
        start, end = self._angles_deg
        beside = BESIDE_DEG if 0.0 < (end - start) % 360.0 < 360.0 - 2.0 * BESIDE_DEG else 0.0
        angles = start - beside, end + beside
        return room & sector(angles, farthest_mm(crank.mesh, crank.anatomy))

    @property
    def _angles_deg(self) -> tuple[float, float] | None:
        """The sector it keeps to, if it does."""
        value = self.item.get("sector_deg")
        if value is None:
            return None
        if not (
            isinstance(value, list) and len(value) == 2 and all(isinstance(v, int | float) for v in value)
        ):
            raise FormatError(f"sector_deg of a correction of kind {self.item.get('kind')!r} is not 2 angles")
        return float(value[0]), float(value[1])

    def _has_edges(self, metal: Metal) -> bool:
        """Tell whether the metal is cut off at both angles of its sector."""
        for angle in np.radians(self._angles_deg or ()):
            across = np.array([-math.sin(angle), math.cos(angle), 0.0])
            along = np.array([math.cos(angle), math.sin(angle), 0.0])
            near = np.abs(metal.corners @ across) <= 8.0 * metal.near_mm + 1e-4
            edge = near.all(axis=1) & ((metal.corners @ along).mean(axis=1) > 0.0)
            if surface_moments(metal.corners[edge]).mass_g < EDGE_MM2:
                return False
        return True

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Heights, depth, the new face, and on which face it is."""
        normal = stated_unit(self.item, "normal")
        up = 1.0 if self.adds else -1.0
        new, cut = metal.facing(up * normal)
        old, stood_on = metal.facing(-up * normal)
        face = self._face(metal, normal, -up * old)
        height = float(face.normal @ face.centroid_mm)
        whole = stood_on.mass_g >= WHOLE_FACE * face.area_mm2
        shows = whole if self._angles_deg is None else self._has_edges(metal)
        sector_deg = {"sector_deg": self.item.get("sector_deg")} if shows else {}
        area = {"area_mm2" if self.adds else "new_face_area_mm2": cut.mass_g}
        return {
            "face": face.id,
            "web": face.web,
            "normal": face.normal,
            "face_height_mm": height,
            "new_height_mm": up * new,
            "depth_mm": height - up * new,
            "position_mm": metal.moments.centre_mm,
            **area,
            **sector_deg,
            **rates(cut.scaled(up * metal.density_g_mm3)),
        }

    def _face(self, metal: Metal, normal: Array, height_mm: float) -> Face:
        """Return the face over or under which the metal lies."""
        centre = metal.moments.centre_mm
        centre = centre + (height_mm - float(normal @ centre)) * normal
        best, nearest = None, math.inf
        for face, patch in zip(metal.crank.faces, metal.crank.patches, strict=True):
            if face.kind == "plane" and float(face.normal @ normal) > ON_PLANE:
                away = float(np.linalg.norm(patch - centre, axis=1).min())
                off = abs(float(face.normal @ face.centroid_mm) - height_mm)
                if away + 10.0 * off < nearest:
                    best, nearest = face, away + 10.0 * off
        if best is None:
            raise FormatError(
                f"normal of a correction of kind {self.item.get('kind')!r}: no face looks that way"
            )
        return best
