"""Fillets of one throw by finite elements of its metal, and the effect of cuts next to them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Self

import numpy as np

from autobalance.balancing.engine_from_job import with_crankpins
from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Pin, Throw
from autobalance.crank_dynamics.strength.fatigue import FilletShape, polar_modulus_mm3
from autobalance.crank_dynamics.strength.fillets_from_job import Costs, Place, Side
from autobalance.crank_dynamics.strength.input import Strength
from autobalance.crank_dynamics.torsion.throw_twist import throw_ends_mm
from autobalance.declare import NotNegative, Ordinal, Positive, record
from autobalance.errors import JobError
from autobalance.finite_elements.elasticity import STEEL
from autobalance.finite_elements.mesher import FilletRing, default_size_mm, need_libraries
from autobalance.finite_elements.throws import Deadline, ThrowLoads, bodies_of_solid, throw_loads
from autobalance.runtime import Progress, no_progress
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.units import N_MM_PER_N_M
from autobalance.value_classes import dataclass

SHARES_OF_RADIUS = (0.6, 0.4)
"""Size of elements in a fillet over its radius, of the two meshes: curved and quadratic as they are."""
CURVED_SHARE = 0.9
"""The same of other curved surfaces."""
COARSENING = (2.0, 1.6)
"""Over the usual size of elements."""
LEAST_CUT_MM3 = 1.0
BESIDE_MM = 0.01
"""Around a cut, whose surface is looked for in the mesh."""
NEAR_END_MM = 0.5
"""From a main journal's end into its metal: the section there shows its size."""
NEEDLE_MM = 1e-3
"""Shorter edges, as cutting leaves them, go before meshing: elements beside them were as fine."""
LONGEST_S = 90.0
"""Processor time for the meshes of one throw [s]."""
EXAMINED_RADIUS_SHARES = (0.15, 0.85)
"""Between these shares of a fillet's radius, out from its pin, its surface is off both pin and web."""
OFF_WEB = 0.02
"""Smallest distance of it from both, as a share of the radius; a smaller one is a sharp corner."""


@dataclass(frozen=True)
class FilletByElements:
    """Largest stress in a fillet by finite elements.

    Attributes
    ----------
    web : int
    place : {"crankpin", "journal"}
    bending_MPa : float
        Von Mises' stress where 1 N·m bends the throw.
    torsion_MPa : float
        Principal stress where 1 N·m twists it.
    error : float
        Difference of the last two meshes, as a share.
    is_there : bool
        Whether the solid has a fillet of about that radius; without, the stress has no limit.
    """

    web: int
    place: Place
    bending_MPa: float
    torsion_MPa: float
    error: float
    is_there: bool


@dataclass(frozen=True, eq=False)
class ThrowByElements:
    """A throw's fillets by finite elements, and the largest stress beyond them, in holes say.

    ``in_boxes_MPa`` is the largest stress of the bending in each box; None where it holds no surface.
    """

    fillets: tuple[FilletByElements, ...]
    nodes: int
    in_boxes_MPa: tuple[float | None, ...] = ()


@record
class FilletElements:
    """A fillet by finite elements: its factors, over those of the formulas, and how sure they are."""

    web: Ordinal
    place: Place
    bending_factor: Positive
    torsion_factor: Positive
    bending_over_formula: Positive
    torsion_over_formula: Positive
    error: NotNegative
    solid_has_fillet: bool
    cost_of_cuts: Positive | None

    @classmethod
    def of(cls, fillet: FilletByElements, shape: FilletShape, costs: Costs | None) -> Self:
        diameter, bore, factors = shape.pin_mm, shape.pin_bore_mm, shape.crankpin
        if fillet.place == "journal":
            diameter, bore, factors = shape.journal_mm, shape.journal_bore_mm, shape.journal
        bending = fillet.bending_MPa * shape.web_breadth_mm * shape.web_thickness_mm**2 / 6.0 / N_MM_PER_N_M
        torsion = fillet.torsion_MPa * polar_modulus_mm3(diameter, bore) / N_MM_PER_N_M
        return cls(
            web=fillet.web,
            place=fillet.place,
            bending_factor=bending,
            torsion_factor=torsion,
            bending_over_formula=bending / factors.bending,
            torsion_over_formula=torsion / factors.torsion,
            error=fillet.error,
            solid_has_fillet=fillet.is_there,
            cost_of_cuts=None if costs is None else costs[fillet.web, fillet.place],
        )


@record
class ThrowFillets:
    """One throw by finite elements; of each cut, its largest stress, bent, over the fillets' largest."""

    schema_name: ClassVar[str] = "ThrowElements"
    throw: Ordinal
    nodes: Ordinal
    fillets: Sequence[FilletElements]
    cuts_over_fillets: Sequence[float]

    @classmethod
    def of(cls, throw: int, elements: ThrowByElements, sides: Sequence[Side], costs: Costs | None) -> Self:
        greatest = max(each.bending_MPa for each in elements.fillets)
        inside = [each for each in elements.in_boxes_MPa if each is not None]
        shapes = {side.loads.web: side.shape for side in sides}
        return cls(
            throw=throw,
            nodes=elements.nodes,
            fillets=[FilletElements.of(each, shapes[each.web], costs) for each in elements.fillets],
            cuts_over_fillets=[each / greatest for each in inside],
        )


def throw_by_elements(
    crank: Crank,
    throw: Throw,
    sides: Sequence[Side],
    asked: Strength,
    boxes_mm: Sequence[tuple[Array, Array]] = (),
    progress: Progress = no_progress,
) -> ThrowByElements:
    """Return the stress in a throw's fillets on two meshes, the finer one the answer.

    Parameters
    ----------
    crank : Crank
    throw : Throw
    sides : sequence of Side
        The throw's two.
    asked : Strength
    boxes_mm : sequence of ((3,), (3,))
        Boxes (rotor frame) in which the largest stress is looked for too: around cuts.
    progress : callable

    Raises
    ------
    FileError If the extra is not installed. SolidError If the throw cannot be meshed. JobError If it has no
    separate bay between two main journals.
    """
    need_libraries()
    ends = throw_ends_mm(crank.anatomy, throw)
    if isinstance(ends, str):
        raise JobError(f"throw {throw.number}: {ends}; finite elements need a main journal on both sides")
    solid = with_crankpins(crank.source.solid.moved(crank.anatomy.file_to_rotor), crank)
    piece = _with_long_journals(solid.above(ends[0]).below(ends[1])).without_needles(NEEDLE_MM)
    deadline = Deadline.after(LONGEST_S)
    rings = [_ring(crank, throw, side, place, asked) for side in sides for place in _places(side)]
    rings = [ring for ring in rings if ring.is_drawn(piece.mesh.vertices)]
    levels = []
    for number, (share, coarser) in enumerate(zip(SHARES_OF_RADIUS, COARSENING, strict=True), 1):
        text = f"throw {throw.number} by finite elements, mesh {number} of 2"
        progress(text, 0.5 * (number - 1))
        size = coarser * default_size_mm(piece.volume_mm3, 0.5 * float(piece.mesh.doubled_areas.sum()))
        body = bodies_of_solid(piece, size, (1.0,), CURVED_SHARE, deadline, rings, share)[0]
        progress(f"{text}: solving {body.nodes} nodes", 0.5 * (number - 0.5))
        levels.append(throw_loads(body, STEEL, throw.direction))
    fillets = tuple(
        _fillet(crank, throw, side, place, asked, levels) for side in sides for place in _places(side)
    )
    inside = tuple(_greatest_MPa(levels[-1], _in_box(levels[-1].places_mm, box)) for box in boxes_mm)
    return ThrowByElements(fillets, levels[-1].nodes, inside)


def _with_long_journals(piece: Solid) -> Solid:
    """Return a throw whose half journals are extended by their thickness.

    So that how its ends are held does not reach its fillets.
    """
    for number, end in enumerate(piece.bounds[:, 2] if piece.bounds.shape == (2, 3) else piece.bounds[2]):
        z = float(end)
        inside = z + (NEAR_END_MM if number == 0 else -NEAR_END_MM)
        section = piece.section(inside)
        low, high = section.bounds
        reach = float(np.max(high - low))
        piece = piece + Solid.prism(section, *((z - reach, inside) if number == 0 else (inside, z + reach)))
    return piece


def _places(side: Side) -> tuple[Place, ...]:
    return ("crankpin", "journal") if side.has_journal else ("crankpin",)


def _ring(crank: Crank, throw: Throw, side: Side, place: Place, strength: Strength) -> FilletRing:
    """Return the arc of a fillet as the job has it."""
    pin: Pin = throw.crankpin
    above = side.loads.is_above
    if place == "crankpin":
        return FilletRing.of(pin, above, strength.pin_fillet_mm)
    mains = crank.anatomy.main_journals
    beside = [m for m in mains if (m.centre_mm[2] > pin.centre_mm[2]) == above]
    journal = min(beside, key=lambda m: abs(float(m.centre_mm[2] - throw.crankpin.centre_mm[2])))
    return FilletRing.of(journal, not above, strength.journal_fillet_mm)


def _fillet(
    crank: Crank, throw: Throw, side: Side, place: Place, strength: Strength, levels: Sequence[ThrowLoads]
) -> FilletByElements:
    ring = _ring(crank, throw, side, place, strength)
    radius = ring.radius_mm
    on_levels = []
    for level in levels:
        out, along = ring.coordinates(level.places_mm)  # from the end of the bare cylinder into the web
        near = (out > -0.05 * radius) & (out < 1.1 * radius) & (np.abs(along - 0.5 * radius) < 0.75 * radius)
        on_levels.append((level, near, along, out))
    level, near, along, out = on_levels[-1]
    middle = near & (out > EXAMINED_RADIUS_SHARES[0] * radius) & (out < EXAMINED_RADIUS_SHARES[1] * radius)
    face = float(along[near].max()) if near.any() else 0.0
    is_there = bool((middle & (along < face - OFF_WEB * radius)).sum() > 0.5 * max(middle.sum(), 1))
    values = [
        (float(each.bending_MPa[mask].max()), float(each.torsion_MPa[mask].max()))
        for each, mask, _, _ in on_levels
        if mask.any()
    ]
    if len(values) < len(on_levels):
        raise JobError(f"the mesh has no surface of the {place} fillet beside web {side.loads.web}")
    bending, torsion = values[-1]
    return FilletByElements(
        side.loads.web, place, bending, torsion, abs(values[0][0] / bending - 1.0), is_there
    )


def _in_box(places: Array, box: tuple[Array, Array]) -> np.typing.NDArray[np.bool_]:
    above, below = (places >= box[0]).all(axis=1), (places <= box[1]).all(axis=1)
    return np.asarray(above & below)


def _greatest_MPa(level: ThrowLoads, mask: np.typing.NDArray[np.bool_]) -> float | None:
    return float(level.bending_MPa[mask].max()) if mask.any() else None


def cut_boxes(before: Crank, after: Crank, throw: Throw) -> list[tuple[Array, Array]]:
    """Return boxes (rotor frame) around the metal that was taken from a throw between its mains."""
    frame = after.anatomy.file_to_rotor
    ends = throw_ends_mm(after.anatomy, throw)
    if isinstance(ends, str):
        return []
    metal_cut = (before.source.solid - after.source.solid).moved(frame).above(ends[0]).below(ends[1])
    boxes = [each.bounds for each in metal_cut.pieces() if each.volume_mm3 > LEAST_CUT_MM3]
    return [(low - BESIDE_MM, high + BESIDE_MM) for low, high in boxes]


def costs_of(before: ThrowByElements, after: ThrowByElements) -> dict[tuple[int, Place], float]:
    """Return the ratio of stress after to before in each fillet, the more of bending and torsion; 1 at least.

    A change that is less than what two meshes of one solid differ by counts as none.
    """
    ratios = {}
    for one, other in zip(before.fillets, after.fillets, strict=True):
        ratio = max(other.bending_MPa / one.bending_MPa, other.torsion_MPa / one.torsion_MPa)
        ratios[other.web, other.place] = ratio if ratio > 1.0 + max(one.error, other.error) else 1.0
    return ratios
