"""BREP files: the CAD kernel's own text; they carry no unit."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any, Final

from autobalance.errors import FormatError
from autobalance.solid.cad.cad_file import CadFile
from autobalance.solid.cad.kernel import require_kernel
from autobalance.solid.cad.sewing import bodies_of

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
    require_kernel("BREP")
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
