"""A crank as an object: read, taken from a mesh or a CAD program, recognised and measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalance import registry
from autobalance.balancing.measured import Crank as MeasuredCrank
from autobalance.balancing.measured_crank import measure_crank, measured_source, recognised
from autobalance.balancing.typed_effects import refuse_density, refuse_size
from autobalance.crank.faces import find_faces
from autobalance.errors import FileError, FormatError
from autobalance.job.model import Crankshaft, LengthUnit
from autobalance.job.read_crankshaft import read_crankshaft
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import Stopwatch
from autobalance.solid.formats.registry import needs_unit
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2, STEEL_KG_M3
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.crank.anatomy import MainJournal, Throw, Web
    from autobalance.solid.formats.read import Source


# A crank as an object: read from a file or taken from a mesh, recognised and measured.


@dataclass(frozen=True, eq=False)
class CrankFace:
    """A face that a correction can use, with the keys of a report's ``faces``.

    ``normal`` and ``centroid_mm`` (3,) are in the rotor frame, ``file_centroid_mm`` in the file's own.
    ``unbalance_per_mm_g_mm`` (2,) is the change by a millimetre of depth. ``max_depth_mm`` is None if no
    metal ends the depth.
    """

    id: str
    kind: Literal["plane", "cylinder"]
    web: int | None
    area_mm2: float
    normal: Array
    centroid_mm: Array
    file_centroid_mm: Array
    unbalance_per_mm_g_mm: Array
    max_depth_mm: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Crank:
    """A crankshaft, recognised and measured; values as in a report, arrays of numpy.

    Everything is in the rotor frame (z the crank axis, x towards crankpin 1) but ``vertices_mm``, which are
    in the file's coordinates, in mm. Cranks pickle.
    """

    measured: MeasuredCrank
    crankshaft: Crankshaft

    @property
    def file(self) -> Path | None:
        """The file it was read from; None for a mesh or a corrected crank."""
        return self.crankshaft.file

    @property
    def mass_g(self) -> float:
        """Mass [g]."""
        return self.measured.moments.mass_g

    @property
    def volume_mm3(self) -> float:
        """Volume [mm³]."""
        return self.measured.volume_mm3

    @property
    def density_kg_m3(self) -> float:
        """Density [kg/m³]."""
        return self.measured.density_g_mm3 * 1e6

    @property
    def centre_of_mass_mm(self) -> Array:
        """Centre of mass (3,) [mm]."""
        return self.measured.moments.centre_mm

    @property
    def inertia_kg_mm2(self) -> Array:
        """Inertia (3, 3) about the rotor's origin, off-diagonals −∫xy dm [kg·mm²]."""
        return self.measured.moments.inertia_g_mm2 / G_MM2_PER_KG_MM2

    @property
    def polar_inertia_kg_mm2(self) -> float:
        """Mass moment of inertia about the crank axis [kg·mm²]."""
        return self.measured.moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2

    @property
    def main_journals(self) -> tuple[MainJournal, ...]:
        """Main journals along increasing z."""
        return self.measured.anatomy.main_journals

    @property
    def throws(self) -> tuple[Throw, ...]:
        """Throws along increasing z."""
        return self.measured.anatomy.throws

    @property
    def webs(self) -> tuple[Web, ...]:
        """Webs along increasing z."""
        return self.measured.anatomy.webs

    @cached_property
    def faces(self) -> tuple[CrankFace, ...]:
        """Faces that a correction can use, the largest unbalance per millimetre first."""
        from autobalance.balancing.measured_crank import offered_faces

        back = self.measured.anatomy.rotor_to_file
        return tuple(
            CrankFace(
                candidates.face.id,
                candidates.face.kind,
                candidates.face.web,
                float(candidates.face.area_mm2),
                candidates.face.normal,
                candidates.face.centroid_mm,
                back[:3, :3] @ candidates.face.centroid_mm + back[:3, 3],
                candidates.unbalance_per_mm_g_mm,
                candidates.max_depth_mm,
            )
            for candidates in offered_faces(self.with_faces().measured)
        )

    @property
    def unbalance(self) -> Unbalance:
        """Unbalance of the bare crank, about z = 0."""
        return Unbalance.of(self.measured.moments)

    @property
    def vertices_mm(self) -> Array:
        """Corners (n, 3) in the file's coordinates [mm]."""
        return self.measured.source.solid.mesh.vertices

    @property
    def triangles(self) -> NDArray[np.int64]:
        """Rows of ``vertices_mm`` (m, 3), counter-clockwise seen from outside."""
        return self.measured.source.solid.mesh.triangles

    @property
    def file_to_rotor(self) -> Array:
        """Motion (4, 4) from file coordinates in mm to the rotor frame."""
        return self.measured.anatomy.file_to_rotor

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the file and the crank in it."""
        return self.measured.warnings(self.file)

    def to_trimesh(self) -> Any:
        """Return the crank as a ``trimesh.Trimesh``, file coordinates in mm."""
        from autobalance.solid.mesh.mesh import to_trimesh

        return to_trimesh(self.measured.source.solid.mesh)

    def to_shape(self) -> Any:
        """Return the crank as a ``TopoDS_Shape`` of OCP, in the unit and the coordinates that it came in.

        Raises
        ------
        FormatError
            If it came in triangles: they have no true surfaces.
        """
        source = self.measured.source
        if source.exact is None:
            raise FormatError(
                "to_shape: found a crank of triangles; expected one of a STEP, BREP or IGES file or of "
                "crank_from_shape; to_trimesh gives the triangles"
            )
        from autobalance.solid.cad.kernel import scaled

        return scaled(source.exact.solid.body, 1.0 / source.mm_per_unit)

    def write(self, path: str | Path, unit: str | None = None) -> Path:
        """Write the crank to a file, whose ending names the format.

        Parameters
        ----------
        path : path
        unit : str or None
            mm, cm, m or inch; None: the unit it was read in, or what the format prescribes.

        Raises
        ------
        FormatError
            If the format is not known, or keeps true surfaces that this crank does not have.
        FileError
            If it cannot be written.
        """
        from autobalance.balancing.measured import encoded
        from autobalance.report.files import Staging

        path = Path(path)
        data = encoded(self.measured.source, path.suffix, unit)
        with Staging([path.parent]) as staging:
            staging.add(path, data)
            staging.commit()
        return path

    def with_faces(self) -> Crank:
        """Return the crank with its planar faces looked for."""
        if self.measured.faces:
            return self
        measured = self.measured
        faces = find_faces(measured.source.solid.mesh, measured.anatomy, measured.source.surfaces)
        return replace(self, measured=replace(measured, faces=faces))

    def __repr__(self) -> str:
        place = "" if self.file is None else f" {self.file.name}"
        return (
            f"<autobalance crank{place}: {self.mass_g:.6g} g, {len(self.throws)} throw"
            f"{'s' * (len(self.throws) != 1)}, {len(self.main_journals)} main journals, unbalance"
            f" {self.unbalance.magnitude_g_mm:.6g} g·mm at {self.unbalance.angle_deg:.4g}°>"
        )

    def show(self) -> Any:
        """Return the app's view of the crank for a notebook; a still picture without anywidget."""
        return registry.loaded(registry.VIEW)(self, self.measured)

    def _repr_html_(self) -> str:
        from autobalance.report.notebook import box, facts, picture, row
        from autobalance.report.pictures.picture import crank_picture

        measured = self.measured
        centre = ", ".join(f"{value:.3f}" for value in self.centre_of_mass_mm.round(3) + 0.0)
        rows = {
            "mass": f"{self.mass_g:.6g} g",
            "centre of mass": f"{centre} mm",
            "polar inertia": f"{self.polar_inertia_kg_mm2:.6g} kg·mm²",
            "throws": str(len(self.throws)),
            "main journals": str(len(self.main_journals)),
            "unbalance": f"{self.unbalance.magnitude_g_mm:.6g} g·mm at {self.unbalance.angle_deg:.4g}°",
        }
        drawn = crank_picture(measured.source.solid.mesh, measured.anatomy, measured.faces, 900, 420)
        return box(
            row(facts(rows.items()), picture(drawn, "the crank from two sides, its journals in colours"))
        )


def read_crank(
    path: str | Path,
    unit: str | None = None,
    density_kg_m3: float = STEEL_KG_M3,
    *,
    crankpin_in_file: bool | None = None,
    body: int | str | None = None,
    axis_point_mm: Sequence[float] | None = None,
    axis_direction: Sequence[float] | None = None,
    crankpins: Sequence[Mapping[str, Any]] | None = None,
    main_journals: Sequence[Mapping[str, Any]] | None = None,
    density_pm_kg_m3: float | None = None,
    fill_holes_mm: float = 0.0,
    keep_open: Sequence[Sequence[float]] | None = None,
) -> Crank:
    """Read a crank file, recognise the crank in it and measure it.

    Parameters
    ----------
    path : path
        Crank file, in any format that docs/job-file.md lists.
    unit : {"mm", "cm", "m", "inch"} or None
        Length unit of the crank file, if its format has no unit; None: the format's, required if it has no
        unit.
    density_kg_m3 : float
        Density [kg/m³].
    crankpin_in_file : bool or None
        Whether the file holds the crankpins, no for a pressed-up crank modelled without them; None: both are
        tried. Crankpins are looked for first, then bores for them.
    body : int or str or None
        Body to measure where the file holds several: its number, its name, or all.
    axis_point_mm : sequence of float or None
        Point of the crank axis, in the file's coordinates [mm], where it is not found or found wrong; None:
        as recognised.
    axis_direction : sequence of float or None
        Direction of the crank axis, in the file's coordinates; None: as recognised.
    crankpins, main_journals
        As the keys of ``[crankshaft]`` in a job.
    density_pm_kg_m3 : float or None
        Uncertainty of the density, ± [kg/m³].
    fill_holes_mm : float
        Width up to which holes of an open mesh are closed [mm]; 0: an open mesh is refused.
    keep_open : sequence of (3,) float or None
        Place at each hole that is a bore, to be joined to its other end, in the file's coordinates [mm].

    Returns
    -------
    Crank

    Raises
    ------
    FileError, FormatError, SolidError
        If the file cannot be read or holds no solid to be trusted.
    JobError
        If a keyword is impossible.
    RecognitionError
        If no crankshaft is found in it.

    Examples
    --------
    >>> from autobalance.bundled import bundled_folder
    >>> file = bundled_folder() / "crf250r" / "drafted" / "crank.stl"
    >>> crank = read_crank(file, unit="mm", density_kg_m3=7850.0, crankpin_in_file=False)
    >>> round(crank.throws[0].crank_radius_mm, 1)
    26.9
    """
    hints = {
        "unit": unit,
        "density_kg_m3": density_kg_m3,
        "density_pm_kg_m3": density_pm_kg_m3,
        "crankpin_in_file": crankpin_in_file,
        "body": body,
        "axis_point_mm": _listed(axis_point_mm),
        "axis_direction": _listed(axis_direction),
        "crankpins": _pins(crankpins),
        "main_journals": _pins(main_journals),
        "fill_holes_mm": fill_holes_mm or None,
        "keep_open": None if keep_open is None else [_listed(place) for place in keep_open],
    }
    if unit is None and not Path(path).exists():  # before its unit is asked for
        raise FileError(f"{path} does not exist")
    values = {"file": str(path), **{key: value for key, value in hints.items() if value is not None}}
    crankshaft = read_crankshaft(values, Path())
    if crankpin_in_file is None:
        crankshaft = replace(crankshaft, overrides=replace(crankshaft.overrides, crankpin_in_file=None))
    return Crank(measure_crank(crankshaft, Stopwatch()), crankshaft)


def _listed(values: Sequence[float] | None) -> list[float] | None:
    return None if values is None else [float(value) for value in values]


def _pins(pins: Sequence[Mapping[str, Any]] | None) -> list[dict[str, Any]] | None:
    return None if pins is None else [{key: plain(value) for key, value in pin.items()} for pin in pins]


def plain(value: Any) -> Any:
    """Return a value as a job file would hold it: lists for arrays and tuples."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    return {key: plain(item) for key, item in value.items()} if isinstance(value, Mapping) else value


# Cranks of no file: of a mesh, or of a shape in the memory of a CAD program.


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
    from autobalance.solid.formats.bodies import source_of_shape

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
