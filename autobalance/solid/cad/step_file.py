"""STEP files: named bodies in their place, and their unit; the kernel works in mm."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from autobalance.errors import FormatError, SolidError
from autobalance.solid.cad.cad_file import CadFile, NamedBody
from autobalance.solid.cad.kernel import MOST_MM, compound, explored, refuse_odd_shape, require_kernel
from autobalance.solid.cad.sewing import bodies_of

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
    require_kernel("STEP")
    if b"ISO-10303-21" not in data[:256]:
        raise FormatError("the STEP file does not begin with ISO-10303-21")
    if HUGE.search(data) and (huge := HUGE.search(re.sub(rb"'[^']*'", b"''", data))):  # names may have any
        raise FormatError(
            f"the STEP file has a number that ends in {huge[0].decode()[:20]}; expected lengths within "
            f"{MOST_MM:g} mm: export it again"
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
        refuse_odd_shape(part.body)
    bodies = tuple(replace(part, body=solid) for part in parts for solid in explored(part.body, "SOLID"))
    repairs: tuple[str, ...] = ()
    if not bodies:
        bodies, repairs = _sewn(parts)
    return CadFile(bodies, _unit(reader.Reader()), repairs)


def _sewn(parts: Sequence[NamedBody]) -> tuple[tuple[NamedBody, ...], tuple[str, ...]]:
    """Return the solids sewn of the loose surfaces of all parts together, and a note on that."""
    if not any(explored(part.body, "FACE") for part in parts):
        raise FormatError("the STEP file holds no solid, and no surfaces to sew; expected a closed body")
    bodies, repairs = bodies_of(compound([part.body for part in parts]), "STEP")
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

    require_kernel("STEP")
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
