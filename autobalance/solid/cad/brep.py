"""BREP and STEP: shapes written and read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from autobalance.errors import BodiesError, SolidError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad import kernel
from autobalance.solid.cad.build import MetalTaken, built, machined
from autobalance.solid.cad.files import CadFile, NamedBody, read_step_file
from autobalance.solid.cad.soundness import Gap, sound
from autobalance.solid.cad.taken import EachTaken, each_taken
from autobalance.solid.cad.tessellation import (
    Facets,
    Surface,
    Surfaces,
    bounds_mm,
    drop_triangles,
    facets,
    surface_kind,
    surfaces,
)
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool
from autobalance.solid.mesh.mesh import Mesh, few, listed, weld
from autobalance.solid.soundness.repair import solid_of, volume_change
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Solids with exact surfaces through the CAD kernel: built, measured, cut; needs the extra ``step``.


class ExactSolid:
    """One or several bodies bounded by exact surfaces: planes, cylinders, cones, tori and others.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed.
    SolidError
        If the kernel cannot build the shape, or its result is not valid.
    """

    def __init__(self, shape: Shape) -> None:
        kernel.require_kernel()
        self._take(kernel.unified(built(shape)), "the CAD kernel could not build the shape exactly")

    @classmethod
    def of(cls, body: Any) -> ExactSolid:
        """Take a body of the CAD kernel, after checking it."""
        solid = cls.__new__(cls)
        solid._take(body, "the CAD kernel finds fault with the solid")
        return solid

    @classmethod
    def of_checked(cls, body: Any) -> ExactSolid:
        """Take a body of the CAD kernel that was checked already."""
        solid = cls.__new__(cls)
        solid._body = body
        return solid

    def __reduce__(self) -> tuple[Callable[..., ExactSolid], tuple[Any, ...]]:
        """Pickle a STEP file: the kernel's bodies stay in their process."""
        return _of_step, (self.step(),)

    def to_plain(self) -> dict[str, Any]:
        """Return the body in the kernel's own binary form, and what is measured on it."""
        return {"body": kernel.shape_bytes(self._body), "unit": self._unit, "kinds": self.face_kinds()}

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> ExactSolid:
        """Return the solid of ``to_plain``; the kernel is loaded at the first use of its body."""
        solid = cls.__new__(cls)
        solid.__dict__.update(_data=plain["body"], _unit=plain["unit"], _kinds=dict(plain["kinds"]))
        return solid

    @cached_property
    def _body(self) -> Any:
        """The kernel's body, of a solid that was kept as bytes; others have theirs from the beginning."""
        kernel.require_kernel()
        return kernel.shape_of_bytes(self.__dict__["_data"])

    def _take(self, body: Any, complaint: str) -> None:
        if not kernel.is_valid(body):
            raise SolidError(complaint)
        self._body = body

    @property
    def body(self) -> Any:
        return self._body

    @property
    def volume_mm3(self) -> float:
        return self._unit.mass_g

    @cached_property
    def _unit(self) -> Moments:
        return kernel.properties(self._body)

    def moments(self, density_g_mm3: float, frame: Array | None = None) -> Moments:
        """Return the mass moments from the exact surfaces, in ``frame`` (4, 4) if given."""
        moments = self._unit.scaled(density_g_mm3)
        return moments if frame is None else moments.moved(frame)

    @property
    def bounds(self) -> Array:
        """Smallest and largest coordinates (2, 3) [mm], with a little room."""
        return bounds_mm(self._body)

    def face_kinds(self) -> dict[str, int]:
        """Count the faces by their surface: ``plane``, ``cylinder``, ``cone``, ``torus`` and others."""
        return dict(self._kinds)

    @cached_property
    def _kinds(self) -> dict[str, int]:
        return dict(Counter(surface_kind(face) for face in kernel.explored(self._body, "FACE")))

    def surfaces(self) -> tuple[Surface, ...]:
        """Return the plane and cylindrical faces."""
        return surfaces(self._body)

    def facets(self) -> Facets:
        """Return triangles whose corners lie on the true surface, and the face of each."""
        return facets(self._body)

    def machined(self, removed: Sequence[Tool], added: Sequence[Tool] = ()) -> ExactSolid:
        """Return the solid with metal added, then other metal removed.

        Raises
        ------
        SolidError
            If the kernel cannot cut it, or it falls apart.
        """
        return self.machined_as_taken(removed, added)[0]

    def machined_as_taken(
        self,
        removed: Sequence[Tool],
        added: Sequence[Tool] = (),
        shares: Sequence[float] | None = None,
    ) -> tuple[ExactSolid, tuple[MetalTaken | None, ...]]:
        """Return the ``machined`` solid and each removing tool's metal, None where its drawing shows that.

        Metal that is on a lowered face is sectioned at the first of ``shares`` of the part's diagonal
        over it that makes a sound cut; see ``clear_shares``.

        Raises
        ------
        SolidError
            As ``machined`` does.
        """
        done = machined(self._body, removed, added, shares)
        return ExactSolid.of(done.body), done.taken

    def each_taken(
        self,
        removed: Sequence[Tool],
        added: Sequence[Tool],
        machined: ExactSolid,
        shares: Sequence[float] | None = None,
    ) -> tuple[tuple[EachTaken, ...], tuple[EachTaken, ...]] | None:
        """Return the metal that each tool took or added on the way to ``machined``; see ``taken``."""
        return each_taken(self._body, removed, added, machined.volume_mm3 - self.volume_mm3, shares)

    def step(self, unit: str = "mm", name: str = "crank") -> bytes:
        """Return a STEP file of the solid, in a unit."""
        from autobalance.solid.cad.files import write_step

        return write_step(self._body, unit, name)


def _of_step(data: bytes) -> ExactSolid:
    from autobalance.solid.cad.files import read_step_file

    return joined_solids([ExactSolid.of(one.body) for one in read_step_file(data).bodies], apart=True)


def joined_solids(solids: Sequence[ExactSolid], apart: bool = False) -> ExactSolid:
    """Return several solids as one; overlaps count once, and are ruled out by ``apart``."""
    if len(solids) == 1:
        return solids[0]
    bodies = [solid.body for solid in solids]
    return ExactSolid.of(kernel.compound(bodies) if apart else kernel.fused(bodies))


def are_apart(solids: Sequence[ExactSolid]) -> bool:
    """Return whether the bounding boxes of solids are clear of each other."""
    boxes = [solid.bounds for solid in solids]
    return all(
        bool(np.any(one[0] > other[1]) or np.any(other[0] > one[1]))
        for place, one in enumerate(boxes)
        for other in boxes[:place]
    )


# Conversion of a CAD file to a solid with exact surfaces, and to the triangles that planning uses.


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
    with kernel.kernel_failures("the solid"):
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
