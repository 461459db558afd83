"""Metal under a planar face, kept: its parts and sectors are cut from the same sections."""

# Needed by cranks of 260 000 triangles, where each part of a face cut the same sections anew.

from __future__ import annotations

from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

from autobalance.correction.faces.layer import Layer
from autobalance.correction.faces.patches import face_region, farthest_mm
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.solid.csg.region import Region
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

CLEARANCE = 5.0
"""Grains between metal on a face and the tool. The tool keeps clear of the fillet, and its outline needs no
more corners than that (a few µm on a crank of 150 mm; the ring of metal left weighs milligrams)."""
FACES_KEPT = 16
"""Faces of a mesh that are remembered: about as many as are offered together."""


@dataclass(frozen=True, eq=False)
class UnderFace:
    """The metal under a face, in the face's frame.

    Attributes
    ----------
    slab : Layer
        The triangles down to the end of the search.
    outline : Region
        The face itself.
    standing : Region
        Area closed to the tool: what is on the face, with room around, and what that encloses.
    room : Region
        Area open to the tool: everywhere else.
    """

    slab: Layer
    outline: Region
    standing: Region
    room: Region
    _sections: dict[float, Region] = field(default_factory=dict)

    @classmethod
    def of(
        cls, mesh: Mesh, anatomy: Anatomy, face: Face, to_face: Array, down_to_mm: float, grain_mm: float
    ) -> UnderFace:
        """Return the metal from just above a face down to a height in its frame."""
        height = float(face.normal @ face.centroid_mm)
        frame = to_face @ anatomy.file_to_rotor
        slab = Layer.of(mesh, frame, down_to_mm, height + 2.0 * grain_mm, grain_mm)
        outline = face_region(mesh, anatomy, face, to_face)
        standing = slab.section(height + grain_mm).grown(CLEARANCE * grain_mm)
        standing = standing.simplified(0.5 * CLEARANCE * grain_mm)
        size = farthest_mm(mesh, anatomy)
        everywhere = Region.rectangle([-size, -size], [size, size])
        rooms = (everywhere - standing).pieces()
        if len(rooms) > 1:  # an oil hole in a journal, say, which no tool at the face gets to
            rooms = [room for room in rooms if not (room & outline).is_empty]
            standing = everywhere - Region.beside_each_other(rooms)
        return cls(slab, outline, standing, Region.beside_each_other(rooms))

    def section(self, height_mm: float) -> Region:
        """Return the solid's cross-section at a height within the slab."""
        if height_mm not in self._sections:
            self._sections[height_mm] = self.slab.section(height_mm)
        return self._sections[height_mm]


_Key = tuple[Face, bytes, float, float]
_SEEN: WeakKeyDictionary[Mesh, dict[_Key, UnderFace]] = WeakKeyDictionary()


def under_face(
    mesh: Mesh, anatomy: Anatomy, face: Face, to_face: Array, down_to_mm: float, grain_mm: float
) -> UnderFace:
    """Return the metal under a face; the kept one where the same depth was searched before."""
    seen = _SEEN.setdefault(mesh, {})
    key = (face, (to_face @ anatomy.file_to_rotor).tobytes(), down_to_mm, grain_mm)
    known = seen.get(key)
    if known is None:
        known = UnderFace.of(mesh, anatomy, face, to_face, down_to_mm, grain_mm)
        for oldest in list(seen)[: max(0, len(seen) - FACES_KEPT + 1)]:
            seen.pop(oldest, None)  # another thread may have done it
        seen[key] = known
    return known
