"""Traces of lowered and built-up faces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from autobalance.correction.contract import Item, Limits
from autobalance.correction.faces.layer import Layer
from autobalance.correction.faces.patches import ROUNDING_SHARE, face_frame, face_region, farthest_mm, sector
from autobalance.correction.machining import loops_area_mm2, side_of
from autobalance.correction.trace import (
    ON_PLANE,
    THIN,
    THIN_MM,
    Before,
    Metal,
    rates,
    slack_mm,
    stated_number,
    stated_unit,
    where_listed,
)
from autobalance.crank.anatomy import Face
from autobalance.errors import FormatError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

LEAN_SHARE = 1.0
"""Distance beside a face at which metal is sought, as a share of the depth, to find metal gone elsewhere."""
BESIDE_MM = 0.1
WHOLE_FACE = 0.98
"""Share of a face that is cut where all of it is."""
AXES = 1e-6
"""Tolerance of the axes of an outline against those of its face."""
OUTLINE_AREA_TOLERANCE = 1e-3
"""Share by which the area inside an outline may differ from that of the face: its corners are thinned."""
EDGE_MM2 = 0.1
"""Area of metal cut off at an angle that shows where the angle is."""
EDGE_MM = 0.05
"""Depth from which edges are read: rounding leaves walls as high as those of a thinner layer."""
EDGE_DEG = 0.05
"""Tolerance of an edge's angle against its listed one."""
OWN_FACETS = 2.0
"""Further area, in facets, of an edge in the metal of a scan that counts though it is not listed."""


def _hanging_together(
    crank: Before, to_face: Array, under: Region, height_mm: float, slack_mm: float
) -> Region:
    """Return the crank's cross-section at a new face, as far as it is connected to the old one.

    Where neighbours lean far outward, a rounded edge above all, far more goes than lies under the face.
    """
    frame, grain = to_face @ crank.anatomy.file_to_rotor, ROUNDING_SHARE * crank.mesh.diagonal_mm
    layer = Layer.of(crank.mesh, frame, height_mm - slack_mm, height_mm + slack_mm, grain)
    parts = [part for part in layer.section(height_mm + grain).pieces() if not (part & under).is_empty]
    return sum(parts, Region.of([])).grown(BESIDE_MM)


BESIDE_DEG = 1e-3
"""Margin of a room beyond its sector: walls of both in one plane would be merged into slanting ones."""


def axes_of_outline(item: Item, normal: Array) -> Array:
    """Return the axes (4, 4) of an outline on an oblique face: a rotation whose z axis is the face's normal.

    Raises
    ------
    FormatError
        If they are anything else.
    """
    try:
        axes = np.array(item["outline_to_rotor"], dtype=np.float64)
        turn = axes[:3, :3]
        is_rotation = axes.shape == (4, 4) and np.allclose(turn @ turn.T, np.eye(3), atol=AXES)
        fits = is_rotation and np.linalg.det(turn) > 0.0 and np.allclose(axes[:3, 2], normal, atol=AXES)
        fits = fits and np.allclose(axes[:3, 3], 0.0) and np.allclose(axes[3], [0.0, 0.0, 0.0, 1.0])
    except (LookupError, TypeError, ValueError):
        fits = False
    if not fits:
        raise FormatError("outline_to_rotor of a correction is not a rotation of z to the normal of its face")
    return axes


@dataclass(frozen=True)
class FaceTrace:
    """Trace of a lowered face, or of metal on one (``adds``)."""

    item: Item
    adds: bool = False

    @property
    def takes_metal(self) -> bool:
        return True

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the face before, its new height (the old one less the depth), and the job's sector."""
        sector = getattr(limits, "sector_deg", None)
        face = self._stated_face(crank)
        height = stated_number(self.item, "face_height_mm")
        return {
            **where_listed(self.item, self._tool(face)),
            "web": face.web,
            "normal": face.normal,
            "face_height_mm": float(face.normal @ face.centroid_mm),
            "new_height_mm": height - stated_number(self.item, "depth_mm"),
            **({} if sector is None else {"sector_deg": np.array([wrapped_deg(angle) for angle in sector])}),
        }

    def _tool(self, face: Face) -> dict[str, Any]:
        """Return the values of the body that the outline draws, its area checked against the listed one."""
        loops = self.item.get("outline")
        if not isinstance(loops, list):
            return {}
        area = stated_number(self.item, "area_mm2" if self.adds else "new_face_area_mm2")
        try:
            drawn = loops_area_mm2(loops)
        except (LookupError, TypeError, ValueError):
            raise FormatError("outline of a correction is not a list of loops of lines and arcs") from None
        if not abs(drawn - area) <= OUTLINE_AREA_TOLERANCE * area + EDGE_MM2:
            raise FormatError(f"outline of a correction holds {drawn:.6g} mm²; its face has {area:.6g} mm²")
        depth = abs(stated_number(self.item, "depth_mm"))
        lift = stated_number({"entry_lift_mm": 0.0, **self.item}, "entry_lift_mm")
        values: dict[str, Any] = {
            "side": side_of(face.normal),
            "tool_volume_mm3": (depth + lift) * drawn,
            "outline": loops,
        }
        if values["side"] is None:
            values["outline_to_rotor"] = axes_of_outline(self.item, face.normal)
        return values

    def _stated_face(self, crank: Before) -> Face:
        face = next((face for face in crank.faces if face.id == self.item.get("face")), None)
        if face is None:
            raise FormatError(f"face {self.item.get('face')!r} of a correction is none of the crank")
        return face

    def room(self, crank: Before) -> Solid:
        """Return the room over or under the face, beside it as far as walls may lean."""
        ends = sorted((stated_number(self.item, "face_height_mm"), stated_number(self.item, "new_height_mm")))
        slack, to_face = slack_mm(ends[1] - ends[0]), face_frame(stated_unit(self.item, "normal"))
        under = face_region(crank.mesh, crank.anatomy, self._stated_face(crank), to_face)
        outline = under.grown(LEAN_SHARE * (ends[1] - ends[0]) + BESIDE_MM)
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
        """Angles of its listed sector; None without one."""
        value = self.item.get("sector_deg")
        if value is None:
            return None
        if not (
            isinstance(value, list) and len(value) == 2 and all(isinstance(v, int | float) for v in value)
        ):
            raise FormatError(f"sector_deg of a correction of kind {self.item.get('kind')!r} is not 2 angles")
        return float(value[0]), float(value[1])

    def _sector_deg(
        self, metal: Metal, is_whole: bool, normal: Array, heights_mm: tuple[float, float]
    ) -> dict[str, Any]:
        """Return the sector as the metal between two heights shows it.

        Nothing where the metal ends before the sector does, or is too thin to show an edge. Where only one of
        its edges shows and is another than listed, that one is reported.
        """
        if abs(heights_mm[0] - heights_mm[1]) < EDGE_MM:
            return {}
        listed = self._angles_deg
        angles = listed or (None, None)
        up, slack = metal.corners @ normal, THIN * metal.near_mm + THIN_MM
        low, high = min(heights_mm) - slack, max(heights_mm) + slack
        layer = metal.corners[((up > low) & (up < high)).all(axis=1)]  # flaps reach into what lies beside it
        walls = metal.crank.corners
        height = walls @ normal  # those beside this metal: another web's would cancel them
        walls = walls[(height.max(axis=1) > low) & (height.min(axis=1) < high)]
        edges = [
            _edge_deg(metal, layer, walls, -1.0, *angles),
            _edge_deg(metal, layer, walls, 1.0, *reversed(angles)),
        ]
        if listed is None:
            return {} if None in edges and not is_whole else {"sector_deg": None if is_whole else edges}
        seen = [angle if edge is None else edge for edge, angle in zip(edges, listed, strict=True)]
        off = max(abs((one - other + 180.0) % 360.0 - 180.0) for one, other in zip(seen, listed, strict=True))
        if off > EDGE_DEG:
            return {"sector_deg": seen}
        return {} if None in edges else {"sector_deg": list(listed)}

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return its face, the heights, the depth and the area of the new face."""
        normal = stated_unit(self.item, "normal")
        up = 1.0 if self.adds else -1.0
        new, cut = metal.facing(up * normal)
        old, stood_on = metal.facing(-up * normal)
        face = self._face(metal, normal, -up * old)
        height = float(face.normal @ face.centroid_mm)
        whole = stood_on.mass_g >= WHOLE_FACE * face.area_mm2
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
            **self._sector_deg(metal, whole, normal, (up * new, -up * old)),
            **rates(cut.scaled(up * metal.density_g_mm3)),
        }

    def _face(self, metal: Metal, normal: Array, height_mm: float) -> Face:
        """Return the face over or under which the metal lies; of several in one plane the most covered."""
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
        thin_mm = THIN * metal.near_mm + THIN_MM
        level = [face for face in metal.crank.faces if _in_one_plane(face, best, thin_mm)]
        if len(level) == 1:
            return best
        to_face = face_frame(best.normal)
        shadow = sum((piece.moved(to_face).shadow() for piece in metal.pieces), Region.of([]))
        shared = [
            (face_region(metal.crank.mesh, metal.crank.anatomy, face, to_face) & shadow).area_mm2
            for face in level
        ]
        most = max(shared)
        return level[shared.index(most)] if most > 0.0 else best


def _in_one_plane(face: Face, other: Face, thin_mm: float) -> bool:
    """Return whether two faces lie in one plane and look the same way."""
    if face.kind != "plane" or float(face.normal @ other.normal) <= ON_PLANE:
        return False
    return abs(float(other.normal @ (face.centroid_mm - other.centroid_mm))) <= thin_mm + face.spread_mm


def _edge_deg(
    metal: Metal,
    layer: Array,
    walls: Array,
    side: float,
    listed_deg: float | None,
    other_deg: float | None,
) -> float | None:
    """Return the angle at which metal was cut off along a half-plane through the crank axis, if it was.

    Where the crank had facets in such a half-plane before, its face ended there: at a wall down, or at the
    step up that an earlier cut left. Facets at the sector's other edge are a neighbour's, who begins there.
    Of several angles the listed one counts, else that of the most area.
    ``layer`` (k, 3, 3) are the facets of the metal to look at, ``walls`` those of the crank beside it;
    ``side`` is 1 where the metal ends there, counter-clockwise, -1 where it begins.
    """
    facets = _radial_facets(layer, side, metal.near_mm)
    if listed_deg is not None and _area_at(*facets, listed_deg) >= EDGE_MM2:
        return listed_deg
    least = EDGE_MM2
    if metal.crank.anatomy.scan is not None:  # pieces of a rough surface's own facets lie any way
        least += OWN_FACETS * metal.crank.facet_mm2
    area_at = {float(angle): _area_at(*facets, angle) for angle in facets[0]}
    area_at = {
        angle: area
        for angle, area in area_at.items()
        if area >= least and (other_deg is None or _apart_deg(angle, other_deg) > EDGE_DEG)
    }
    if area_at:
        own = _radial_facets(walls, side, metal.near_mm)
        area_at = {angle: area for angle, area in area_at.items() if abs(_area_at(*own, angle)) < EDGE_MM2}
    return max(area_at, key=area_at.__getitem__, default=None)


def _area_at(angles: Array, areas: Array, angle: float) -> float:
    return float(areas[_apart_deg(angles, angle) <= EDGE_DEG].sum())


def _apart_deg(angles: Array | float, angle: float) -> Array:
    """Return the distances between angles, around the turn [deg]."""
    return np.asarray(np.abs((angles - angle + 180.0) % 360.0 - 180.0))


def _radial_facets(corners: Array, side: float, near_mm: float) -> tuple[Array, Array]:
    """Return angles [deg] of facets (k, 3, 3) in half-planes that the crank axis bounds, and their areas.

    Areas are below 0 where facets look the other way: those of flaps cancel.
    """
    a, b, c = corners.transpose(1, 0, 2)
    vectors = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(vectors, axis=1)
    middle = corners.mean(axis=1)
    angles = np.arctan2(middle[:, 1], middle[:, 0])
    across = np.column_stack([-np.sin(angles), np.cos(angles), np.zeros(len(angles))])
    off = np.abs((corners * across[:, None, :]).sum(axis=2)).max(axis=1)
    along = side * (vectors * across).sum(axis=1)
    radial = (off <= 8.0 * near_mm + 1e-4) & (np.abs(along) > ON_PLANE * areas)
    return np.degrees(angles[radial]) % 360.0, along[radial]
