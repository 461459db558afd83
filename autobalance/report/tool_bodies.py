"""The tools' bodies as a file for CAD programs: STEP where the kernel is installed, else 3MF."""

from __future__ import annotations

from autobalance.report.material import FileMaterial


def tool_bodies(material: FileMaterial, is_exact: bool) -> bytes:
    """Return a file with a named solid for each correction, file coordinates, in mm.

    Kept cuts of depth 0 have no body.
    """
    import numpy as np

    entries = material.balanced.corrections
    material.notify("drawing the tools")
    if not is_exact:
        from autobalance.solid.formats.threemf import write_objects

        meshes = [tool.mesh for tool in material.tools]
        named = [
            (entry.label, mesh.vertices, mesh.triangles)
            for entry, mesh in zip(entries, meshes, strict=True)
            if entry.depth_mm != 0.0
        ]
        return write_objects(named, "millimeter")
    from autobalance.solid.cad.build import shape_of
    from autobalance.solid.cad.files import write_parts

    back = np.linalg.inv(np.array(material.balanced.frame.file_to_rotor))
    drawn = [(entry.label, entry.of_kind.drawn(entry.item)) for entry in entries if entry.depth_mm != 0.0]
    return write_parts([(label, shape_of(shape, back)) for label, shape in drawn if shape is not None], "mm")
