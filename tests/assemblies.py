"""STEP assemblies of named parts, each moved to its place; and an engine's, drawn from exact shapes."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import crank_shape
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.csg.shape import Bar, Prism, Shape, Without, circle
from tests.rods import FlatRod

Parts = Mapping[str, tuple[Shape, tuple[float, float, float]]]
"""Name → shape, and by how much it is moved [mm]."""
ROD = FlatRod(
    length=110.0,
    half_width=24.0,
    thickness=16.0,
    big_radius=18.0,
    small_radius=9.0,
    beyond_big=26.0,
    beyond_small=16.0,
    light_at=60.0,
)
PIN = (22.0, 9.0, 6.0)
"""Half the wrist pin's length, its radius and its bore's [mm]."""


def assembly(parts: Parts) -> bytes:
    """Write named parts, each moved to its place, as an assembly."""
    from OCP.gp import gp_Trsf, gp_Vec
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_ExtendedString as Text
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(Text("test"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    root = tool.NewShape()
    for name, (shape, place) in parts.items():
        motion = gp_Trsf()
        motion.SetTranslation(gp_Vec(*place))
        part = tool.AddShape(ExactSolid(shape).body, False)
        TDataStd_Name.Set_s(part, Text(name, True))
        TDataStd_Name.Set_s(tool.AddComponent(root, part, TopLoc_Location(motion)), Text(f"{name}:1", True))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    writer.SetNameMode(True)
    writer.Transfer(document)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "assembly.step"
        assert writer.Write(str(path)) is not None
        return path.read_bytes()


def engine_parts() -> dict[str, tuple[Shape, tuple[float, float, float]]]:
    """Return a single's crank with rod, big end's ring, pin, clip, piston, and a flywheel; names say nothing.

    It stands at top dead centre: the rod lies along the throw.
    """
    design = preset("single")
    back = crank_anatomy(design).rotor_to_file
    x, y, z = (float(value) for value in back[:3, :3] @ [0.5 * design.stroke_mm, 0.0, 0.0] + back[:3, 3])
    end, (half, outer, inner) = ROD.length, PIN
    pin = Without(_bar(half, outer, end), (_bar(half + 1.0, inner, end),))
    clip = Without(_bar(half + 1.0, outer, end, half), (_bar(half + 2.0, outer - 1.0, end, half - 1.0),))
    ring = Without(_bar(7.0, 18.0, 0.0), (_bar(8.0, 16.0, 0.0),))
    cup = Bar((end - 18.0, 0.0, 0.0), (end + 22.0, 0.0, 0.0), 76.0)
    hollow = Bar((end - 20.0, 0.0, 0.0), (end + 15.0, 0.0, 0.0), 66.0)
    piston = Without(cup, (hollow, _bar(50.0, outer, end)))
    there = (x, y, z)
    return {
        "Teil-1": (Prism(circle(70.0), -120.0, -110.0), (0.0, 0.0, 0.0)),
        "Teil-2": (ROD.shape, there),
        "Teil-3": (crank_shape(design), (0.0, 0.0, 0.0)),
        "Teil-4": (pin, there),
        "Teil 5": (piston, there),
        "Teil-6": (ring, there),
        "Teil-7": (clip, there),
    }


def _bar(half: float, radius: float, along: float, start: float | None = None) -> Bar:
    """Return a bar along z about a place on the rod."""
    low = -half if start is None else start
    return Bar((along, 0.0, low), (along, 0.0, half), 2.0 * radius)
