"""Faces of a crank that a correction can use, with the unbalance per millimetre of each."""

from __future__ import annotations

from autobalance.balancing.measured import Crank
from autobalance.balancing.record import FaceOffer
from autobalance.correction import face_depths_mm
from autobalance.crank.faces import lowering_worth_g_mm_per_mm
from autobalance.crank.rims import find_rims


def offered_faces(crank: Crank) -> tuple[FaceOffer, ...]:
    """Return the faces on webs and the rims, the largest unbalance per millimetre first."""
    faces = tuple(face for face in crank.faces if face.web is not None)
    rims = find_rims(crank.source.solid.mesh, crank.anatomy)
    depths = face_depths_mm(crank.source.solid, crank.anatomy, crank.density_g_mm3, faces, rims)
    offers = [
        FaceOffer(face, lowering_worth_g_mm_per_mm(face, crank.density_g_mm3), depths.get(face.id))
        for face in (*faces, *rims)
    ]
    return tuple(
        sorted(
            offers,
            key=lambda candidates: (
                -float(candidates.unbalance_per_mm_g_mm @ candidates.unbalance_per_mm_g_mm)
            ),
        )
    )
