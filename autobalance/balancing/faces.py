"""Faces of a crank that a correction can use, with what a millimetre of each is worth."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.balancing.measured_crank import Crank
from autobalance.balancing.record import FaceOffer
from autobalance.correction import shoulder, turn
from autobalance.crank.anatomy import Face
from autobalance.crank.faces import lowering_worth_g_mm_per_mm
from autobalance.crank.rims import find_rims
from autobalance.errors import CorrectionError


def offered_faces(crank: Crank) -> tuple[FaceOffer, ...]:
    """Return what a correction can use: faces on webs, the greatest unbalance per millimetre first."""
    found = [face for face in crank.faces if face.web is not None]
    depths = _max_depths_mm(crank, found)
    rims = find_rims(crank.source.solid.mesh, crank.anatomy)
    depths |= _max_rim_depths_mm(crank, rims)
    offers = [
        FaceOffer(face, lowering_worth_g_mm_per_mm(face, crank.density_g_mm3), depths.get(face.id))
        for face in (*found, *rims)
    ]
    return tuple(
        sorted(offers, key=lambda offer: -float(offer.unbalance_per_mm_g_mm @ offer.unbalance_per_mm_g_mm))
    )


def _max_depths_mm(crank: Crank, faces: list[Face]) -> dict[str, float]:
    """Return how deep each face may go by itself with the default limits, where metal ends it."""
    solid = crank.source.solid
    planes = [shoulder.Patch(face) for face in faces if face.kind == "plane"]
    found = shoulder.cuts(
        solid, crank.anatomy, planes, crank.density_g_mm3, shoulder.ShoulderLimits(), solid.mesh.diagonal_mm
    )
    return {cut.face.id: cut.max_depth_mm for cut in found if not cut.limit_is_reach}


def _max_rim_depths_mm(crank: Crank, rims: Sequence[Face]) -> dict[str, float]:
    """Return how deep each rim may be turned by default, unless its web reaches farther elsewhere."""
    outlines = {web.number: web.outline for web in crank.anatomy.webs}
    try:
        found = turn.cuts(
            crank.source.solid, crank.anatomy, crank.density_g_mm3, turn.TurnLimits(per_web=True)
        )
    except CorrectionError:
        return {}
    radius = {cut.webs[0]: cut.rim_mm for cut in found}
    depth = {cut.webs[0]: cut.max_depth_mm for cut in found}
    return {
        rim.id: depth[rim.web]
        for rim in rims
        if rim.web in depth
        and (outline := outlines[rim.web]) is not None
        and abs(outline.rim_radius_mm - radius[rim.web]) < turn.THIN_MM
    }
