"""CAD files read by the kernel: STEP, BREP, IGES, and formats of other programs."""

from __future__ import annotations

import re
import signal
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from autobalance.child_process import Children, ended_after
from autobalance.errors import FormatError, SolidError
from autobalance.solid.cad import kernel
from autobalance.solid.cad.tessellation import Fineness, bounds_mm, tessellate
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

# Contents of a CAD file: bodies of the kernel, with their names and the file's unit.


@dataclass(frozen=True, eq=False)
class NamedBody:
    """A solid of a CAD file with its part's name, and its place's in the assembly; both may be empty."""

    name: str
    body: Any
    place: str = ""


@dataclass(frozen=True, eq=False)
class CadFile:
    """The solids of a CAD file [mm], the name of its unit, and the repairs that the solids needed.

    Where the file carries no unit, ``unit`` is None and its bodies are in the file's numbers.
    """

    bodies: tuple[NamedBody, ...]
    unit: str | None
    repairs: tuple[str, ...] = ()


def in_unit(file: CadFile, unit: str) -> CadFile:
    """Return a file that carries no unit, with its numbers taken in a unit."""
    if MM_PER[unit] == 1.0:
        return replace(file, unit=unit)
    bodies = (replace(one, body=kernel.scaled(one.body, MM_PER[unit])) for one in file.bodies)
    return replace(file, bodies=tuple(bodies), unit=unit)


# Reading of CAD files from elsewhere in a separate process: a damaged one can bring the kernel down.
#
# Of 300 STEP files with a line or a number changed, some 40 ended the kernel's reader by a segmentation
# fault, and three kept it for ever. Here that is one line. The answer is the kernel's own binary form, which
# keeps every surface to the bit.


LEAST_S: Final = 20.0
S_PER_MB: Final = 10.0
"""Processor time after which a reader is ended [s]; the largest file tried, of 30 MB, takes 40 s."""
KINDS: Final = ("step", "iges", "brep")


def read_foreign_file(kind: str, data: bytes, longest_s: float | None = None) -> CadFile:
    """Read the solids of a CAD file, in a separate process.

    Parameters
    ----------
    kind : str
        One of ``KINDS``.
    data : bytes
    longest_s : float, optional
        Processor time after which the reader is ended [s]; by the size of the file where None.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed, or the file cannot be read, or brings the kernel down.
    SolidError
        If its surfaces do not close.
    """
    with readers.one() as child:
        longest_s = LEAST_S + S_PER_MB * len(data) / 1e6 if longest_s is None else longest_s
        child.send(kind, data, longest_s, Fineness.usual())
        kernel.require_kernel(kind.upper())  # meanwhile: loading it takes as long here as there
        answer = child.receive()
        if answer is None:
            raise FormatError(_end_message(kind, child.end(), longest_s))
    bodies = tuple(
        NamedBody(name, kernel.shape_of_bytes(body), place) for name, place, body in answer["bodies"]
    )
    return CadFile(bodies, answer["unit"], answer["repairs"])


readers: Final = Children(__name__)
"""Kept for the next file: the kernel takes a second to load."""


def _end_message(kind: str, code: int, longest_s: float) -> str:
    if code == -signal.SIGPROF:
        why = f"keeps the CAD kernel busy for more than {longest_s:.3g} s"
    elif code < 0:
        why = f"brings the CAD kernel down ({signal.Signals(-code).name})"
    else:
        why = f"ends the CAD kernel's process (exit code {code})"
    return (
        f"the {kind.upper()} file {why}; expected a sound file: "
        "export it again, or open and save it in a CAD program"
    )


def answer(kind: str, data: bytes, longest_s: float, fineness: Fineness) -> dict[str, Any]:
    """Read a file, in the process that reads: bodies with their triangles as bytes, unit and repairs.

    Bodies are tessellated here too: on a STEP file with one number of a curve changed, which reads well,
    that never ends.
    """
    kernel.require_kernel(kind.upper())
    with ended_after(longest_s), kernel.kernel_failures(f"the {kind.upper()} file"):
        file = {"step": read_step_file, "iges": read_iges_file, "brep": read_brep_file}[kind](data)
        for one in file.bodies:
            tessellate(one.body, fineness)
    bodies = [(one.name, one.place, kernel.shape_bytes(one.body)) for one in file.bodies]
    return {"bodies": bodies, "unit": file.unit, "repairs": file.repairs}


# Sewing of a CAD file's loose surfaces to solids.


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
    kernel.refuse_odd_shape(shape)
    solids = kernel.explored(shape, "SOLID")
    if solids:
        return tuple(NamedBody("", solid) for solid in solids), ()
    faces = kernel.explored(shape, "FACE")
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
    return kernel.explored(sewing.SewedShape(), "SHELL"), share * diagonal


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
            outer_solids[around] = kernel.explored(kernel.cut(outer_solids[around], [solids[k]]), "SOLID")[0]
    return outer_solids


def _contains(outer: Any, inner: Any) -> bool:
    from OCP.BRep import BRep_Tool
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.TopAbs import TopAbs_State
    from OCP.TopoDS import TopoDS

    corner = BRep_Tool.Pnt_s(TopoDS.Vertex(kernel.explored(inner, "VERTEX")[0]))
    return bool(BRepClass3d_SolidClassifier(outer, corner, 1e-7).State() == TopAbs_State.TopAbs_IN)


# STEP files: named bodies in their place, and their unit; the kernel works in mm.


UNITS: Final = {"millimetre": "mm", "centimetre": "cm", "metre": "m", "inch": "inch"}
"""Names of units in STEP files, in small letters, and ours."""
WRITTEN_UNITS: Final = {"mm": "MM", "cm": "CM", "m": "M", "inch": "INCH"}
HUGE: Final = re.compile(rb"(?<=[\d.])[Ee]\+?0*(?:10[1-9]|1[1-9]\d|[2-9]\d\d|[1-9]\d{3,})(?!\d)")
"""Exponents of numbers beyond 1e101, which are not lengths; the kernel's own word for infinite is 2e100."""
TIME: Final = "2000-01-01T00:00:00"
"""Written as the time of every file, so that equal solids are equal files."""


def read_step_file(data: bytes) -> CadFile:
    """Read the solids of a STEP file; without solids, its surfaces are sewn.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed, or the file is not a STEP file or holds neither solids nor
        surfaces.
    SolidError
        If its surfaces do not close, or lie if no crankshaft does.
    """
    kernel.require_kernel("STEP")
    if b"ISO-10303-21" not in data[:256]:
        raise FormatError("the STEP file does not begin with ISO-10303-21")
    if HUGE.search(data) and (huge := HUGE.search(re.sub(rb"'[^']*'", b"''", data))):  # names may have any
        raise FormatError(
            f"the STEP file has a number that ends in {huge[0].decode()[:20]}; expected lengths within "
            f"{kernel.MOST_MM:g} mm: export it again"
        )
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document

    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    document = TDocStd_Document(TCollection_ExtendedString("autobalance"))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "crank.step"
        path.write_bytes(data)
        if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise FormatError("the STEP file cannot be read")
        reader.Transfer(document)
    parts = _parts(document)
    for part in parts:
        kernel.refuse_odd_shape(part.body)
    bodies = tuple(
        replace(part, body=solid) for part in parts for solid in kernel.explored(part.body, "SOLID")
    )
    repairs: tuple[str, ...] = ()
    if not bodies:
        bodies, repairs = _sewn_step(parts)
    return CadFile(bodies, _unit(reader.Reader()), repairs)


def _sewn_step(parts: Sequence[NamedBody]) -> tuple[tuple[NamedBody, ...], tuple[str, ...]]:
    """Return the solids sewn of the loose surfaces of all parts together, and a note on that."""
    if not any(kernel.explored(part.body, "FACE") for part in parts):
        raise FormatError("the STEP file holds no solid, and no surfaces to sew; expected a closed body")
    bodies, repairs = bodies_of(kernel.compound([part.body for part in parts]), "STEP")
    if len(parts) == 1:
        bodies = tuple(replace(one, name=parts[0].name, place=parts[0].place) for one in bodies)
    return bodies, repairs


def _unit(reader: Any) -> str:
    from OCP.collections import Sequence_TCollection_AsciiString as Names

    lengths, angles, solid_angles = Names(), Names(), Names()
    reader.FileUnits(lengths, angles, solid_angles)
    names = {lengths.Value(place + 1).ToCString().lower() for place in range(lengths.Length())}
    known = {UNITS[name] for name in names if name in UNITS}
    return known.pop() if len(known) == 1 else "mm"


def _parts(document: Any) -> list[NamedBody]:
    """Return the shapes of all parts in their places, in the order of the file."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    roots = Sequence_TDF_Label()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    parts: list[NamedBody] = []
    for place in range(roots.Length()):
        parts += _of_label(roots.Value(place + 1), None)
    return parts


def _of_label(label: Any, place: Any) -> list[NamedBody]:
    """Return the shape of a label, or of its parts, if it is an assembly, each moved to its place."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.TDF import TDF_Label
    from OCP.XCAFDoc import XCAFDoc_ShapeTool

    if not XCAFDoc_ShapeTool.IsAssembly_s(label):
        shape = XCAFDoc_ShapeTool.GetShape_s(label)
        return [NamedBody(_name(label), shape if place is None else shape.Moved(place))]
    bodies: list[NamedBody] = []
    parts = Sequence_TDF_Label()
    XCAFDoc_ShapeTool.GetComponents_s(label, parts, False)
    for number in range(parts.Length()):
        part, target = parts.Value(number + 1), TDF_Label()
        here = XCAFDoc_ShapeTool.GetLocation_s(part)
        there = here if place is None else place.Multiplied(here)
        if XCAFDoc_ShapeTool.GetReferredShape_s(part, target):
            inside = _of_label(target, there)
            bodies += [replace(one, place=_name(part)) for one in inside]
    return bodies


def _name(label: Any) -> str:
    from OCP.TDataStd import TDataStd_Name

    name = TDataStd_Name()
    return str(name.Get().ToExtString()) if label.FindAttribute(TDataStd_Name.GetID_s(), name) else ""


def write_step(body: Any, unit: str, name: str) -> bytes:
    """Return a STEP file of a body [mm] in a unit; equal bodies give equal files.

    Raises
    ------
    SolidError
        If the kernel cannot write it.
    """
    return write_parts([(name, body)], unit)


def write_parts(parts: Sequence[tuple[str, Any]], unit: str) -> bytes:
    """Return a STEP file of named bodies [mm] side by side, in a unit.

    Raises
    ------
    SolidError
        If the kernel cannot write it.
    """
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_HAsciiString

    kernel.require_kernel("STEP")
    document = _document(parts)
    Interface_Static.SetCVal_s("write.step.unit", WRITTEN_UNITS[unit])
    writer = STEPCAFControl_Writer()
    writer.SetNameMode(True)
    writer.Transfer(document)
    header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
    header.SetTimeStamp(TCollection_HAsciiString(TIME))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "crank.step"
        if writer.Write(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise SolidError("the CAD kernel could not write the STEP file")
        return path.read_bytes()


def _document(parts: Sequence[tuple[str, Any]]) -> Any:
    """Return a document that holds parts with their names."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("autobalance"))
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    for name, body in parts:
        label = shapes.AddShape(body, False)
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))
    return document


# BREP files: the CAD kernel's own text; they carry no unit.


BEGINNING: Final = re.compile(rb"\s*(DBRep_DrawableShape\s+)?CASCADE Topology V[123],")


def read_brep_file(data: bytes) -> CadFile:
    """Read the solids of a BREP file.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed, or the file is not a BREP file.
    SolidError
        If its surfaces do not close.
    """
    kernel.require_kernel("BREP")
    if not BEGINNING.match(data):
        raise FormatError("the BREP file does not begin with 'CASCADE Topology V1', V2 or V3")
    from OCP.BRep import BRep_Builder
    from OCP.BRepTools import BRepTools
    from OCP.TopoDS import TopoDS_Shape

    shape: Any = TopoDS_Shape()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "crank.brep"
        path.write_bytes(data)
        read = BRepTools.Read_s(shape, str(path), BRep_Builder())
    if not read or shape.IsNull():
        raise FormatError("the BREP file cannot be read")
    bodies, repairs = bodies_of(shape, "BREP")
    return CadFile(bodies, None, repairs)


# IGES files: surfaces or solids, sewn if need be, and their unit; the kernel works in mm.


IGES_UNITS: Final = {1: "inch", 2: "mm", 6: "m", 10: "cm"}
"""Our names of units, by the unit flag of the file's global section."""


def read_iges_file(data: bytes) -> CadFile:
    """Read the solids of an IGES file.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed, the file is not an IGES file, or its unit is none of ours.
    SolidError
        If its surfaces do not close.
    """
    kernel.require_kernel("IGES")
    if data[72:73] != b"S" and b"S      1" not in data[:200]:
        raise FormatError("the IGES file does not begin with a start section")
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.IGESControl import IGESControl_Reader

    reader = IGESControl_Reader()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "crank.igs"
        path.write_bytes(data)
        if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise FormatError("the IGES file cannot be read")
        reader.TransferRoots()
    head = reader.IGESModel().GlobalSection()
    if head.UnitFlag() not in IGES_UNITS:
        raise FormatError(
            f"the IGES file is in unit {head.UnitFlag()}; expected one of "
            + ", ".join(f"{flag} ({name})" for flag, name in IGES_UNITS.items())
        )
    shape = reader.OneShape()
    if shape.IsNull():
        raise FormatError("the IGES file holds no surface; expected a closed body")
    bodies, repairs = bodies_of(shape, "IGES")
    return CadFile(bodies, IGES_UNITS[head.UnitFlag()], repairs)
