"""Netgen in a separate process: a mesher that crashes, prints or hangs does so there.

Run as ``python -m autobalance.finite_elements.netgen_process ORDER.json``. The order names the input and, for
each mesh, its size and file; the answer goes to the order's ``answer``.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.finite_elements.mesher import default_size_mm

GRADINGS = (0.3, 0.5, 0.2)
"""Growth rates of elements, tried one after the other until the mesher succeeds."""
ROUGH_GRADINGS = (0.5, 0.3, 0.7)
ROUGH_STEPS = {"optsteps2d": 2, "optsteps3d": 1}
"""Rounds of improvement of a mesh, if a rough mesh suffices; netgen's own is 3."""
TRIES = (1.0, 0.85, 1.2)
"""Factors of the size requested, tried likewise."""


def main(order_file: str) -> None:
    """Make the meshes that an order asks for."""
    order = json.loads(Path(order_file).read_text(encoding="utf-8"))
    _limit(order["longest_s"])
    answer: dict[str, Any] = {"error": None, "volume_mm3": None, "solids": None, "size_mm": order["size_mm"]}
    import netgen.meshing as netgen

    netgen.SetMessageImportance(0)
    try:
        if order["exact"]:
            geometry = _exact_geometry(order, answer)
        else:
            from netgen.stl import STLGeometry

            geometry = STLGeometry(order["solid"])
        for mesh in order["meshes"] if answer["solids"] in (None, 1) else ():
            _one(geometry, order, mesh, answer["size_mm"])
    except netgen.NgException as error:
        answer["error"] = " ".join(str(error).split())
    Path(order["answer"]).write_text(json.dumps(answer), encoding="utf-8")


def _limit(seconds: float) -> None:
    """Let the system end this process after so much processor time, where it can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    most = max(1, math.ceil(seconds))
    resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))


def _exact_geometry(order: dict[str, Any], answer: dict[str, Any]) -> Any:
    """Return the geometry of a STEP file; its volume, and the size where none was given, go to the answer."""
    from netgen.occ import OCCGeometry

    geometry = OCCGeometry(order["solid"])
    solids = list(geometry.shape.solids)
    volume = float(sum(solid.mass for solid in solids))
    area = float(sum(face.mass for face in geometry.shape.faces))
    answer.update(volume_mm3=volume, solids=len(solids))
    if answer["size_mm"] is None and volume > 0.0:
        answer["size_mm"] = default_size_mm(volume, area)
    return geometry


def _one(geometry: Any, order: dict[str, Any], size_field: dict[str, Any], size_mm: float) -> None:
    """Make one mesh, with coarser or finer settings where those requested fail."""
    import netgen.meshing as netgen

    options: dict[str, Any] = {}
    if order["exact"]:
        options["curvaturesafety"] = 1.0 / (order["share_of_radius"] * size_field["factor"])
    else:
        options["meshsizefilename"] = size_field["sizes"]
    if order["rough"]:
        options |= ROUGH_STEPS
    gradings = ROUGH_GRADINGS if order["rough"] else GRADINGS
    attempts = [(grading, factor) for factor in TRIES for grading in gradings]
    for number, (grading, factor) in enumerate(attempts, 1):
        try:
            mesh = geometry.GenerateMesh(
                maxh=size_mm * size_field["factor"] * factor, grading=grading, **options
            )
            mesh.SecondOrder()
        except netgen.NgException:
            if number == len(attempts):
                raise
            continue
        if len(mesh.Elements3D()):
            break
    np.savez(
        size_field["file"],
        nodes_mm=np.asarray(mesh.Coordinates()),
        tetrahedra=mesh.Elements3D().NumPy()["nodes"][:, :10].astype(np.int64) - 1,
    )


if __name__ == "__main__":
    main(sys.argv[1])
