"""A STEP file becomes a solid with exact surfaces, and the triangles that it is planned on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.errors import BodiesError, SolidError
from autobalance.solid.cad.brep import ExactSolid, are_apart, joined_solids
from autobalance.solid.cad.step_file import StepFile, read_step_file
from autobalance.solid.cad.surface import Surfaces
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh, weld
from autobalance.solid.mesh.repair import solid_of

FACETS_MOST = 1e-2
"""Share of the volume that the triangles may miss: fine ones miss less than a thousandth of this."""


@dataclass(frozen=True, eq=False)
class Exact:
    """A solid with its own surfaces, as a file gives it.

    ``unit`` and ``name`` are the file's; ``surfaces`` are its planes and cylinders with the triangles of
    ``mesh`` that stand for them, or None where the triangles had to be mended.
    """

    solid: ExactSolid
    unit: str
    name: str
    bodies: int
    triangles: int
    mesh: Solid
    surfaces: Surfaces | None


def exact_of(file: StepFile, body: int | str | None, pressed_up: bool) -> Exact:
    """Choose from the solids of a STEP file, and tessellate what was chosen.

    Parameters
    ----------
    file : StepFile
    body : int or str or None
        A number, from 1 by falling volume; a name; or "all".
    pressed_up : bool
        Whether the file may hold one body for each half of a crank; all are taken.

    Raises
    ------
    SolidError
        If none or several fit, the kernel finds fault with the solid, or its triangles are not closed.
    """
    parts = [_Part(ExactSolid.of(one.body), one.name, one.place) for one in file.bodies]
    parts.sort(key=lambda part: -part.solid.volume_mm3)
    chosen, name = _chosen(parts, body, pressed_up)
    facets = chosen.facets()
    distinct, number = weld(facets.points)
    corners = number[facets.triangles]
    whole = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    mesh, repairs = solid_of(Mesh(distinct, corners[whole]))
    if abs(mesh.volume_mm3 - chosen.volume_mm3) > FACETS_MOST * chosen.volume_mm3:
        raise SolidError(
            f"the CAD kernel's triangles bound {mesh.volume_mm3:.6g} mm³, the solid holds "
            f"{chosen.volume_mm3:.6g} mm³; needed a solid that can be tessellated"
        )
    surfaces = None if repairs else Surfaces(chosen.surfaces(), facets.face[whole])
    return Exact(chosen, file.unit, name, len(parts), len(facets.triangles), mesh, surfaces)


def written_and_read(exact: Exact, solid: ExactSolid) -> tuple[bytes, Exact]:
    """Return a STEP file of a solid that was made from ``exact``, and the solid as a reader finds it.

    Raises
    ------
    SolidError
        If a reader would refuse it.
    """
    data = solid.step(exact.unit, exact.name)
    return data, exact_of(read_step_file(data), "all", False)


@dataclass(frozen=True, eq=False)
class _Part:
    """A solid with the name of its part, and that of the part's place in the assembly."""

    solid: ExactSolid
    name: str
    place: str


def _chosen(parts: Sequence[_Part], body: int | str | None, pressed_up: bool) -> tuple[ExactSolid, str]:
    if body == "all" or (body is None and (pressed_up or len(parts) == 1)):
        every = [part.solid for part in parts]
        return joined_solids(every, are_apart(every)), parts[0].name
    if body is None:
        raise BodiesError(f"{_listed(parts)}; needed body = a number or a name, or 'all' to unite them")
    found = _named(parts, body) if isinstance(body, str) else list(parts[body - 1 : body] if body > 0 else ())
    if len(found) != 1:
        raise SolidError(f"body {body!r} was asked for; {_listed(parts)}")
    return found[0].solid, found[0].name


def _named(parts: Sequence[_Part], name: str) -> list[_Part]:
    """Return the parts of a name; else those at a place of that name; else whatever the letters' size."""
    small = name.casefold()
    for found in (
        [part for part in parts if part.name == name],
        [part for part in parts if part.place == name],
        [part for part in parts if small in (part.name.casefold(), part.place.casefold())],
    ):
        if len(found) == 1:
            return found
    return []


def _listed(parts: Sequence[_Part]) -> str:
    lines = []
    shared = {part.name for part in parts if sum(part.name == other.name for other in parts) > 1}
    for number, part in enumerate(parts, start=1):
        low, high = part.solid.bounds
        x, y, z = high - low
        name = part.place if part.name in shared and part.place else part.name
        label = f" {name!r}," if name else ""
        lines.append(f"{number}:{label} {part.solid.volume_mm3:.6g} mm³, {x:.5g} × {y:.5g} × {z:.5g} mm")
    bodies = "1 body" if len(parts) == 1 else f"{len(parts)} bodies"
    return f"the file holds {bodies} ({'; '.join(lines)})"
