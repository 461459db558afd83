"""IGES files: surfaces or solids, sewn if need be, and their unit; the kernel works in mm."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Final

from autobalance.errors import FormatError
from autobalance.solid.cad.cad_file import CadFile
from autobalance.solid.cad.kernel import require_kernel
from autobalance.solid.cad.sewing import bodies_of

UNITS: Final = {1: "inch", 2: "mm", 6: "m", 10: "cm"}
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
    require_kernel("IGES")
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
    if head.UnitFlag() not in UNITS:
        raise FormatError(
            f"the IGES file is in unit {head.UnitFlag()}; expected one of "
            + ", ".join(f"{flag} ({name})" for flag, name in UNITS.items())
        )
    shape = reader.OneShape()
    if shape.IsNull():
        raise FormatError("the IGES file holds no surface; expected a closed body")
    bodies, repairs = bodies_of(shape, "IGES")
    return CadFile(bodies, UNITS[head.UnitFlag()], repairs)
