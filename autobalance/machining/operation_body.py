"""Metal of an operation, as a body in the rotor frame: the report's own, however a tool makes it."""

from __future__ import annotations

from autobalance.correction.holes.hole import drill_body
from autobalance.correction.holes.surface import Axis
from autobalance.correction.machining import AreaOperation, HoleOperation, Operation
from autobalance.correction.rings.trace import EQUAL_AREA, RING_SIDES, faceted_ring
from autobalance.solid.csg.solid import Solid

OVER_MM = 0.01
"""Height over a face up to which its metal counts as the face's: roughness."""
BEYOND_MM = 1.0


def operation_body(operation: Operation) -> Solid:
    """Return the metal of an operation, rotor frame."""
    if isinstance(operation, HoleOperation):
        placement = Axis(operation.entry_mm, operation.inward).placement
        radius = 0.5 * operation.diameter_mm
        body = drill_body(radius, -operation.lift_mm, operation.depth_mm, operation.point_mm)
        return body.moved(placement)
    if isinstance(operation, AreaOperation):
        ends = (
            operation.top_z_mm + operation.side * OVER_MM,
            operation.top_z_mm - operation.side * operation.depth_mm,
        )
        return Solid.prism(operation.region, min(ends), max(ends))
    inner, outer = operation.new_radius_mm * EQUAL_AREA, operation.rim_radius_mm + BEYOND_MM
    return faceted_ring(inner, outer, operation.z_from_mm, operation.z_to_mm, RING_SIDES)
