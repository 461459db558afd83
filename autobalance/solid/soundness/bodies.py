"""The connected bodies of a solid, and which of them are the crank."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np

from autobalance.errors import BodiesError, SolidError
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.measure import CRUMB_VOLUME_SHARE, crumbs_dropped, part_volumes, parts_at_edges
from autobalance.solid.mesh.mesh import Mesh, listed
from autobalance.solid.soundness.repair import volume_change
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# The connected bodies of a solid: filled ones with their cavities, turned round if inside out.


@dataclass(frozen=True, eq=False)
class Body:
    """One connected body of a file, with its cavities; its solid is built on first use.

    Attributes
    ----------
    mesh : Mesh
        The mesh that it is part of.
    part_of : (m,) int
        The part that each of its triangles belongs to.
    part : int
        The part that is this body's outside.
    outside_volume_mm3 : float
        Volume inside that part; negative while it is inside out.
    bounds : (2, 3) float
        Smallest and largest coordinates [mm].
    cavities : tuple of Solid
    """

    mesh: Mesh
    part_of: Indices
    part: int
    outside_volume_mm3: float
    bounds: Array
    cavities: tuple[Solid, ...] = ()

    @cached_property
    def solid(self) -> Solid:
        """The body without its cavities, right side out."""
        outside = self.mesh.part(self.part_of == self.part)
        solid = Solid.of_parts(outside if self.outside_volume_mm3 > 0.0 else outside.flipped())
        for cavity in self.cavities:
            solid = solid - cavity
        return solid

    @property
    def volume_mm3(self) -> float:
        """Volume without the cavities [mm³]."""
        return abs(self.outside_volume_mm3) - sum(cavity.volume_mm3 for cavity in self.cavities)

    @property
    def size_mm(self) -> Array:
        """Edges of its bounding box (3,) [mm]."""
        low, high = self.bounds
        size: Array = high - low
        return size


def bodies_of(solid: Solid) -> tuple[list[Body], list[str]]:
    """Return the connected bodies by falling volume, then by place, and notes on their repairs.

    A part that is inside out is a cavity if it lies within another; otherwise it is turned round. Parts that
    bound next to nothing, folded triangles, are dropped.
    """
    parts, notes = _without_crumbs(_parts(solid))
    whole = solid.volume_mm3
    filled = sorted((part for part in parts if part.outside_volume_mm3 > 0.0), key=lambda one: one.volume_mm3)
    for part in parts:
        if part.outside_volume_mm3 > 0.0:
            continue
        around = next((k for k, one in enumerate(filled) if _contains(one.solid, part.solid)), None)
        if around is not None:
            filled[around] = replace(filled[around], cavities=(*filled[around].cavities, part.solid))
            continue
        filled.append(part)
        change = volume_change(whole, whole + 2.0 * part.volume_mm3)
        whole += 2.0 * part.volume_mm3
        notes.append(f"a body of {part.volume_mm3:.6g} mm³ was inside out: turned round; {change}")
    filled.sort(key=lambda one: (-one.volume_mm3, *one.bounds[0]))
    return filled, notes


def _without_crumbs(parts: list[Body]) -> tuple[list[Body], list[str]]:
    """Return the parts that bound more than a share of the whole, and a note on those dropped, if any."""
    least = CRUMB_VOLUME_SHARE * sum(part.volume_mm3 for part in parts)
    kept = [part for part in parts if part.volume_mm3 > least]
    dropped = sum(part.volume_mm3 for part in parts if part.volume_mm3 <= least)
    number = len(parts) - len(kept)
    if not number or not kept:
        return parts, []
    return kept, [crumbs_dropped(number, dropped)]


def _parts(solid: Solid) -> list[Body]:
    """Return the connected parts of a solid's mesh as bodies without cavities.

    Parts that lie against each other, and share vertices or edges, are still separate parts.
    """
    mesh = solid.mesh
    if not solid.is_built and mesh.twins is not None:
        part_of, count = parts_at_edges(mesh)
        if count == 1:  # also where it touches itself, which building it would tell
            return [Body(mesh, part_of, 0, solid.volume_mm3, mesh.bounds)]
    if solid.is_pinched:
        part_of, count = parts_at_edges(mesh)
        points, part_of_point = mesh.corners.reshape(-1, 3), np.repeat(part_of, 3)
    else:
        part_of_point, count = mesh.parts_at_vertices
        points, part_of = mesh.vertices, part_of_point.take(mesh.triangles[:, 0])
    parts = np.flatnonzero(np.bincount(part_of, minlength=count))  # vertices in no triangle are none
    if len(parts) == 1:
        return [Body(mesh, part_of, int(parts[0]), solid.volume_mm3, mesh.bounds)]
    bounds = np.stack([np.full((3, count), np.inf), np.full((3, count), -np.inf)])
    for axis, column in enumerate(points.T):
        np.minimum.at(bounds[0, axis], part_of_point, column)
        np.maximum.at(bounds[1, axis], part_of_point, column)
    volumes = part_volumes(mesh, part_of, count)
    return [Body(mesh, part_of, part, float(volumes[part]), bounds[:, :, part]) for part in parts.tolist()]


def are_apart(bodies: Sequence[Body]) -> bool:
    """Return whether the bounding boxes of bodies are clear of each other, so that nothing can overlap."""
    boxes = [body.bounds for body in bodies]
    return all(
        bool((one[0] > other[1]).any() or (other[0] > one[1]).any()) for one, other in combinations(boxes, 2)
    )


def _contains(outer: Solid, inner: Solid) -> bool:
    low, high = outer.bounds
    if (inner.bounds[0] < low).any() or (inner.bounds[1] > high).any():
        return False
    return (outer & inner).volume_mm3 >= (1.0 - 1e-9) * inner.volume_mm3  # rounding of a boolean


# Choice of the bodies of a file that are the crank.


def chosen_bodies(
    solid: Solid, body: int | str | None, pressed_up: bool, unite: bool
) -> tuple[Solid, int, list[str]]:
    """Return the chosen bodies of a solid as one, the number of its bodies, and the repairs.

    Parameters
    ----------
    body : int, str or None
        The body's number from 1, or ``all``; None for the only one or, if ``pressed_up``, for all of them.
    unite : bool
        Whether bodies that touch or overlap become one; else they stay as they are.

    Raises
    ------
    BodiesError
        If there are several and none was chosen.
    SolidError
        If there is no such body.
    """
    bodies, turned = bodies_of(solid)
    if len(bodies) == 1:
        if body not in (None, "all", 1):
            raise SolidError(f"body {body!r} does not exist; {_listed(bodies)}")
        return bodies[0].solid if turned else solid, 1, turned
    together = (body == "all" or (body is None and pressed_up)) and not turned
    if together and (not unite or are_apart(bodies)):
        return solid, len(bodies), turned
    chosen, changes = _choose(bodies, body, pressed_up)
    return chosen, len(bodies), turned + changes


def _choose(bodies: list[Body], body: int | str | None, pressed_up: bool) -> tuple[Solid, list[str]]:
    if isinstance(body, str) and body != "all":
        raise SolidError(f"body {body!r} does not exist; this format has no names; {_listed(bodies)}")
    if isinstance(body, int):
        if not 1 <= body <= len(bodies):
            raise SolidError(f"body {body} does not exist; {_listed(bodies)}")
        return bodies[body - 1].solid, []
    if body is None and not pressed_up:
        hint = "expected body = a number, or 'all' to unite them"
        raise BodiesError(f"{_listed(bodies)}; {hint}", len(bodies))
    united = union([one.solid for one in bodies])
    total = sum(one.volume_mm3 for one in bodies)
    overlap = total - united.volume_mm3
    notes = (
        f"{len(bodies)} bodies united; overlaps of {overlap:.6g} mm³ now count once; "
        f"{volume_change(total, united.volume_mm3)}"
    )
    return united, [notes] if abs(overlap) > 1e-9 * total else []


def _listed(bodies: list[Body]) -> str:
    lines = []
    for number, one in enumerate(bodies, start=1):
        x, y, z = one.size_mm
        lines.append(f"{number}: {one.volume_mm3:.6g} mm³, {x:.5g} × {y:.5g} × {z:.5g} mm")
    return listed(lines)
