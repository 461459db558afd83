"""Pins beside a face that looks across the crank: its cut ends before it bites into them."""

# Needed by the generated twin: named sides of its webs could be lowered 18 mm, 9 mm of that through the main
# journal, since a pin beside the web stands out nowhere over the face.

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from autobalance.correction.faces.depth_limit import DepthLimit
from autobalance.correction.faces.layer import FaceLayer
from autobalance.correction.faces.patches import MIN_AXIAL_COMPONENT
from autobalance.crank.anatomy import Anatomy, Pin
from autobalance.solid.csg.region import Region
from autobalance.types import Array

BARE_PIN_SHARE = 0.98
"""Share of a pin's radius and length that is surely its own: no fillet, no web."""


def clear_of_pins(layer: FaceLayer, to_face: Array, anatomy: Anatomy, limit: DepthLimit) -> DepthLimit:
    """Return the depth limit of a face whose cut must not bite into a pin; the other one if that is sooner.

    Pins are on faces that look along the axis, or lie behind the wall: those are left as they are. A pin
    whose axis lies above the face is on it too; of one that the face cuts through, nothing may be taken.

    Parameters
    ----------
    layer : FaceLayer
    to_face : (4, 4)
        Turns the rotor frame to the face's.
    anatomy : Anatomy
    limit : DepthLimit
        Limit of the cut otherwise.
    """
    along = abs(float(to_face[2, 2]))
    if along >= MIN_AXIAL_COMPONENT:
        return limit
    for name, pin in _pins(anatomy):
        axis = float(to_face[2, :3] @ pin.centre_mm)
        top = axis + 0.5 * (pin.diameter_mm * math.sqrt(1.0 - along**2) + pin.width_mm * along)
        sooner = limit.or_sooner(max(layer.height_mm - top, 0.0), f"the surface of {name}")
        if layer.height_mm > axis and sooner is not limit:
            bitten = layer.taken(limit.depth_mm) & _footprint(pin, to_face)
            limit = limit if bitten.is_empty else sooner
    return limit


def _pins(anatomy: Anatomy) -> Iterator[tuple[str, Pin]]:
    for journal in anatomy.main_journals:
        yield f"main journal {journal.number}", journal
    for throw in anatomy.throws:
        yield f"crankpin {throw.number}", throw.crankpin


def _footprint(pin: Pin, to_face: Array) -> Region:
    """Return a pin's bare cylinder as seen from the face: a rectangle."""
    ends = pin.centre_mm + 0.5 * BARE_PIN_SHARE * pin.width_mm * np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    low, high = ends @ to_face[:2, :3].T
    ahead = (high - low) / float(np.linalg.norm(high - low))
    aside = 0.5 * BARE_PIN_SHARE * pin.diameter_mm * np.array([-ahead[1], ahead[0]])
    return Region.of([np.array([low - aside, high - aside, high + aside, low + aside])])
