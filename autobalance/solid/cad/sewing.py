"""Sewing of a CAD file's loose surfaces to solids."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from autobalance.errors import FormatError, SolidError
from autobalance.solid.cad.cad_file import NamedBody
from autobalance.solid.cad.kernel import cut, explored, refuse_odd_shape
from autobalance.solid.cad.tessellation import bounds_mm

SEWING_SHARES: Final = (1e-6, 1e-5, 1e-4, 3e-4)
"""Shares of the diagonal within which edges are one, tried one after the other."""
MAX_NAMED_EDGES: Final = 4
"""Open edges that an error names."""


def bodies_of(shape: Any, what: str) -> tuple[tuple[NamedBody, ...], tuple[str, ...]]:
    """Return the solids of a shape of the kernel, sewn from its faces if it has no solid, and a note on that.

    Raises
    ------
    FormatError
        If it has no face.
    SolidError
        If its faces do not close, or lie if no crankshaft does.
    """
    refuse_odd_shape(shape)
    solids = explored(shape, "SOLID")
    if solids:
        return tuple(NamedBody("", solid) for solid in solids), ()
    faces = explored(shape, "FACE")
    if not faces:
        raise FormatError(f"the {what} file holds no surface; expected a closed body")
    shells, reach_mm = _sewn(shape, faces)
    solids = _without_cavities([_outward(shell) for shell in shells])
    count = "1 solid" if len(solids) == 1 else f"{len(solids)} solids"
    note = f"{len(faces)} loose faces sewn to {count}, within {reach_mm:.2g} mm"
    return tuple(NamedBody("", solid) for solid in solids), (note,)


def _sewn(shape: Any, faces: Sequence[Any]) -> tuple[list[Any], float]:
    """Return closed shells of faces, and the distance within which edges were joined [mm]."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing

    low, high = bounds_mm(shape)
    diagonal = float(np.linalg.norm(high - low))
    for share in SEWING_SHARES:
        sewing = BRepBuilderAPI_Sewing(share * diagonal)
        for face in faces:
            sewing.Add(face)
        sewing.Perform()
        if sewing.NbFreeEdges() == 0:
            break
    count = sewing.NbFreeEdges()
    if count:
        middles = [bounds_mm(sewing.FreeEdge(k + 1)).mean(axis=0) for k in range(min(count, MAX_NAMED_EDGES))]
        places = ", ".join(f"({x:.6g}, {y:.6g}, {z:.6g})" for x, y, z in middles)
        raise SolidError(
            f"the {len(faces)} faces do not close: {count} edges have one face only, sewn within "
            f"{share * diagonal:.2g} mm; middles of open edges in the file's coordinates [mm]: {places}"
            f"{', ...' if count > MAX_NAMED_EDGES else ''}"
        )
    return explored(sewing.SewedShape(), "SHELL"), share * diagonal


def _outward(shell: Any) -> Any:
    """Return the solid inside a closed shell."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS

    solid = BRepBuilderAPI_MakeSolid(TopoDS.Shell(shell)).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    return solid


def _without_cavities(solids: list[Any]) -> list[Any]:
    """Subtract from each solid those that lie within it: shells around cavities."""
    boxes = [bounds_mm(solid) for solid in solids]
    order = sorted(range(len(solids)), key=lambda k: -float(np.prod(boxes[k][1] - boxes[k][0])))
    outer_solids: list[Any] = []
    for k in order:
        around = next(
            (place for place, outer in enumerate(outer_solids) if _contains(outer, solids[k])), None
        )
        if around is None:
            outer_solids.append(solids[k])
        else:
            outer_solids[around] = explored(cut(outer_solids[around], [solids[k]]), "SOLID")[0]
    return outer_solids


def _contains(outer: Any, inner: Any) -> bool:
    from OCP.BRep import BRep_Tool
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.TopAbs import TopAbs_State
    from OCP.TopoDS import TopoDS

    corner = BRep_Tool.Pnt_s(TopoDS.Vertex(explored(inner, "VERTEX")[0]))
    return bool(BRepClass3d_SolidClassifier(outer, corner, 1e-7).State() == TopAbs_State.TopAbs_IN)
