"""Cranks of no file: of a mesh, or of a shape in the memory of a CAD program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from autobalance.balancing.crank_size import refuse_density, refuse_size
from autobalance.balancing.measured_crank import measured_source, recognised
from autobalance.errors import FormatError
from autobalance.job.model import Crankshaft, LengthUnit
from autobalance.job.read_crankshaft import read_crankshaft
from autobalance.solid.formats.registry import needs_unit
from autobalance.types import Array
from autobalance.units import STEEL_KG_M3
from autobalance.verbs.crank import Crank, plain

if TYPE_CHECKING:
    from autobalance.solid.formats.read import Source


def crank_from_mesh(
    vertices: ArrayLike | Any,
    triangles: ArrayLike | None = None,
    density_kg_m3: float = STEEL_KG_M3,
    *,
    unit: str = "mm",
    crankpin_in_file: bool | None = None,
    **overrides: Any,
) -> Crank:
    """Recognise and measure the crank in a mesh; no file is needed.

    Parameters
    ----------
    vertices : (n, 3) float, or a mesh with ``vertices`` and ``faces``
        Corners in ``unit``; a ``trimesh.Trimesh`` may stand for both.
    triangles : (m, 3) int or None
        Rows of ``vertices``, counter-clockwise seen from outside.
    density_kg_m3 : float
        Density [kg/m³].
    unit : str
        mm, cm, m or inch.
    crankpin_in_file : bool or None
        As for ``read_crank``.
    **overrides
        ``body``, ``axis_point_mm``, ``axis_direction``, ``crankpins``, ``main_journals``, ``fill_holes_mm``,
        ``keep_open``: see ``read_crank``.

    Raises
    ------
    FormatError
        If the arrays are not triangles, or a number is not finite.
    SolidError, RecognitionError
        As for ``read_crank``.

    Examples
    --------
    >>> import autobalance as ab
    >>> drawn = ab.generate("single", segments=24).crank
    >>> crank = crank_from_mesh(drawn.vertices_mm, drawn.triangles, density_kg_m3=7850.0)
    >>> round(crank.throws[0].crank_radius_mm, 2)
    29.0
    """
    from autobalance.solid.formats.read import source_of

    if triangles is None:
        if not (hasattr(vertices, "vertices") and hasattr(vertices, "faces")):
            raise FormatError("triangles is missing; expected (m, 3) rows of vertices, or a mesh for both")
        vertices, triangles = vertices.vertices, vertices.faces
    soup = _soup(vertices, triangles)
    crankshaft = _of_no_file("mesh.ply", unit, density_kg_m3, crankpin_in_file, overrides)
    pressed_up = crankpin_in_file is False
    source = source_of(soup, unit, crankshaft.body, pressed_up, holes=crankshaft.holes)
    return _measured(source, crankshaft, "the mesh")


def crank_from_shape(
    shape: Any,
    density_kg_m3: float = STEEL_KG_M3,
    *,
    unit: str = "mm",
    body: int | str | None = None,
    crankpin_in_file: bool | None = None,
    **overrides: Any,
) -> Crank:
    """Recognise and measure the crank in a shape of a CAD program, on its true surfaces; no file is needed.

    Parameters
    ----------
    shape : TopoDS_Shape, an object that wraps one, or bytes
        Shape of OCP, a build123d or CadQuery object (for a ``Workplane``, the shape on its stack), or the
        bytes of a STEP or BREP file.
    density_kg_m3 : float
        Density [kg/m³].
    unit : str
        mm, cm, m or inch, of a shape or a BREP file; a STEP file's own counts.
    body : int, str or None
        As for ``read_crank``.
    crankpin_in_file : bool or None
        As for ``read_crank``.
    **overrides
        ``axis_point_mm``, ``axis_direction``, ``crankpins``, ``main_journals``: see ``read_crank``.

    Returns
    -------
    Crank
        Measured as the STEP file of the shape would be.

    Raises
    ------
    FormatError
        If it is not a shape, or the CAD kernel is not installed or of another generation.
    SolidError, RecognitionError
        As for ``read_crank``.
    """
    from autobalance.solid.formats.shape import source_of_shape

    named = {**overrides, "body": body}
    crankshaft = _of_no_file("shape.step", None, density_kg_m3, crankpin_in_file, named)
    source = source_of_shape(shape, unit, crankshaft.body, pressed_up=crankpin_in_file is False)
    own = cast("LengthUnit", unit) if needs_unit(Path(f"shape.{source.format}")) else None
    return _measured(source, replace(crankshaft, unit=own), "the shape")


def _of_no_file(
    name: str,
    unit: str | None,
    density_kg_m3: float,
    crankpin_in_file: bool | None,
    overrides: Mapping[str, Any],
) -> Crankshaft:
    """Return the job's table of a crank in memory; ``name`` stands for its file's."""
    hints = {"unit": unit, "crankpin_in_file": crankpin_in_file, **overrides}
    values = {key: plain(value) for key, value in hints.items() if value is not None}
    crankshaft = read_crankshaft({"file": name, "density_kg_m3": density_kg_m3, **values}, Path())
    if crankpin_in_file is None:
        crankshaft = replace(crankshaft, overrides=replace(crankshaft.overrides, crankpin_in_file=None))
    return replace(crankshaft, file=None)


def _measured(source: Source, crankshaft: Crankshaft, what: str) -> Crank:
    refuse_density(crankshaft)
    refuse_size(source, what)
    anatomy = recognised(source, crankshaft.overrides)
    measured = measured_source(source, anatomy, crankshaft.density_g_mm3, read_as=crankshaft)
    return Crank(measured, crankshaft)


def _soup(vertices: ArrayLike, triangles: ArrayLike) -> Array:
    from autobalance.solid.formats.raw import soup_of

    points, rows = np.asarray(vertices), np.asarray(triangles)
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
        raise FormatError(f"vertices are {points.shape} of {points.dtype}; expected (n, 3) numbers")
    if rows.ndim != 2 or rows.shape[1] != 3 or rows.dtype.kind not in "iu":
        raise FormatError(f"triangles are {rows.shape} of {rows.dtype}; expected (m, 3) whole numbers")
    soup: Array = soup_of(points.astype(np.float64), rows.astype(np.int64), "mesh")
    return soup
