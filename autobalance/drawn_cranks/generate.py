"""Build a crankshaft from its dimensions.

The crank axis is z; the first crankpin lies at the angle that the design gives it, and the first main
journal begins at z = 0.
"""

from __future__ import annotations

from functools import lru_cache

from autobalance.drawn_cranks.axial_plan import axial_plan, has_free_end
from autobalance.drawn_cranks.design import Design
from autobalance.drawn_cranks.metal_taken import metal_taken
from autobalance.drawn_cranks.pins import crankpin_shape, journal_shape
from autobalance.drawn_cranks.webs import web_shapes
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.shape import Joined, Shape, Without, on_grid, tessellated
from autobalance.solid.csg.solid import Solid
from autobalance.units import G_PER_MM3_PER_KG_M3


def crank_shape(crank: Design) -> Shape:
    """Return the exact shape of a crankshaft.

    Raises
    ------
    JobError
        If its parts do not fit together.
    """
    plan = axial_plan(crank)
    parts: list[Shape] = [part for web in plan.webs for part in web_shapes(crank, web)]
    for number, journal in enumerate(plan.journals):
        above = number + 1 < len(plan.journals) or crank.journals == "first"
        parts.append(journal_shape(crank, journal, webs_below=number > 0, webs_above=above))
    if crank.crankpin_in_file:
        thinnest = min(web.high - web.low for web in plan.webs)
        root = on_grid(thinnest / 2.0)
        parts += [crankpin_shape(crank, pin, root, has_free_end(crank, plan, pin)) for pin in plan.pins]
    tools = metal_taken(crank, plan)
    body = Joined(tuple(parts))
    return Without(body, tuple(tools)) if tools else body


def crank_solid(crank: Design, segments: int | None = None) -> Solid:
    """Return a crankshaft as triangles, ``segments`` a full circle (default: the design's)."""
    return tessellated(crank_shape(crank), segments or crank.segments)


@lru_cache(maxsize=16)
def exact_moments(crank: Design, segments: int = 128) -> Moments:
    """Return the mass moments of the true surface, without facets.

    The facets' error falls as n⁻², so that two tessellations, one twice as fine as the other in every arc,
    give the limit (Richardson). What is left falls as n⁻⁴; where surfaces cross slantwise more is left: some
    1e-7 of the mass with oil holes.
    """
    density = crank.density_kg_m3 * G_PER_MM3_PER_KG_M3
    shape = crank_shape(crank)
    coarse, fine = (tessellated(shape, segments, times).moments(density) for times in (1, 2))
    return fine.scaled(4.0 / 3.0) - coarse.scaled(1.0 / 3.0)
