"""Shapes of the CAD kernel that a caller holds in memory, and the files that stand for them."""

from __future__ import annotations

from typing import Any

from autobalance.errors import FormatError
from autobalance.solid.cad.build import built, moved
from autobalance.solid.cad.kernel import compound, require_kernel, scaled
from autobalance.solid.cad.step_file import write_step
from autobalance.solid.csg.shape import Shape
from autobalance.types import Array
from autobalance.units import MM_PER

EXPECTED = (
    "an OCP TopoDS_Shape, an object whose .wrapped is one (build123d, CadQuery), "
    "or the bytes of a STEP or BREP file"
)


def step_of_shape(source: Any, unit: str) -> bytes:
    """Return the STEP file, in ``unit``, of a shape whose numbers are in ``unit``.

    Parameters
    ----------
    source : TopoDS_Shape, or an object that wraps one
        Of a CadQuery ``Workplane``, the shape on its stack.
    unit : str
        mm, cm, m or inch.

    Raises
    ------
    FormatError
        If it is not a shape of the kernel, or the kernel is not installed or of another generation.
    """
    require_kernel("a shape in memory")
    from OCP.TopoDS import TopoDS_Shape

    shape = source
    if not isinstance(shape, TopoDS_Shape) and callable(getattr(shape, "val", None)):
        shape = shape.val()  # a Workplane of CadQuery
    shape = getattr(shape, "wrapped", shape)
    if not isinstance(shape, TopoDS_Shape) or shape.IsNull():
        kind = "an empty shape" if isinstance(shape, TopoDS_Shape) else type(source).__name__
        raise FormatError(f"shape: found {kind}; expected {EXPECTED}")
    return write_step(scaled(shape, MM_PER[unit]), unit, str(getattr(source, "label", "") or "crank"))


def nothing() -> Any:
    """Return an empty shape of the kernel.

    Raises
    ------
    FormatError
        If the kernel is not installed.
    """
    require_kernel("a shape in memory")
    return compound([])


def shape_of(drawn: Shape, motion: Array) -> Any:
    """Return an exact description as a shape of the kernel, moved rigidly by a matrix (4, 4).

    Raises
    ------
    FormatError
        If the kernel is not installed.
    """
    require_kernel("a shape in memory")
    return moved(built(drawn), motion)
