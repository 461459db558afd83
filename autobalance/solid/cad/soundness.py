"""Soundness of a shape."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from autobalance.errors import SolidError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad.kernel import explored, is_valid, properties
from autobalance.solid.cad.tessellation import area_mm2, bounds_mm, surface_kind
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.soundness.repair import volume_change
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Check of a CAD file's body: faults that the kernel finds, their healing, edges off their faces.


CONTRADICTION_SHARE: Final = 1e-3
"""Distance of an edge from its face, as a share of the diagonal, from which on a file contradicts itself."""
TOUCHING_SHARE: Final = 1e-5
"""Distance up to which an edge lies on its face, as a share of the diagonal: usual precision of files."""
POINTS: Final = 23
"""Points of an edge that are compared with its face, as many as the kernel's own check takes."""
FAULTS_SHOWN: Final = 3
WORDS: Final = {
    "NotClosed": "is not closed",
    "SelfIntersectingWire": "crosses itself",
    "IntersectingWires": "has outlines that cross each other",
    "InvalidImbricationOfWires": "has a hole outside its outline",
    "BadOrientationOfSubshape": "has an edge or an outline that runs the wrong way",
    "UnorientableShape": "cannot be turned one way",
    "NotConnected": "falls apart",
    "RedundantFace": "holds a face twice",
    "InvalidMultiConnexity": "has an edge with more than two faces",
}
"""Meaning of the kernel's names of faults."""


@dataclass(frozen=True, eq=False)
class Gap:
    """A face whose edges lie off its surface.

    Attributes
    ----------
    face : int
        Its number in the solid, from 0.
    distance_mm : float
        The largest.
    area_mm2 : float
        Of the face.
    bounds : (2, 3) float
        Smallest and largest coordinates of the face [mm].
    """

    face: int
    distance_mm: float
    area_mm2: float
    bounds: Array


@dataclass(frozen=True, eq=False)
class Sound:
    """Body without faults by the kernel's check, its repairs, and the faces that its edges lie off."""

    body: Any
    repairs: tuple[str, ...]
    gaps: tuple[Gap, ...]


def sound(body: Any) -> Sound:
    """Return a body of a file that passed all checks, healed if need be.

    Raises
    ------
    SolidError
        If its surfaces contradict its edges, or the kernel finds fault with it also after healing.
    """
    gaps = edges_off_faces(body)
    repairs = tuple(_said(gaps))
    if not is_valid(body):
        body, healing = _healed(body)
        gaps = edges_off_faces(body)
        repairs = (*_said(gaps), *healing)
    return Sound(body, repairs, gaps)


# --- edges and faces --------------------------------------------------------------------------------------


def edges_off_faces(body: Any) -> tuple[Gap, ...]:
    """Return the faces some of whose edges do not lie on them.

    The kernel integrates within its faces' outlines, and takes the outlines from the edges: where an edge and
    a surface disagree, the result is not a solid's.

    Raises
    ------
    SolidError
        If an edge lies so far off that no tolerance explains it.
    """
    low, high = bounds_mm(body)
    diagonal = float(np.linalg.norm(high - low))
    gaps = []
    for number, face in enumerate(explored(body, "FACE")):
        off = [
            (distance, edge, place) for edge, distance, place in _distances(face, TOUCHING_SHARE * diagonal)
        ]
        if not off:
            continue
        distance, edge, (x, y, z) = max(off, key=lambda one: one[0])
        if distance > CONTRADICTION_SHARE * diagonal:
            raise SolidError(
                f"edge {edge + 1} of face {number + 1}, a {surface_kind(face)}, lies {distance:.4g} mm off "
                f"it at ({x:.6g}, {y:.6g}, {z:.6g}) mm: the file's surfaces contradict its edges; "
                f"expected at most {CONTRADICTION_SHARE * diagonal:.2g} mm"
            )
        gaps.append(Gap(number, distance, area_mm2(face), bounds_mm(face)))
    return tuple(gaps)


def _distances(face: Any, least_mm: float) -> Iterator[tuple[int, float, Array]]:
    """Yield the edges of a face that lie off it by more than ``least_mm``: number, distance, place (3,)."""
    from OCP.BRep import BRep_Tool
    from OCP.TopoDS import TopoDS

    for number, shape in enumerate(explored(face, "EDGE")):
        edge = TopoDS.Edge(shape)
        if BRep_Tool.Tolerance_s(edge) <= least_mm or BRep_Tool.Degenerated_s(edge):
            continue  # the kernel has made each edge's tolerance as wide as it lies off its faces
        apart, place = _apart(edge, TopoDS.Face(face))
        if apart > least_mm:
            yield number, apart, place


def _apart(edge: Any, face: Any) -> tuple[float, Array]:
    """Return the largest distance of an edge's curve from its curve on a face's surface, and its place."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    curves = BRepAdaptor_Curve(edge), BRepAdaptor_Curve(edge, face)
    steps = (np.linspace(curve.FirstParameter(), curve.LastParameter(), POINTS) for curve in curves)
    points = [
        np.array([(point.X(), point.Y(), point.Z()) for point in map(curve.Value, step.tolist())])
        for curve, step in zip(curves, steps, strict=True)
    ]
    apart = np.linalg.norm(points[0] - points[1], axis=1)
    return float(apart.max()), points[0][apart.argmax()]


def _said(gaps: tuple[Gap, ...]) -> Iterator[str]:
    if gaps:
        most = max(gaps, key=lambda gap: gap.distance_mm)
        yield (
            f"edges lie off their faces: {len(gaps)} faces, by {most.distance_mm:.3g} mm at most "
            f"(face {most.face + 1}); left as they are, counted in the error bar"
        )


# --- faults and healing -----------------------------------------------------------------------------------


def _healed(body: Any) -> tuple[Any, tuple[str, ...]]:
    """Return a body as repaired by the kernel, and a note on the repair."""
    from OCP.ShapeFix import ShapeFix_Shape

    fault = faults(body)
    before = properties(body).mass_g
    tool = ShapeFix_Shape(body)
    tool.Perform()
    solids = explored(tool.Shape(), "SOLID")
    if len(solids) != 1 or not is_valid(solids[0]):
        raise SolidError(
            f"the CAD kernel finds fault with the solid and cannot heal it: {fault}; expected a closed body"
        )
    after = properties(solids[0]).mass_g
    return solids[0], (
        f"the CAD kernel found fault with the solid: {fault}; healed; {volume_change(before, after)}",
    )


def faults(body: Any) -> str:
    """Return the faults that the kernel finds in a body, and their faces."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    if body.IsNull():
        return "it is empty"
    check = BRepCheck_Analyzer(body)
    causes = []
    for number, face in enumerate(explored(body, "FACE")):
        if not check.IsValid(face):
            middle = bounds_mm(face).mean(axis=0)
            place = ", ".join(f"{value:.6g}" for value in middle)
            causes.append(
                f"face {number + 1}, a {surface_kind(face)} at ({place}) mm, {_fault_of(face, check)}"
            )
    if not causes:
        causes = [f"its shell {_words(fault)}{_open_faces(body)}" for fault in _shell_faults(body)]
    more = f" and {len(causes) - FAULTS_SHOWN} more" if len(causes) > FAULTS_SHOWN else ""
    return "; ".join(causes[:FAULTS_SHOWN]) + more if causes else "it names none"


def _fault_of(face: Any, check: Any) -> str:
    """Return the fault of a face: its own, or that of an outline or an edge."""
    from OCP.BRepCheck import BRepCheck_Face, BRepCheck_Status, BRepCheck_Wire
    from OCP.TopoDS import TopoDS, TopoDS_Edge

    face = TopoDS.Face(face)
    none = BRepCheck_Status.BRepCheck_NoError
    for number, edge in enumerate(explored(face, "EDGE")):
        if not check.IsValid(edge):
            return f"has a fault in its edge {number + 1}"
    for shape in explored(face, "WIRE"):
        wire = BRepCheck_Wire(TopoDS.Wire(shape))
        for fault in (
            wire.Closed(),
            wire.Orientation(face),
            wire.SelfIntersect(face, TopoDS_Edge(), TopoDS_Edge()),
        ):
            if fault != none:
                return _words(fault)
    whole = BRepCheck_Face(face)
    for fault in (whole.IntersectWires(), whole.ClassifyWires(), whole.OrientationOfWires()):
        if fault != none:
            return _words(fault)
    return "is wrong in a way that the kernel does not name"


def _shell_faults(body: Any) -> Iterator[Any]:
    from OCP.BRepCheck import BRepCheck_Shell, BRepCheck_Status
    from OCP.TopoDS import TopoDS

    for shape in explored(body, "SHELL"):
        shell = BRepCheck_Shell(TopoDS.Shell(shape))
        for fault in (shell.Closed(), shell.Orientation()):
            if fault != BRepCheck_Status.BRepCheck_NoError:
                yield fault
                break


def _open_faces(body: Any) -> str:
    """Return a list of the faces that have an edge without a neighbour; empty if every edge has one."""
    bare = [str(number + 1) for number in faces_without_neighbour(body)]
    more = ", ..." if len(bare) > FAULTS_SHOWN else ""
    return f" beside face {', '.join(bare[:FAULTS_SHOWN])}{more}" if bare else ""


def faces_without_neighbour(body: Any) -> list[int]:
    """Return the numbers of faces that have an edge shared with no other face and not twice their own."""
    from OCP.BRep import BRep_Tool
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as Parts
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp
    from OCP.TopoDS import TopoDS

    edges = Parts()
    TopExp.MapShapes_s(body, TopAbs_ShapeEnum.TopAbs_EDGE, edges)
    owners: dict[int, list[int]] = {}
    for number, face in enumerate(explored(body, "FACE")):
        for edge in map(TopoDS.Edge, explored(face, "EDGE")):
            if not BRep_Tool.Degenerated_s(edge):
                twice = BRep_Tool.IsClosed_s(edge, TopoDS.Face(face))
                owners.setdefault(edges.FindIndex(edge), []).extend([number] * (1 + twice))
    return sorted({of[0] for of in owners.values() if len(of) == 1})


def _words(fault: Any) -> str:
    name = str(fault.name).rpartition("_")[2]
    return WORDS.get(name, f"has the fault '{name}'")


# Error bar of a solid whose edges lie off its faces.


def doubt_of(gaps: Sequence[Gap], density_g_mm3: float, frame: Array) -> ChordalError:
    """Return the error bar of a solid measured on its true surfaces: none where its edges lie on them.

    A face that its edges lie off by d may itself lie off by d. The layer of that thickness on its area counts
    as far from the axis as the box around it reaches, all faces in the same direction.

    Parameters
    ----------
    gaps : sequence of Gap
    density_g_mm3 : float
    frame : (4, 4) float
        From the file's coordinates to those of the rotor.
    """
    known = ChordalError.known(Moments.zero())
    if not gaps:
        return known
    mass_g = density_g_mm3 * np.array([gap.area_mm2 * gap.distance_mm for gap in gaps])
    corners = np.array([list(itertools.product(*gap.bounds.T)) for gap in gaps])
    corners = corners @ frame[:3, :3].T + frame[:3, 3]
    bars_g_mm = mass_g * np.hypot(corners[..., 0], corners[..., 1]).max(axis=1)
    z_mm = corners[..., 2]
    return replace(
        known,
        mass_bar_g=float(mass_g.sum()),
        unbalance_bar_g_mm=float(bars_g_mm.sum()),
        bar_at_mm=(
            float(np.average(z_mm.mean(axis=1), weights=bars_g_mm)),
            float(np.average((z_mm**2).max(axis=1), weights=bars_g_mm)),
        ),
    )
