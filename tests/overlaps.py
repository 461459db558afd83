"""Connected closed meshes that overlap themselves: metal that a measurement of their surface counts twice."""

from __future__ import annotations

import numpy as np

from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh

HEAD_RADIUS, STEM_RADIUS, HEAD_THICKNESS = 4.0, 0.1, 0.5
SEGMENTS = 32
DEEP_MM = 6.1
"""From the face to the head's far end."""


def with_hidden_head(solid: Solid, x: float, y: float, face_z: float) -> tuple[Mesh, float]:
    """Return a solid with a bent pin on a flat face that looks to −z, its head pushed into the metal.

    The pin stands on the face at (x, y), goes away from it, across by 12 mm, and back through the face on a
    thin stem to a flat head inside. One connected mesh, closed and wound as it must be; returned with the
    volume that it counts twice [mm³].
    """
    post = Solid.prism(Region.circle(1.5, SEGMENTS, (x, y)), face_z - 15.0, face_z + 1.0)
    arm = Solid.box(np.array([x - 2.0, y - 2.0, face_z - 17.0]), np.array([x + 2.0, y + 14.0, face_z - 15.0]))
    stem, head = (Region.circle(radius, SEGMENTS, (x, y + 12.0)) for radius in (STEM_RADIUS, HEAD_RADIUS))
    outside = Solid.prism(stem, face_z - 16.0, face_z - 8.0)
    knob = Solid.prism(head, face_z - 8.0 - HEAD_THICKNESS, face_z - 8.0)
    drawn = (solid + post + arm + outside + knob).mesh
    vertices = drawn.vertices.copy()
    near = np.hypot(vertices[:, 0] - x, vertices[:, 1] - y - 12.0) < HEAD_RADIUS + 0.1
    moving = near & (vertices[:, 2] > face_z - 10.0) & (vertices[:, 2] < face_z - 5.0)
    vertices[moving, 2] += 8.0 + DEEP_MM
    volume = head.area_mm2 * HEAD_THICKNESS + stem.area_mm2 * (DEEP_MM - HEAD_THICKNESS)
    return Mesh(vertices, drawn.triangles), volume
