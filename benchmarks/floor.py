"""The least that balancing a crank can cost: read, weld, construct, cut, measure and write, each once."""

import sys
from pathlib import Path

import manifold3d as m3
import numpy as np

from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def main() -> None:
    data = Path(sys.argv[1]).read_bytes()
    mesh = mesh_of_soup(np.frombuffer(data, dtype=RECORD, offset=84)["corners"])
    body = m3.Manifold(m3.Mesh64(mesh.vertices, mesh.triangles.astype(np.uint64)))
    slab = m3.Manifold.cube((200.0, 200.0, 2.81), True)
    shoulders = slab.translate((0.0, -121.0, 26.5)) + slab.translate((0.0, -121.0, -26.5))
    raw = (body - shoulders).to_mesh64()
    cut = Mesh(np.asarray(raw.vert_properties)[:, :3], np.asarray(raw.tri_verts).astype(np.int64))
    mesh_moments(cut, 7.85e-3)
    out = np.zeros(len(cut.triangles), dtype=RECORD)
    out["corners"] = cut.vertices[cut.triangles]
    Path(sys.argv[1]).with_name("floor.stl").write_bytes(
        bytes(80) + np.uint32(len(out)).tobytes() + out.tobytes()
    )


if __name__ == "__main__":
    main()
