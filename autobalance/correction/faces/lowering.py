"""A shoulder's tool without facets: a box over the new face, around the metal that is to go."""

from __future__ import annotations

from autobalance.correction.faces.layer import FaceLayer
from autobalance.errors import CorrectionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Prism, Shape, Without, polygon, reversed_outline
from autobalance.solid.csg.tool import Lowering
from autobalance.types import Array

BESIDE_MM = 0.5
"""Margin of the box around the metal that it takes, and its distance from spared metal, if possible."""
SLIVER_MM = 0.01
"""Metal that is nowhere twice as thick is not metal, but the difference of two outlines."""
LAYER_SHARES = (1.0, 0.5, 0.2, 0.1, 0.04)
"""Shares of that distance tried between removed and spared metal."""


def lowering(layer: FaceLayer, depth_mm: float, to_rotor: Array, within: Shape | None) -> Lowering:
    """Return the tool that lowers a face; the exact solid finds the metal on the face itself.

    Raises
    ------
    CorrectionError
        If other metal is so near that the tool has no room between.
    """
    metal = layer.taken(depth_mm)
    low, high = metal.bounds
    low, high = (low - BESIDE_MM).tolist(), (high + BESIDE_MM).tolist()
    bottom, seed = layer.height_mm - depth_mm, layer.outline.inner_point()
    spared = layer.spared(depth_mm) & Region.rectangle(low, high)
    return Lowering(
        placement=to_rotor,
        outline=polygon([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]),
        face_mm=layer.height_mm,
        low_mm=bottom,
        seed=(float(seed[0]), float(seed[1])),
        spared=clear_of(spared, metal, (bottom - 1.0, layer.height_mm + 1.0)),
        within=within,
    )


def clear_of(spared: Region, metal: Region, heights_mm: tuple[float, float]) -> tuple[Shape, ...]:
    """Return prisms around metal to spare, with walls through air, well clear of the metal's surface.

    Slivers are left out: those lie between the facets of what is on the face and the tool's outline.
    """
    spared = spared.grown(-SLIVER_MM).grown(SLIVER_MM)
    if spared.is_empty:
        return ()
    for share in LAYER_SHARES:
        grown = spared.grown(share * BESIDE_MM).simplified(0.25 * share * BESIDE_MM)
        if (grown & metal).is_empty:
            return tuple(_prism(piece, heights_mm) for piece in grown.pieces())
    raise CorrectionError(
        f"other metal is nearer to the face than {LAYER_SHARES[-1] * BESIDE_MM:g} mm;"
        " no tool fits between them"
    )


def _prism(piece: Region, heights_mm: tuple[float, float]) -> Shape:
    """Return a connected region, with its holes, drawn out between two heights."""
    outlines = sorted(piece.polygons, key=lambda one: -Region.of([one]).area_mm2)
    drawn = [polygon([(float(x), float(y)) for x, y in outline]) for outline in outlines]
    outer = Prism(drawn[0], *heights_mm)
    holes = [Prism(tuple(reversed_outline(hole)), *heights_mm) for hole in drawn[1:]]
    return Without(outer, tuple(holes)) if holes else outer
