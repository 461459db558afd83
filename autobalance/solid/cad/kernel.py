"""Helpers of the CAD kernel: loading, silence, lists, parts of shapes, booleans and moments."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from autobalance.errors import FormatError, SolidError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad.installed import (
    GENERATION,
    INSTALL,
    has_kernel,
    installed_versions,
    is_of_generation,
)

MOST_MM: Final = 1e7
"""Largest distance from the origin, 10 km: on files beyond it the kernel computes without end."""
VOLUME_TOLERANCE = 1e-10
"""Relative error of each face's share of the volume; in its default order the kernel is off by 1e-5
of a hole that enters a round rim."""


def require_kernel(what: str = "STEP") -> None:
    """Load the kernel and silence it; ``what`` names the feature that needs it.

    Raises
    ------
    FormatError
        If it is not installed, is of another generation, or cannot be loaded.
    """
    versions = installed_versions()
    if versions and not any(is_of_generation(each) for each in versions):
        raise _other_generation(what, versions[-1])
    if not has_kernel():
        raise FormatError(f"{what} needs the CAD kernel, which is not installed: {INSTALL}")
    try:
        loaded = loaded_version()
        if not is_of_generation(loaded):  # two packages were unpacked under one name
            raise _other_generation(what, loaded)
        silence()
    except ImportError as error:
        reason = str(error).splitlines()[0]
        raise FormatError(
            f"{what} needs the CAD kernel, which cannot be loaded ({reason}): {INSTALL}"
        ) from None


def _other_generation(what: str, version: str) -> FormatError:
    return FormatError(
        f"{what} needs the CAD kernel OCP {GENERATION}; found OCP {version}; use an environment without it "
        f"(CadQuery brings it): {INSTALL}"
    )


def loaded_version() -> str:
    """Return the version that the kernel states of itself; loads it."""
    import OCP

    return str(OCP.__version__)


@contextmanager
def kernel_failures(what: str) -> Iterator[None]:
    """Turn the kernel's exceptions, from numbers that it cannot compute with, into one line.

    Raises
    ------
    SolidError
        In place of the kernel's own exceptions.
    """
    from OCP import Standard, StdFail

    # in C++ they share a base, in Python they do not
    kinds = [kind for module in (Standard, StdFail) for kind in vars(module).values()]
    failures = tuple(kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Exception))
    try:
        yield
    except failures as failure:
        reason = str(failure).splitlines()[0] if str(failure) else type(failure).__name__
        raise SolidError(
            f"the CAD kernel cannot compute {what} ({reason[:80]}); expected sound surfaces: "
            "export the file again"
        ) from None


def refuse_odd_shape(body: Any) -> None:
    """Refuse a shape on which the kernel would compute without end, or for nothing.

    Raises
    ------
    SolidError
        If it is empty, has no bounds, or reaches farther than ``MOST_MM``.
    """
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.AddClose_s(body, box)
    if box.IsVoid():
        raise SolidError(
            "the shape is empty; expected a crankshaft's solid: choose the body and export it again"
        )
    reach = math.inf
    if not box.IsOpen():
        low, high = box.CornerMin(), box.CornerMax()
        reach = max(abs(value) for point in (low, high) for value in (point.X(), point.Y(), point.Z()))
    if not reach <= MOST_MM:
        raise SolidError(
            f"the solid reaches {reach:.3g} mm from the origin; expected a crankshaft within {MOST_MM:g} mm "
            "(a damaged number, or another unit)"
        )


def silence() -> None:
    """Remove the kernel's printers, which write statistics and complaints on standard output."""
    from OCP.Message import Message

    messenger = Message.DefaultMessenger_s()
    for printer in list(messenger.Printers()):
        messenger.RemovePrinter(printer)


def explored(shape: Any, kind: str) -> list[Any]:
    """Return the parts of a kernel's shape of one kind, ``SOLID``, ``FACE`` or ``EDGE``, each once."""
    from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as Parts
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp

    parts = Parts()
    TopExp.MapShapes_s(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind}"), parts)
    return [parts.FindKey(number + 1) for number in range(parts.Extent())]


def listed(bodies: Sequence[Any]) -> Any:
    """Return the kernel's own list of bodies."""
    from OCP.collections import List_TopoDS_Shape

    shapes = List_TopoDS_Shape()
    for body in bodies:
        shapes.Append(body)
    return shapes


def compound(bodies: Sequence[Any]) -> Any:
    """Return bodies as one shape, side by side."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    if len(bodies) == 1:
        return bodies[0]
    whole, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(whole)
    for body in bodies:
        builder.Add(whole, body)
    return whole


def fused(bodies: Sequence[Any]) -> Any:
    """Return the union of the bodies."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    return bodies[0] if len(bodies) == 1 else _boolean(BRepAlgoAPI_Fuse(), bodies[:1], bodies[1:])


def cut(body: Any, tools: Sequence[Any]) -> Any:
    """Return the body without the volume of the tools."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return _boolean(BRepAlgoAPI_Cut(), [body], tools) if tools else body


def common(body: Any, other: Any) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

    return _boolean(BRepAlgoAPI_Common(), [body], [other])


def _boolean(operation: Any, arguments: Sequence[Any], tools: Sequence[Any]) -> Any:
    operation.SetArguments(listed(arguments))
    operation.SetTools(listed(tools))
    operation.SetRunParallel(False)
    operation.Build()
    if not operation.IsDone():
        raise SolidError("the CAD kernel could not join or cut two shapes")
    return operation.Shape()


def unified(body: Any) -> Any:
    """Merge faces and edges that lie on one surface or curve."""
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    tool = ShapeUpgrade_UnifySameDomain(body, True, True, False)
    tool.Build()
    return tool.Shape()


def is_valid(body: Any) -> bool:
    """Return whether the kernel finds no fault with a body."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    return not body.IsNull() and bool(BRepCheck_Analyzer(body).IsValid())


def properties(body: Any) -> Moments:
    """Return the moments of a kernel's body of density 1 about the origin, from its exact surfaces.

    Extruded splines are converted to spline surfaces first: on unconverted ones the kernel's rule takes all
    spans at once and is off by 3e-4.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    props = GProp_GProps()
    if any(_is_drawn_out(face) for face in explored(body, "FACE")):
        body = BRepBuilderAPI_NurbsConvert(body).Shape()
    BRepGProp.VolumeProperties_s(body, props, VOLUME_TOLERANCE, True, False)
    return _moments_of(props)


def area_properties(face: Any) -> Moments:
    """Return (1, r, r rᵀ) dA over a face."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    props = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, props)
    return _moments_of(props)


def _moments_of(props: Any) -> Moments:
    """Return the kernel's properties as moments about the origin."""
    volume, centre, matrix = props.Mass(), props.CentreOfMass(), props.MatrixOfInertia()
    middle = np.array([centre.X(), centre.Y(), centre.Z()])
    inertia = np.array([[matrix.Value(i, j) for j in (1, 2, 3)] for i in (1, 2, 3)])
    about_centre = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    second = about_centre + volume * np.outer(middle, middle)
    return Moments(volume, volume * middle, second)


def _is_drawn_out(face: Any) -> bool:
    """Return whether a face is a curve extruded along a line, and neither plane nor cylinder."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_SurfaceType
    from OCP.TopoDS import TopoDS

    kind = BRepAdaptor_Surface(TopoDS.Face(face), False).GetType()
    return bool(kind == GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion)


def scaled(shape: Any, factor: float) -> Any:
    """Return a shape enlarged about the origin."""
    if factor == 1.0:
        return shape
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf

    larger = gp_Trsf()
    larger.SetScaleFactor(factor)
    return BRepBuilderAPI_Transform(shape, larger, True).Shape()


def shape_bytes(shape: Any) -> bytes:
    """Return a shape in the kernel's binary form, with its triangles."""
    from OCP.BinTools import BinTools, BinTools_FormatVersion

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shape"
        newest = BinTools_FormatVersion.BinTools_FormatVersion_CURRENT
        if not BinTools.Write_s(shape, str(path), True, False, newest):
            raise SolidError("the CAD kernel could not hand a solid on")
        return path.read_bytes()


def shape_of_bytes(data: bytes) -> Any:
    """Return the shape that ``shape_bytes`` wrote."""
    from OCP.BinTools import BinTools
    from OCP.TopoDS import TopoDS_Shape

    shape: Any = TopoDS_Shape()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shape"
        path.write_bytes(data)
        if not BinTools.Read_s(shape, str(path)):
            raise SolidError("the CAD kernel could not take a solid over")
    return shape
