"""Conversion of a CAD file to a solid with exact surfaces, and to the triangles that planning uses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.errors import BodiesError, SolidError
from autobalance.solid.cad.brep import ExactSolid, are_apart, joined_solids
from autobalance.solid.cad.cad_file import CadFile, NamedBody
from autobalance.solid.cad.kernel import kernel_failures
from autobalance.solid.cad.soundness import Gap, sound
from autobalance.solid.cad.step_file import read_step_file
from autobalance.solid.cad.surface import Surfaces
from autobalance.solid.cad.tessellation import drop_triangles
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.body_list import few, listed
from autobalance.solid.mesh.mesh import Mesh, weld
from autobalance.solid.soundness.repair import solid_of, volume_change

FACETS_MOST = 1e-2
"""Share of the volume that the triangles may miss: fine ones miss less than a thousandth of this."""


@dataclass(frozen=True, eq=False)
class Exact:
    """A solid with its own surfaces, as a file gives it.

    ``unit`` and ``name`` are the file's. ``surfaces`` are its planes and cylinders with the triangles of
    ``mesh`` that represent them, or None if the triangles were repaired. ``repairs`` has a line each;
    ``gaps`` are faces that its edges lie off.
    """

    solid: ExactSolid
    unit: str
    name: str
    bodies: int
    triangles: int
    mesh: Solid
    surfaces: Surfaces | None
    repairs: tuple[str, ...] = ()
    gaps: tuple[Gap, ...] = ()


def exact_of(file: CadFile, body: int | str | None, pressed_up: bool) -> Exact:
    """Choose from the solids of a CAD file, check the chosen ones, and tessellate them.

    Parameters
    ----------
    file : CadFile
    body : int or str or None
        A number, from 1 by falling volume, a name, or "all".
    pressed_up : bool
        Whether the file may hold one body for each half of a crank; all are taken.

    Raises
    ------
    SolidError
        If none or several fit, the kernel finds fault with the solid, or its triangles are not closed.
    """
    with kernel_failures("the solid"):
        return _exact_of(file, body, pressed_up)


def _exact_of(file: CadFile, body: int | str | None, pressed_up: bool) -> Exact:
    parts = [_part(one) for one in file.bodies]
    parts.sort(key=lambda part: -part.solid.volume_mm3)
    bodies = _chosen(parts, body, pressed_up)
    every = [part.solid for part in bodies]
    chosen = joined_solids(every, are_apart(every))
    facets = chosen.facets()
    if not np.isfinite(facets.points).all():  # a damaged file: a vector left out, a radius of no number
        raise SolidError(
            "the CAD kernel's triangles have corners that are not numbers; expected a solid that can be"
            " tessellated: export it again"
        )
    distinct, number = weld(facets.points)
    corners = number[facets.triangles]
    whole = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    mesh, repairs = solid_of(Mesh(distinct, corners[whole]))
    if abs(mesh.volume_mm3 - chosen.volume_mm3) > FACETS_MOST * chosen.volume_mm3:
        raise SolidError(
            f"the CAD kernel's triangles bound {mesh.volume_mm3:.6g} mm³, the solid holds "
            f"{chosen.volume_mm3:.6g} mm³; expected a solid that can be tessellated"
        )
    surfaces = None if repairs else Surfaces(chosen.surfaces(), facets.face[whole])
    return Exact(
        solid=chosen,
        unit=file.unit or "mm",
        name=bodies[0].name,
        bodies=len(parts),
        triangles=len(facets.triangles),
        mesh=mesh,
        surfaces=surfaces,
        repairs=(
            *file.repairs,
            *(note for part in bodies for note in part.repairs),
            *_united(bodies, chosen),
        ),
        gaps=tuple(gap for part in bodies for gap in part.gaps),
    )


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
    """Solid with the names of its part and of the part's place in the assembly."""

    solid: ExactSolid
    name: str
    place: str
    repairs: tuple[str, ...]
    gaps: tuple[Gap, ...]


def _part(one: NamedBody) -> _Part:
    """Return a checked solid of a file, outward."""
    try:
        checked = sound(one.body)
    except SolidError as error:
        raise SolidError(f"the part {one.name!r}: {error}" if one.name else str(error)) from None
    if checked.gaps or checked.repairs:  # cuts would keep stale triangles where edges lie off faces
        drop_triangles(checked.body)
    solid, repairs = ExactSolid.of_checked(checked.body), checked.repairs
    volume = solid.volume_mm3
    if volume < 0.0:
        solid = ExactSolid.of_checked(checked.body.Reversed())
        repairs += (f"the solid was inside out: turned round; {volume_change(volume, -volume)}",)
    return _Part(solid, one.name, one.place, repairs, checked.gaps)


def _chosen(parts: Sequence[_Part], body: int | str | None, pressed_up: bool) -> Sequence[_Part]:
    if body == "all" or (body is None and (pressed_up or len(parts) == 1)):
        return parts
    if body is None:
        hint = "expected body = a number or a name, or 'all' to unite them"
        raise BodiesError(f"{_listed(parts)}; {hint}", len(parts))
    matching = (
        _named(parts, body) if isinstance(body, str) else list(parts[body - 1 : body] if body > 0 else ())
    )
    if len(matching) != 1:
        raise SolidError(f"body {body!r} does not exist; {_listed(parts)}")
    return matching


def _united(parts: Sequence[_Part], whole: ExactSolid) -> list[str]:
    """Return a note on the parts that were united, and on their overlap; none for a single part."""
    if len(parts) == 1:
        return []
    total = sum(part.solid.volume_mm3 for part in parts)
    twice = total - whole.volume_mm3
    overlaps = f"; overlaps of {twice:.6g} mm³ now count once" if twice > 1e-9 * total else ""
    each = [f"{_label(parts, part)} {part.solid.volume_mm3:.6g} mm³".lstrip() for part in parts]
    return [f"{len(parts)} bodies united: {few(each)}{overlaps}"]


def _named(parts: Sequence[_Part], name: str) -> list[_Part]:
    """Return the one part of a name, else the one at a place of that name, else that in any case; or none."""
    small = name.casefold()
    for matching in (
        [part for part in parts if part.name == name],
        [part for part in parts if part.place == name],
        [part for part in parts if small in (part.name.casefold(), part.place.casefold())],
    ):
        if len(matching) == 1:
            return matching
    return []


def _listed(parts: Sequence[_Part]) -> str:
    lines = []
    for number, part in enumerate(parts, start=1):
        low, high = part.solid.bounds
        x, y, z = high - low
        label = _label(parts, part)
        label = f" {label}," if label else ""
        lines.append(f"{number}:{label} {part.solid.volume_mm3:.6g} mm³, {x:.5g} × {y:.5g} × {z:.5g} mm")
    return listed(lines)


def _label(parts: Sequence[_Part], part: _Part) -> str:
    """Return the name that distinguishes a part from the others, in quotes."""
    shared = sum(part.name == other.name for other in parts) > 1
    name = part.place if shared and part.place else part.name
    return repr(name) if name else ""
